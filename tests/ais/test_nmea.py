import itertools
import math
from datetime import UTC, datetime

import pytest
from tests.ais.nmea_lines import POSITION, STATIC, TIME, ais, sentence, tagged

from glasshelm.ais.multipart import MAX_PENDING
from glasshelm.ais.nmea_decoder import NmeaDecoder
from glasshelm.ais.nmea_sentence import MAX_SENTENCE_BYTES
from glasshelm.ais.reports import Counts, RejectReason
from glasshelm.ship.nomoto import KNOT_M_S


def read(*lines, live=False, own=None):
    counts = Counts()
    reader = NmeaDecoder(counts, live=live, own_mmsi=own)
    reports = list(reader.decode(iter(lines)))
    reader.close()
    assert counts.pending == 0
    return reports, counts


def refused(counts):
    return {why: n for why, n in counts.rejected.items() if n}


def test_a_position_in_si_units_at_the_time_of_its_tag_block():
    (report,), counts = read(*ais(POSITION))
    assert report.id == "211000001"
    assert report.time == datetime(2014, 8, 15, 19, tzinfo=UTC)
    assert (report.latitude_deg, report.longitude_deg) == (59.5, 24.5)
    assert report.speed_m_s == pytest.approx(12.3 * KNOT_M_S)
    assert report.course_rad == pytest.approx(math.radians(45.6))
    assert report.heading_rad == pytest.approx(math.radians(44))
    assert report.rate_of_turn_rad_s is None
    assert not report.is_own
    assert (counts.received, counts.accepted) == (1, 1)


def test_milliseconds_in_a_tag_block():
    (report,), _ = read(*ais(POSITION, TIME * 1000 + 250))
    assert report.time.timestamp() == TIME + 0.25


def test_codes_for_not_available_are_absent():
    void = POSITION | {"speed": 102.3, "course": 360.0, "heading": 511}
    (report,), _ = read(*ais(void))
    assert report.latitude_deg == 59.5
    assert (report.speed_m_s, report.course_rad, report.heading_rad) == (None, None, None)
    _, counts = read(*ais(POSITION | {"lat": 91.0, "lon": 181.0}))
    assert refused(counts) == {RejectReason.EMPTY: 1}


@pytest.mark.parametrize("turn", [10.0, -20.0])
def test_rate_of_turn(turn):
    (report,), _ = read(*ais(POSITION | {"turn": turn}))
    # AIS codes the square root of it: what comes back is within 5 %.
    assert report.rate_of_turn_rad_s == pytest.approx(math.radians(turn / 60), rel=0.05)


def test_identity_in_two_parts_counts_both():
    lines = ais(STATIC)
    assert len(lines) == 2
    (report,), counts = read(*lines)
    assert (report.name, report.length_m, report.beam_m) == ("ALPHA BRAVO", 150.0, 22.0)
    assert report.ship_type == "70"
    assert report.latitude_deg is None
    assert (counts.received, counts.accepted) == (2, 2)


def test_parts_of_several_messages_in_turn():
    ships = [STATIC | {"mmsi": 211000001 + k, "shipname": f"SHIP {k}"} for k in range(4)]
    parts = zip(*(ais(ship, seq=k + 1) for k, ship in enumerate(ships)), strict=True)
    reports, counts = read(*itertools.chain(*parts))
    assert [report.name for report in reports] == [f"SHIP {k}" for k in range(4)]
    assert counts.accepted == 8


def test_missing_parts_are_counted():
    first, second = ais(STATIC)
    _, counts = read(second)
    assert refused(counts) == {RejectReason.INCOMPLETE: 1}
    reports, counts = read(first, *ais(STATIC))
    assert len(reports) == 1
    assert refused(counts) == {RejectReason.INCOMPLETE: 1}
    _, counts = read(first)
    assert refused(counts) == {RejectReason.INCOMPLETE: 1}


def test_what_waits_for_other_parts_is_bounded():
    counts = Counts()
    reader = NmeaDecoder(counts, live=False)
    for k in range(10 * MAX_PENDING):
        # No device counts so far; the slot of a message is (talker, channel, number).
        first = f"AIVDM,2,1,{k},A,{'5' * 50},0"
        reader.decode_line(tagged(sentence(first).replace(b"$", b"!")))
    assert counts.pending == MAX_PENDING
    assert counts.rejected[RejectReason.INCOMPLETE] == 9 * MAX_PENDING


def test_own_ship_by_vdo_and_by_number():
    (report,), _ = read(*ais(POSITION, kind="VDO"))
    assert report.is_own
    (report,), _ = read(*ais(POSITION), own="211000001")
    assert report.is_own


