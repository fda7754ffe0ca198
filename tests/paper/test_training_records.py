import json

import numpy as np
from tests.untrained import write_weights

from glasshelm.paper.training_records import learning_curve, train_config, weights_path


def line(steps, intrusions, stage="ddpg"):
    return {
        "stage": stage, "number": steps, "env_steps": steps, "intrusions": intrusions,
        "return_waypoint": 40.0, "return_collision": -1.0,
    }  # fmt: skip


def test_trainings_that_went_on_are_counted_together_and_critics_left_out(tmp_path):
    parts = [[line(10, 0.5), line(20, 0.4)], [line(99, 0.4, "critic")], [line(10, 0.3)]]
    (tmp_path / "a.json").write_text(json.dumps({"parts": [{"curve": part} for part in parts]}))
    curve = learning_curve(tmp_path / "a.safetensors", "a")
    np.testing.assert_array_equal(curve.env_steps, [10, 20, 30])
    np.testing.assert_array_equal(curve.intrusions, [0.5, 0.4, 0.3])
    np.testing.assert_array_equal(curve.returns, [39, 39, 39])


def test_a_training_of_ones_own_has_its_log(tmp_path):
    text = "\n".join(json.dumps(line(steps, 0.1)) for steps in (5, 6))
    (tmp_path / "log.jsonl").write_text(text)
    assert len(learning_curve(tmp_path / "best.safetensors", "best").returns) == 2


def test_without_a_record_there_is_no_curve(tmp_path):
    assert learning_curve(tmp_path / "a.safetensors", "a") is None
    (tmp_path / "a.json").write_text("{")
    assert learning_curve(tmp_path / "a.safetensors", "a") is None


def test_bundled_pilots_have_a_record_and_a_configuration():
    path = weights_path("paper-sum-ddpg")
    assert learning_curve(path, "x").intrusions.size > 5
    assert train_config(path).algorithm == "ddpg"


def test_weights_without_a_configuration_have_none(tmp_path):
    write_weights(tmp_path / "a.safetensors")
    assert train_config(tmp_path / "a.safetensors") is None
