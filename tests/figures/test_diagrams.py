"""Diagrams of the paper are drawn from the numbers of the code."""

import math

import equinox as eqx
import jax
import numpy as np
import pytest

from glasshelm.figures.network_diagrams import actor_flow, critic_flow, describe
from glasshelm.figures.scene_diagrams import closest_point, domain_shape, turning_track
from glasshelm.networks.actors import ActorSizes, AttentionActor, SumActor
from glasshelm.networks.critics import CriticSizes, SubTaskCritic
from glasshelm.ship.domain import AHEAD_LOA, ASTERN_LOA, PORT_LOA, STARBOARD_LOA
from glasshelm.ship.nomoto import NAUTICAL_MILE_M, SHIPS

SHIP = SHIPS["paper"]


def texts(figure):
    return " ".join(text.get_text() for ax in figure.axes for text in ax.texts)


def shape(kind, sizes):
    return eqx.filter_eval_shape(kind, sizes, jax.random.key(0))


def test_the_domain_is_that_of_the_simulator():
    edge = domain_shape(SHIP).axes[0].get_lines()[0].get_xydata() * NAUTICAL_MILE_M / SHIP.loa_m
    assert edge.max(0) == pytest.approx([STARBOARD_LOA, AHEAD_LOA])
    assert edge.min(0) == pytest.approx([-PORT_LOA, -ASTERN_LOA])


def test_a_turn_settles_on_the_rate_of_eq_6():
    ship = SHIPS["large_ship"]
    _, early = turning_track(ship, 900.0)
    _, late = turning_track(ship, 1000.0)
    rate = math.degrees(ship.gain_1_s * ship.rudder_limit_rad)
    assert (late - early) / 100.0 == pytest.approx(rate, rel=0.01)


def test_the_closest_point_is_where_two_straight_ways_are_closest():
    figure = closest_point(SHIP)
    own, target = (
        next(line for line in figure.axes[0].get_lines() if line.get_color() == colour).get_xydata()
        for colour in ("#1b1f24", "#0072B2")
    )
    share = np.linspace(0, 1, 2001)[:, None]
    gap = (own[0] - target[0]) + share * ((own[1] - own[0]) - (target[1] - target[0]))
    assert f"DCPA {np.hypot(*gap.T).min():.2f} NM" in texts(figure)


def test_networks_are_drawn_with_their_own_widths():
    critic = shape(SubTaskCritic, CriticSizes((7, 5), norm=True))
    assert describe(critic.of_waypoint) == "16 → 7 → 5 → 1\nReLU, LayerNorm"
    assert "51 → 7 → 5 → 1" in texts(critic_flow(critic))
    sizes = ActorSizes((9,), (4,), (3,))
    assert "50 → 9" in texts(actor_flow(shape(SumActor, sizes)))
    assert "100 → 3 → 1" in texts(actor_flow(shape(AttentionActor, sizes)))
