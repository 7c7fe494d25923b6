# ---
# jupyter:
#   kernelspec:
#     display_name: Python 3 (ipykernel)
#     language: python
#     name: python3
# ---

# %% [markdown]
# # Gradients
#
# Energies, clearances and the ball's flight are differentiable, so settings can be fitted to what
# people prefer, and a throw to where it should bounce. What is differentiable with respect to
# what is a table in `docs/gradients.md`.

# %%
TRIALS = 60  # attacks that the made-up observer is asked about
STEPS = 400  # of the fit
SEED = 0

# %%
import os

import mgjax

mgjax.enable_cache()

import jax
import jax.numpy as jnp
import matplotlib.pyplot as plt
import numpy as np
import optax

from mgjax.avoidance import EnergyConfig, Measures, ball_attack, explain, score, soft_energies
from mgjax.ballsport import BallPhysics, contact_times, fly
from mgjax.clips import synthetic_clips
from mgjax.graph import GraphConfig, build_graph

if os.environ.get("MGJAX_NOTEBOOK_SMOKE"):  # the tests run it small
    TRIALS, STEPS = 4, 20

# %% [markdown]
# ## Corners, and how they are blurred
#
# One sphere steps out of the way of a ball. The energies of the paper are flat where the step is
# large, and $e_\mathrm{body}$ jumps where the clearance is what it was without a reaction. The
# soft forms have slopes everywhere; as the temperature falls they become the paper's.

# %%
steps = np.linspace(-0.1, 0.8, 181)
ball = np.zeros((12, 1, 3), np.float32)
ball[:, 0, 2] = np.linspace(1.5, -1.5, 12)
body = np.zeros((len(steps), 12, 1, 3), np.float32)
body[:, :, 0, 0] = steps[:, None] * np.linspace(0, 1, 12)
radii = np.float32([0.12]), np.float32([0.2])
always = np.ones(12, bool)
config = EnergyConfig(D_body=0.3)
figure, columns = plt.subplots(1, 2, figsize=(10, 3.4), layout="constrained")
for tau in (0.1, 0.03, 0.01, 1e-4):
    soft = jax.vmap(
        lambda spheres, tau=tau: soft_energies(
            ball, radii[0], spheres, radii[1], spheres[0], always, always,
            dt=0.05, config=config, temperature=tau,
        )
    )(body)  # fmt: skip
    for axes, values in zip(columns, (soft.avoidance, soft.body), strict=True):
        axes.plot(steps, values, label=f"{100 * tau:g} cm")
for axes, name in zip(columns, ("e_avoidance", "e_body"), strict=True):
    axes.set(xlabel="step aside, m", title=name)
    axes.grid(alpha=0.3)
columns[1].legend(title="temperature")
plt.show()

# %% [markdown]
# ## Whose weights are these?
#
# `explain` lists all candidates of an attack with what was measured of each: $e'$, $d$, $d_0$, how
# far the body moves, the time scale. `score` makes energies of that, and is differentiable in the
# settings. A made-up observer picks by settings of its own, with some noise.

# %%
clips, labels = synthetic_clips()
graph = build_graph(clips, labels=labels, config=GraphConfig(threshold_m=0.05))
rng = np.random.default_rng(SEED)
tables = []
while len(tables) < TRIALS:
    side, height = rng.uniform(0, 2 * np.pi), rng.uniform(0.5, 1.7)
    aim = np.array([0, height, 0])
    start = aim + 5.0 * np.array([np.sin(side), 0, np.cos(side)])
    attack = ball_attack(start, aim, speed=10.0, arrives=1.2)
    rows = explain(graph, int(rng.integers(graph.num_nodes)), attack).rows()
    rows = [row for row in rows if row["energy_total"] is not None]
    if len(rows) > 1:
        tables.append(rows)
most = max(len(rows) for rows in tables)
present = np.array([[k < len(rows) for k in range(most)] for rows in tables])
fields = {
    "penetration": "energy_penetration",
    "d": "energy_d",
    "d0": "energy_d0",
    "displacement": "energy_displacement",
    "s_time": "time_scale",
}
measures = Measures(
    **{
        name: jnp.asarray(
            [[rows[min(k, len(rows) - 1)][field] for k in range(most)] for rows in tables],
            jnp.float32,
        )
        for name, field in fields.items()
    }
)
print(f"{TRIALS} attacks, {present.sum()} candidates")

