"""Lines are read whole: fields that are cut, what stands beside a sentence, parts, minutes."""

import pytest
from tests.ais.nmea_lines import POSITION, STATIC, TIME, ais, cut, sentence, tagged

from glasshelm.ais.nmea_decoder import NmeaDecoder
from glasshelm.ais.nmea_sensors import parse_sensor_sentence
from glasshelm.ais.nmea_sentence import nmea_checksum
from glasshelm.ais.reports import Counts, RejectReason

CLASS_B = POSITION | {"type": 18}
LONG_RANGE = {k: v for k, v in POSITION.items() if k != "heading"} | {"type": 27, "speed": 12}
#: The bit before which each field ends (ITU-R M.1371-5).
ENDS = [
    (POSITION, 116, {"course_rad": 128, "heading_rad": 137}),
    (CLASS_B, 112, {"course_rad": 124, "heading_rad": 133}),
    (LONG_RANGE, 79, {"speed_m_s": 85, "course_rad": 94}),
]


def read(*lines, live=False):
    counts = Counts()
    reader = NmeaDecoder(counts, live=live)
    reports = list(reader.decode(iter(lines)))
    reader.close()
    assert counts.pending == 0
    return reports, {why: n for why, n in counts.rejected.items() if n}


@pytest.mark.parametrize(("message", "placed", "ends"), ENDS)
def test_a_field_in_which_a_message_ends_is_not_told(message, placed, ends):
    ((whole,), _), length = read(tagged(cut(message, 168 if placed > 79 else 96))), 168
    for bits in range(6, length if placed > 79 else 96):
        reports, refused = read(tagged(cut(message, bits)))
        if bits < placed:
            assert (reports, refused) == ([], {RejectReason.UNDECODABLE: 1}), bits
            continue
        (report,) = reports
        assert report.latitude_deg == whole.latitude_deg
        assert report.longitude_deg == whole.longitude_deg
        for name, end in ends.items():
            expected = getattr(whole, name) if bits >= end else None
            assert getattr(report, name) == expected, (bits, name)


@pytest.mark.parametrize(
    ("message", "ends"),
    [
        (STATIC, {"name": 232, "ship_type": 240, "length_m": 258, "beam_m": 270}),
        (POSITION | STATIC | {"type": 19}, {"name": 263, "ship_type": 271, "length_m": 289}),
        ({"type": 24, "partno": 0, "mmsi": 1, "shipname": "ALPHA"}, {"name": 160}),
        (STATIC | {"type": 24, "partno": 1}, {"ship_type": 48, "length_m": 150, "beam_m": 162}),
    ],
)
def test_a_cut_identity_tells_what_is_whole(message, ends):
    for bits in range(6, 312, 3):
        reports, refused = read(tagged(cut(message, bits)))
        told = {name for name, end in ends.items() if bits >= end}
        if reports:
            assert {n for n in ends if getattr(reports[0], n) is not None} <= told, bits
        else:
            assert refused == {RejectReason.UNDECODABLE: 1}, bits


def test_characters_that_carry_no_bits_are_no_message():
    body = b"AIVDM,1,1,,A,139>JhOP1s1h9g0R2u81j1H1P00X,0"
    line = sentence(body.decode()).replace(b"$", b"!")
    assert read(tagged(line)) == ([], {RejectReason.UNDECODABLE: 1})


@pytest.mark.parametrize(
    "told", [TIME, TIME * 10**3, TIME * 10**6, TIME * 10**9, f"{TIME}.0", f"{TIME}.000"]
)
def test_seconds_and_their_parts_are_told_apart(told):
    (report,), _ = read(*ais(POSITION, told))
    assert report.time.timestamp() == TIME


@pytest.mark.parametrize("told", ["0", "1", "2024", "-5", "99999999999", "1e9", "noon", "9" * 40])
def test_an_impossible_time_is_told_as_such(told):
    assert read(*ais(POSITION, told)) == ([], {RejectReason.INVALID_TIME: 1})


@pytest.mark.parametrize(
    "around",
    [
        b"%s,1408129200",
        b"%s,1408129200.5",
        b"%s,rEEA,1408129200",
        b"%s,s12345,d-100,T50.12,r003669959,1408129200",
        b"%s\t2014-08-15T19:00:00Z",
        b"%s 2014-08-15 19:00:00",
        b"1408129200 %s",
        b"1408129200000;%s",
        b"2014-08-15 19:00:00 %s",
        b"[2014-08-15T21:00:00+02:00] %s",
        b"\xef\xbb\xbf1408129200,%s",
    ],
)
def test_a_time_beside_the_sentence_is_its_time(around):
    (report,), refused = read(around % ais(POSITION, None)[0])
    assert report.time.timestamp() == pytest.approx(TIME, abs=0.6)
    assert refused == {}


@pytest.mark.parametrize("beside", [b"%s,extra,text", b"%s \x07", b"\xef\xbb\xbf%s", b"%s,12,7"])
def test_what_stands_beside_a_sentence_does_no_harm(beside):
    (report,), refused = read(beside % ais(POSITION, None)[0], live=True)
    assert report.latitude_deg == 59.5
    assert refused == {}


def test_parts_in_any_order_are_one_message():
    first, second = ais(STATIC)
    (report,), refused = read(second, first)
    assert report.name == "ALPHA BRAVO"
    assert refused == {}


def test_parts_of_two_messages_are_not_mixed():
    _, second = ais(STATIC)
    between = [line for k in range(9) for line in ais(POSITION | {"mmsi": 211000010 + k})]
    other = ais(STATIC | {"mmsi": 211000002, "shipname": "OTHER", "to_bow": 30})
    reports, refused = read(second, *between, *other)
    assert refused == {RejectReason.INCOMPLETE: 1}
    assert (reports[-1].id, reports[-1].name, reports[-1].length_m) == ("211000002", "OTHER", 80.0)


