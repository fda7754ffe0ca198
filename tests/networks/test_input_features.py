import jax.numpy as jnp
import numpy as np
import pytest

from glasshelm.networks.input_features import encode, input_size


@pytest.mark.parametrize("lens", ["flat", "fine"])
@pytest.mark.parametrize(("row", "features"), [("waypoint", 3), ("target", 10)])
def test_input_has_the_size_told(lens, row, features):
    frames = jnp.ones((2, 7, 5, features))
    assert encode(lens, frames).shape == (2, 7, input_size(lens, row))


def test_flat_is_the_frames_side_by_side_newest_first():
    frames = jnp.arange(15.0).reshape(5, 3)
    np.testing.assert_array_equal(encode("flat", frames), np.arange(15.0))
    assert input_size("flat", "target") == 50


def waypoint_history(bearings) -> jnp.ndarray:
    return jnp.zeros((5, 3)).at[:, 2].set(jnp.float32(bearings))


def test_fine_steps_of_the_bearing_run_across_dead_astern():
    # 179°, 177° ... against −179°, 179°: in units of half a turn.
    plain = encode("fine", waypoint_history([0.98, 0.97, 0.96, 0.95, 0.94]))
    across = encode("fine", waypoint_history([-0.99, 1.0, 0.99, 0.98, 0.97]))
    steps = slice(3, 15)  # after the current frame: four differences of three features
    np.testing.assert_allclose(plain[steps], across[steps], atol=1e-4)
    np.testing.assert_allclose(plain[steps].reshape(4, 3)[:, 2], 20 * 0.01, rtol=1e-3)


def test_fine_has_no_jump_dead_astern():
    port = encode("fine", waypoint_history([-0.9999] * 5))
    starboard = encode("fine", waypoint_history([0.9999] * 5))
    np.testing.assert_allclose(port[15:], starboard[15:], atol=1e-3)  # sine and cosine
    np.testing.assert_allclose(port[16], -1.0, atol=1e-5)


def test_fine_sees_what_flat_sees():
    # The frames can be rebuilt from the input: nothing is lost.
    frames = np.random.default_rng(0).uniform(-0.4, 0.4, (5, 10)).astype(np.float32)
    fine = np.asarray(encode("fine", jnp.asarray(frames)))
    now, steps = fine[:10], fine[10:50].reshape(4, 10) / 20
    rebuilt = [now]
    for step in steps:
        rebuilt.append(rebuilt[-1] - step)
    np.testing.assert_allclose(np.stack(rebuilt), frames, atol=1e-5)
