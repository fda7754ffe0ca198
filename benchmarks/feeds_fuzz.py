"""Mangled NMEA sentences and Signal K messages: does anything crash, is each one counted, how fast?

    python benchmarks/feeds_fuzz.py [--count 100000] [--seed 0]

Good sentences and messages are made of the bundled recording of the Gulf of Finland; two of
three are then mangled, half of those with their checksum made right again, so that
what is behind the checksum is tried as well. All reports go into one picture, of which a
scenario is made now and then. Prints how many were heard, understood and refused, by reason.
Exits with 1 if one is not counted.
"""

import argparse
import json
import math
import os
import platform
import random
import sys
import time
from collections.abc import Iterator, Sequence
from datetime import UTC, datetime
from importlib.resources import as_file, files

os.environ.setdefault("JAX_PLATFORMS", "cpu")

from pyais.encode import encode_dict
from pyais.messages import TagBlock

from glasshelm.ais.nmea_decoder import NmeaDecoder
from glasshelm.ais.nmea_sentence import MAX_SENTENCE_BYTES, nmea_checksum
from glasshelm.ais.reading import read_recording_file
from glasshelm.ais.reports import Counts
from glasshelm.ais.signalk_deltas import MAX_MESSAGE_BYTES, DeltaDecoder
from glasshelm.ais.table import OWN_SENSORS, ReportTable
from glasshelm.live.traffic_picture import TrafficPicture
from glasshelm.ship.nomoto import KNOT_M_S, SHIPS

#: A scenario is made after so many sentences or messages.
LOOK_EVERY = 2000
#: Of other ships (pyais writes AIVDO if nothing is said).
HEARD = {"talker_id": "AI", "sentence_type": "VDM"}


def recording() -> ReportTable:
    """The reports of the bundled recording in order of time."""
    with as_file(files("glasshelm") / "data" / "gulf_of_finland.csv.gz") as path:
        reports = read_recording_file(path).reports
    return reports.take(reports.time_s.argsort(kind="stable"))


def sentence(body: str) -> bytes:
    """A sentence with its checksum."""
    return f"${body}*{nmea_checksum(body.encode()):02X}".encode()


def nmea(reports: ReportTable) -> Iterator[bytes]:
    """Reports as lines of NMEA 0183: AIVDM with tag blocks; own ship as RMC, VTG, HDT, ROT, RSA."""
    tagged = set()
    for i in range(len(reports)):
        time_s, mmsi, latitude, longitude, sog, cog, heading = (
            column[i].item() for column in vars(reports).values()
        )
        tag = TagBlock.create(receiver_timestamp=str(round(time_s)), source_station="gof")  # pyright: ignore
        prefix = b"\\" + tag + b"\\"
        if mmsi == OWN_SENSORS:
            for line in own_sensors(time_s, latitude, longitude, sog, cog, heading):
                yield prefix + line
            continue
        message = {
            "type": 1, "mmsi": mmsi, "lat": latitude, "lon": longitude, "turn": -128,
            "speed": 102.3 if math.isnan(sog) else sog,
            "course": 360.0 if math.isnan(cog) else cog,
            "heading": 511 if math.isnan(heading) else round(heading) % 360,
        }  # fmt: skip
        for part in encode_dict(message, **HEARD):
            yield prefix + part.encode()
        if mmsi not in tagged:
            tagged.add(mmsi)
            static = {"type": 5, "mmsi": mmsi, "shipname": f"SHIP {mmsi}", "ship_type": 70}
            static |= {"to_bow": 100, "to_stern": 50, "to_port": 12, "to_starboard": 13}
            for part in encode_dict(static, **HEARD, seq_id=len(tagged) % 9 + 1):
                yield prefix + part.encode()


