"""What is said of a band: only what it proves, in the words of a helm."""

import math

import msgspec
import numpy as np
import pytest
from tests.voyages import Other, voyage

from glasshelm.certify.rudder_band import RudderBand
from glasshelm.frames.schema import (
    AlternativeBand,
    BySubTask,
    Manoeuvre,
    ManoeuvreBand,
    TargetBand,
)
from glasshelm.frames.schema import Band as Drawn
from glasshelm.frames.series import to_series
from glasshelm.report.band_text import (
    band_rows,
    certainty_text,
    full_band_text,
    short_band_text,
)
from glasshelm.report.current_sentence import current_sentence
from glasshelm.report.narrative import narrate
from glasshelm.ship.nomoto import KNOT_M_S

WITHIN = "while errors stay within 10 m, 0.5°, 0.1 kn"
SHIP = Other("Aurora", 3000.0, 3000.0, 270.0, share_deg=lambda k: 3.0)


def band(low_deg: float, high_deg: float, position_m: float = 10.0) -> Drawn:
    low, high = math.radians(low_deg), math.radians(high_deg)
    side = {1: "starboard", 0: None, -1: "port"}[RudderBand(low, high).certain_side]
    return Drawn(low, high, position_m, math.radians(0.5), 0.1 * KNOT_M_S, side)


def sailed(rudder_deg: float, *bands: Drawn | None):
    """A turn with this rudder, a frame for each band."""
    frames = voyage(
        np.linspace(0, 2.0 * len(bands), len(bands)).tolist(),
        [SHIP],
        rudder_deg=lambda k: rudder_deg,
        alone_deg=lambda k: rudder_deg - 3.0,
    )
    return [msgspec.structs.replace(f, band=b) for f, b in zip(frames, bands, strict=True)]


GOLDEN = [
    # rudder, band; what is certain; between which rudders
    (3.0, (2.13, 5.0), "certain: to starboard", "between 2.1° and 5.0° to starboard"),
    (-1.0, (-1.42, -0.61), "certain: to port", "between 0.6° and 1.5° to port"),
    (3.0, (0.2, 4.0), "side not certain", "between 0.2° and 4.0° to starboard"),
    (1.0, (-1.25, 3.0), "side not certain",
     "between 1.3° to port and 3.0° to starboard"),
    (0.1, (-0.31, 0.4), "certain: amidships", "between 0.4° to port and 0.4° to starboard"),
    (0.1, (-0.1, 0.7), "amidships not certain", "between 0.1° to port and 0.7° to starboard"),
    (0.4, (0.3, 0.8), "amidships not certain", "between 0.3° and 0.8° to starboard"),
    (5.0, (4.999, 5.0), "certain: to starboard", "between 4.9° and 5.0° to starboard"),
    (5.0, (5.0, 5.0), "certain: to starboard", "5.0° to starboard"),
]  # fmt: skip


@pytest.mark.parametrize(("rudder", "ends", "short", "between"), GOLDEN)
def test_golden_words(rudder, ends, short, between):
    frame = sailed(rudder, band(*ends))[0]
    assert short_band_text(frame) == short
    assert full_band_text(frame) == f"rudder {between} {WITHIN}"


def test_a_band_of_all_rudders_proves_nothing():
    frame = sailed(3.0, band(-5.0, 5.0))[0]
    assert short_band_text(frame) == "side not certain"
    assert full_band_text(frame) == f"any rudder is possible {WITHIN}"


def test_without_a_band_nothing_is_said():
    frame = sailed(3.0, None)[0]
    assert short_band_text(frame) == full_band_text(frame) == ""
    assert "certain" not in current_sentence([frame]).why
    assert not any("certain" in line.text for line in narrate(sailed(3.0, *[None] * 20)))


def test_the_sentence_of_an_instant_says_it_last_and_only_when_it_is():
    said = f"To starboard for certain {WITHIN}"
    assert current_sentence(sailed(3.0, band(2.0, 4.0))).why.endswith(f". {said}")
    assert "certain" not in current_sentence(sailed(3.0, band(0.1, 4.0))).why
    assert "certain" not in current_sentence(sailed(-3.0, band(2.0, 4.0))).why


def test_a_turn_is_certain_if_all_its_frames_are():
    sure, unsure = band(2.0, 4.0), band(-1.0, 4.0)
    other = band(2.0, 4.0, position_m=30.0)
    whole = to_series(sailed(3.0, *[sure] * 20))
    assert certainty_text(whole, np.arange(20)) == f"To starboard for certain {WITHIN}"
    for odd in (unsure, other, None):
        mixed = to_series(sailed(3.0, *[sure] * 10, odd, *[sure] * 9))
        assert certainty_text(mixed, np.arange(20)) == ""
        assert certainty_text(mixed, np.arange(10)) != ""
    told = [line.text for line in narrate(sailed(3.0, *[sure] * 20)) if line.kind == "turn"]
    assert told
    assert told[0].endswith(f" To starboard for certain {WITHIN}.")


def chosen(courses_deg: list[float], depth: float, low: float = 83.18, high: float = 84.41):
    """A frame on course 060°, with the band of its manoeuvre."""
    parts = [BySubTask(x, 0.0, x, 0.0) for x in (low, high)]
    choice = ManoeuvreBand(
        *parts,
        [TargetBand("Aurora", -1.0, 0.0, depth, 1_500.0)],
        [AlternativeBand("keep", 0.5, 2.0)],
        [math.radians(x) for x in courses_deg],
        depth <= 0,
    )
    (frame,) = sailed(3.0, msgspec.structs.replace(band(2.0, 4.0), manoeuvre=choice))
    return msgspec.structs.replace(frame, manoeuvre=Manoeuvre(math.radians(60.0), 400.0))


def test_a_manoeuvre_that_is_certain():
    frame = chosen([60.0], -0.5)
    assert short_band_text(frame) == "certain: course 060°"
    assert full_band_text(frame) == (
        "no other course can be better; worth 83.1 to 84.5 points; every ship stays out of the "
        f"domain (Aurora no nearer than 0.80 NM), {WITHIN}"
    )
    assert current_sentence([frame]).why.endswith(f". No other course can be better {WITHIN}")


def test_a_manoeuvre_that_is_not_certain():
    frame = chosen([350.0, 60.0, 90.0], 0.1)
    assert short_band_text(frame) == "course not certain"
    assert full_band_text(frame).startswith(
        "another course can be better, up to 70° to port or 30° to starboard; worth "
    )
    assert "Aurora can come into the domain (Aurora no nearer than 0.80 NM)" in full_band_text(
        frame
    )
    assert "certain" not in current_sentence([frame]).why
    one_side = full_band_text(chosen([60.0, 90.0], 0.1))
    assert one_side.startswith("another course can be better, up to 30° to starboard; ")


def test_the_table_of_a_band_never_promises_more_than_it_holds():
    rows = {name: cells for name, *cells in band_rows(chosen([60.0], -0.5, 83.181, 84.411))}
    assert rows["Aurora"] == ["-1.00", "+0.00", "-0.50", "0.80 NM"]
    assert rows["total"][:2] == ["+83.18", "+84.42"]
    assert rows["gain over: keep"][:2] == ["+0.50", "+2.00"]
    assert band_rows(sailed(3.0, band(2.0, 4.0))[0]) == []
