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
# # Explain an encounter
#
# You will simulate one encounter with a learned pilot, see which ship moved the rudder and why, and ask what would have
# happened without that ship. You need a clone of Glasshelm and `make install`.
#
# ## Simulate
#
# An encounter is one string. `random:35` is a random encounter of the paper with four ships: one crosses from starboard, two from port, and
# one overtakes on the port side. The pilot `paper-attention` comes with the package.

# %%
# %matplotlib inline
import glasshelm

pilot = glasshelm.load("paper-attention")
scenario = glasshelm.scenario("random:35", "paper")
frames = list(glasshelm.simulate(scenario, pilot, 360))  # 360 steps of 5 s: half an hour
print(f"{scenario.title}: {len(frames)} frames, {len(frames[0].targets)} other ships")

# %% [markdown]
# A frame is the situation, the decision and its explanation at one instant, in SI units. Frames are 5 s apart. Here is the decision
# after 145 s, when the rudder is almost amidships:

# %%
frame = frames[29]
frame.decision

# %% [markdown]
# ## Look at the tracks

# %%
from glasshelm.figures.coloured_tracks import attention
from glasshelm.figures.trajectories import absolute

absolute(frames)

# %% [markdown]
# Colour the tracks by the pilot's attention (Eq. 23): the darker, the more this ship weighs in the decision.

# %%
attention(frames)

# %% [markdown]
# ## Ask what moved the rudder
#
# Attention has no side. Shapley values do: they split the rudder into one share per ship, plus the rudder that the pilot would use with
# no ship around (`base_rad`). The shares add up exactly.

# %%
import math

decision = frame.decision
print(f"alone    {math.degrees(decision.base_rad):+6.2f}°")
for ship in frame.targets:
    print(
        f"{ship.name:8s} {math.degrees(ship.shapley_rad):+6.2f}°   "
        f"DCPA {ship.dcpa_m:5.0f} m, TCPA {ship.tcpa_s / 60:4.1f} min, attention {ship.attention:.2f}"
    )
total = decision.base_rad + sum(ship.shapley_rad for ship in frame.targets)
print(f"rudder   {math.degrees(total):+6.2f}°  (+ is to starboard)")
assert math.isclose(total, decision.rudder_rad, abs_tol=1e-5)

# %% [markdown]
# The rudder is amidships because the waypoint and the ships balance, not because nothing matters. Without any ship, the pilot would
# turn to port towards its waypoint. Two ships hold it back. Over the whole voyage:

# %%
from glasshelm.figures.shapley_over_time import reasons

reasons(frames)

# %% [markdown]
# ## Ask "what if?"
#
# Branch the voyage at a frame and run it twice with the same pilot: once unchanged, once without the ship that moved the rudder most.

# %%
strongest = max(frame.targets, key=lambda ship: abs(ship.shapley_rad))
answer = glasshelm.what_if(frames, 29, pilot, [glasshelm.Deleted(strongest.id)], minutes=20)
print(answer.summary)

# %% [markdown]
# ## Next
#
# * `glasshelm explain random:35 --out story` writes all figures and a report in sentences.
# * `glasshelm bridge random:35` shows the same live.
# * [Explanations](../explanation/explanations.md) defines every number, and [Faithfulness](../results/faithfulness.md) says which to trust.
# * [Train and examine your own pilot](train-your-own-pilot.md).
