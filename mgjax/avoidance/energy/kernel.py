"""The loops over attack spheres, times and body spheres that the energies are made of.

Arrays have the components outermost and the body's spheres last, as the tables of body volumes have
them, and time is streamed: per pair of spheres one sum and two smallest *squared* distances are
kept, so a root is taken once per pair and not once per time.

The counterfactual body, which stops moving when the avoidance begins, is a second body whose
spheres are those of the first until then. While the avoidance lasts it stands at t0, so it serves
both e' (eq. 5) and d0 (eq. 8).
"""

from __future__ import annotations

from functools import partial, reduce
from typing import NamedTuple, TypeAlias

import jax
import jax.numpy as jnp
from jax import lax
from jaxtyping import Bool, Float

from mgjax.avoidance.rates import FAR
from mgjax.core.arrays import Array

_TINY = 1e-20
"""Squared length under which two points coincide or a sphere stands still, m²."""

WIDE = 8
"""Candidates from which straight code over time pays for its compilation."""

_STRAIGHT = 128
"""Most times that are written out as straight code; 0.05 s of compilation each."""

_BLOCK = 10
"""Times in one piece of straight code. Longer ones leave the cache, and from about 50 on the
compiler stops vectorising them."""

Vector: TypeAlias = tuple[Array, ...]


class RawMeasures(NamedTuple):
    """What the kernel finds over times and spheres, per candidate.

    Attributes:
        moved: e'/Δt, m.
        d, d0: least clearances (eqs 7–8), m; ``FAR`` where no time was active.
    """

    moved: Float[Array, " C"]
    d: Float[Array, " C"]
    d0: Float[Array, " C"]

    def measured(
        self, met: Bool[Array, " C"], dt: Float[Array, "*c"]
    ) -> tuple[Float[Array, " C"], Float[Array, " C"], Float[Array, " C"]]:
        """e' (m·s), d and d0 (m), the last two ``FAR`` where the attack was never ``met``.

        Args:
            met: whether the attack was there at any time.
            dt: interval of the evaluated times, s; one for each candidate, or one for all.
        """
        d, d0 = jnp.where(met, self.d, FAR), jnp.where(met, self.d0, FAR)
        return self.moved * dt, d, d0


class Paths(NamedTuple):
    """The candidates, as the kernel reads them. Spheres with a radius below 0 are padding."""

    centres: Float[Array, "3 T C S"]
    start: Float[Array, "3 C S"]
    radii: Float[Array, " S"]
    frozen: Bool[Array, "T C"]
    active: Bool[Array, "T C"]
    scored: Bool[Array, "T C"]


class _Sums(NamedTuple):
    """What one pass over time keeps, per candidate and body sphere."""

    moved: Float[Array, "C S"]
    nearest: Float[Array, "C S"]
    nearest0: Float[Array, "C S"]
    last: Vector
    last0: Vector
    active: Bool[Array, "C 1"]


def over_attack(
    form: str,
    swept: bool,
    paths: Paths,
    centres: Float[Array, "3 T I"],
    radii: Float[Array, " I"],
    present: Bool[Array, "T I"],
) -> RawMeasures:
    """(e'/Δt, d, d0) over all attack spheres, one after the other."""

    def step(totals: RawMeasures, sphere: tuple[Array, Array, Array]) -> tuple[RawMeasures, None]:
        centre, radius, lives = sphere
        added = over_sphere(form, swept, paths, centre[..., None], radius[None], lives[:, None])
        return join(totals, added), None

    each, lives = jnp.moveaxis(centres, 2, 0), present.T
    none = nothing_measured(paths.active.shape[1])
    if centres.shape[2] == 1:
        return step(none, (each[0], radii[0], lives[0]))[0]
    return lax.scan(step, none, (each, radii, lives))[0]


def over_sphere(
    form: str,
    swept: bool,
    paths: Paths,
    sphere: Float[Array, "3 T A"],
    radius: Float[Array, " A"],
    present: Bool[Array, "T A"],
) -> RawMeasures:
    """(e'/Δt, d, d0) of every candidate against one sphere, or (A = C) each against its own."""
    times, candidates = paths.active.shape
    wide = candidates >= WIDE and times <= _STRAIGHT
    masked = paths._replace(active=paths.active & present, scored=paths.scored & present)
    return (_over_time_wide if wide else _over_time)(form, swept, masked, sphere, radius)