# %%
names = ("w_a", "w_b", "w_t", "w_m", "E_avoidance", "D_body")
observer = dict(zip(names, (2.0, 6.0, 1.0, 12.0, 0.01, 0.25), strict=True))
NOISE = 0.05  # of what the observer thinks of a candidate
truth = score(measures, EnergyConfig(**observer)).total
seen = truth + rng.gumbel(size=truth.shape) * NOISE
picks = np.argmin(np.where(present, seen, np.inf), axis=1)

# %% [markdown]
# A candidate is picked with a probability of $\exp(-e)$ over the sum of all. Logarithms of the
# settings are fitted by Adam, from the defaults; learning on three quarters of the trials.

# %%
learn = np.arange(TRIALS) < max(3 * TRIALS // 4, 1)
begin = {name: jnp.log(jnp.float32(max(getattr(EnergyConfig(), name), 0.1))) for name in names}
totals = jax.jit(
    lambda logs: jnp.where(
        present,
        score(measures, EnergyConfig(**{k: jnp.exp(v) for k, v in logs.items()})).total,
        jnp.inf,
    )
)
loss = jax.jit(
    jax.value_and_grad(
        lambda logs: (
            -jnp.mean(
                jax.nn.log_softmax(-totals(logs), axis=1)[np.flatnonzero(learn), picks[learn]]
            )
        )
    )
)
optimiser = optax.adam(0.03)
logs, state, losses, slopes = begin, optimiser.init(begin), [], []
for _ in range(STEPS):
    value, slope = loss(logs)
    updates, state = optimiser.update(slope, state)
    logs = optax.apply_updates(logs, updates)
    losses.append(float(value))
    slopes.append(max(abs(float(x)) for x in slope.values()))
assert np.isfinite(slopes).all()
agree = {
    who: np.argmin(np.asarray(totals(some)), axis=1) == picks
    for who, some in (("defaults", begin), ("fitted", logs))
}
for who, right in agree.items():
    print(
        f"{who}: picks the same in {right[learn].mean():.0%}, held out {right[~learn].mean():.0%}"
    )
fitted = {name: float(jnp.exp(value)) for name, value in logs.items()}
for name in names:
    unit = (observer["w_t"], fitted["w_t"]) if name.startswith("w_") else (1, 1)
    print(
        f"{name + ' / w_t' * name.startswith('w_'):12}"
        f" observer {observer[name] / unit[0]:7.3f}   fitted {fitted[name] / unit[1]:7.3f}"
    )

# %%
figure, axes = plt.subplots(figsize=(6, 3.2), layout="constrained")
axes.plot(losses)
axes.set(xlabel="step", ylabel="negative log likelihood of a pick")
axes.grid(alpha=0.3)
plt.show()

# %% [markdown]
# Weights are in units of the observer's noise, so twice the weights are the same preferences with
# half the noise; what counts are their ratios. For picks of real people there is `mgjax study`,
# with intervals, and a test of whether there is anything to fit.

# %% [markdown]
# ## A ball to a wanted bounce
#
# Where does a throw meet the ground for the second time? The place is differentiable through the
# first bounce, so a few Gauss–Newton steps with the smallest change lead it to where it should be.

# %%
physics = BallPhysics()
start = jnp.float32([0, 1.2, 0])
wanted = jnp.float32([6.0, 2.0])  # on the floor, x and z
bounce = jax.jit(
    lambda v: fly(start, v, contact_times(start, v, physics=physics)[1:2], physics=physics)[0]
)
velocity = jnp.float32([4.0, 1.0, 0.0])
tried = [velocity]
for _ in range(8):
    miss = bounce(velocity)[jnp.array([0, 2])] - wanted
    slope = jax.jacrev(bounce)(velocity)[jnp.array([0, 2])]
    velocity = velocity - jnp.linalg.pinv(slope) @ miss
    tried.append(velocity)
left = float(jnp.linalg.norm(bounce(velocity)[jnp.array([0, 2])] - wanted))
print(f"missed by {1000 * left:.3f} mm, velocity {np.asarray(velocity).round(3)} m/s")

# %%
times = jnp.linspace(0, 2, 200)
figure, axes = plt.subplots(figsize=(8, 3.2), layout="constrained")
for number, v in enumerate(tried[:4]):
    way = fly(start, v, times, physics=physics)
    axes.plot(way[:, 0], way[:, 1], label=f"after {number} steps")
axes.axvline(float(wanted[0]), color="k", lw=0.8, ls=":")
axes.set(xlabel="x, m", ylabel="height, m")
axes.legend()
plt.show()
