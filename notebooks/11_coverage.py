# ---
# jupyter:
#   kernelspec:
#     display_name: Python 3 (ipykernel)
#     language: python
#     name: python3
# ---

# %% [markdown]
# # Coverage: what a graph can avoid, and what it lacks
#
# Balls from all sides, at all heights, at many places of the graph: which of them is the character
# rid of, by which kind of part, and where should more be captured?

# %%
import os

import mgjax

mgjax.enable_cache()

import matplotlib.pyplot as plt
import numpy as np

from mgjax.avoidance import ball_attack, coverage_report, measure_coverage, select
from mgjax.clips import synthetic_clips
from mgjax.graph import GraphConfig, build_graph
from mgjax.pictures import coverage_figure

DIRECTIONS, NODES = 24, 60
if os.environ.get("MGJAX_NOTEBOOK_SMOKE"):  # the tests run it small
    DIRECTIONS, NODES = 4, 4

# %%
clips, labels = synthetic_clips()
graph = build_graph(clips, labels=labels, config=GraphConfig(threshold_m=0.05))
found = measure_coverage(graph, directions=DIRECTIONS, nodes=NODES)
print(f"{len(found)} balls at {found.speed:g} m/s")

# %% [markdown]
# ## Seen from the character
#
# A ball for each direction and height, coloured by the share that is avoided.

# %%
found

# %%
coverage_figure(graph, found)

# %% [markdown]
# ## In figures
#
# Shares come with a 95 % interval, which knows that balls at one place of the graph are alike.

# %%
report = coverage_report(graph, found)
low, high = report["all"]["avoided_interval"]
print(f"avoided {report['all']['avoided']:.0%} ({low:.0%} … {high:.0%})")
print("where it is worst:")
for row in report["regions"][:8]:
    print(f"  {row['from']:13} {row['band']:8} {row['avoided']:.0%} of {row['attacks']}")
print("by what is avoided:", report["all"]["kinds"])

# %% [markdown]
# ## A ball that is not avoided, thrown again
#
# Now near misses are refined, which coverage leaves out: it measures what the graph itself holds.

# %%
missed = np.flatnonzero(found.answers.status != 0)
if len(missed):
    ball = int(missed[0])
    angle, height = found.directions[found.direction[ball]], found.heights[found.height[ball]]
    start = np.array([5 * np.sin(angle), height, 5 * np.cos(angle)])
    attack = ball_attack(
        start,
        np.array([0, height, 0]),
        speed=found.speed,
        arrives=float(found.arrivals[found.arrival[ball]]),
    )
    again = select(graph, int(found.node[ball]), attack)
    print(f"{np.degrees(angle):.0f}° to the left of ahead, {height:.2f} m high: {again.status}")
else:
    again = None
again

# %% [markdown]
# ## What more time would do
#
# The same balls known earlier or later. Coverage falls with the time that is left, because fewer
# parts can be reached.

# %%
shares = []
times = (0.6, 0.8, 1.0, 1.2, 1.6)
for time in times:
    early = measure_coverage(graph, directions=DIRECTIONS, nodes=NODES, arrivals=(time,))
    shares.append(100 * np.mean(early.answers.status == 0))
figure, axes = plt.subplots(figsize=(6, 3), layout="constrained")
axes.plot(times, shares, "o-")
axes.set(xlabel="there in, s", ylabel="avoided, %", ylim=(0, 105))
axes.grid(alpha=0.3)
plt.show()