def _over_time(
    form: str,
    swept: bool,
    paths: Paths,
    sphere: Float[Array, "3 T A"],
    radius: Float[Array, " A"],
) -> RawMeasures:
    """(e'/Δt, d, d0) of every candidate against one attack sphere, by a loop over time."""
    step = partial(_time_step, form, swept, paths, sphere, radius)
    sums, _ = lax.scan(step, _no_sums(paths), jnp.arange(sphere.shape[1]))
    return _over_body(sums, paths, radius)


@partial(jax.custom_jvp, nondiff_argnums=(0, 1))
def _over_time_wide(
    form: str,
    swept: bool,
    paths: Paths,
    sphere: Float[Array, "3 T A"],
    radius: Float[Array, " A"],
) -> RawMeasures:
    """(e'/Δt, d, d0) of many candidates against one attack sphere, as straight code.

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
    return reduce(join, totals)


@_over_time_wide.defjvp
def _over_time_wide_jvp(form: str, swept: bool, primals, tangents):
    return jax.jvp(partial(_over_time, form, swept), primals, tangents)


def _time_step(
    form: str,
    swept: bool,
    paths: Paths,
    sphere: Array,
    radius: Array,
    sums: _Sums,
    t: int | Array,
) -> tuple[_Sums, None]:
    """Adds one time to the sums."""
    attack, body = _at(sphere, t, 1), _at(paths.centres, t, 1)
    masks = (paths.active, paths.frozen, paths.scored)
    active, frozen, scored = (_at(mask, t, 0)[:, None] for mask in masks)
    now, held = _relative(attack, body), _relative(attack, paths.start)
    # Chosen after the subtraction, component by component: a choice between [3, C, S] arrays is
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


def _no_sums(paths: Paths) -> _Sums:
    zero = jnp.zeros_like(paths.start[0])
    far, still = jnp.full_like(zero, FAR**2), (zero, zero, zero)
    inactive = jnp.zeros_like(paths.active[0])[:, None]
    return _Sums(moved=zero, nearest=far, nearest0=far, last=still, last0=still, active=inactive)


def _over_body(sums: _Sums, paths: Paths, radius: Array) -> RawMeasures:
    """(e'/Δt, d, d0) over the body spheres."""
    reach = _reach(paths, radius)
    sums = lax.optimization_barrier(sums)
    nearest = jnp.min(_distance(sums.nearest) - reach, axis=1)
    nearest0 = jnp.min(_distance(sums.nearest0) - reach, axis=1)
    moved = jnp.where(paths.radii[None] >= 0, sums.moved, 0.0)
    return RawMeasures(jnp.sum(moved, axis=1), nearest, nearest0)


def nothing_measured(candidates: int) -> RawMeasures:
    """The totals of candidates that were compared with nothing."""
    far = jnp.full(candidates, FAR, jnp.float32)
    return RawMeasures(jnp.zeros_like(far), far, far)


def join(one: RawMeasures, other: RawMeasures) -> RawMeasures:
    """The totals over the spheres or times of both."""
    return RawMeasures(
        one.moved + other.moved, jnp.minimum(one.d, other.d), jnp.minimum(one.d0, other.d0)
    )


def _reach(paths: Paths, radius: Array) -> Array:
    """[A,S] distance of the centres at which the attack sphere touches each body sphere."""
    return paths.radii[None] + radius[:, None]


def _at(array: Array, t: int | Array, axis: int) -> Array:
    if isinstance(t, int):
        return lax.index_in_dim(array, t, axis, keepdims=False)
    return lax.dynamic_index_in_dim(array, t, axis, keepdims=False)


def _relative(sphere: Float[Array, "3 A"], body: Float[Array, "3 C S"]) -> Vector:
    """Vectors from the body spheres to the attack sphere."""
    x, y, z = (sphere[k][:, None] - body[k] for k in range(3))
    return x, y, z


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
