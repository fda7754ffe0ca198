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
# You will train a tiny pilot, measure how safe it is beside a good one, and test whether its attention says what it does. It takes a few
# minutes on two cores. A useful pilot takes half an hour; the last section says how.
#
# ## Train
#
# The preset `tiny-fast` has the stages of [`fast`](../explanation/training.md), imitation and then critics, with networks of eight units and
# voyages of two minutes. It shows the machinery; most of the time goes into compilation.

# %%
import os
import tempfile
from pathlib import Path

os.environ.pop("FORCE_COLOR", None)  # commands below print no progress bars
folder = Path(tempfile.mkdtemp())
run, evaluation = folder / "run", folder / "evaluation"

# %%
# !glasshelm train --preset tiny-fast --actor attention --seed 1 --set dagger.iterations=30 --out {run} 2>&1 | tail -n 1

# %% [markdown]
# `best.safetensors` holds the weights and the whole configuration: this one file is the pilot.

# %%
sorted(file.name for file in run.glob("[!.]*"))

# %% [markdown]
# ## Measure its safety
#
# All pilots sail the same 50 random encounters.

# %%
# !glasshelm evaluate --pilots straight tiny={run}/best.safetensors paper-attention --suites random --encounters 50 --ships paper --out {evaluation} 2>&1 | tail -n 1

# %% [markdown]
# `report.md` has every table with intervals. The rows behind it are in Parquet, one per encounter and pilot:

# %%
import pyarrow.parquet as pq

rows = pq.read_table(evaluation / "encounters.parquet").to_pylist()
for name in ("straight", "tiny", "paper-attention"):
    intruded = [row["intruded"] for row in rows if row["pilot"] == name]
    print(f"{name:16s} intrudes into the domain in {sum(intruded)} of {len(intruded)}")

# %% [markdown]
# The tiny pilot is hardly better than doing nothing: a few seconds of training are not enough. The bundled one has had far more.
#
# ## Test its explanations
#
# Attention claims to say which ship matters. Does it? Compare it with how far each ship really moves the rudder: leave the ship out, and
# ask the actor again. Every frame has that number as `leave_one_out_rad`. Count how often the ship with the most attention also moves the rudder most.

# %%
import glasshelm


def same_first_ship(pilot):
    """Share of the frames in which attention and leave-one-out name the same ship."""
    hits = []
    for seed in range(5):
        scenario = glasshelm.scenario(f"random:{seed}:4", "paper")
        for frame in glasshelm.simulate(scenario, pilot, 240):
            most_attention = max(frame.targets, key=lambda ship: ship.attention)
            most_effect = max(frame.targets, key=lambda ship: abs(ship.leave_one_out_rad))
            if abs(most_effect.leave_one_out_rad) > 0.0005:  # 0.03°: some ship matters
                hits.append(most_attention is most_effect)
    return f"{sum(hits)} of {len(hits)} frames"


tiny = glasshelm.load(run / "best.safetensors")
good = glasshelm.load("paper-attention")
print("tiny           ", same_first_ship(tiny))
print("paper-attention", same_first_ship(good))

# %% [markdown]
# By chance it would be one frame in four. In the well-trained pilot, attention nearly always names the right ship. In one that has learned little, it
# often does not. `glasshelm faithfulness` makes this test with proper scores, baselines and intervals, for every explanation
# ([method](../explanation/explanations.md#measuring-faithfulness), [results](../results/faithfulness.md)).
#
# ## Train a useful pilot
#
#     glasshelm train --preset fast --actor attention --ship paper --out runs/mine
#     glasshelm evaluate --pilots straight mine=runs/mine/best.safetensors paper-attention --suites random --out evaluation
#     glasshelm faithfulness --pilots mine=runs/mine/best.safetensors --out faithfulness
#
# Three quarters of an hour on one core give a pilot that intrudes in about 2 % of the encounters. `--resume` continues an interrupted training, and
# `--set dagger.iterations=200` gives a better pilot. [Training choices](../results/training-choices.md) says what else was tried.
