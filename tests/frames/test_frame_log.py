import json
import typing
from typing import Any

import msgspec
import pyarrow.parquet as pq
import pytest
from tests import voyages

from glasshelm.core.errors import InputError
from glasshelm.frames import frame_log, frame_parquet
from glasshelm.frames import schema as f


def target(name: str, **more) -> f.Target:
    return f.Target(
        id=name,
        name=name.upper(),
        east_m=1.0,
        north_m=2.0,
        course_rad=0.5,
        speed_m_s=5.0,
        range_m=2.25,
        bearing_rad=-0.5,
        dcpa_m=1.5,
        tcpa_s=-3.0,
        danger=0.0,
        **more,
    )


def frame(time_s: float, *targets: f.Target, **more) -> f.Frame:
    return f.Frame(
        time_s=time_s,
        pilot="straight",
        source="random:1",
        ship=f.Ship(340.0, 60.0, 0.1, 11.0, 0.08, 5.1),
        own=f.Own(0.0, 0.0, 0.0, 5.1, 0.0),
        waypoint=f.Waypoint(0.0, 1e4),
        targets=list(targets),
        **more,
    )


FRAMES = [
    frame(0.0),
    frame(5.0, target("a", q=-0.25), target("b", lost=True, age_s=400.0)),
    frame(10.0, target("a"), value=f.BySubTask(1.0, -0.5, 0.5), outside_training=["x", "y"]),
]


def test_what_is_written_is_read(tmp_path):
    path = tmp_path / "new" / "log.jsonl"
    assert frame_log.write_log(path, FRAMES) == 3
    assert list(frame_log.read_log(path)) == FRAMES
    assert frame_log.write_log(path, FRAMES[:1]) == 1
    assert list(frame_log.read_log(path)) == FRAMES[:1]


def test_absent_is_not_written(tmp_path):
    path = tmp_path / "log.jsonl"
    frame_log.write_log(path, FRAMES)
    first, second, _ = map(json.loads, path.read_text().splitlines())
    assert "value" not in first
    assert "rudder_rad" not in first["own"]
    assert second["targets"][0]["q"] == -0.25
    assert "attention" not in second["targets"][0]


def test_every_frame_is_on_disk_at_once(tmp_path):
    path = tmp_path / "log.jsonl"
    with frame_log.FrameLog(path) as log:
        for count, one in enumerate(FRAMES, start=1):
            log.write(one)
            assert len(list(frame_log.read_log(path))) == count


@pytest.mark.parametrize("left", [1, 40, 400])
def test_a_torn_tail_is_left_out_and_then_written_over(tmp_path, left):
    path = tmp_path / "log.jsonl"
    frame_log.write_log(path, FRAMES)
    whole = path.read_bytes()
    start_of_last = whole.rstrip(b"\n").rfind(b"\n") + 1
    path.write_bytes(whole[: start_of_last + left])
    assert list(frame_log.read_log(path)) == FRAMES[:2]
    with frame_log.FrameLog(path) as log:
        log.write(FRAMES[2])
    assert path.read_bytes() == whole


def test_a_log_torn_in_its_first_line_begins_anew(tmp_path):
    path = tmp_path / "log.jsonl"
    path.write_bytes(b'{"time_s": 1' + b" " * 200_000)
    assert list(frame_log.read_log(path)) == []
    with frame_log.FrameLog(path) as log:
        log.write(FRAMES[0])
    assert list(frame_log.read_log(path)) == FRAMES[:1]


@pytest.mark.parametrize(
    "damage", [b'{"time_s": \n', b"\xff\xfe\n", b'{"time_s": "five"}\n', b"[]\n"]
)
def test_a_damaged_line_in_the_middle_is_named(tmp_path, damage):
    path = tmp_path / "log.jsonl"
    frame_log.write_log(path, FRAMES)
    lines = path.read_bytes().splitlines(keepends=True)
    path.write_bytes(lines[0] + damage + lines[2])
    reading = frame_log.read_log(path)
    assert next(reading) == FRAMES[0]
    with pytest.raises(InputError, match=r"log\.jsonl: line 2 is not a frame") as caught:
        next(reading)
    assert "\n" not in str(caught.value)


