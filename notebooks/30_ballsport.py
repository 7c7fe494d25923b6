# ---
# jupyter:
#   kernelspec:
#     display_name: Python 3 (ipykernel)
#     language: python
#     name: python3
# ---

# %% [markdown]
# # From the curves of a kick to a scene of three
#
# A kick is found where a foot is high (F_H) and fast (F_S); between the two it can hit a ball
# (S_B). A live kick is matched to stored ones, a ball is aimed through its bounces, and players
# pass it to one another (Choi, Kim, Kim and Kang 2019).

# %%
PASSES = 6
TAKES = 2  # embedded kicks of each kind and foot
SEED = 0

# %%
import os

import mgjax

mgjax.enable_cache()

import matplotlib.pyplot as plt
import numpy as np

from mgjax.ballsport import (
    AnalysisConfig,
    BallPhysics,
    ClipSetConfig,
    Matcher,
    Pass,
    Player,
    SceneConfig,
    aim,
    analyse,
    build_clip_set,
    build_scene,
    fly,
    hit_joint,
    mark,
)
from mgjax.pictures import scene_figure

if os.environ.get("MGJAX_NOTEBOOK_SMOKE"):  # the tests run it small
    PASSES, TAKES = 2, 1

# %% [markdown]
# ## The curves of a foot

# %%
clips = build_clip_set(config=ClipSetConfig(), seed=SEED, takes=TAKES)
rate, hit = clips.motion.frame_rate, 0
first, last = (int(x[clips.hit_clip[hit]]) for x in (clips.clip_starts, clips.clip_stops))
positions = clips.positions[first:last]
bone = clips.hit_bone[hit]
marks = mark(positions[:, hit_joint(clips.skeleton, bone)].astype(float), rate, AnalysisConfig())
time = np.arange(last - first) / rate
figure, axes = plt.subplots(figsize=(9, 3))
axes.plot(time, marks.height, "k", label="height, m")
axes.plot(time, 0.1 * np.asarray(marks.speed), color="tab:orange", label="speed, 10 m/s")
kicks = analyse(clips.skeleton, positions, rate, bones=(bone,), config=AnalysisConfig())
for found in kicks:
    axes.axvspan(found.hit.start / rate, found.hit.stop / rate, alpha=0.15)
    axes.axvspan(found.hit.hit_start / rate, found.hit.hit_stop / rate, alpha=0.35, color="tab:red")
axes.set(xlabel="s", title=f"{bone}: S_H blue, S_B red")
axes.legend()
plt.show()

# %% [markdown]
# ## Which stored kick is it?

# %%
# Stored: kicks of the same kinds, drawn anew.
stored = build_clip_set(config=ClipSetConfig(), seed=SEED + 1, takes=TAKES)
matcher = Matcher(stored)
matched = matcher.match(kicks[0].vector, bone, clips.leg_length)
nearest = stored.hit_kind[matched.hit]
print(f"a {clips.hit_kind[hit]} with the {bone} is nearest to a {nearest}")

# %% [markdown]
# ## A ball aimed through a bounce

# %%
physics = BallPhysics()
start, goal = np.array([0.0, 0.3, 0.0]), np.array([1.0, 0.6, 6.0])
figure, axes = plt.subplots(figsize=(9, 2.6))
for bounces in (0, 1, 2):
    guess = np.array([0.5, 4.0, 5.0])
    found = aim(start, goal, bounces=bounces, guess=guess, physics=physics)
    path = fly(start, found.velocity, np.linspace(0, float(found.time), 200), physics=physics)
    axes.plot(np.asarray(path)[:, 2], np.asarray(path)[:, 1], label=f"{bounces} bounces")
    print(f"{bounces} bounces: {np.linalg.norm(found.velocity):.1f} m/s, {float(found.time):.2f} s")
axes.set(xlabel="z, m", ylabel="y, m")
axes.legend()
plt.show()

# %% [markdown]
# ## Three players

# %%
names = ("Ana", "Ben", "Cem")
places = ((0.0, -2.2), (1.9, 2.4), (-1.9, 2.4))
players = tuple(Player(name=n, x=x, z=z) for n, (x, z) in zip(names, places, strict=True))
passes = tuple(Pass(by=names[k % 3], to=names[(k + 1) % 3]) for k in range(PASSES))
scene = build_scene(SceneConfig(players=players, passes=passes, seed=SEED, takes=TAKES))
for by, to in scene.ends:
    print(f"{by or 'thrown in'} -> {to or 'nobody'}")
scene_figure(scene)

# %% [markdown]
# Played: who kicks looks where the ball is to go, and each ball meets the next foot.

# %%
scene