@pytest.mark.parametrize(
    ("body", "said"),
    [
        ("HEHDT,123.4,T", {"heading_rad": math.radians(123.4)}),
        ("HETHS,123.4,A", {"heading_rad": math.radians(123.4)}),
        ("HCHDG,100.0,2.0,W,10.0,E", {"heading_rad": math.radians(108)}),
        ("HCHDG,355.0,,,10.0,E", {"heading_rad": math.radians(5)}),
        ("TIROT,-30.0,A", {"rate_of_turn_rad_s": math.radians(-0.5)}),
        ("IIRSA,-5.0,A,,V", {"rudder_rad": math.radians(-5)}),
        (
            "GPRMB,A,0.66,L,003,004,5930.00,N,02430.00,W,1.3,52.5,0.5,V,A",
            {"waypoint_latitude_deg": 59.5, "waypoint_longitude_deg": -24.5},
        ),
        (
            "GPRMB,V,0.66,L,003,004,5930.00,N,02430.00,W,1.3,52.5,0.5,V,A",
            {"route_ended": True, "waypoint_latitude_deg": None},
        ),
        ("GPRMB,A,0.66,L,003,004,,,,,1.3,52.5,0.5,V,A", {"route_ended": True}),
        (
            "GPVTG,90.0,T,85.0,M,10.0,N,18.52,K,A",
            {"course_rad": math.pi / 2, "speed_m_s": 10 * KNOT_M_S},
        ),
        ("GPVTG,,T,,M,,N,36.0,K,A", {"speed_m_s": 10.0}),
        ("GPGLL,5930.00,N,02430.00,W,190000,A,A", {"latitude_deg": 59.5, "longitude_deg": -24.5}),
        ("GPGGA,190000,5930.00,S,02430.00,E,1,08,0.9,0,M,0,M,,", {"latitude_deg": -59.5}),
        (
            "GNRMC,190001.00,A,5930.00,N,02430.00,E,7.0,180.0,150814,,,A",
            {"latitude_deg": 59.5, "speed_m_s": 7 * KNOT_M_S, "course_rad": math.pi},
        ),
    ],
)
def test_own_sensors(body, said):
    (report,), counts = read(tagged(sentence(body)))
    assert report.is_own
    for name, value in said.items():
        assert getattr(report, name) == pytest.approx(value), name
    assert counts.accepted == 1


@pytest.mark.parametrize(
    "body",
    [
        "GPRMC,190001.00,V,5930.00,N,02430.00,E,7.0,180.0,150814,,,N",
        "GPRMC,190001.00,A,5930.00,N,02430.00,E,7.0,180.0,150814,,,S",
        "TIROT,-30.0,V",
        "IIRSA,-5.0,V,,V",
        "GPRMB,A,0.66,L,003,004,5930.00,N,02430.00,W,1.3,52.5,0.5,V,S",
        "HEHDT,,T",
        "HCHDG,100.0,,,,",
        "GPGGA,190000,5930.00,N,02430.00,E,0,00,,,M,,M,,",
    ],
)
def test_sensors_that_are_not_valid_tell_nothing(body):
    reports, counts = read(tagged(sentence(body)))
    assert reports == []
    assert refused(counts) == {RejectReason.EMPTY: 1}


@pytest.mark.parametrize(
    ("line", "why"),
    [
        (b"hello", RejectReason.MALFORMED),
        (b"\\c:1408129200", RejectReason.MALFORMED),
        (b"!AIVDM,1,1,,A", RejectReason.MALFORMED),
        (b"$GPRMC,1,2,3", RejectReason.MALFORMED),
        (b"$HEHDT,123.4,T*00", RejectReason.CHECKSUM),
        (b"\\c:1408129200*00\\$HEHDT,123.4,T*2D", RejectReason.CHECKSUM),
        (b"$HEHDT,123.4,T*ZZ", RejectReason.CHECKSUM),
        (b"$" + b"A" * MAX_SENTENCE_BYTES, RejectReason.TOO_LONG),
        (sentence("GPGSV,1,1,00"), RejectReason.UNUSED_KIND),
        (sentence("HEHDT,north,T"), RejectReason.UNDECODABLE),
        (sentence("HEHDT,nan,T"), RejectReason.UNDECODABLE),
        (sentence("GPRMC,190001.00,A"), RejectReason.UNDECODABLE),
        (sentence("GPGLL,5990.00,N,02430.00,W,190000,A,A"), RejectReason.UNDECODABLE),
        (sentence("HEHDT,123.4,T"), RejectReason.NO_TIME),
        (ais(POSITION, None)[0], RejectReason.NO_TIME),
        (ais(POSITION)[0][:-1] + b"G", RejectReason.CHECKSUM),
        (ais({"type": 4, "mmsi": 2300000})[0], RejectReason.NO_SHIP),
        (ais(POSITION | {"mmsi": 992301234})[0], RejectReason.NO_SHIP),
        (ais(POSITION | {"mmsi": 111230001})[0], RejectReason.NO_SHIP),
        (ais({"type": 8, "mmsi": 2, "dac": 1, "fid": 1, "data": b"\x00"})[0],
         RejectReason.UNUSED_KIND),
    ],
)  # fmt: skip
def test_every_refusal_has_its_reason(line, why):
    reports, counts = read(line)
    assert reports == []
    assert refused(counts) == {why: 1}


def test_an_empty_line_is_nothing():
    _, counts = read(b"", b"\r\n", b"  ")
    assert counts.received == 0


def test_a_live_stream_without_times_is_dated_by_arrival():
    before = datetime.now(UTC)
    (report,), _ = read(*ais(POSITION, None), live=True)
    assert before <= report.time <= datetime.now(UTC)


def test_what_has_no_time_in_a_tagged_stream_has_that_of_the_stream():
    for live in (True, False):
        reports, _ = read(*ais(POSITION), sentence("HEHDT,123.4,T"), live=live)
        assert abs((reports[1].time - reports[0].time).total_seconds()) < 5


def test_rmc_is_the_clock_of_a_file_without_tag_blocks():
    rmc = "GPRMC,190001.50,A,5930.00,N,02430.00,E,7.0,180.0,150814,,,A"
    reports, counts = read(*ais(POSITION, None), sentence(rmc), *ais(POSITION, None))
    assert [report.is_own for report in reports] == [True, False]
    assert {report.time.timestamp() for report in reports} == {TIME + 1.5}
    assert refused(counts) == {RejectReason.NO_TIME: 1}


def test_counts_in_words():
    _, counts = read(*ais(POSITION), b"hello", b"hello")
    assert counts.summary() == (
        "heard 3 sentences: 1 used, 2 not of the form of a sentence or message"
    )
