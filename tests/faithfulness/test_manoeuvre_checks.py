"""What is exact of a chosen manoeuvre's explanation holds, and a false one is found out."""

import dataclasses

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from tests.pilots.scenes import colliding, meeting

from glasshelm.env.step import reset
from glasshelm.explanation.coalitions import coalitions
from glasshelm.faithfulness.explainers import explainers_for
from glasshelm.faithfulness.manoeuvre_checks import CHECKS, SURPRISES, manoeuvre_checks
from glasshelm.faithfulness.subjects import Question, subject_of
from glasshelm.pilots.registry import pilot_named
from glasshelm.ship.nomoto import SHIPS

SHIP = SHIPS["paper"]


@pytest.fixture(scope="module")
def subject():
    return subject_of(pilot_named("paper-glassbox"))


@pytest.fixture(scope="module")
def scene(subject):
    """Three ships that meet own ship: the explanation, the courses of all 8 sets, the bearing."""
    rows = [colliding(180, tcpa_s=1000), colliding(270, tcpa_s=1300), colliding(45, tcpa_s=1500)]

    @jax.jit
    def asked(encounter):
        observation = reset(encounter, SHIP).observation
        inside = jnp.asarray(coalitions(3))
        courses = jax.lax.map(lambda members: subject.decided(observation, members), inside)
        question = Question(subject, observation, jax.random.key(0))
        told = {e.name: e.of(question) for e in explainers_for(subject)}
        return question.why, courses, subject.bearing_rad(observation), told

    encounter = meeting(*rows)  # with an empty slot behind
    targets, present = jax.tree.map(lambda x: x[:3], (encounter.targets, encounter.present))
    return asked(eqx.tree_at(lambda e: (e.targets, e.present), encounter, (targets, present)))


def changed(why, **fields):
    """The explanation of a manoeuvre with something else said."""
    return eqx.tree_at(lambda e: e.manoeuvre, why, dataclasses.replace(why.manoeuvre, **fields))


def found(why, courses, bearing):
    return {name: float(value) for name, value in manoeuvre_checks(why, courses, bearing).items()}


def test_all_checks_hold_where_the_pilot_is_asked_again(scene):
    why, courses, bearing, _ = scene
    checks = found(why, courses, bearing)
    assert set(checks) == set(CHECKS) | set(SURPRISES)
    assert [checks[name] for name in CHECKS] == [1.0] * len(CHECKS)
    assert abs(float(courses[-1] - courses[0])) > np.radians(5)  # or there was nothing to check


def test_an_explanation_that_says_something_else_fails_its_check(scene):
    why, courses, bearing, _ = scene
    m = why.manoeuvre
    others = {
        "leave_one_out": changed(why, course_leave_one_out=m.course_leave_one_out + 0.1),
        "empty_sea": changed(why, alternative_course_rad=m.alternative_course_rad + 0.1),
        "needed": changed(why, needed=jnp.zeros(3, bool)),
        "smallest": changed(why, needed=jnp.ones(3, bool)),
        "shapley": changed(why, course_shapley=jax.tree.map(lambda x: x + 0.1, m.course_shapley)),
    }
    for name, other in others.items():
        assert found(other, courses, bearing)[name] == 0.0, name


def test_every_explanation_gives_one_number_a_ship(scene):
    _, courses, _, told = scene
    assert {len(value) for value in told.values()} == {3}
    assert all(np.isfinite(value).all() for value in told.values())
    assert float(told["shapley"].sum()) == pytest.approx(float(courses[-1] - courses[0]), abs=1e-4)
    assert set(np.unique(told["needed"])) <= {0.0, 1.0}
    assert (np.asarray(told["danger"]) <= 0).all()


def test_only_pilots_that_explain_their_own_decision_are_examined():
    for name in ("straight", "paper-sum-guarded", "paper-mpc"):
        assert subject_of(pilot_named(name)) is None
    assert subject_of(pilot_named("paper-sum")).quantity == "rudder"
