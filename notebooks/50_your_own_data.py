# ---
# jupyter:
#   kernelspec:
#     display_name: Python 3 (ipykernel)
#     language: python
#     name: python3
# ---
# %% [markdown]
# # Your own data: from foreign BVH files to a ball that is avoided
#
# Files of another maker: other joint names, inches, nothing said about either. What their numbers
# mean is found in the motion. Labels and a threshold make a graph of them, and a ball is avoided.

# %%
import os
import tempfile
from dataclasses import replace
from pathlib import Path

import mgjax

mgjax.enable_cache()

import matplotlib.pyplot as plt
import numpy as np

from mgjax.avoidance import ball_attack, select
from mgjax.clips import Label, find_roles, load_clips, synthetic_clips
from mgjax.graph import GraphConfig, build_graph

THRESHOLDS = (0.03, 0.05, 0.08)  # m, of an adult
if os.environ.get("MGJAX_NOTEBOOK_SMOKE"):  # the tests run it small
    THRESHOLDS = (0.05,)

# %% [markdown]
# ## Foreign files
#
# Stand-ins for your own: four of the embedded clips, written with the joint names of a well-known
# game rig and in inches. Skip this cell and set `FOLDER` to a folder of yours.

# %%
names = {
    "root": "Hips",
    "lowerback": "Spine",
    "upperback": "Spine1",
    "thorax": "Spine2",
    "lowerneck": "Neck",
    "upperneck": "Neck1",
    "head": "Head",
}
for short, side in (("l", "Left"), ("r", "Right")):
    names |= {
        f"{short}{ours}": side + theirs
        for ours, theirs in (
            *(("hipjoint", "HipJoint"), ("femur", "UpLeg"), ("tibia", "Leg"), ("foot", "Foot")),
            *(("toes", "ToeBase"), ("clavicle", "Shoulder"), ("humerus", "Arm")),
            *(("radius", "ForeArm"), ("wrist", "Hand"), ("hand", "HandMiddle1")),
            *(("fingers", "HandMiddle2"), ("thumb", "HandThumb1")),
        )
    }
clips, labels = synthetic_clips()
scratch = tempfile.TemporaryDirectory()
FOLDER = Path(scratch.name)
inches = 1 / 2.54  # files are written in centimetres
for clip in clips:
    if clip.name in ("steps", "duck", "sway", "crouch_jump"):
        skeleton = replace(
            clip.skeleton,
            names=tuple(f"Rig:{names.get(name, name)}" for name in clip.skeleton.names),
            offsets=clip.skeleton.offsets * inches,
        )
        motion = replace(clip.motion, root_translation=clip.motion.root_translation * inches)
        mgjax.save_bvh(FOLDER / f"{clip.name}.bvh", skeleton, motion)
        text = (FOLDER / f"{clip.name}.bvh").read_text().split("\n")
        text[0] = "HIERARCHY"  # without the blanks that say that the unit is known
        (FOLDER / f"{clip.name}.bvh").write_text("\n".join(text))
print("\n".join((FOLDER / "duck.bvh").read_text().split("\n")[:9]))

# %% [markdown]
# ## What do the numbers mean?
#
# Lengths of legs and trunk say that these are inches, and how sure that is; the tree says which
# joint is which. On the command line `mgjax info FOLDER` says the same. What is known better goes
# into a `clips.toml` beside the files (`units = "in"`).

# %%
loaded, notes = load_clips(FOLDER)
for clip in loaded:
    unit, sure = clip.reading["unit"], clip.reading["unit_sure"]
    print(f"{clip.name:16} {clip.motion.num_frames:4} frames, {clip.motion.frame_rate:g} fps,"
          f" {unit} ({sure:.0%} sure), height {clip.reading['height_m']:.2f} m")  # fmt: skip
print(*notes, sep="\n")

# %%
roles = find_roles(loaded[0].skeleton)
print({role: loaded[0].skeleton.names[joint] for role, joint in roles.items()})

# %%
loaded[1]

# %% [markdown]
# ## Where does something happen?
#
# A label is an interval of a clip. A curve that shows what you look for helps to find it: a duck is
# where the head is low. `mgjax view edit --clips FOLDER` does it with the mouse and writes
# `labels.json`.

# %%
duck = next(clip for clip in loaded if clip.name == "duck.bvh")
places = np.asarray(mgjax.global_positions(duck.skeleton, duck.motion))
head = places[:, roles["head"], 1]
seconds = np.arange(len(head)) / duck.motion.frame_rate
low = head < head.max() - 0.15
begins = np.flatnonzero(low[1:] & ~low[:-1]) + 1
ends = np.flatnonzero(~low[1:] & low[:-1]) + 1
figure, axes = plt.subplots(figsize=(9, 2.6), layout="constrained")
axes.plot(seconds, head)
for begin, end in zip(begins, ends, strict=True):
    axes.axvspan(seconds[begin], seconds[end], alpha=0.25, color="tab:orange")
axes.set(xlabel="s", ylabel="head, m", title="duck.bvh, with what is to be labelled")
plt.show()

# %%
mine = {
    "duck.bvh": tuple(
        Label(start_s=float(seconds[begin]), end_s=float(seconds[end]), kind="duck")
        for begin, end in zip(begins, ends, strict=True)
    ),
    **{f"{name}.bvh": items for name, items in labels.items() if f"{name}.bvh" in
       {"steps.bvh", "sway.bvh", "crouch_jump.bvh"}},
}  # fmt: skip
for name, items in mine.items():
    print(name, ", ".join(f"{item.kind} {item.start_s:.2f}–{item.end_s:.2f} s" for item in items))

# %% [markdown]
# ## Which threshold?
#
# A higher one gives more transitions: more walks, which reach a part sooner, and blends of poses
# that are less alike. Without `threshold_m` the smallest is taken that keeps 90 % of the labels.

# %%
graphs = {
    threshold: build_graph(loaded, labels=mine, config=GraphConfig(threshold_m=threshold))
    for threshold in THRESHOLDS
}
print("threshold  transitions  nodes  labels kept  enterable")
for threshold, graph in graphs.items():
    report = graph.report
    print(f"{threshold:7.2f} m  {report['transitions']:11}  {graph.num_nodes:5}"
          f"  {report['labels_kept']:5} of {report['labels_total']}"
          f"  {report['labels_enterable']:9}")  # fmt: skip

# %% [markdown]
# ## Avoid
#
# The graph has the body of the files: its own names, its own proportions.

# %%
graph = graphs[0.05]
attack = ball_attack(np.array([0.5, 1.45, 5.0]), np.array([0, 1.45, 0]), speed=10.0, arrives=1.2)
selection = select(graph, 0, attack)
print(f"{selection.status}; joints are called {graph.skeleton.names[1]}, ...")
selection

# %%
scratch.cleanup()
