import json
import math
from datetime import UTC, datetime

import pytest
from tests.feeds.live import SHIP, shown

from glasshelm.ais import signalk_deltas
from glasshelm.ais.reports import Counts, RejectReason
from glasshelm.ais.signalk_deltas import MAX_MESSAGE_BYTES, DeltaDecoder
from glasshelm.live.traffic_picture import TrafficPicture

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
    reader = DeltaDecoder(counts, own)
    reports = []
    for message in messages:
        raw = message if isinstance(message, str | bytes) else json.dumps(message)
        reports += reader.decode(raw)
    assert counts.pending == 0
    return reports, {why: n for why, n in counts.rejected.items() if n}


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
    assert (report.id, report.name, report.ship_type) == ("276780000", "MEGASTAR", "60")
    assert report.time == datetime(2014, 8, 15, 19, 0, 1, 40_000, tzinfo=UTC)
    assert (report.latitude_deg, report.longitude_deg) == (59.86, 24.8)
    assert (report.speed_m_s, report.course_rad, report.heading_rad) == (14.91, 3.48, 3.45)
    assert (report.rate_of_turn_rad_s, report.length_m, report.beam_m) == (0.0003, 212.0, 30.6)
    assert not report.is_own


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


UUID = "vessels.urn:mrn:signalk:uuid:0d95e282-3e1f-4521-8c30-8288addbdbab"
HERE = {"navigation.position": {"latitude": 59.5, "longitude": 24.5}}


@pytest.mark.parametrize(
    "told",
    [
        {"": {"mmsi": "257999990", "name": "X"}},
        {"": {"mmsi": 257999990}},
        {"mmsi": "257999990"},
        {"mmsi": 257999990},
    ],
)
def test_one_context_is_one_ship_whose_mmsi_is_told_later(told):
    reports, refused = read(HELLO, delta(HERE, UUID), delta(told, UUID), delta(HERE, UUID))
    assert refused == {}
    assert [r.id for r in reports] == [UUID.removeprefix("vessels."), "257999990", "257999990"]
    assert [r.previous_id for r in reports] == [None, UUID.removeprefix("vessels."), None]
    # Told with a position, and before anything else.
    reports, _ = read(HELLO, delta(told | HERE, UUID), delta(HERE, UUID))
    assert {r.id for r in reports} == {"257999990"}


def test_the_number_of_a_context_is_hers_whatever_is_told():
    (first, second), _ = read(
        HELLO, delta(HERE | {"": {"mmsi": "257999990"}}), delta(HERE, OTHER.replace("27", "027"))
    )
    assert (first.id, first.previous_id, second.id) == ("276780000", None, "276780000")
    reports, refused = read(HELLO, delta({"mmsi": "002766140"}, UUID), delta(HERE, UUID))
    # Whoever was taken for a ship before is let go by the picture.
    assert [(report.id, report.previous_id is not None) for report in reports] == [
        ("2766140", True)
    ]
    assert refused == {RejectReason.NO_SHIP: 1}


def test_own_ship_may_be_named_by_an_mmsi_that_is_told_later():
    reports, _ = read(delta({"mmsi": "257999990"}, UUID), delta(HERE, UUID), own="257999990")
    assert [r.is_own for r in reports] == [True, True]


def test_the_contexts_that_are_remembered_are_bounded(monkeypatch):
    monkeypatch.setattr(signalk_deltas, "MAX_LEARNT", 10)
    reader = DeltaDecoder(Counts())
    for k in range(100):
        reader.decode(json.dumps(delta({"mmsi": 257000000 + k}, f"vessels.urn:x{k}")))
    assert len(reader._learnt) == 10
    long = "x" * 500_000
    assert read(delta(HERE, f"vessels.{long}")) == ([], {RejectReason.UNDECODABLE: 1})
    (report,), _ = read(delta({"name": long}))
    assert len(report.name) <= 64


