"""Which frame and which pilot are meant; what the command refuses, in one line."""

import msgspec
import pytest
from tests.voyages import Other, voyage

from glasshelm.cli import main
from glasshelm.core.errors import InputError
from glasshelm.frames.frame_log import read_log, write_log
from glasshelm.whatif.logged_world import frame_at, pilot_of


def clock(k: int) -> str:
    """Frames every 5 s from 23:59:30.5 on, over midnight."""
    second = 30 + 5 * k
    return f"2026-03-0{1 + second // 60}T{'23:59' if second < 60 else '00:00'}:{second % 60:02d}.5Z"


CLOCKLESS = voyage([0.0] * 20, [Other("Aurora", 3000.0, 3000.0, 270.0)])
CLOCKED = voyage([0.0] * 13, time_utc=lambda k: clock(k) if k < 12 else None)[:12]


@pytest.mark.parametrize(
    ("at", "number"), [("0", 0), ("12.4", 2), ("95", 19), ("frame:7", 7), ("1e1", 2)]
)
def test_instant_is_the_last_frame_not_later(at, number):
    assert frame_at(CLOCKLESS, at) == number


@pytest.mark.parametrize(
    ("at", "number"),
    [("23:59:41", 2), ("00:00:05", 6), ("23:59", 0), ("2026-03-02T00:00:11Z", 8), ("20", 4)],
)
def test_clock_of_the_log_is_read_over_midnight(at, number):
    assert frame_at(CLOCKED, at) == number


@pytest.mark.parametrize(
    ("frames", "at", "line"),
    [
        (CLOCKLESS, "96", "outside the log, which holds 0 to 95 s"),
        (CLOCKLESS, "-1", "outside the log"),
        (CLOCKLESS, "nan", "no time"),
        (CLOCKLESS, "frame:20", "the log has frames 0 to 19"),
        (CLOCKLESS, "frame:x", "the log has frames 0 to 19"),
        (CLOCKLESS, "14:30", "the log has no clock"),
        (CLOCKED, "14:30", "outside the log, which holds 0 to 55 s (23:59:30 to"),
        (CLOCKED, "noon:ish", "seconds, frame:NUMBER, HH:MM"),
    ],
)
def test_instant_outside_is_one_line(frames, at, line):
    with pytest.raises(InputError) as caught:
        frame_at(frames, at)
    assert line in str(caught.value)
    assert "\n" not in str(caught.value)


def test_pilot_of_a_log_must_be_bundled_and_have_the_same_weights():
    frame = CLOCKLESS[0]
    with pytest.raises(InputError, match="'by hand' is not bundled"):
        pilot_of(frame)
    with pytest.raises(InputError, match="'os:system' is not bundled"):
        pilot_of(msgspec.structs.replace(frame, pilot="os:system"))
    other = msgspec.structs.replace(frame, pilot="paper-attention", weights_sha256="ab" * 32)
    with pytest.raises(InputError, match="other weights"):
        pilot_of(other)
    assert pilot_of(msgspec.structs.replace(frame, pilot="straight")).name == "straight"


@pytest.mark.slow
def test_command_prints_a_table_and_writes_both_futures(tmp_path, capsys):
    log, out = tmp_path / "log.jsonl", tmp_path / "out"
    write_log(log, [msgspec.structs.replace(f, pilot="straight") for f in CLOCKLESS])
    args = [
        "whatif",
        str(log),
        "--at",
        "10",
        "--rudder",
        "-5",
        "--rudder-seconds",
        "30",
        "--minutes",
        "5",
    ]
    assert main([*args, "--out", str(out)]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "as things are" in said
    assert "With the rudder 5° to port for 30 s, own ship would alter" in said
    fact, other = (list(read_log(out / name)) for name in ("factual.jsonl", "counterfactual.jsonl"))
    assert len(fact) == len(other) == 61
    assert fact[0].own == other[0].own
    assert other[1].own.heading_rad < 0
    for name in ("whatif.png", "whatif.pdf", "whatif.svg"):
        assert (out / name).stat().st_size > 5000


@pytest.mark.parametrize(
    ("more", "line"),
    [
        ([], "nothing is asked"),
        (["--delete", "Borealis"], "no ship 'Borealis' from this instant on: there are Aurora"),
        (["--rudder", "20"], "own ship's goes to 5°"),
        (["--keep-course", "own", "--minutes", "0"], "0 minutes"),
        (["--keep-course", "own", "--pilot", "nobody"], "unknown pilot 'nobody'"),
    ],
)
def test_command_refuses_in_one_line(tmp_path, capsys, more, line):
    log = tmp_path / "log.jsonl"
    write_log(log, [msgspec.structs.replace(f, pilot="straight") for f in CLOCKLESS])
    assert main(["whatif", str(log), "--at", "10", *more]) == 2
    said = capsys.readouterr().err
    assert line in said
    assert said.count("\n") == 1