def own_sensors(
    time_s: float, latitude: float, longitude: float, sog: float, cog: float, heading: float
) -> Iterator[bytes]:
    """Own ship's sentences; a value that is NaN is an empty field."""

    def number(value: float, digits: int = 1) -> str:
        return "" if math.isnan(value) else f"{value:.{digits}f}"

    def degrees(value: float, width: int, sides: str) -> str:
        whole, minutes = divmod(abs(value) * 60, 60)
        return f"{int(whole):0{width}d}{minutes:08.5f},{sides[value < 0]}"

    when = datetime.fromtimestamp(time_s, UTC)
    place = f"{degrees(latitude, 2, 'NS')},{degrees(longitude, 3, 'EW')}"
    yield sentence(
        f"GPRMC,{when:%H%M%S.%f},A,{place},{number(sog)},{number(cog)},{when:%d%m%y},,,A"
    )
    yield sentence(f"GPVTG,{number(cog)},T,,M,{number(sog)},N,{number(sog * 1.852)},K,A")
    yield sentence(f"HEHDT,{number(heading)},T")
    yield sentence("TIROT,0.0,A")
    yield sentence("IIRSA,1.5,A,,V")


def signalk(reports: ReportTable) -> Iterator[str]:
    """Reports as Signal K messages, after the hello."""
    yield json.dumps({"name": "test", "version": "2", "self": "vessels.urn:mrn:signalk:uuid:1"})
    for i in range(len(reports)):
        time_s, mmsi, latitude, longitude, sog, cog, heading = (
            column[i].item() for column in vars(reports).values()
        )
        said = {
            "navigation.position": {"latitude": latitude, "longitude": longitude},
            "navigation.speedOverGround": sog * KNOT_M_S,
            "navigation.courseOverGroundTrue": math.radians(cog),
            "navigation.headingTrue": math.radians(heading),
            "": {"mmsi": str(mmsi), "name": f"SHIP {mmsi}"},
        }
        if mmsi == OWN_SENSORS:
            del said[""]
        context = "signalk:uuid:1" if mmsi == OWN_SENSORS else f"imo:mmsi:{mmsi}"
        values = [
            {"path": path, "value": value}
            for path, value in said.items()
            if not (isinstance(value, float) and math.isnan(value))
        ]
        stamp = datetime.fromtimestamp(time_s, UTC).isoformat().replace("+00:00", "Z")
        yield json.dumps(
            {
                "context": f"vessels.urn:mrn:{context}",
                "updates": [{"$source": "test", "timestamp": stamp, "values": values}],
            }
        )


def mangled(item: bytes, chance: random.Random) -> bytes:
    """Bytes with one to three faults of transmission."""
    data = bytearray(item)
    for _ in range(chance.randint(1, 3)):
        at = chance.randrange(len(data) + 1)
        end = min(len(data), at + chance.randint(1, 12))
        match chance.randrange(7):
            case 0:  # other bytes
                data[at:end] = chance.randbytes(end - at)
            case 1:  # other characters
                data[at:end] = bytes(chance.choices(range(32, 127), k=end - at))
            case 2:  # lost
                del data[at:end]
            case 3:  # cut off
                del data[at:]
            case 4:  # twice
                data[at:at] = data[at:end]
            case 5:  # two in one
                data += item[: chance.randrange(len(item) + 1)]
            case 6:  # endless
                if chance.random() < 0.02:
                    data[at:at] = b"0" * (MAX_SENTENCE_BYTES + 1)
    # A line end inside would make two lines of it.
    return bytes(data).replace(b"\n", b" ").replace(b"\r", b" ")


def made_right(line: bytes) -> bytes:
    """The same line with the checksum that its contents have."""
    start = max(line.rfind(b"!"), line.rfind(b"$"), 0)
    body, star, _ = line[start + 1 :].partition(b"*")
    return line[: start + 1] + body + b"*%02X" % nmea_checksum(body) if star else line


ODD = (
    None, True, -1, 0, 1e308, 10**30, "", "x", "NaN", [], {}, [[]], {"latitude": 91},
    "2014-08-15T19:00:00Z", "9999-12-31T23:59:59-23:59", "0001-01-01T00:00:00+23:59",
    {"overall": "long"}, {"latitude": 1, "longitude": None}, "vessels.self", "\x00",
)  # fmt: skip