@pytest.mark.parametrize(
    "values",
    [
        {"navigation": {"speedOverGround": 5.0, "position": HERE["navigation.position"]}},
        {"": {"navigation": {"speedOverGround": 5.0, "position": {"value": None}}}},
        {"": {"navigation": {"speedOverGround": {"value": 5.0}, "state": {"value": "x"}}}},
    ],
)
def test_nested_objects_are_read_as_their_paths(values):
    (report,), _ = read(HELLO, delta(values))
    assert report.speed_m_s == 5.0


ROUTE = {"navigation.course.nextPoint": {"position": {"latitude": 59.5, "longitude": 24.5}}}


@pytest.mark.parametrize(
    "null",
    [
        {"navigation.course.nextPoint": None},
        {"navigation.course.nextPoint": {"position": None}},
        {"navigation.course.nextPoint.position": None},
        {"navigation.course": None},
        {"navigation.course": {"nextPoint": None, "activeRoute": None}},
        {"navigation.course.activeRoute": None},
        {"navigation": {"course": {"nextPoint": None}}},
    ],
)
def test_a_null_ends_the_route_that_was_told(null):
    (_, ended), _ = read(HELLO, delta(ROUTE, None), delta(null, None))
    assert ended.route_ended
    assert ended.waypoint_latitude_deg is None
    # The same of a route that nobody told, or another part of the tree told: nothing.
    assert read(HELLO, delta(null, None))[1] == {RejectReason.EMPTY: 1}
    other = {"navigation.courseRhumbline.nextPoint": {"latitude": 59.5, "longitude": 24.5}}
    reports, _ = read(HELLO, delta(other, None), delta(null, None))
    assert [r.route_ended for r in reports] == [False]
    # Other ships have no route here.
    assert read(HELLO, delta(ROUTE, None), delta(null))[1] == {RejectReason.EMPTY: 1}


def test_a_waypoint_without_a_route_is_one():
    (report,), _ = read(HELLO, delta(ROUTE | {"navigation.course.activeRoute": None}, None))
    assert report.waypoint_latitude_deg == 59.5
    assert not report.route_ended


def test_a_null_ends_what_a_sensor_said():
    paths = {
        "navigation.speedOverGround": "speed_m_s",
        "navigation.courseOverGroundTrue": "course_rad",
        "navigation.headingTrue": "heading_rad",
        "navigation.rateOfTurn": "rate_of_turn_rad_s",
        "steering.rudderAngle": "rudder_rad",
    }
    for path, name in paths.items():
        (report,), _ = read(HELLO, delta({path: None}))
        assert report.cleared == (name,)


@pytest.mark.parametrize(
    ("stamp", "seconds"),
    [
        ("2014-08-15T19:00:05.250Z", 5.25),
        ("2014-08-15T19:0:5.25Z", 5.25),
        ("2014-8-15T19:00:05Z", 5),
        ("2014-08-15 19:00:05", 5),
        ("2014-08-15T19:00:05,250000001", 5.25),
        ("2014-08-15T22:00:05+03:00", 5),
        ("2014-08-15T17:30:05-0130", 5),
        ("2014-08-15t18:59:60z", 0),
        (1_408_129_205, 5),
        (1_408_129_205.25, 5.25),
        ("1408129205", 5),
    ],
)
def test_other_forms_of_a_time(stamp, seconds):
    (report,), _ = read(HELLO, delta(HERE, timestamp=stamp))
    assert report.time.timestamp() == 1_408_129_200 + seconds


@pytest.mark.parametrize(
    "stamp",
    [
        "now", " ", "2014-08-15", "19:00:05", "2014-13-15T19:00:05Z", "2014-08-15T19:00:61Z",
        "2014-08-15T25:00:05Z", "9999-12-31T23:59:59-23:59", "0001-01-01T00:00:00+23:59",
        "2014-08-15T19:00:05+99:99", 1e300, -5, True, [1], {"s": 1}, 10**40, "9" * 30, "\u0665",
    ],
)  # fmt: skip
def test_a_time_that_is_none_is_refused(stamp):
    assert read(HELLO, delta(HERE, timestamp=stamp)) == ([], {RejectReason.UNDECODABLE: 1})