def test_no_such_log(tmp_path):
    with pytest.raises(InputError, match="No such file"):
        list(frame_log.read_log(tmp_path / "none.jsonl"))
    with pytest.raises(InputError, match="cannot write the log"):
        frame_log.FrameLog(tmp_path)


def test_parquet_has_a_row_for_each_target_and_for_an_empty_frame(tmp_path):
    path = tmp_path / "frames.parquet"
    assert frame_parquet.to_parquet(FRAMES, path) == 4
    table = pq.read_table(path)
    assert table.column_names == list(frame_parquet.columns())
    rows = table.to_pylist()
    assert [r["time_s"] for r in rows] == [0.0, 5.0, 5.0, 10.0]
    assert [r["target_id"] for r in rows] == [None, "a", "b", "a"]
    assert rows[1]["target_q"] == -0.25
    assert rows[2]["target_q"] is None
    assert rows[2]["target_lost"] is True
    assert rows[3]["value_total"] == 0.5
    assert rows[3]["outside_training"] == ["x", "y"]
    assert rows[0]["own_rudder_rad"] is None


def frames_of(rows: list[dict[str, Any]]) -> list[f.Frame]:
    """The table backwards: rows of one time are one frame, names with a prefix one part of it."""

    def part(kind: type, prefix: str, row: dict[str, Any]) -> Any:
        values: dict[str, Any] = {}
        for name, hint in typing.get_type_hints(kind).items():
            inner = [h for h in typing.get_args(hint) or [hint] if isinstance(h, type)]
            struct = next((h for h in inner if issubclass(h, msgspec.Struct)), None)
            if prefix + name == "targets":
                value = []
            elif typing.get_origin(hint) is list:
                value = row[prefix + name]
                value = None if value is None else msgspec.convert(value, hint)
            elif struct is not None:
                value = part(struct, f"{prefix}{name}_", row)
            else:
                value = row[prefix + name]
            if value is not None:
                values[name] = value
        return kind(**values) if values else None

    made: dict[float, f.Frame] = {}
    for row in rows:
        whole = made.setdefault(row["time_s"], part(f.Frame, "", row))
        if row["target_id"] is not None:
            whole.targets.append(part(f.Target, "target_", row))
    return list(made.values())


BANDED = frame(
    0.0,
    target("a"),
    band=f.Band(
        -0.1, 0.1, 10.0, 0.01, 0.1,
        manoeuvre=f.ManoeuvreBand(
            f.BySubTask(1.0, -0.5, 0.5),
            f.BySubTask(2.0, 0.0, 2.0),
            [f.TargetBand("a", -0.5, 0.0, -0.25, 900.0)],
            [f.AlternativeBand("keep", 0.5, 1.5)],
            [0.25],
            True,
        ),
    ),
)  # fmt: skip


@pytest.mark.parametrize("made", [FRAMES, [BANDED], voyages.learned()[:30], voyages.plain()[:5]])
def test_the_frames_can_be_made_again_from_the_table(tmp_path, made):
    # Everything is in it, Q over the rudder range of the frame and of each target too.
    path = tmp_path / "frames.parquet"
    frame_parquet.to_parquet(made, path)
    assert frames_of(pq.read_table(path).to_pylist()) == made


def test_every_value_of_a_frame_has_a_column():
    known = set(frame_parquet.columns())
    for row in frame_parquet.rows(FRAMES):
        assert set(row) <= known
    assert {"own_latitude_deg", "ship_K_1_s", "target_intention_level", "reward_total"} <= known
    assert {"sweep_rudder_rad", "sweep_collision", "target_q_sweep"} <= known
