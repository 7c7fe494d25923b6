# ---
# jupyter:
#   kernelspec:
#     display_name: Python 3 (ipykernel)
#     language: python
#     name: python3
# ---

# %% [markdown]
# # Start: load, look, build, throw
#
# A character is made of clips. Where one clip can pass into another a motion graph gets a
# transition, and a walk over the graph is motion that never stops. When a ball comes, the walk is
# chosen that gets the body out of its way with little movement.

# %%
import os
import tempfile
from pathlib import Path

import mgjax

mgjax.enable_cache()  # compiled programs are kept: from the second time on it is quick

import matplotlib.pyplot as plt
import numpy as np

from mgjax.avoidance import ball_attack, explain, select
from mgjax.clips import synthetic_clips
from mgjax.graph import GraphConfig, build_graph, random_walk

WALK_S = 8.0
if os.environ.get("MGJAX_NOTEBOOK_SMOKE"):  # the tests run it small
    WALK_S = 1.0

# %% [markdown]
# ## Load
#
# The clips that come with the package are made by a program, and so are the labels, which say
# where something is avoided. With capture of your own it is `load_clips("folder")`.

# %%
clips, labels = synthetic_clips()
for clip in clips[:6]:
    kinds = ", ".join(
        f"{label.kind} {label.direction}".strip() for label in labels.get(clip.name, ())
    )
    print(f"{clip.name:16} {clip.motion.seconds:5.1f} s   {kinds}")
print(f"... {len(clips)} clips, {sum(clip.motion.seconds for clip in clips):.0f} s in all")

# %% [markdown]
# ## Look
#
# Whatever moves shows itself: play it, drag to turn it, roll to come nearer. Where no script may
# run there is the small moving picture. A duck, with a second before it:

# %%
clip = next(clip for clip in clips if clip.name == "duck")
middle = labels["duck"][0].start_s
mgjax.cut(clip.motion, round(30 * (middle - 1)), round(30 * (middle + 2)))

# %% [markdown]
# ## Build
#
# All windows of a third of a second are compared with all others. Pairs below the threshold become
# transitions, blended so that planted feet stay. No transition divides a labelled part.

# %%
graph = build_graph(clips, labels=labels, config=GraphConfig(threshold_m=0.05))
for name in ("frames", "transitions", "nodes", "edges", "labels_kept", "labels_enterable"):
    print(f"{name:18} {graph.report[name]}")

# %% [markdown]
# A walk: from each node any edge that leaves it. The timeline under the player says which clip is
# played, and where it is a transition.

# %%
random_walk(graph, 0, WALK_S, seed=3)

# %% [markdown]
# ## Throw
#
# Coordinates are those of the character: x to its left, y up, z ahead. The ball comes from 5 m
# ahead at head height and is there in 1.2 s.

# %%
attack = ball_attack(np.array([0, 1.4, 5.0]), np.array([0, 1.4, 0]), speed=10.0, arrives=1.2)
selection = select(graph, 0, attack)
print(f"{selection.status}, {100 * selection.clearance_m:.0f} cm clear")
selection

# %% [markdown]
# ## What else could it have done?
#
# Every candidate has its energies; the cheapest one that is clear was played.

# %%
rows = explain(graph, 0, attack)
print("rank  part              time scale  energy  clearance  outcome")
for row in rows[:8]:
    part = f"{graph.label_kind[row.part]} {graph.label_direction[row.part]}"
    clear = "" if row.clearance_m is None else f"{100 * row.clearance_m:.0f} cm"
    print(f"{row.rank:4}  {part:16}  {row.time_scale:10.2f}  {row.energy.total:6.3f}"
          f"  {clear:>9}  {row.outcome}")  # fmt: skip

# %%
timed = [row for row in rows if row.energy is not None]
terms = ("avoidance", "body", "timescale", "movement")
figure, axes = plt.subplots(figsize=(8, 3), layout="constrained")
for term in terms:
    axes.plot([getattr(row.energy, term) for row in timed], ".", markersize=4, label=term)
axes.set(xlabel="candidates, in the order of their energy", title="the terms of the energy")
axes.legend()
plt.show()

# %% [markdown]
# ## Keep it
#
# As BVH for other programs, or as a page to send to a friend.

# %%
with tempfile.TemporaryDirectory() as folder:
    mgjax.save_bvh(Path(folder) / "avoided.bvh", graph.skeleton, selection.motion)
    mgjax.save_html(Path(folder) / "avoided.html", selection)
    for file in sorted(Path(folder).iterdir()):
        print(f"{file.name}: {file.stat().st_size / 1e3:.0f} kB")