def test_a_group_shares_the_time_of_its_first_line():
    first, second = (part.encode() for part in _untagged(STATIC))
    tag = tagged(first, group="1-2-77")
    body = b"g:2-2-77"
    rest = b"\\%s*%02X\\%s" % (body, _check(body), second)
    position = b"\\%s*%02X\\%s" % (body, _check(body), ais(POSITION, None)[0])
    (report,), _ = read(tag, rest)
    assert (report.name, report.time.timestamp()) == ("ALPHA BRAVO", TIME)
    reports, _ = read(tagged(sentence("HEHDT,1.0,T"), group="1-2-77"), position)
    assert reports[1].time.timestamp() == TIME


@pytest.mark.parametrize("damage", [b"*00", b"*5", b"*", b""])
def test_without_a_right_checksum_nothing_is_believed(damage):
    line = ais(POSITION, None)[0]
    reports, refused = read(tagged(line.partition(b"*")[0] + damage))
    assert reports == []
    assert sum(refused.values()) == 1


@pytest.mark.parametrize(
    "number", [0, 111_257_500, 2_570_000, 992_570_000, 1_000_000_000, (1 << 30) - 1]
)
def test_what_is_no_ship_is_none_whoever_reads_it(number):
    payload = ais(POSITION, None)[0].split(b",")[5]
    bits = int.from_bytes(bytes(_six(c) for c in payload[:7]), "big")
    assert bits  # the number stands in bits 8 to 38
    assert read(tagged(_with_number(payload, number))) == ([], {RejectReason.NO_SHIP: 1})


@pytest.mark.parametrize(
    ("fields", "west"),
    [
        (["5047.4450", "N", "00100.1020", "W"], 1 + 0.1020 / 60),
        (["5047.4450", "N", "100.1020", "W"], 1 + 0.1020 / 60),
        (["5047.4450", "N", "0100.1020", "W"], 1 + 0.1020 / 60),
        (["5047.4450", "N", "59.9618", "W"], 59.9618 / 60),
        (["5047.4450", "N", "1.1020", "W"], 1.1020 / 60),
        (["5047.4450", "N", "424.1230", "W"], 4 + 24.1230 / 60),
        (["5047", "N", "12424", "W"], 124 + 24 / 60),
        (["547.4450", "S", "00424.1230", "W"], 4 + 24.1230 / 60),
    ],
)
def test_minutes_are_the_two_digits_before_the_point(fields, west):
    assert parse_sensor_sentence("GLL", [*fields, "120000", "A"])["longitude_deg"] == pytest.approx(
        -west
    )


@pytest.mark.parametrize(
    "place",
    [
        ["50.7907", "N", "1.0017", "W"],  # degrees: or minutes?
        ["9100.00", "N", "00100.00", "W"],
        ["5000.00", "N", "18100.00", "W"],
        ["5060.00", "N", "00100.00", "W"],
        ["-5000.00", "N", "00100.00", "W"],
        ["50 00.00", "N", "00100.00", "W"],
        ["5e3", "N", "00100.00", "W"],
    ],
)
def test_a_place_that_may_be_another_is_refused(place):
    body = f"GPGLL,{','.join(place)},120000,A,A"
    assert read(tagged(sentence(body))) == ([], {RejectReason.UNDECODABLE: 1})


@pytest.mark.parametrize(
    ("clock", "date", "seconds"),
    [
        ("190001.50", "150814", 1.5),
        ("090001", "150814", 1 - 36000),
        ("90001.5", "150814", 1.5 - 36000),
    ],
)
def test_a_time_of_day_without_its_first_zero(clock, date, seconds):
    body = f"GPRMC,{clock},A,5930.00,N,02430.00,E,7.0,180.0,{date},,,A"
    (report,), _ = read(sentence(body))
    assert report.time.timestamp() == pytest.approx(TIME + seconds)


@pytest.mark.parametrize(
    ("clock", "date"),
    [("250000", "150814"), ("196100", "150814"), ("190001", "320814"), ("1", "1")],
)
def test_a_time_that_is_none_is_refused(clock, date):
    body = f"GPRMC,{clock},A,5930.00,N,02430.00,E,7.0,180.0,{date},,,A"
    assert read(sentence(body))[1] == {RejectReason.UNDECODABLE: 1}


def _untagged(message):
    return [line.decode() for line in ais(message, None)]


def _check(body):
    return nmea_checksum(body)


def _six(c):
    value = c - 48
    return value - 8 if value > 40 else value


def _with_number(payload, number):
    """The sentence of a payload with another number of its station in bits 8 to 38."""
    bits = "".join(f"{_six(c):06b}" for c in payload)
    bits = bits[:8] + f"{number:030b}" + bits[38:]
    values = [int(bits[k : k + 6], 2) for k in range(0, len(bits), 6)]
    body = b"AIVDM,1,1,,A,%s,0" % bytes(v + 48 if v < 40 else v + 56 for v in values)
    return b"!%s*%02X" % (body, _check(body))


@pytest.mark.parametrize(
    ("around", "times"),
    [
        (b"636012345;2014-08-15T19:00:00Z;%s", [TIME]),
        (b"970012345,1408129200,%s", [TIME]),
        (b"%s,636012345,1408129200", [TIME]),
        (b"%s,636012345", []),
    ],
)
def test_a_number_of_nine_digits_beside_a_sentence_is_no_time(around, times):
    reports, _ = read(around % ais(POSITION, None)[0])
    assert [report.time.timestamp() for report in reports] == times
