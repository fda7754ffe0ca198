# ---
# jupyter:
#   jupytext:
#     formats: py:percent
#   kernelspec:
#     display_name: Python 3
#     language: python
#     name: python3
# ---

# %% [markdown]
# # Train and examine your own pilot
#
# You will train a small pilot by imitation of a planner, look at how safe it is, and test whether its explanations say what it does. It takes a
# few minutes on two cores. A good pilot needs half an hour; the last section says how.
#
# ## Train
#
# `tiny-fast` has the stages of the preset [`fast`](../explanation/training.md), imitation and then critics, with networks of eight units. A few more
# iterations make it steer sensibly. `glasshelm train --preset tiny-fast` does the same from the command line.

# %%
import dataclasses
import tempfile
from pathlib import Path

from glasshelm.training.config import override, preset_named
from glasshelm.training.trainer import train

out = Path(tempfile.mkdtemp())
config = override(
    dataclasses.replace(preset_named("tiny-fast"), seed=1),
    ["imitation.iterations=20"],
)
train(config, out / "run")
sorted(file.name for file in (out / "run").iterdir())

# %% [markdown]
# `best.safetensors` holds the weights and the whole configuration: the file alone is the pilot.

# %%
import glasshelm

pilot = glasshelm.load(out / "run" / "best.safetensors")
print(pilot.name, pilot.weights_sha256[:8])
