import json
import math
from datetime import UTC, datetime

import pytest

from glasshelm.feeds.deltas import LONGEST_MESSAGE, DeltaReader
from glasshelm.feeds.types import Counts, Refusal

HELLO = {"name": "x", "version": "2.23.0", "self": "vessels.urn:mrn:signalk:uuid:1", "roles": []}
STAMP = "2014-08-15T19:00:01.040Z"
STATION = "vessels.urn:mrn:imo:mmsi:002766140"
OTHER = "vessels.urn:mrn:imo:mmsi:276780000"


def delta(values, context=OTHER, timestamp=STAMP):
    update = {"$source": "n2k.1", "values": [{"path": p, "value": v} for p, v in values.items()]}
    update |= {"timestamp": timestamp} if timestamp else {}
    return {"updates": [update]} | ({"context": context} if context else {})


def read(*messages, own=None):
    counts = Counts()
    reader = DeltaReader(counts, own)
    reports = []
    for message in messages:
        raw = message if isinstance(message, str | bytes) else json.dumps(message)
        reports += reader.message(raw)
    assert counts.waiting == 0
    return reports, {why: n for why, n in counts.refused.items() if n}


def test_a_target_in_si_units_as_it_comes():
    (report,), refused = read(
        HELLO,
        delta(
            {
                "navigation.position": {"longitude": 24.8, "latitude": 59.86},
                "navigation.speedOverGround": 14.91,
                "navigation.courseOverGroundTrue": 3.48,
                "navigation.headingTrue": 3.45,
                "navigation.rateOfTurn": 0.0003,
                "navigation.state": "motoring",
                "": {"mmsi": "276780000", "name": " MEGASTAR "},
                "design.length": {"overall": 212},
                "design.beam": 30.6,
                "design.aisShipType": {"id": 60, "name": "Passenger ship"},
            }
        ),
    )
    assert refused == {}
    assert (report.id, report.name, report.kind) == ("276780000", "MEGASTAR", "60")
    assert report.time == datetime(2014, 8, 15, 19, 0, 1, 40_000, tzinfo=UTC)
    assert (report.latitude_deg, report.longitude_deg) == (59.86, 24.8)
    assert (report.speed_m_s, report.course_rad, report.heading_rad) == (14.91, 3.48, 3.45)
    assert (report.rate_of_turn_rad_s, report.length_m, report.beam_m) == (0.0003, 212.0, 30.6)
    assert not report.own


@pytest.mark.parametrize(
    ("path", "value"),
    [
        ("navigation.course.nextPoint", {"position": {"latitude": 59.5, "longitude": 24.5}}),
        (
            "navigation.courseGreatCircle.nextPoint.position",
            {"latitude": 59.5, "longitude": 24.5},
        ),
    ],
)
def test_the_next_waypoint_of_her_route(path, value):
    (report,), _ = read(HELLO, delta({path: value}, None))
    assert (report.waypoint_latitude_deg, report.waypoint_longitude_deg) == (59.5, 24.5)
    assert report.latitude_deg is None


@pytest.mark.parametrize("context", [HELLO["self"], "vessels.self", None])
def test_own_ship_is_the_self_of_the_hello(context):
    (report,), _ = read(HELLO, delta({"steering.rudderAngle": 0.1}, context))
    assert report.own
    assert report.rudder_rad == 0.1


def test_own_ship_may_be_named_by_her_mmsi():
    (report,), _ = read(delta({"navigation.speedOverGround": 1.0}), own="276780000")
    assert report.own
    (report,), _ = read({"self": OTHER}, delta({"navigation.speedOverGround": 1.0}))
    assert report.own
    assert report.id == "276780000"


def test_every_update_is_a_report_and_one_without_time_is_of_now():
    both = {
        "context": OTHER,
        "updates": [
            *delta({"navigation.speedOverGround": 1.0}, timestamp=None)["updates"],
            *delta({"navigation.headingTrue": 2.0})["updates"],
            *delta({"environment.depth": 2.0})["updates"],
        ],
    }
    before = datetime.now(UTC)
    (first, second), refused = read(both)
    assert before <= first.time <= datetime.now(UTC)
    assert second.heading_rad == 2.0
    assert refused == {}


@pytest.mark.parametrize(
    ("message", "why"),
    [
        ("", Refusal.UNREADABLE),
        ("{", Refusal.UNREADABLE),
        (b"\xff\xfe", Refusal.UNREADABLE),
        ('{"updates":[{"values":[{"path":"","value":' + "[" * 100_000, Refusal.UNREADABLE),
        (" " * (LONGEST_MESSAGE + 1), Refusal.TOO_LONG),
        ([], Refusal.UNDECODABLE),
        ({"updates": 5}, Refusal.UNDECODABLE),
        ({"updates": [{"values": [{"value": 5}]}]}, Refusal.UNDECODABLE),
        ({"requestId": "1", "state": "COMPLETED"}, Refusal.UNUSED),
        (delta({"environment.depth.belowKeel": 5.0}), Refusal.UNUSED),
        (delta({}), Refusal.UNUSED),
        ({"context": OTHER, "updates": []}, Refusal.NOTHING_TOLD),
        (delta({"navigation.speedOverGround": None}), Refusal.NOTHING_TOLD),
        (delta({"navigation.speedOverGround": "fast"}), Refusal.UNDECODABLE),
        (delta({"navigation.speedOverGround": True}), Refusal.UNDECODABLE),
        (delta({"navigation.position": {"latitude": 5}}), Refusal.UNDECODABLE),
        (delta({"navigation.position": [1, 2]}), Refusal.UNDECODABLE),
        (delta({"navigation.headingTrue": 1.0}, timestamp="today"), Refusal.UNDECODABLE),
        (
            delta({"navigation.headingTrue": 1.0}, timestamp="0001-01-01T00:00:00+23:59"),
            Refusal.UNDECODABLE,
        ),
        (
            delta({"navigation.position": {"latitude": 1, "longitude": 1}}, "shore.basestations.x"),
            Refusal.NO_SHIP,
        ),
        (delta({"navigation.headingTrue": 1.0}, "atons.x"), Refusal.NO_SHIP),
        (delta({"navigation.headingTrue": 1.0}, STATION), Refusal.NO_SHIP),
    ],
)  # fmt: skip
def test_every_refusal_has_its_reason(message, why):
    reports, refused = read(message)
    assert reports == []
    assert refused == {why: 1}


def test_one_value_that_cannot_be_read_spoils_no_other():
    (report,), _ = read(
        delta({"navigation.speedOverGround": "fast", "navigation.headingTrue": math.pi})
    )
    assert report.speed_m_s is None
    assert report.heading_rad == pytest.approx(math.pi)
