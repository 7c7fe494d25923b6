# ---
# jupyter:
#   kernelspec:
#     display_name: Python 3 (ipykernel)
#     language: python
#     name: python3
# ---

# %% [markdown]
# # Sketch, walk, reach
#
# A path is sketched on the floor, a motion graph is searched for the walk that follows it (eq. 7 of
# Kalouache and Cherif: the squared distances to the points of the path at the same arc length), and
# a hand reaches for a target on the way.

# %%
GRAPH = ""  # folder of a graph with locomotion made by `mgjax build`; empty: the embedded clips
LENGTH_M = 6.0
SECONDS = 20.0  # time limit of the search

# %%
import os

import mgjax

mgjax.enable_cache()

import matplotlib.pyplot as plt
import numpy as np

from mgjax.clips import synthetic_clips
from mgjax.graph import GraphConfig, build_graph, load_graph
from mgjax.hybrid import PathConfig, fabrik, follow, make_sketch, make_target, reach
from mgjax.pictures import distances, hands_above, top_view

if os.environ.get("MGJAX_NOTEBOOK_SMOKE"):  # the tests run it small
    LENGTH_M = 2.0

# %% [markdown]
# ## A graph and a sketch

# %%
if GRAPH:
    graph = load_graph(GRAPH)
else:
    clips, _ = synthetic_clips()
    graph = build_graph(clips, config=GraphConfig(threshold_m=0.05))
along = np.linspace(0, 1, 9)
points = np.stack([0.15 * LENGTH_M * np.sin(2 * np.pi * along), LENGTH_M * along], axis=1)
sketch = make_sketch(points, spline=True)
print(f"{graph.num_nodes} nodes, {graph.num_edges} edges; a path of {LENGTH_M:g} m and its bends")

# %% [markdown]
# ## The walk
#
# Depth-first branch and bound within a horizon of a few seconds; a beam gives it a walk to beat.

# %%
walked = follow(graph, sketch, config=PathConfig(time_limit_s=SECONDS))
print(f"{walked.status}: {walked.seconds:.1f} s of motion, searched in {walked.search_s:.2f} s")
print(f"mean distance to the path {walked.mean_distance:.3f} m, error of eq. 7 {walked.error:.3f}")
figure, axes = plt.subplots(figsize=(5, 6))
top_view(axes, graph, sketch, walked)
axes.legend(loc="best", fontsize=8)
plt.show()

# %%
walked

# %% [markdown]
# ## Reaching on the way
#
# The right hand wants a point beside the path, head-high, held for half a second. If it is out of
# range there, the walk is extended until it is not; then the arm is solved in each frame from the
# frame before, and blended in and out while the legs keep the walk.

# %%
middle = walked.track.places[len(walked.track.places) // 2]
target = make_target("right_hand", place=[middle[0] - 0.3, 1.5, middle[1] + 0.2], when="passing")
reached = reach(graph, sketch, (target,), path=PathConfig(time_limit_s=SECONDS))
for row in reached.targets:
    print(row.target.limb, row.status, f"off by {1000 * row.error_m:.1f} mm")
figure, columns = plt.subplots(1, 2, figsize=(10, 4), layout="constrained")
top_view(columns[0], graph, sketch, reached.walked)
hands_above(columns[0], graph, reached)
distances(columns[1], graph, reached)
plt.show()

# %%
reached

# %% [markdown]
# ## Inverse kinematics alone
#
# `fabrik` solves chains of any length, many at once; bone lengths stay exact.

# %%
rng = np.random.default_rng(0)
chain = np.concatenate([np.zeros((1, 3)), np.cumsum(rng.uniform(0.1, 0.3, (6, 3)), axis=0)])
targets = rng.normal(scale=0.5, size=(200, 3))
solved, status = fabrik(
    np.broadcast_to(chain, (200, 7, 3)).astype(np.float32), targets.astype(np.float32)
)
off = np.linalg.norm(np.asarray(solved)[:, -1] - targets, axis=1)
print(f"{np.mean(np.asarray(status) == 0):.0%} reached, the farthest of them off by"
      f" {1000 * off[np.asarray(status) == 0].max():.2f} mm")  # fmt: skip
positions = np.asarray(mgjax.global_positions(graph.skeleton, reached.motion))
print(f"lowest joint of the whole walk {positions[..., 1].min():.3f} m above the floor")