def test_an_update_without_a_time_is_of_the_time_of_the_stream():
    first, last = delta(HERE), delta(HERE, timestamp=None)
    reports, _ = read(HELLO, first, last)
    assert (reports[1].time - reports[0].time).total_seconds() < 60


def test_a_ship_under_two_contexts_is_there_once():
    picture = TrafficPicture()
    reader = DeltaDecoder(Counts())

    def hear(context, second, values):
        stamp = f"2014-08-15T19:00:{second:02d}Z"
        for report in reader.decode(json.dumps(delta(values, context, stamp))):
            picture.update(report)

    moving = {"navigation.speedOverGround": 5.0, "navigation.courseOverGroundTrue": 1.0}
    reader.decode(json.dumps(HELLO))
    there = {"navigation.position": {"latitude": 59.52, "longitude": 24.5}}
    hear(None, 0, HERE | moving)
    hear(UUID, 1, there | moving)
    assert [*shown(picture)] == [UUID.removeprefix("vessels.")]
    slots = [t.id for t in picture.scenario(picture.now(), SHIP).targets]
    hear(UUID, 5, {"": {"mmsi": "257999990", "name": "UUID SHIP"}})
    assert {i: t.name for i, t in shown(picture).items()} == {"257999990": "UUID SHIP"}
    assert [t.id for t in picture.scenario(picture.now(), SHIP).targets].index("257999990") == next(
        k for k, one in enumerate(slots) if one
    )
    # AIS tells of her as well.
    hear("vessels.urn:mrn:imo:mmsi:257999990", 6, there | moving)
    hear(UUID, 8, there | moving)
    assert [*shown(picture)] == ["257999990"]
    other = "vessels.urn:mrn:signalk:uuid:2"
    hear(other, 9, there | moving)
    hear(other, 10, {"mmsi": "257999990"})
    assert [*shown(picture)] == ["257999990"]


@pytest.mark.parametrize("context", [HELLO["self"], "vessels.self", None])
def test_own_ship_is_the_self_of_the_hello(context):
    (report,), _ = read(HELLO, delta({"steering.rudderAngle": 0.1}, context))
    assert report.is_own
    assert report.rudder_rad == 0.1


def test_own_ship_may_be_named_by_her_mmsi():
    (report,), _ = read(delta({"navigation.speedOverGround": 1.0}), own="276780000")
    assert report.is_own
    (report,), _ = read({"self": OTHER}, delta({"navigation.speedOverGround": 1.0}))
    assert report.is_own
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
        ("", RejectReason.MALFORMED),
        ("{", RejectReason.MALFORMED),
        (b"\xff\xfe", RejectReason.MALFORMED),
        ('{"updates":[{"values":[{"path":"","value":' + "[" * 100_000, RejectReason.MALFORMED),
        (" " * (MAX_MESSAGE_BYTES + 1), RejectReason.TOO_LONG),
        ([], RejectReason.UNDECODABLE),
        ({"updates": 5}, RejectReason.UNDECODABLE),
        ({"updates": [{"values": [{"value": 5}]}]}, RejectReason.UNDECODABLE),
        ({"requestId": "1", "state": "COMPLETED"}, RejectReason.UNUSED_KIND),
        (delta({"environment.depth.belowKeel": 5.0}), RejectReason.UNUSED_KIND),
        (delta({}), RejectReason.UNUSED_KIND),
        ({"context": OTHER, "updates": []}, RejectReason.EMPTY),
        (delta({"navigation.position": None}), RejectReason.EMPTY),
        (delta({"name": None, "design.length": None}), RejectReason.EMPTY),
        (delta({"mmsi": True}), RejectReason.EMPTY),
        (delta({"navigation.speedOverGround": "fast"}), RejectReason.UNDECODABLE),
        (delta({"navigation.speedOverGround": True}), RejectReason.UNDECODABLE),
        (delta({"navigation.position": {"latitude": 5}}), RejectReason.UNDECODABLE),
        (delta({"navigation.position": [1, 2]}), RejectReason.UNDECODABLE),
        (delta({"navigation.headingTrue": 1.0}, timestamp="today"), RejectReason.UNDECODABLE),
        (
            delta({"navigation.headingTrue": 1.0}, timestamp="0001-01-01T00:00:00+23:59"),
            RejectReason.UNDECODABLE,
        ),
        (
            delta({"navigation.position": {"latitude": 1, "longitude": 1}}, "shore.basestations.x"),
            RejectReason.NO_SHIP,
        ),
        (delta({"navigation.headingTrue": 1.0}, "atons.x"), RejectReason.NO_SHIP),
        (delta({"navigation.headingTrue": 1.0}, STATION), RejectReason.NO_SHIP),
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


