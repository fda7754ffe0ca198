import dataclasses
import json
import math

import jax
import jax.numpy as jnp
import pytest

from glasshelm.core.errors import InputError
from glasshelm.encounters.random_encounters import CONVERGING, PAPER, WIDE, random_scenario
from glasshelm.encounters.scenario_factory import BUNDLED, recording_settings, scenario_from
from glasshelm.encounters.types import motion_at
from glasshelm.ship.nomoto import SHIPS

SHIP = SHIPS["large_ship"]


@pytest.mark.parametrize("ships", [0, 40])
def test_random_with_exactly_so_many_ships(ships):
    s = scenario_from(f"random:7:{ships}", SHIP)
    assert s.source == f"random:7:{ships}"
    assert s.encounter.present.shape == (ships,)
    assert bool(jnp.all(motion_at(s.encounter.targets, jnp.zeros(())).present))
    assert len(s.targets) == ships


@pytest.mark.parametrize(
    ("settings", "source"),
    [
        (PAPER, "random:7"),
        (WIDE, "wide:7"),
        (CONVERGING, "converging:7"),
        (dataclasses.replace(PAPER, targets=(3, 3)), "random:7:3"),
        (dataclasses.replace(WIDE, targets=(6, 6)), "wide:7:6"),
    ],
)
def test_the_label_of_a_random_encounter_draws_it_again(settings, source):
    made = random_scenario(7, SHIP, settings)
    assert made.source == source
    again = scenario_from(made.source, SHIP)
    for a, b in zip(jax.tree.leaves(made.encounter), jax.tree.leaves(again.encounter), strict=True):
        assert bool(jnp.all(a == b))


def test_the_label_of_settings_without_a_name_tells_them():
    calm = dataclasses.replace(PAPER, position_noise_m=0.0, targets=(2, 2))
    told = random_scenario(7, SHIP, calm).source
    assert told == "random:7 with position_noise_m=0.0, targets=(2, 2)"


def test_random_by_seed_and_imazu():
    once, again = scenario_from("random:7", SHIP), random_scenario(7, SHIP)
    assert once.source == again.source == "random:7"
    assert bool(jnp.all(once.encounter.targets.east_m == again.encounter.targets.east_m))
    assert scenario_from(" imazu:12b ", SHIP).title == "Imazu case 12b: 3 ships"
    assert scenario_from("imazu:1", SHIP).ship is SHIP


@pytest.mark.parametrize("name", BUNDLED)
def test_bundled_recordings(name):
    s = scenario_from(name, SHIP)
    assert s.source == name
    assert len(s.targets) > 90
    assert s.own_track is not None


def test_another_own_ship_of_a_bundled_recording():
    assert scenario_from("new-york", SHIP, own="367784630").own_name == "HAPPY HAULER"


def test_files_are_known_by_name_or_content(tmp_path):
    point = {"position": {"lat": 59.0, "lon": 10.0}, "sog": 10.0, "cog": 0.0}
    situation = json.dumps({"ownShip": {"initial": point}, "targetShips": []})
    for name in ("s.json", "s.dnv"):
        (tmp_path / name).write_text(situation)
        assert scenario_from(str(tmp_path / name), SHIP).origin == (59.0, 10.0)
    table = ["t,mmsi,lat,lon"]
    table += [f"2024-01-01T00:{m:02d}:00,255500001,{59 + 0.003 * m},10" for m in range(9)]
    (tmp_path / "t.csv").write_text("\n".join(table))
    assert scenario_from(str(tmp_path / "t.csv"), SHIP, own=255500001).duration_s == 480


@pytest.mark.parametrize(
    ("source", "message"),
    [
        ("nowhere", "no source 'nowhere'.*random:SEED.*imazu.*gulf-of-finland.*json.*nmea"),
        ("", "no source ''"),
        ("random:", "must be random:SEED"),
        ("random:x", "must be random:SEED"),
        ("random:-1", "must be random:SEED"),
        ("wide:x", "must be wide:SEED or wide:SEED:SHIPS"),
        ("random:1:2:3", "must be random:SEED"),
        ("random:1:", "must be random:SEED"),
        ("random:1:501", "at most 500 ships"),
        ("random:99999999999", "seed must be at most"),
        ("imazu:23", "choose 1 to 22"),
        ("none/such.json", "no source 'none/such.json'"),
        (".", "nor such a file"),
        ("x" * 300, "nor such a file"),
        ("\0", "nor such a file"),
    ],
)
def test_unknown_sources_say_what_is_possible(source, message):
    with pytest.raises(InputError, match=message) as error:
        scenario_from(source, SHIP)
    assert "\n" not in str(error.value)


def test_own_ship_and_time_belong_to_recordings():
    with pytest.raises(InputError, match="own ship can be chosen only in recorded traffic"):
        scenario_from("imazu:1", SHIP, own=5)
    with pytest.raises(InputError, match="start time can be chosen only in recorded traffic"):
        scenario_from("random:1", SHIP, at="12:00")
    with pytest.raises(InputError, match="number of minutes can be chosen only in recorded"):
        scenario_from("random:1", SHIP, settings=recording_settings(5.0))


@pytest.mark.parametrize("minutes", [0.0, -1.0, math.nan, math.inf])
def test_minutes_are_more_than_none(minutes):
    with pytest.raises(InputError, match="minutes: must be more than 0"):
        recording_settings(minutes)


def test_a_few_minutes_of_a_recording():
    whole, part = (
        scenario_from("new-york", SHIP, settings=recording_settings(m)) for m in (None, 10.0)
    )
    assert 500 < part.duration_s <= 600 < whole.duration_s
    assert part.start == whole.start
    assert 50 < len(part.targets) <= len(whole.targets)
