"""The energies of candidate paths: how well each one avoids an attack, and how modestly.

One kernel judges many candidates. Its arrays have the components outermost and the candidates
last, and it streams over time: per pair of spheres it keeps one sum and two smallest *squared*
distances, so a root is taken once per pair and not once per time. :func:`energies` is the same
kernel with one candidate.

The counterfactual body, which stops moving when the avoidance begins, is treated as a second body
whose spheres are those of the first until then. While the avoidance lasts it stands at t0, so it
serves both e' (eq. 5) and d0 (eq. 8).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial, reduce
from typing import NamedTuple, TypeAlias

import jax
import jax.numpy as jnp
from jax import lax
from jaxtyping import Bool, Float

from mgjax.avoidance.config import EnergyConfig, Number
from mgjax.core.arrays import Array
from mgjax.core.errors import ConfigError
from mgjax.core.pytree import register

FAR = 1e6
"""Clearance of a path that meets no active attack, m: large, but finite."""

_SAME = 1e-5
"""Clearances that differ by less, m, are equal: rounding, some metres from the origin."""

_TINY = 1e-20
"""Squared length under which two points coincide or a sphere stands still, m²."""

_WIDE = 64
"""Candidates from which straight code over time pays for its compilation."""

_STRAIGHT = 128
"""Most times that are written out as straight code; 0.05 s of compilation each."""

_BLOCK = 10
"""Times in one piece of straight code. Longer ones leave the cache, and from about 50 on the
compiler stops vectorising them."""

Vector: TypeAlias = tuple[Array, ...]
Totals: TypeAlias = tuple[Array, Array, Array]

register("form", "d0")(EnergyConfig)


@register()
@dataclass(frozen=True, kw_only=True)
class Energies:
    """What one path, or each of many, is worth. Smaller energies are better.

    Attributes:
        avoidance: e_avoidance (eq. 6), 0 … 1.
        body: e_body (eq. 8), 0 … 1.
        penetration: e' (eq. 4), m·s: what the avoidance moved out of the attack's way.
        d: least clearance of attack and body (eq. 7), m; negative where the body is hit. ``FAR``
            where no time is active.
        d0: the same had the body frozen when the avoidance began, m; never clamped here.
    """

    avoidance: Float[Array, "*c"]
    body: Float[Array, "*c"]
    penetration: Float[Array, "*c"]
    d: Float[Array, "*c"]
    d0: Float[Array, "*c"]


class _Paths(NamedTuple):
    """The candidates, as the kernel reads them."""

    centres: Float[Array, "3 T S C"]
    start: Float[Array, "3 S C"]
    radii: Float[Array, " S"]
    frozen: Bool[Array, "T C"]
    active: Bool[Array, "T C"]
    scored: Bool[Array, "T C"]


class _Sums(NamedTuple):
    """What one pass over time keeps, per body sphere and candidate."""

    moved: Float[Array, "S C"]
    nearest: Float[Array, "S C"]
    nearest0: Float[Array, "S C"]
    last: Vector
    last0: Vector
    active: Bool[Array, "1 C"]


@jax.jit
def energies(
    attack_centres: Float[Array, "T I 3"],
    attack_radii: Float[Array, " I"],
    body_centres: Float[Array, "T S 3"],
    body_radii: Float[Array, " S"],
    start_centres: Float[Array, "S 3"],
    avoidance_mask: Bool[Array, " T"],
    active_mask: Bool[Array, " T"],
    *,
    dt: Float[Array, ""] | float,
    config: EnergyConfig,
) -> Energies:
    """Energies of one path against one attack (eqs 4–8); see :func:`energies_batch`.

    Args:
        attack_centres: centres of the attack's spheres at the evaluated times, world, m.
        attack_radii: their radii, m.
        body_centres: centres of the body's spheres at the same times, world, m.
        body_radii: their radii, m.
        start_centres: centres of the body's spheres at t0, the start of the avoidance part, m.
        avoidance_mask: times inside the avoidance part.
        active_mask: times at which the attack is there.
        dt: interval of the evaluated times, s.
        config: forms, scales and weights.

    Returns:
        Energies with scalar fields.
    """
    batch = energies_batch(
        jnp.moveaxis(jnp.asarray(attack_centres), -1, 0),
        attack_radii,
        jnp.moveaxis(jnp.asarray(body_centres), -1, 0)[..., None],
        body_radii,
        jnp.moveaxis(jnp.asarray(start_centres), -1, 0)[..., None],
        jnp.asarray(avoidance_mask)[:, None],
        jnp.asarray(active_mask)[:, None],
        dt=dt,
        config=config,
    )
    return jax.tree.map(lambda field: field[0], batch)


@partial(jax.jit, static_argnames="swept")
def energies_batch(
    attack_centres: Float[Array, "3 T I"],
    attack_radii: Float[Array, " I"],
    body_centres: Float[Array, "3 T S C"],
    body_radii: Float[Array, " S"],
    start_centres: Float[Array, "3 S C"],
    avoidance_mask: Bool[Array, "T C"],
    active_mask: Bool[Array, "T C"],
    *,
    dt: Float[Array, ""] | float,
    config: EnergyConfig,
    swept: bool = True,
) -> Energies:
    """Energies of many candidates against one attack (Oshita & Masaoka 2011, eqs 4–8).

    With D(S1, S2) = distance of the centres − both radii:

    - e' (eqs 4–5) sums max(0, −x) Δt over the times that are active *and* in the avoidance mask and
      over all pairs of spheres, where x compares the body at t0 with the body at t
      (``config.form``); e_avoidance = max(0, 1 − e'/E_avoidance) (eq. 6).
    - d (eq. 7) is the smallest D over the active times. Between two consecutive active times both
      centres move linearly and the smallest distance is exact.
    - d0 is the same for the body that is frozen at ``start_centres`` from the first true entry of
      the avoidance mask on; it moves linearly into that pose during the interval before. Without
      such an entry d0 = d.
    - e_body (eq. 8) is (d − d0)/D_body between d0 and d0 + D_body, and 1 outside.

    Everything is computed in float32. Entries at masked times must be finite and change nothing.
    First derivatives are exact and finite, also for coincident centres and spheres at rest; second
    derivatives treat the time of closest approach as fixed. A NaN at an active time makes d NaN.

    Deviation:
        Eq. 6 is garbled in print and read as above. Eq. 5 as printed also counts a body that moves
        away from an attack that is metres off; the default ``form="overlap"`` counts penetration
        only. Eq. 7 takes the minimum over sampled times; here it is swept, since a ball at 10 m/s
        moves 0.5 m in 1/20 s. Eq. 8 uses max(d0, 0) by default. A d less than 10 µm above
        d0 counts as d ≤ d0, so that rounding cannot make a body that never moved look modest.

    Args:
        attack_centres: centres of the attack's spheres, world, m.
        attack_radii: their radii, m.
        body_centres: centres of each candidate's body spheres, world, m.
        body_radii: their radii, the same for all candidates, m.
        start_centres: the body's spheres at t0, the start of each avoidance part, m.
        avoidance_mask: times inside each candidate's avoidance part.
        active_mask: times at which the attack is there.
        dt: interval of the evaluated times, s.
        config: forms, scales and weights.
        swept: without it d and d0 look at the sampled times only. They are then upper bounds, by at
            most half the largest relative displacement of one interval: a negative one is a hit.
            The sweep does not even double the time, so sorting out the candidates that need it does
            not pay.

    Returns:
        Energies with fields ``[C]``.

    Raises:
        ConfigError: an unknown ``form`` or ``d0``.
    """
    if config.form not in ("paper", "overlap") or config.d0 not in ("clamped", "paper"):
        raise ConfigError(f"unknown energy form {config.form!r} or d0 {config.d0!r}")
    avoidance, active = jnp.asarray(avoidance_mask), jnp.asarray(active_mask)
    times = jnp.arange(active.shape[0])[:, None]
    first = jnp.min(jnp.where(avoidance, times, active.shape[0]), axis=0, keepdims=True)
    paths = _Paths(
        centres=_float32(body_centres),
        start=_float32(start_centres),
        radii=_float32(body_radii),
        frozen=times >= first,
        active=active,
        scored=avoidance & active,
    )
    attack = _float32(attack_centres), _float32(attack_radii)
    moved, d, d0 = _over_attack(config.form, swept, paths, *attack)
    met = jnp.any(active, axis=0)
    d, d0 = jnp.where(met, d, FAR), jnp.where(met, d0, FAR)
    penetration = moved * _float32(dt)
    return Energies(
        avoidance=jnp.maximum(1 - penetration / _float32(config.E_avoidance), 0.0),
        body=_body_energy(d, d0, config),
        penetration=penetration,
        d=d,
        d0=d0,
    )


def time_scale_energy(s: Float[Array, "*c"] | float, E_time: Number) -> Float[Array, "*c"]:
    """e_timescale (eq. 9): s/E_time if s > 1, 1/(s E_time) if s < 1; 1/E_time at s = 1.

    Args:
        s: factor on the duration of the adjustable edges, > 0.
        E_time: largest acceptable factor.
    """
    scale = jnp.maximum(jnp.abs(_float32(s)), 1e-6)
    return jnp.maximum(scale, 1 / scale) / _float32(E_time)


def total_energy(
    avoidance: Float[Array, "*c"] | float,
    body: Float[Array, "*c"] | float,
    timescale: Float[Array, "*c"] | float,
    config: EnergyConfig,
) -> Float[Array, "*c"]:
    """e (eq. 10), the weighted sum of the three energies; the smallest wins."""
    return (
        _float32(config.w_a) * _float32(avoidance)
        + _float32(config.w_b) * _float32(body)
        + _float32(config.w_t) * _float32(timescale)
    )


def _float32(value: Number) -> jax.Array:
    return jnp.asarray(value, jnp.float32)


def _body_energy(d: Array, d0: Array, config: EnergyConfig) -> Array:
    """e_body (eq. 8)."""
    excess = d - (jnp.maximum(d0, 0.0) if config.d0 == "clamped" else d0)
    width = _float32(config.D_body)
    return jnp.where((excess > _SAME) & (excess < width), excess / width, 1.0)


def _over_attack(form: str, swept: bool, paths: _Paths, centres: Array, radii: Array) -> Totals:
    """(e'/Δt, d, d0) over all attack spheres, one after the other."""
    times, candidates = paths.active.shape
    wide = candidates >= _WIDE and times <= _STRAIGHT
    over_time = partial(_over_time_wide if wide else _over_time, form, swept)

    def step(totals, sphere):
        return _join(totals, over_time(paths, *sphere)), None

    return lax.scan(step, _no_totals(paths), (jnp.moveaxis(centres, 2, 0), radii))[0]


def _over_time(
    form: str,
    swept: bool,
    paths: _Paths,
    sphere: Float[Array, "3 T"],
    radius: Float[Array, ""],
) -> Totals:
    """(e'/Δt, d, d0) of every candidate against one attack sphere, by a loop over time."""
    step = partial(_time_step, form, swept, paths, sphere, radius)
    sums, _ = lax.scan(step, _no_sums(paths), jnp.arange(sphere.shape[1]))
    return _over_body(sums, paths, radius)


@partial(jax.custom_jvp, nondiff_argnums=(0, 1))
def _over_time_wide(
    form: str,
    swept: bool,
    paths: _Paths,
    sphere: Float[Array, "3 T"],
    radius: Float[Array, ""],
) -> Totals:
    """The same for many candidates, as straight code.

    XLA's CPU code for a loop reads the index of a slice from memory for every element, which keeps
    it scalar; straight code is vectorised, six times faster. A block too long is not, hence the
    blocks. Derivatives go through the loop: those of straight code take minutes to compile.
    """
    step = partial(_time_step, form, swept, paths, sphere, radius)
    sums, totals = _no_sums(paths), []
    for start in range(0, sphere.shape[1], _BLOCK):
        sums = _no_sums(paths)._replace(last=sums.last, last0=sums.last0, active=sums.active)
        for t in range(start, min(start + _BLOCK, sphere.shape[1])):
            sums, _ = step(sums, t)
        totals.append(_over_body(sums, paths, radius))
    return reduce(_join, totals)


@_over_time_wide.defjvp
def _over_time_wide_jvp(form: str, swept: bool, primals, tangents):
    return jax.jvp(partial(_over_time, form, swept), primals, tangents)


def _time_step(
    form: str,
    swept: bool,
    paths: _Paths,
    sphere: Array,
    radius: Array,
    sums: _Sums,
    t: int | Array,
) -> tuple[_Sums, None]:
    """Adds one time to the sums."""
    attack, body = _at(sphere, t, 1), _at(paths.centres, t, 1)
    masks = (paths.active, paths.frozen, paths.scored)
    active, frozen, scored = (_at(mask, t, 0)[None] for mask in masks)
    now, held = _relative(attack, body), _relative(attack, paths.start)
    # Chosen after the subtraction, component by component: a choice between [3, S, C] arrays is
    # not vectorised.
    now0 = tuple(jnp.where(frozen, h, n) for h, n in zip(held, now, strict=True))
    square, square0 = _squared(now), _squared(now0)
    excess = _excess(square, square0, _reach(paths, radius), form)
    if swept:
        linked = active & sums.active
        square = _closest_squared(now, sums.last, linked)
        square0 = _closest_squared(now0, sums.last0, linked)
    sums = _Sums(
        moved=sums.moved + jnp.where(scored, jnp.maximum(excess, 0.0), 0.0),
        nearest=jnp.minimum(sums.nearest, jnp.where(active, square, FAR**2)),
        nearest0=jnp.minimum(sums.nearest0, jnp.where(active, square0, FAR**2)),
        last=now,
        last0=now0,
        active=active,
    )
    return sums, None


def _no_sums(paths: _Paths) -> _Sums:
    zero = jnp.zeros_like(paths.start[0])
    far, still = jnp.full_like(zero, FAR**2), (zero, zero, zero)
    inactive = jnp.zeros_like(paths.active[:1])
    return _Sums(moved=zero, nearest=far, nearest0=far, last=still, last0=still, active=inactive)


def _over_body(sums: _Sums, paths: _Paths, radius: Array) -> Totals:
    """(e'/Δt, d, d0) over the body spheres.

    A loop, not a reduction: a reduction would be fused with the whole sum over time before it,
    which then runs candidate by candidate instead of along the candidates.
    """

    def step(totals, sphere):
        moved, square, square0, reach = sphere
        return _join(totals, (moved, _distance(square) - reach, _distance(square0) - reach)), None

    rows = (sums.moved, sums.nearest, sums.nearest0, _reach(paths, radius))
    return lax.scan(step, _no_totals(paths), rows)[0]


def _no_totals(paths: _Paths) -> Totals:
    far = jnp.full_like(paths.start[0, 0], FAR)
    return jnp.zeros_like(far), far, far


def _join(one: Totals, other: Totals) -> Totals:
    return one[0] + other[0], jnp.minimum(one[1], other[1]), jnp.minimum(one[2], other[2])


def _reach(paths: _Paths, radius: Array) -> Array:
    """[S,1] distance of the centres at which the attack sphere touches each body sphere."""
    return (paths.radii + radius)[:, None]


def _at(array: Array, t: int | Array, axis: int) -> Array:
    if isinstance(t, int):
        return lax.index_in_dim(array, t, axis, keepdims=False)
    return lax.dynamic_index_in_dim(array, t, axis, keepdims=False)


def _relative(sphere: Float[Array, "3"], body: Float[Array, "3 S C"]) -> Vector:
    """Vectors from the body spheres to the attack sphere."""
    return sphere[0] - body[0], sphere[1] - body[1], sphere[2] - body[2]


def _squared(vector: Vector) -> Array:
    x, y, z = vector
    return x * x + y * y + z * z


def _distance(square: Array) -> Array:
    """Root with the gradient 0 where the points coincide."""
    return jnp.sqrt(jnp.maximum(square, _TINY))


def _excess(square: Array, square0: Array, reach: Array, form: str) -> Array:
    """−x of eq. 5 for the squared distances of the body at t and at t0.

    The radii cancel. With the depth of penetration max(0, reach − distance) in the place of
    −D, the two differ by their distances cut off at ``reach``.
    """
    distance, distance0 = _distance(square), _distance(square0)
    if form == "overlap":
        distance, distance0 = jnp.minimum(distance, reach), jnp.minimum(distance0, reach)
    return distance - distance0


def _closest_squared(now: Vector, before: Vector, linked: Array) -> Array:
    """Least squared length of a vector that moves linearly from ``before`` to ``now``.

    Where not ``linked``, that of ``now``. At the closest point the derivative by its time is zero
    or the time is fixed at an end, so the time is a constant to the gradient.
    """
    nx, ny, nz = now
    dx, dy, dz = (n - b for n, b in zip(now, before, strict=True))
    back = (nx * dx + ny * dy + nz * dz) / jnp.maximum(_squared((dx, dy, dz)), _TINY)
    back = lax.stop_gradient(jnp.where(linked, jnp.clip(back, 0.0, 1.0), 0.0))
    return _squared((nx - back * dx, ny - back * dy, nz - back * dz))