@pytest.mark.parametrize("name", ["²", "٢٥٧٠٦٣٧٧٠", "urn:mrn:imo:mmsi:²", "½", "1e5", "-5", "0x10"])
def test_a_name_of_other_digits_is_a_name(name):
    reports, _ = read(HELLO, delta({"navigation.speedOverGround": 5.0}, context=f"vessels.{name}"))
    assert [report.id for report in reports] == [name]


@pytest.mark.parametrize(
    "told", ["0276780000", "276780000.0", 276780000.0, 276780000, " 276780000 ", "276780000."]
)
def test_an_mmsi_in_any_form_is_that_ship(told):
    reports, _ = read(
        HELLO,
        delta({"": {"mmsi": told}, "navigation.speedOverGround": 5.0}, context="vessels.x"),
    )
    assert [report.id for report in reports] == ["276780000"]


@pytest.mark.parametrize("told", [True, "27678000A", "1e8", 2.5, float(10**12), [], {}, "²"])
def test_what_is_no_mmsi_names_nobody(told):
    reports, _ = read(
        HELLO,
        delta({"": {"mmsi": told}, "navigation.speedOverGround": 5.0}, context="vessels.x"),
    )
    assert [report.id for report in reports] == ["x"]


@pytest.mark.parametrize(
    "null",
    [
        {"navigation.course.nextPoint.position": {"latitude": None, "longitude": None}},
        {"navigation.course.nextPoint": {"position": {"value": None}}},
        {"navigation.course": {"nextPoint": {"value": None}}},
        {"navigation.course.nextPoint": None},
    ],
)
def test_every_form_of_null_ends_a_route(null):
    own = HELLO["self"]
    point = {"navigation.course.nextPoint": {"position": {"latitude": 59.0, "longitude": 24.0}}}
    reports, refused = read(HELLO, delta(point, context=own), delta(null, context=own))
    assert [report.route_ended for report in reports] == [False, True]
    assert refused == {}


@pytest.mark.parametrize("number", ["992571111", "111257500", "002570001"])
def test_what_turns_out_to_be_no_ship_is_one_no_more(number):
    counts, picture = Counts(), TrafficPicture()
    reader = DeltaDecoder(counts)
    position = {"navigation.position": {"latitude": 59.0, "longitude": 24.0}}
    for told in (position, {"": {"mmsi": number, "name": "BUOY"}}, position):
        for report in reader.decode(json.dumps(delta(told, context="vessels.urn:x"))):
            picture.update(report)
    assert len(picture) == 0


@pytest.mark.parametrize(
    "stamp", [1408129201040, "1408129201.04", "1408129201040000", "2014-8-15T19:00:01.040Z"]
)
def test_counts_since_1970_are_told_apart(stamp):
    (report,), _ = read(HELLO, delta({"navigation.speedOverGround": 5.0}, timestamp=stamp))
    assert report.time == datetime(2014, 8, 15, 19, 0, 1, 40_000, tzinfo=UTC)
