"""An oracle knows all of each case, and is evaluated as any pilot is."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from tests.evaluation.cases import ABEAM, HEAD_ON, SHIP, encounter, suite

from glasshelm.evaluation.contenders import Contender, parse_contenders, pilot_digest
from glasshelm.evaluation.measure_columns import assemble
from glasshelm.evaluation.result_cache import run_job, split_into_jobs
from glasshelm.evaluation.suites.disturbed_suite import disturbed_suites
from glasshelm.evaluation.worst_cases import replay_cases
from glasshelm.pilots.clairvoyant import Clairvoyant, Playback
from glasshelm.pilots.straight import StraightPilot
from glasshelm.planning.cross_entropy_search import SearchSettings, rollout_rudders
from glasshelm.ship.nomoto import SHIPS
from glasshelm.simulation.rollout import policy_for, rollout

pytestmark = pytest.mark.slow

SEER = Clairvoyant(SHIP, "seer", (StraightPilot(),), SearchSettings(8, 16, 4, 6))
ENTRANT = Contender("seer", "paper", SHIP, (SEER,))


class Weaving:
    """Is told the cases, remembers what, and weaves through all of them."""

    name = "weaving"

    def policy_for(self, known):
        self.known = known
        count = known.steps.shape[0]
        self.rudders = 0.5 * jnp.sin(jnp.arange(240) / 15.0 + jnp.arange(count)[:, None])
        return Playback(self.rudders)


def test_what_a_seer_is_told_is_all_that_decides_the_voyage():
    """Altering targets, a current, another ship: its own reckoning is what is measured."""
    disturbed = {s.name: s for s in disturbed_suites(SHIP, 8)}["disturbed-all"]
    cases = jax.tree.map(jnp.asarray, disturbed.take(np.arange(8)))
    cases = dataclasses.replace(cases, steps=jnp.arange(8, dtype=jnp.int32) * 10 + 160)
    weaving = Weaving()
    real = rollout(policy_for(weaving, cases), cases, 240)
    known = weaving.known
    assert float(jnp.abs(known.current_m_s.x).min()) > 0
    imagined = jax.jit(jax.vmap(lambda k, r: rollout_rudders(k, r * k.ship.rudder_limit_rad)))(
        known, weaving.rudders
    )
    np.testing.assert_allclose(imagined.margin, real.margin[:, 1], atol=2e-3)
    np.testing.assert_allclose(imagined.range_m, real.range_m[:, 1], rtol=2e-3, atol=2.0)
    # And each part of it matters.
    for without in (
        dataclasses.replace(known, current_m_s=jax.tree.map(jnp.zeros_like, known.current_m_s)),
        dataclasses.replace(known, steps=known.steps // 2),
    ):
        other = jax.vmap(lambda k, r: rollout_rudders(k, r * k.ship.rudder_limit_rad))(
            without, weaving.rudders
        )
        assert (np.abs(other.range_m - real.range_m[:, 1]) > 10.0).any()


def test_it_is_examined_as_a_pilot_is_and_its_voyages_are_drawn_as_they_were():
    """It keeps clear where doing nothing collides; drawn alone the voyage is the same."""
    made = suite(encounter(HEAD_ON), encounter(ABEAM), encounter(HEAD_ON))
    parts = [(job, run_job(job)) for job in split_into_jobs(made, 0, ENTRANT, chunk=2)]
    found = assemble(made, ENTRANT, 0, parts)
    assert not found.columns["intruded"].any()
    assert found.columns["margin"][0] == found.columns["margin"][2]
    straight = assemble(made, ENTRANT, 0, [(j, run_job(_instead(j))) for j, _ in parts])
    assert straight.columns["collided"].tolist() == [True, False, True]
    (frames,) = replay_cases(found, np.array([2]))
    nearest = min(target.range_m for frame in frames for target in frame.targets)
    assert abs(nearest - found.columns["nearest_m"][2]) < 1.0


def _instead(job):
    return dataclasses.replace(job, pilot=StraightPilot())


def test_by_name_it_is_an_entrant_of_its_own_ship():
    first, second = parse_contenders(["paper-clairvoyant", "large-ship-clairvoyant"])
    assert (first.name, first.ship_name, first.ship) == (
        "paper-clairvoyant", "paper", SHIPS["paper"],
    )  # fmt: skip
    assert second.ship_name == "large_ship"
    assert first.weights == ("",)
    harder = dataclasses.replace(SEER, settings=SearchSettings(8, 16, 4, 7))
    assert len({pilot_digest(p) for p in (SEER, harder, *first.pilots, *second.pilots)}) == 4
