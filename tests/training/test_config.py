import dataclasses
import json

import pytest

from glasshelm.core.errors import InputError
from glasshelm.training.config import (
    PRESETS,
    config_from_dict,
    config_to_dict,
    preset_named,
    with_settings,
)
from glasshelm.training.ddpg import packed_size


def test_the_paper_preset_is_table_a6():
    config = preset_named("paper")
    ddpg, loss = config.ddpg, config.ddpg.actor_loss
    assert (ddpg.env_steps, ddpg.train_interval, ddpg.batch_size) == (10_000_000, 100, 1024)
    assert (ddpg.learning_rate, ddpg.tau, ddpg.discount) == (0.001, 0.001, 0.98)
    assert (loss.regularisation, loss.smoothing, loss.action_size) == (0.001, 0.005, 0.0001)
    assert config.actor_sizes.encoder == config.actor_sizes.head == (256, 256, 128)
    assert config.critic_sizes.hidden == (256, 256, 128)
    assert not config.critic_sizes.norm
    assert config.actor_sizes.lens == config.critic_sizes.lens == "flat"
    assert (ddpg.replay_size, ddpg.critic_starts, ddpg.actor_starts) == (1_000_000, 20_480, 102_400)
    assert ddpg.cycles * ddpg.cycle_updates == 100_000


@pytest.mark.parametrize("num_envs", [10, 50, 100, 400])
def test_one_update_to_a_hundred_steps_whatever_the_number_of_envs(num_envs):
    ddpg = dataclasses.replace(preset_named("paper").ddpg, num_envs=num_envs)
    assert ddpg.cycle_env_steps == 100 * ddpg.cycle_updates


@pytest.mark.parametrize("name", list(PRESETS))
def test_a_configuration_survives_json(name):
    config = preset_named(name)
    assert config_from_dict(json.loads(json.dumps(config_to_dict(config)))) == config
    assert hash(config) == hash(config_from_dict(config_to_dict(config)))


def test_any_field_can_be_set():
    config = with_settings(
        preset_named("paper"),
        ("ddpg.batch_size=64", "actor_sizes.head=[8, 4]", "critic_sizes.lens=fine", "seed=3"),
    )
    assert config.ddpg.batch_size == 64
    assert config.actor_sizes.head == (8, 4)
    assert config.critic_sizes.lens == "fine"
    assert config.seed == 3


@pytest.mark.parametrize(
    ("setting", "words"),
    [
        ("ddpg.bach=64", "bach"),
        ("seed", "FIELD=VALUE"),
        ("ddpg.batch_size=many", "batch_size"),
        ("ddpg.tau.size=1", "size"),
        ("critic_sizes.lens=wide", "lens"),
    ],
)
def test_bad_settings_are_named(setting, words):
    with pytest.raises(InputError, match=words):
        with_settings(preset_named("paper"), (setting,))


def test_unknown_preset():
    with pytest.raises(InputError, match="choose one of paper, fast"):
        preset_named("quick")


def test_packed_rows_are_mean_and_four_deviations():
    rows = packed_size(1024, (0, 6), True)
    assert 1024 * 3 + 4 * 32 * 2 <= rows.targets < 1024 * 3 + 4 * 32 * 2 + 16
    assert rows.pairs is not None
    assert 1024 * 13 + 4 * 32 * 12.4 < rows.pairs < 1024 * 13 + 4 * 32 * 12.6 + 16
    assert packed_size(4, (6, 6), False).targets == 24
