"""The band of a choice holds every value that errors can bring, and is the value without errors."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from benchmarks.certify import (
    attacked_values,
    choice_is_within,
    sampled_choices,
    with_fractions,
)
from tests.certify.scenes import KINDS, LEVELS, errors, one_of, scenes

from glasshelm.certify.manoeuvre_band import certified_choice
from glasshelm.certify.measurements import RawPlots, observe_plots
from glasshelm.pilots.registry import pilot_named
from glasshelm.planning.simulated_critic import simulate_manoeuvres
from glasshelm.planning.situation import situation_of

pytestmark = pytest.mark.slow

SAMPLES = 32
#: Nobody is there in the first, one ship in the second.
SOME = (0, 1, 4, 7)


@pytest.fixture(scope="module", params=["paper-glassbox", "large-ship-glassbox"])
def pilot(request):
    return pilot_named(request.param)


def banded(pilot, scene, level):
    return jax.device_get(certified_choice(pilot, scene, errors(*level)))


@pytest.mark.parametrize("level", LEVELS, ids=str)
@pytest.mark.parametrize("kind", KINDS)
def test_no_error_brings_a_value_out_of_the_band(pilot, kind, level):
    for number in SOME[1:]:
        scene, key = one_of(scenes(kind), number), jax.random.key(number)
        band = banded(pilot, scene, level)
        values, best = sampled_choices(pilot, scene, errors(*level), key, SAMPLES)
        assert choice_is_within(band, values, best).all()
        row = int(band.chosen)
        attacked = attacked_values(pilot, scene, errors(*level), jnp.asarray(row), key, 1, 8)
        assert np.all(np.asarray(attacked) >= band.low.total[row])
        assert np.all(np.asarray(attacked) <= band.high.total[row])


@eqx.filter_jit
def met(pilot, scene, errors, fractions):
    """The deepest Eq. 13 and the least range of every ship on every manoeuvre."""
    at = situation_of(with_fractions(scene, errors, fractions), pilot.ship)
    table = pilot.critic.table.at(at.bearing_rad)
    ships = simulate_manoeuvres(table, at, pilot.ship, pilot.critic.costs)[1]
    return jnp.stack([s.margin for s in ships], -1), jnp.stack([s.range_m2 for s in ships], -1)


@pytest.mark.parametrize("level", LEVELS, ids=str)
def test_no_ship_comes_deeper_or_nearer_than_certified(pilot, level):
    drawn = np.random.default_rng(4)
    for number in SOME[2:]:
        scene = one_of(scenes(), number)
        band = banded(pilot, scene, level)
        for _ in range(4):
            fractions = jnp.asarray(np.sign(drawn.uniform(-1, 1, 16)), jnp.float32)
            margin, square = jax.device_get(met(pilot, scene, errors(*level), fractions))
            # What never comes nearer than Eq. 13 = -1 is not told apart by the critic.
            assert np.all(margin <= np.maximum(band.margin, -1.0) + 1e-6)
            assert np.all(np.sqrt(square) >= band.range_m * (1 - 1e-6))


@pytest.mark.parametrize("kind", KINDS)
def test_without_errors_it_is_the_value(pilot, kind):
    for number in SOME:
        scene = one_of(scenes(kind), number)
        band = banded(pilot, scene, LEVELS[0])
        _, values = pilot.critic(observe_plots(scene), pilot.ship)
        row = int(band.chosen)
        total = float(values.total[row])
        cost = abs(float(values.collision[row]))
        # Rounding of a range costs as much as the square of the nearness is steep.
        steep = np.sqrt(pilot.critic.costs.near_weight * cost)
        room = 1e-3 * max(1.0, cost) + 2e-3 + 5e-4 * steep
        assert band.low.total[row] == pytest.approx(total, abs=room)
        assert band.high.total[row] == pytest.approx(total, abs=room)
        assert float(band.rudder_low) <= float(band.rudder) <= float(band.rudder_high)
        assert np.all(band.gain_low <= values.total[row] - np.asarray(values.total))


def test_larger_errors_make_it_no_narrower(pilot):
    for number in SOME:
        scene = one_of(scenes(), number)
        narrow, wide = (banded(pilot, scene, level) for level in LEVELS[:2])
        row = int(narrow.chosen)
        assert np.all(wide.low.total[row] <= narrow.low.total[row])
        assert np.all(wide.high.total[row] >= narrow.high.total[row])
        assert np.all(wide.possible >= narrow.possible)
        assert wide.rudder_low <= narrow.rudder_low
        assert wide.rudder_high >= narrow.rudder_high


def test_who_is_not_there_does_not_matter(pilot):
    scene = one_of(scenes(), 1)
    other = RawPlots(scene.waypoint, scene.targets.at[1:].multiply(-3.0), scene.present)
    one, two = (banded(pilot, x, LEVELS[1]) for x in (scene, other))
    jax.tree.map(np.testing.assert_array_equal, one, two)
    assert np.all(np.isinf(one.range_m[:, 1:]))


def test_the_chosen_course_is_always_among_those_that_are_possible(pilot):
    for number in SOME:
        band = banded(pilot, one_of(scenes(), number), LEVELS[1])
        chosen = float(band.course_rad[int(band.chosen)])
        assert min(abs(np.array(band.possible_courses_rad) - chosen)) < 1e-6
        assert np.all(np.diff(band.possible_courses_rad) > 0)
