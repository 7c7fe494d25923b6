# ---
# jupyter:
#   kernelspec:
#     display_name: Python 3 (ipykernel)
#     language: python
#     name: python3
# ---
# %% [markdown]
# # Scale: what more motion costs
#
# All windows of a corpus are compared with all others, so twice the motion is four times the work.
# What is found is kept in stages, computed anywhere, and thinned, so that the graph itself grows
# with the length of its clips. Here that is measured on eight of the embedded clips and varied
# copies of them, and multiplied up.

# %%
import os
import tempfile
import time
from dataclasses import replace

import mgjax

mgjax.enable_cache()

import matplotlib.pyplot as plt
import numpy as np

from mgjax.avoidance import build_index
from mgjax.clips import Clip, synthetic_clips
from mgjax.graph import GraphConfig, Stages, build_graph, executor, stage_store

SPEEDS = (1.0, 0.9, 1.1, 1.2)  # copies are played at these speeds
SIZES = (1, 2, 3, 4)  # how many copies are taken
THRESHOLD_M = 0.05
if os.environ.get("MGJAX_NOTEBOOK_SMOKE"):  # the tests run it small
    SIZES = (1,)

# %% [markdown]
# ## A corpus
#
# Copies of the clips at other speeds. They are no new motion: real corpora are less alike.

# %%
clips, labels = synthetic_clips()
clips = clips[:8]
if os.environ.get("MGJAX_NOTEBOOK_SMOKE"):
    clips = clips[1:5]
copies = [
    [
        Clip(
            name=f"{clip.name}@{speed:g}",
            skeleton=clip.skeleton,
            motion=replace(mgjax.resample(clip.motion, 30 / speed), frame_rate=30.0),
        )
        for clip in clips
    ]
    for speed in SPEEDS
]
for count in SIZES:
    corpus = [clip for copy in copies[:count] for clip in copy]
    print(f"{count} copies: {len(corpus)} clips, {sum(c.motion.num_frames for c in corpus)} frames")

# %% [markdown]
# ## Time and size over length
#
# Each corpus is built twice and timed the second time, when its programs are compiled.

# %%
rows = []
for count in SIZES:
    corpus = [clip for copy in copies[:count] for clip in copy]
    for best in (0, 100, 20):
        config = GraphConfig(threshold_m=THRESHOLD_M, best_per_s=best)
        build_graph(corpus, config=config)
        begin = time.process_time()
        graph = build_graph(corpus, config=config)
        rows.append(
            {
                "frames": sum(clip.motion.num_frames for clip in corpus),
                "best_per_s": best,
                "cpu_s": time.process_time() - begin,
                "transitions": graph.report["transitions"],
            }
        )
for row in rows:
    print(f"{row['frames']:6} frames, best_per_s {row['best_per_s']:3}:"
          f" {row['cpu_s']:5.2f} s of CPU, {row['transitions']:6} transitions")  # fmt: skip

# %%
figure, (left, right) = plt.subplots(1, 2, figsize=(10, 3.2), layout="constrained")
for best in (0, 100, 20):
    some = [row for row in rows if row["best_per_s"] == best]
    frames = [row["frames"] for row in some]
    left.plot(frames, [row["cpu_s"] for row in some], "o-", label=f"best_per_s = {best}")
    right.plot(frames, [row["transitions"] for row in some], "o-")
left.set(xlabel="frames", title="CPU seconds of a build")
right.set(xlabel="frames", title="transitions")
left.legend()
plt.show()

# %% [markdown]
# ## Stages: what is there is not done again
#
# Every block of the work is a file named by what it was made of. A build that was killed goes on,
# and one with more clips does what is new; the graph is the same bit for bit.

# %%
config = GraphConfig(threshold_m=THRESHOLD_M)
with tempfile.TemporaryDirectory() as folder:
    for name, taken in (
        ("all but one clip", copies[0][:-1]),
        ("one more", copies[0]),
        ("again", copies[0]),
    ):
        store = stage_store(folder)
        begin = time.process_time()
        staged = build_graph(taken, config=config, stages=Stages(store=store))
        cpu_s, read, made = time.process_time() - begin, store.found.total(), store.made.total()
        print(f"{name:17} {cpu_s:5.2f} s of CPU, {read:3} files read, {made:3} made")

# %% [markdown]
# ## Executors
#
# Blocks are computed by any executor of `concurrent.futures`: here threads; `"processes"` and
# `"ray"` are other machines' cores by the same line. Whoever computes them, the result is the same.

# %%
with executor("threads", 2) as pool:
    threaded = build_graph(copies[0], config=config, stages=Stages(executor=pool))
same = all(
    np.array_equal(getattr(staged, name), getattr(threaded, name))
    for name in ("edge_source", "edge_target", "edge_frames")
)
print("the same graph:", same)

# %% [markdown]
# ## The index
#
# Which walks reach an avoidance part in time, and what space they need, follows from little.

# %%
named = {f"{name}@1": items for name, items in labels.items() if f"{name}@1" in
         {clip.name for clip in copies[0]}}  # fmt: skip
labelled = build_graph(copies[0], labels=named, config=config)
index = build_index(labelled)
minutes = sum(clip.motion.seconds for clip in copies[0]) / 60
print(f"{index.nbytes / 1e6:.2f} MB for {minutes:.1f} min of motion:"
      f" {index.nbytes / 1e6 / minutes * 60:.0f} MB per hour")  # fmt: skip

# %% [markdown]
# ## The arithmetic
#
# The power of the length with which time grows, and what that makes of 40 hours. Copies are more
# alike than capture, so this is pessimistic; [docs/scaling.md](../docs/scaling.md) has the same of
# real corpora, with what handing out blocks costs.

# %%
some = [row for row in rows if row["best_per_s"] == 100]
if len(some) > 1:
    power, _ = np.polyfit(
        np.log([row["frames"] for row in some]), np.log([row["cpu_s"] for row in some]), 1
    )
    print(f"time goes with the power {power:.1f} of the length")
    largest = some[-1]
    for hours in (1, 4, 40):
        cpu_h = largest["cpu_s"] * (hours * 3600 * 30 / largest["frames"]) ** 2 / 3600
        cores = ", ".join(f"{cpu_h / n:.2g} h on {n}" for n in (1, 16, 256))
        print(f"{hours:3} h of motion, with the power 2: {cores} cores")
