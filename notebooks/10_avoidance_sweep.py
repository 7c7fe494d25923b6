# ---
# jupyter:
#   kernelspec:
#     display_name: Python 3 (ipykernel)
#     language: python
#     name: python3
# ---

# %% [markdown]
# # Sweeping the energies of an avoidance
#
# A ball flies at a character that stands somewhere in a motion graph. All walks whose avoidance
# part comes at about the right time are candidates; each is worth
# $e = w_a e_\mathrm{avoidance} + w_b e_\mathrm{body} + w_t e_\mathrm{timescale}$ (Oshita and
# Masaoka 2011) $+ w_m e_\mathrm{move}$, and the cheapest one that stays clear is played.
#
# What do the scales $E_\mathrm{avoidance}$, $D_\mathrm{body}$ and the weights change? Candidates
# are judged once per ball; one compiled call ranks them again for a whole grid of settings. Every
# answer is the one that a search with that setting gives.

# %%
GRAPH = ""  # folder of a graph made by `mgjax build`; empty: the graph of the embedded clips
BALLS = 60
POINTS = 13  # values per setting
SEED = 0

# %%
import os
from dataclasses import replace

import mgjax

mgjax.enable_cache()

import matplotlib.pyplot as plt
import numpy as np

from mgjax.avoidance import (
    AvoidanceConfig,
    EnergyConfig,
    Status,
    ball_attack,
    select,
    sweep_energies,
)
from mgjax.clips import synthetic_clips
from mgjax.graph import GraphConfig, build_graph, load_graph

if os.environ.get("MGJAX_NOTEBOOK_SMOKE"):  # the tests run it small
    BALLS, POINTS = 3, 4

# %% [markdown]
# ## A graph

# %%
if GRAPH:
    graph = load_graph(GRAPH)
else:
    clips, labels = synthetic_clips()
    graph = build_graph(clips, labels=labels, config=GraphConfig(threshold_m=0.05))
print(f"{graph.num_nodes} nodes, {graph.num_edges} edges, {len(graph.label_edge)} avoidance parts")

# %% [markdown]
# ## Throws
#
# 10 m/s from any side, 0.5–1.7 m high over the root, there in 1.2 s, at random nodes.

# %%
rng = np.random.default_rng(SEED)
nodes = rng.integers(graph.num_nodes, size=BALLS)
sides = rng.uniform(0, 2 * np.pi, size=BALLS)
aims = np.stack([np.zeros(BALLS), rng.uniform(0.5, 1.7, size=BALLS), np.zeros(BALLS)], axis=1)
starts = aims + 5.0 * np.stack([np.sin(sides), np.zeros(BALLS), np.cos(sides)], axis=1)
balls = [
    ball_attack(start, aim, speed=10.0, arrives=1.2)
    for start, aim in zip(starts, aims, strict=True)
]

# %% [markdown]
# ## The grid
#
# Each setting is varied alone, from a sixteenth of its default to sixteen times that; the first
# setting of the grid is the default. Then $E_\mathrm{avoidance}$ and $D_\mathrm{body}$ together.

# %%
default = EnergyConfig()
names = ["E_avoidance", "D_body", "w_a", "w_b", "w_t"]
factors = np.geomspace(1 / 16, 16, POINTS)
grid = [default]
grid += [replace(default, **{name: getattr(default, name) * f}) for name in names for f in factors]
plane = [
    replace(default, E_avoidance=default.E_avoidance * e, D_body=default.D_body * d)
    for e in factors
    for d in factors
]
answers = [
    sweep_energies(graph, int(node), ball, grid + plane)
    for node, ball in zip(nodes, balls, strict=True)
]
print(f"{len(grid) + len(plane)} settings, {BALLS} balls")

# %%
settings = range(len(grid) + len(plane))
avoided = np.array([answer.status == Status.AVOIDED.code for answer in answers])
clearance = np.where(avoided, [answer.clearance for answer in answers], np.nan)
scaling = np.where(avoided, [np.abs(np.log(answer.time_scale)) for answer in answers], np.nan)
changed = np.array([[answer.path(g) != answer.path(0) for g in settings] for answer in answers])
print(f"avoided by default: {avoided[:, 0].mean():.0%}")

# %% [markdown]
# ## What changes
#
# Success hardly depends on the energies: they say which of the clear walks is played, and nearly
# any order finds a clear one if there is one. What they change is the walk.

# %%
figure, columns = plt.subplots(1, 3, figsize=(13, 3.6), layout="constrained")
for number, name in enumerate(names):
    rows = slice(1 + number * POINTS, 1 + (number + 1) * POINTS)
    columns[0].plot(factors, 100 * changed[:, rows].mean(axis=0), label=name)
    columns[1].plot(factors, 100 * np.nanmean(clearance[:, rows], axis=0))
    columns[2].plot(factors, np.exp(np.nanmean(scaling[:, rows], axis=0)))
titles = ["another walk than the default's, %", "mean clearance, cm", "mean time scale, s or 1/s"]
for axes, title in zip(columns, titles, strict=True):
    axes.set(xscale="log", xlabel="setting / its default", title=title)
    axes.grid(alpha=0.3)
figure.legend(loc="outside right upper")
plt.show()

# %% [markdown]
# ## The same ball, answered twice
#
# By default, and where the deviation of the body weighs sixteen times as much: of the balls thrown,
# the first for which that is another walk.

# %%
heavy = 1 + 4 * POINTS - 1  # of the grid: the largest w_b
other = np.flatnonzero(changed[:, heavy] & avoided[:, 0] & avoided[:, heavy])
number = int(other[0]) if len(other) else 0
select(graph, int(nodes[number]), balls[number])

# %%
select(graph, int(nodes[number]), balls[number], config=AvoidanceConfig(energy=grid[heavy]))

# %% [markdown]
# ## Where the energies are saturated

# %%
shares = {
    "e_avoidance = 0": [answer.avoidance <= 0 for answer in answers],
    "e_avoidance = 1": [answer.avoidance >= 1 for answer in answers],
    "e_body = 1": [answer.body >= 1 for answer in answers],
}
figure, columns = plt.subplots(1, 2, figsize=(9, 3.4), layout="constrained", sharey=True)
for number, axes in enumerate(columns):
    rows = slice(1 + number * POINTS, 1 + (number + 1) * POINTS)
    for label, share in shares.items():
        axes.plot(factors, 100 * np.mean(share, axis=0)[rows], label=label)
    axes.set(xscale="log", xlabel=f"{names[number]} / its default", ylim=(0, 100))
    axes.grid(alpha=0.3)
columns[0].set_ylabel("chosen walks whose energy is saturated, %")
columns[1].legend()
plt.show()

# %%
tables = {
    "another walk than the default's, %": 100 * changed[:, len(grid) :].mean(axis=0),
    "mean clearance, cm": 100 * np.nanmean(clearance[:, len(grid) :], axis=0),
}
figure, columns = plt.subplots(1, 2, figsize=(10, 4), layout="constrained")
ends = np.log2(factors[[0, -1]])
for axes, (title, values) in zip(columns, tables.items(), strict=True):
    image = axes.imshow(
        values.reshape(POINTS, POINTS), origin="lower", aspect="auto", extent=(*ends, *ends)
    )
    axes.set(xlabel="D_body, doublings", ylabel="E_avoidance, doublings", title=title)
    figure.colorbar(image, ax=axes)
plt.show()
