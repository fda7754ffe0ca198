"""Lines of NMEA 0183 for tests, with right checksums."""

from benchmarks.feeds_fuzz import sentence
from pyais.encode import encode_dict
from pyais.messages import TagBlock

from glasshelm.ais.nmea_sentence import nmea_checksum

TIME = 1_408_129_200  # 2014-08-15 19:00 UTC
POSITION = {
    "type": 1, "mmsi": 211000001, "lat": 59.5, "lon": 24.5, "speed": 12.3, "course": 45.6,
    "heading": 44, "turn": -128,
}  # fmt: skip
STATIC = {
    "type": 5, "mmsi": 211000001, "shipname": "ALPHA BRAVO", "to_bow": 100, "to_stern": 50,
    "to_port": 10, "to_starboard": 12, "ship_type": 70,
}  # fmt: skip


def tagged(line, time=TIME, **more):
    """A line behind a tag block; ``more`` as pyais calls its fields."""
    tag = TagBlock.create(receiver_timestamp=str(time), **more)
    return b"\\" + tag + b"\\" + line


def ais(message, time=TIME, kind="VDM", seq=1):
    """The lines of a message; without tag blocks if there is no time."""
    parts = encode_dict(message, talker_id="AI", sentence_type=kind, seq_id=seq)
    return [part.encode() if time is None else tagged(part.encode(), time) for part in parts]


def cut(message, bits):
    """The sentence of a message that ends after so many bits, as a receiver writes it."""
    payload = "".join(part.split(",")[5] for part in encode_dict(message))
    characters = -(-bits // 6)
    body = f"AIVDM,1,1,,A,{payload[:characters]},{characters * 6 - bits}".encode()
    return b"!%s*%02X" % (body, nmea_checksum(body))


__all__ = ["POSITION", "STATIC", "TIME", "ais", "cut", "sentence", "tagged"]
