import dataclasses

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from glasshelm.networks.actors import ActorSizes, make_actor
from glasshelm.networks.ship_batch import Packed
from glasshelm.planning.course_planner import CourseSettings, rudder_towards
from glasshelm.ship.nomoto import SHIPS
from glasshelm.training.analytic_policy_gradient import AnalyticSettings, draw_batch, sail
from glasshelm.training.dagger import (
    ImitationSettings,
    draw_lessons,
    imitate,
    start_imitation,
    teach,
)

SHIP = SHIPS["large_ship"]
MIX = AnalyticSettings(worlds_by_count=(1, 2, 2, 1))
SETTINGS = ImitationSettings(
    CourseSettings(
        # A teacher of few words, who minds no turn: what a small actor can learn in seconds.
        (-60.0, -30.0, 30.0, 60.0),
        (400.0, 900.0),
        (),
        (),
        keep_s=(),
        horizon_s=1800.0,
        step_s=20.0,
        alter_cost=0.0,
    ),
    stretches=6,
    iterations=20,
    updates=100,
    kept=2,
    instants=4,
    average_rate=0.02,
)
ACTOR = make_actor("sum", ActorSizes((24, 16), (16,), (8,), "fine"), jax.random.key(2))
BATCH = jax.jit(lambda: draw_batch(jax.random.key(5), SHIP, MIX))()
FLEET = Packed(BATCH.present, MIX.ships, MIX.pairs)


@eqx.filter_jit
def taught(share):
    return teach(ACTOR, BATCH, share, jax.random.key(1), SHIP, FLEET, SETTINGS)


def test_alone_the_teacher_steers_her_own_labels():
    lessons = taught(jnp.zeros(()))
    assert lessons.rudder.shape == (24, 6)
    # The first command of a stretch is the one that her course asks for: seen again one step on.
    turned = lessons.observation.waypoint[4, :, 0, 2] - lessons.observation.waypoint[0, :, 0, 2]
    steered = lessons.rudder[:4].sum(0)
    moved = jnp.abs(turned) > 1e-3
    assert moved.any()
    np.testing.assert_array_less(0.0, (-turned * steered)[moved])


def test_the_actor_sails_but_the_teacher_labels():
    alone, together = taught(jnp.zeros(())), taught(jnp.ones(()))
    np.testing.assert_allclose(alone.rudder[0], together.rudder[0])
    assert not np.allclose(alone.observation.waypoint[-1], together.observation.waypoint[-1])
    straight = jax.vmap(lambda s: rudder_towards(jnp.zeros(()), s, SHIP))(
        jax.tree.map(lambda x: x[-1], together.observation)
    )
    empty = ~BATCH.present.any(-1)  # nobody there: the teacher steers for the waypoint
    np.testing.assert_allclose(together.rudder[-1][empty], straight[empty], atol=1e-6)


def test_a_tolerant_teacher_follows_the_actor():
    """Where anything will do, she wants what the actor does, within half of the limit."""
    fleet_seen = jax.tree.map(lambda x: x[0], taught(jnp.ones(())).observation)
    own = ACTOR(fleet_seen, FLEET)

    @eqx.filter_jit
    def first_labels(tolerance):
        settings = dataclasses.replace(SETTINGS, tolerance=tolerance)
        key = jax.random.key(1)
        return teach(ACTOR, BATCH, jnp.ones(()), key, SHIP, FLEET, settings).rudder[0]

    strict, tolerant = first_labels(0.0), first_labels(1e6)
    np.testing.assert_allclose(strict, taught(jnp.ones(())).rudder[0])
    apart = jnp.abs(strict - own) > 0.5
    assert apart.any()
    assert float(jnp.abs(tolerant - own)[apart].min()) <= 0.5


def test_weights_say_what_is_at_stake():
    weight = taught(jnp.zeros(())).weight[0]
    assert float(weight.min()) >= 0.1
    assert float(weight.max()) <= 1.0
    crowded = BATCH.present.sum(-1)
    assert float(weight[crowded == 0].max()) < float(weight[crowded > 0].max())


def test_the_hardest_of_several_is_sailed():
    """Where all voyages are the hardest of four: as many ships in each as else, and closer ones."""
    mix = dataclasses.replace(MIX, worlds_by_count=(1, 4, 4, 4), decisions=60)

    @eqx.filter_jit
    def drawn(share):
        settings = dataclasses.replace(SETTINGS, hard_share=share, hardest_of=4)
        batch = draw_lessons(ACTOR, jax.random.key(8), SHIP, mix, settings)
        return batch.present, sail(ACTOR, batch, SHIP, mix)[1].worst

    (present, plain), (hard_present, hard) = drawn(0.0), drawn(1.0)
    np.testing.assert_array_equal(present, hard_present)
    assert float(jnp.median(hard[1:])) > float(jnp.median(plain[1:])) + 0.1


@pytest.fixture(scope="module")
def learned():
    run = eqx.filter_jit(lambda state, key: imitate(state, key, SHIP, MIX, SETTINGS))
    state, errors = start_imitation(ACTOR, MIX, SETTINGS, 6), []
    for number in range(12):
        state, lesson = run(state, jax.random.fold_in(jax.random.key(3), number))
        errors.append(float(lesson.error))
    return state, errors


def test_the_actor_comes_to_steer_like_the_teacher(learned):
    state, errors = learned
    lessons = jax.tree.map(lambda x: x.reshape(-1, *x.shape[2:]), state.lessons)

    @eqx.filter_jit
    def wrong(actor):
        rudders = jax.vmap(lambda observation: actor(observation, FLEET))(lessons.observation)
        return jnp.mean(lessons.weight * (rudders - lessons.rudder) ** 2)

    assert float(wrong(state.average)) < 0.75 * float(wrong(ACTOR))
    assert all(np.isfinite(errors))
    assert int(state.iteration) == 12


def test_the_oldest_lessons_are_replaced(learned):
    state, _ = learned
    assert state.lessons.rudder.shape == (2, 24, 6)
    assert not np.allclose(state.lessons.rudder[0], state.lessons.rudder[1])
    assert np.all(np.abs(np.asarray(state.lessons.rudder)) <= 1.0)
