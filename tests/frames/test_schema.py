import json

import msgspec

from glasshelm.frames.schema import Frame, Target

FRAME = ("time_s", "pilot", "weights_sha256", "ship", "own", "waypoint", "decision", "reward",
         "value", "priority", "targets")  # fmt: skip
PARTS = {
    "Ship": ("loa_m", "K_1_s", "T_s"),
    "Own": ("east_m", "north_m", "heading_rad", "speed_m_s", "rate_of_turn_rad_s", "rudder_rad"),
    "Waypoint": ("east_m", "north_m"),
    "Decision": ("rudder_rad",),
    "BySubTask": ("waypoint", "collision", "total"),
    "Target": ("id", "name", "east_m", "north_m", "course_rad", "speed_m_s", "range_m",
               "bearing_rad", "dcpa_m", "tcpa_s", "danger", "q", "priority", "attention",
               "intention"),
}  # fmt: skip


def test_the_names_that_others_build_on_are_there():
    definitions = msgspec.json.schema(Frame)["$defs"]
    for part, names in {"Frame": FRAME, **PARTS}.items():
        assert set(names) <= set(definitions[part]["properties"]), part


def test_only_what_every_source_has_is_required():
    definitions = msgspec.json.schema(Frame)["$defs"]
    assert set(definitions["Frame"]["required"]) == {
        "time_s", "pilot", "source", "ship", "own", "waypoint", "targets"
    }  # fmt: skip
    assert not set(definitions["Target"]["required"]) & {
        "q", "priority", "attention", "intention", "length_m", "latitude_deg"
    }  # fmt: skip


def test_a_reader_of_today_reads_fields_of_tomorrow():
    target = Target("1", "one", 0.0, 0.0, 0.0, 5.0, 9.0, 0.0, 1.0, 2.0, 0.0)
    line = json.loads(msgspec.json.encode(target)) | {"mood": "calm"}
    assert msgspec.json.decode(json.dumps(line), type=Target) == target
    assert "selected" not in line
    assert msgspec.json.decode(json.dumps(line), type=Target).selected


def test_frames_cannot_be_changed():
    assert Frame.__struct_config__.frozen
