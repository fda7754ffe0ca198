"""Nothing that is heard does harm, and nothing that is heard is lost: each one is counted."""

import json
import random
from datetime import datetime

import pytest
from benchmarks.feeds_fuzz import (
    lines,
    messages,
    nmea,
    nmea_trial,
    recording,
    signalk,
    signalk_trial,
)
from hypothesis import given
from hypothesis import strategies as st

from glasshelm.ais.nmea_decoder import NmeaDecoder
from glasshelm.ais.reports import Counts, RejectReason, Report
from glasshelm.ais.signalk_deltas import DeltaDecoder
from glasshelm.live.traffic_picture import TrafficPicture
from glasshelm.ship.nomoto import SHIPS

COUNT = 3000


@pytest.mark.slow
@pytest.mark.parametrize(
    ("trial", "given_"),
    [
        (nmea_trial, lambda chance: lines(COUNT, chance, list(nmea(recording())))),
        (signalk_trial, lambda chance: messages(COUNT, chance, list(signalk(recording())))),
    ],
)
def test_mangled_traffic_is_counted_each_one(trial, given_):
    counts, picture = trial(list(given_(random.Random(7))))
    assert counts.received == COUNT
    assert counts.received == counts.accepted + sum(counts.rejected.values())
    assert counts.accepted > COUNT / 4
    assert sum(n > 0 for n in counts.rejected.values()) >= 4
    reports = picture.counts
    assert reports.received == reports.accepted + sum(reports.rejected.values())
    assert len(picture) > 20


@given(st.lists(st.binary(max_size=100).filter(lambda b: b.strip()), max_size=5))
def test_any_bytes_as_lines(given_):
    counts = Counts()
    reader = NmeaDecoder(counts, live=True)
    for line in given_:
        reader.decode_line(line)
    reader.close()
    assert counts.received == len(given_)
    assert counts.pending == 0


json_ = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=10),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner),
    max_leaves=8,
)
paths = st.sampled_from(
    ["", "navigation.position", "navigation.speedOverGround", "design.length", "x", "steering."]
)


@pytest.mark.slow
@given(
    st.fixed_dictionaries(
        {},
        optional={
            "context": st.sampled_from(["vessels.self", "vessels.", "shore.x", "", 5]) | json_,
            "updates": st.lists(
                st.fixed_dictionaries(
                    {},
                    optional={
                        "timestamp": st.datetimes().map(str) | json_,
                        "values": st.lists(st.fixed_dictionaries({"path": paths, "value": json_})),
                    },
                ),
                max_size=3,
            ),
            "self": json_,
        },
    )
)
def test_any_tree_as_signal_k(tree):
    counts = Counts()
    picture = TrafficPicture()
    for report in DeltaDecoder(counts).decode(json.dumps(tree)):
        picture.update(report)
    assert counts.received == 1
    assert counts.pending == 0
    assert picture.counts.pending == 0


number = st.none() | st.floats() | st.floats(-7, 7)
degrees = st.none() | st.floats() | st.floats(-180, 180)


@given(
    st.lists(
        st.builds(
            Report,
            id=st.sampled_from(["1", "2", "own", ""]) | st.text(max_size=5),
            time=st.datetimes() | st.just(datetime(2014, 8, 15)),
            latitude_deg=degrees,
            longitude_deg=degrees,
            course_rad=number,
            speed_m_s=number,
            heading_rad=number,
            rate_of_turn_rad_s=number,
            rudder_rad=number,
            length_m=number,
            name=st.none() | st.text(max_size=100),
            is_own=st.booleans(),
            previous_id=st.sampled_from([None, "1", "2", "own"]),
            route_ended=st.booleans(),
            cleared=st.just(()) | st.just(("course_rad", "speed_m_s", "heading_rad", "x")),
        ),
        max_size=6,
    ),
    st.datetimes(),
)
def test_any_reports_make_a_picture(reports, now):
    picture = TrafficPicture(slots=4)
    for report in reports:
        assert isinstance(picture.update(report), RejectReason | None)
    assert picture.counts.received == len(reports)
    assert picture.counts.pending == 0
    assert "\n" not in picture.status(now)
    for when in (now, picture.latest_time):
        if when is not None:
            picture.scenario(when, SHIPS["paper"])
