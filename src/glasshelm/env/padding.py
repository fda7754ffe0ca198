"""Any number of ships through programs of few shapes.

A program is compiled once a number of slots. Observations are padded to the
next of 0, 1, 2, 4, 8, 16, … slots, so that a ship more or less seldom costs a
compilation, and what comes out is cut back to the slots that went in.
"""

import equinox as eqx
import numpy as np

from glasshelm.env.observe import Observation


def bucket_size(ships: int) -> int:
    """The smallest of 0, 1, 2, 4, 8, … that holds so many ships."""
    return 0 if ships == 0 else 1 << (ships - 1).bit_length()


def pad_observation(observation: Observation, slots: int) -> Observation:
    """The same observation with empty slots added at the end, on the host."""
    extra = slots - observation.present.shape[-1]
    if extra < 0:
        raise ValueError(f"{observation.present.shape[-1]} slots do not fit into {slots}")
    return eqx.tree_at(
        lambda o: (o.waypoint, o.targets, o.present),
        observation,
        (
            np.asarray(observation.waypoint, np.float32),
            np.pad(np.asarray(observation.targets, np.float32), ((0, extra), (0, 0), (0, 0))),
            np.pad(np.asarray(observation.present), (0, extra)),
        ),
    )