def disordered(message: str, chance: random.Random) -> str:
    """JSON of which one part is another, is gone, or is there twice."""
    tree = json.loads(message)
    node = tree
    while True:
        keys = list(node) if isinstance(node, dict) else list(range(len(node)))
        if not keys:
            return json.dumps(tree)
        key = chance.choice(keys)
        if isinstance(node[key], dict | list) and node[key] and chance.random() < 0.7:
            node = node[key]
            continue
        match chance.randrange(3):
            case 0:
                node[key] = chance.choice(ODD)
            case 1:
                del node[key]
            case 2 if isinstance(node, list):
                node.append(node[key])
            case _:
                node[key] = [node[key]]
        return json.dumps(tree)


def lines(count: int, chance: random.Random, good: list[bytes]) -> Iterator[bytes]:
    """``count`` lines: good, mangled, mangled with the checksum right."""
    for i in range(count):
        line = good[i % len(good)]
        fault = chance.randrange(6)
        if fault >= 2:
            line = mangled(line, chance)
        if fault >= 4:
            line = made_right(line)
        yield line if line.strip() else b"?"  # an empty line is not heard


def messages(count: int, chance: random.Random, good: list[str]) -> Iterator[bytes]:
    """``count`` messages: good, mangled, of another order."""
    for i in range(count):
        message = good[i % len(good)]
        fault = chance.randrange(3)
        if fault == 0:
            yield message.encode()
        elif fault == 1:
            yield mangled(message.encode(), chance)
        elif chance.random() < 0.0005:
            yield b"[" * (MAX_MESSAGE_BYTES + 1 if chance.random() < 0.5 else 100_000)
        else:
            yield disordered(message, chance).encode()


def nmea_trial(given: Sequence[bytes]) -> tuple[Counts, TrafficPicture]:
    """Lines through the reader of NMEA into a picture."""
    counts, picture = Counts(), TrafficPicture("fuzz")
    reader = NmeaDecoder(counts, live=True)
    for i, line in enumerate(given):
        report = reader.decode_line(line)
        if report is not None:
            picture.update(report)
        _look(picture, i)
    reader.close()
    return counts, picture


def signalk_trial(given: Sequence[bytes]) -> tuple[Counts, TrafficPicture]:
    """Messages through the reader of Signal K into a picture."""
    counts, picture = Counts(), TrafficPicture("fuzz")
    reader = DeltaDecoder(counts)
    for i, message in enumerate(given):
        for report in reader.decode(message):
            picture.update(report)
        _look(picture, i)
    return counts, picture


def _look(picture: TrafficPicture, i: int) -> None:
    if i % LOOK_EVERY == LOOK_EVERY - 1:
        now = picture.latest_time
        if now is not None:
            picture.status(now)
            picture.scenario(now, SHIPS["paper"])


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=100_000, help="of both together")
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    machine = f"{platform.machine()}, {os.cpu_count()} cores, Python {platform.python_version()}"
    count, chance = options.count // 2, random.Random(options.seed)
    trials = {
        "NMEA 0183 sentences": (nmea_trial, lines(count, chance, list(nmea(recording())))),
        "Signal K messages": (signalk_trial, messages(count, chance, list(signalk(recording())))),
    }
    lost = 0
    for what, (trial, made) in trials.items():
        given = list(made)
        start = time.perf_counter()
        counts, picture = trial(given)
        spent = time.perf_counter() - start
        print(f"{what}: {count:,} in {spent:.1f} s, {count / spent:,.0f} a second ({machine})")
        _print(counts)
        print("  reports to the picture:")
        _print(picture.counts)
        print(f"  ships known at the end: {len(picture)}")
        for one, given in ((counts, count), (picture.counts, picture.counts.received)):
            lost += abs(given - one.received) + abs(one.pending)
    print("each one is counted" if lost == 0 else f"{lost} are not counted")
    return int(lost != 0)


def _print(counts: Counts) -> None:
    rows = {"heard": counts.received, "understood": counts.accepted}
    for name, number in (rows | {f"refused: {w}": n for w, n in counts.rejected.items()}).items():
        if number:
            print(f"  {number:>9,}  {name}")


if __name__ == "__main__":
    sys.exit(main())
