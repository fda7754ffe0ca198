import dataclasses
import warnings

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

import glasshelm.env.gymnasium_env  # noqa: F401 (registers the environment)
from glasshelm.core.errors import InputError
from glasshelm.encounters.random_encounters import PAPER, WIDE
from glasshelm.ship.nomoto import SHIPS

ID = "glasshelm/Encounter-v0"
FIVE = dataclasses.replace(PAPER, targets=(5, 5))


def make(**options) -> gymnasium.Env:
    return gymnasium.make(ID, **options).unwrapped


def same(a, b) -> bool:
    if isinstance(a, dict):
        return a.keys() == b.keys() and all(same(a[k], b[k]) for k in a)
    return np.array_equal(a, b)


@pytest.mark.slow
@pytest.mark.parametrize("flat", [False, True])
def test_gymnasium_has_nothing_to_object(flat):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(make(flat=flat))


@pytest.mark.parametrize(("ship", "encounters"), [("paper", PAPER), ("large_ship", WIDE)])
def test_everything_seen_lies_in_the_space(ship, encounters):
    env = make(ship=ship, encounters=encounters)
    env.action_space.seed(0)
    for seed in range(4):
        observation, _ = env.reset(seed=seed)
        rudder = np.sign(env.action_space.sample())
        for _ in range(240):
            assert env.observation_space.contains(observation), observation
            observation, _, terminated, truncated, _ = env.step(rudder)
        assert env.observation_space.contains(observation)
        assert truncated
        assert not terminated


def test_bounds_are_not_idle():
    env = make()
    space = env.observation_space
    tops = np.zeros(10)
    for seed in range(30):
        observation, _ = env.reset(seed=seed)
        tops = np.maximum(tops, np.abs(observation["targets"]).max((0, 1)))
    share = tops / space["targets"].high.max((0, 1))
    assert (share <= 1).all()
    assert (share > 0.05).all(), share  # ships begin on collision courses: CPA is near


@pytest.mark.slow
def test_same_seed_same_voyage_and_other_seed_another():
    def voyage(seed):
        env = make(flat=True, encounters=FIVE)
        observation = [env.reset(seed=seed)[0]]
        for k in range(5):
            observation.append(env.step(np.float32([np.sin(k)]))[0])
        observation.append(env.reset()[0])
        return np.stack(observation)

    first = voyage(3)
    np.testing.assert_array_equal(first, voyage(3))
    assert not np.array_equal(first[0], voyage(4)[0])
    assert not np.array_equal(first[0], first[-1])  # the next episode is another


def test_flat_is_the_dictionary_side_by_side():
    plain, flat = make(), make(flat=True)
    a, b = plain.reset(seed=1)[0], flat.reset(seed=1)[0]
    assert b.shape == flat.observation_space.shape == (15 + 51 * 6,)
    np.testing.assert_array_equal(
        b, np.concatenate([a["waypoint"].ravel(), a["targets"].ravel(), a["present"]])
    )


def test_clock_truncates_and_arrival_terminates():
    env = make(episode_steps=3)
    env.reset(seed=0)
    ends = [env.step(np.zeros(1, np.float32))[2:4] for _ in range(3)]
    assert ends == [(False, False), (False, False), (False, True)]
    env = make(encounters=dataclasses.replace(PAPER, waypoint_m=(600.0, 600.0)))
    env.reset(seed=0)
    ends = [env.step(np.zeros(1, np.float32))[2:4] for _ in range(4)]
    assert ends == [(False, False)] * 3 + [(True, False)]


def test_info_splits_the_reward_and_tells_how_near_the_ships_are():
    near = dataclasses.replace(
        FIVE,
        time_to_collision_s=(60.0, 120.0),
        position_noise_m=0.0,
        nearest_spawn_loa=0.0,
        spawn_danger=1.0,
    )
    env = make(encounters=near)
    observation, info = env.reset(seed=2)
    distance = observation["targets"][:, 0, 5] * 20_000 * 2**0.5
    np.testing.assert_allclose(info["range_m"], distance, rtol=1e-4)
    _, reward, _, _, info = env.step(np.ones(1, np.float32))
    assert info["reward"].keys() == {"waypoint", "collision"}
    assert info["reward"]["collision"] < 0 < info["reward"]["waypoint"]
    assert (info["margin"] > 0).any()
    assert reward == pytest.approx(sum(info["reward"].values()), abs=1e-5)


def test_action_is_a_share_of_the_rudder_limit_starboard_positive():
    env = make(ship="large_ship")
    env.reset(seed=0)
    for _ in range(10):
        observation, *_ = env.step(np.ones(1, np.float32))
    assert observation["waypoint"][0, 2] < -0.005  # the waypoint has gone to port
    assert float(env._world[1].own.rudder_rad) == pytest.approx(np.radians(5), rel=1e-5)


def test_wrong_options_are_told():
    with pytest.raises(InputError, match="unknown ship"):
        make(ship="tug")
    with pytest.raises(InputError, match="loa_m"):
        make(ship=dataclasses.replace(SHIPS["paper"], loa_m=-1.0))
    with pytest.raises(InputError, match="must allow one or more"):
        make(encounters=dataclasses.replace(PAPER, targets=(0, 0)))
    with pytest.raises(InputError, match="episode_steps 0"):
        make(episode_steps=0)
    with pytest.raises(InputError, match="reset first"):
        make().step(np.zeros(1))


@pytest.mark.parametrize("action", [
    np.nan, [np.nan], [np.inf], [1.01], -1.5, [0.0, 0.0], [], [[0.0]], None, "port", [1e40],
])  # fmt: skip
def test_an_action_that_is_none_is_refused(action):
    env = make()
    env.reset(seed=0)
    with pytest.raises(ValueError, match=r"must be one number from -1 to 1"):
        env.step(action)
    for fine in (np.float32([1.0]), np.array([-1.0]), 0.5, [0]):
        assert np.isfinite(env.step(fine)[1])
