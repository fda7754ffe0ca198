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
# You will simulate one encounter, see which course the pilot steers and for which ship, ask why not another course, and ask what
# would have happened without that ship. You need a clone of Glasshelm and `make install`.
#
# ## Simulate
#
# An encounter is one string. `random:35` is a random encounter of the paper with four ships: one crosses from starboard, two from port, and
# one overtakes on the port side. `glassbox` is the default pilot. It needs no training.

# %%
# %matplotlib inline
import glasshelm

pilot = glasshelm.pilot("glassbox")
scenario = glasshelm.scenario("random:35", "paper")
frames = list(glasshelm.simulate(scenario, pilot, 360))  # 360 steps of 5 s: half an hour
print(f"{scenario.title}: {len(frames)} frames, {len(frames[0].targets)} other ships")

# %% [markdown]
# A frame is the situation, the decision and its explanation at one instant, in SI units. Frames are 5 s apart. Here is what is steered
# after 50 s: a course, how long it is to be held, and what comes then.

# %%
frame = frames[10]
frame.manoeuvre

# %% [markdown]
# ## Look at the tracks

# %%
from glasshelm.figures.trajectories import absolute

absolute(frames)

# %% [markdown]
# ## Ask for which ship
#
# The pilot takes the manoeuvre of the largest value. A value is a sum over the way to the waypoint, the ships and the helm. The **priority**
# of each (Eq. 22) is what it gains over keeping course and speed. `needed` is a smallest set of ships without which another course would
# be steered.

# %%
import math

names = {ship.id: ship.name for ship in frame.targets}
print("needed:", [names[id] for id in frame.needed])
for ship in frame.targets:
    print(
        f"{ship.name:8s} {ship.priority:+8.1f} points   DCPA {ship.dcpa_m:5.0f} m, TCPA {ship.tcpa_s / 60:4.1f} min"
    )
print(f"waypoint {frame.priority.waypoint:+8.1f}")
print(f"helm     {frame.priority.helm:+8.1f}")
print(f"total    {frame.priority.total:+8.1f}")

# %% [markdown]
# ## Ask "why not another course?"
#
# Every frame has the best manoeuvre to starboard and to port, keeping on, and the way to the waypoint, each with its parts:

# %%
for other in frame.alternatives:
    less = frame.value.total - other.value.total
    print(
        f"{other.name:18s} {math.degrees(other.course_rad) % 360:03.0f}°  {less:8.1f} points less"
    )

# %% [markdown]
# Any other course can be asked about. The difference of the parts is the whole reason:

# %%
print(glasshelm.why_not(frames, 10, pilot, math.radians(20)).summary)

# %% [markdown]
# ## Ask what moved the rudder
#
# Shapley values split the rudder into one share per ship, plus the rudder that the pilot would use with no ship around (`base_rad`). The
# shares add up exactly.

# %%
decision = frame.decision
print(f"alone    {math.degrees(decision.base_rad):+6.2f}°")
for ship in frame.targets:
    print(f"{ship.name:8s} {math.degrees(ship.shapley_rad):+6.2f}°")
total = decision.base_rad + sum(ship.shapley_rad for ship in frame.targets)
print(f"rudder   {math.degrees(total):+6.2f}°  (+ is to starboard)")
assert math.isclose(total, decision.rudder_rad, abs_tol=1e-5)

# %% [markdown]
# Over the whole voyage:

# %%
from glasshelm.figures.shapley_over_time import reasons

reasons(frames)

# %% [markdown]
# ## Ask "what if?"
#
# Branch the voyage at a frame and run it twice with the same pilot: once unchanged, once without the ship of the largest priority.

# %%
weightiest = max(frame.targets, key=lambda ship: abs(ship.priority))
answer = glasshelm.what_if(frames, 10, pilot, [glasshelm.Deleted(weightiest.id)], minutes=20)
print(answer.summary)

# %% [markdown]
# ## Next
#
# * `glasshelm explain random:35 --out story` writes all figures and a report in sentences.
# * `glasshelm bridge random:35` shows the same live.
# * [The glassbox pilot](../explanation/glassbox.md) defines every number here.
# * Learned pilots explain themselves otherwise, by attention and the critic's values: `glasshelm.pilot("paper-attention")`.
#   [Explanations](../explanation/explanations.md) defines those, and [Faithfulness](../results/faithfulness.md) says which to trust.
# * [Train and examine your own pilot](train-your-own-pilot.md).
