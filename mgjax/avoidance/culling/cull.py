"""Culling: candidates whose body is where the attack is are dropped before they are judged (§5.2).

slices = jax.device_put(build_slices(tables))        # once for a graph
keep = cull(slices, candidates, scales, attack, crop, form="binned", threshold=32)
"""

from __future__ import annotations

from functools import partial

import jax
import numpy as np
from jaxtyping import Bool, Float, Int

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.attacks.crop import Crop
from mgjax.avoidance.candidates.enumerate import Candidates
from mgjax.avoidance.culling.overlap import Pixels, overlap
from mgjax.avoidance.culling.pictures import Form, Slices
from mgjax.avoidance.culling.rasterise import Drawn, draw_attack
from mgjax.core.xla.padding import bucket_size, pad_axis
from mgjax.graph.types import NO_EDGE

TILE = 512
"""Most candidates in one call; calls are compiled for 32, 128 and this."""

_overlap = partial(jax.jit, static_argnames=("form", "span"))(overlap)


def cull(
    slices: Slices,
    candidates: Candidates,
    scales: Float[np.ndarray, "C L"],
    attack: Attack,
    crop: Crop,
    *,
    form: Form,
    threshold: int,
) -> Bool[np.ndarray, " C"]:
    """Which candidates are kept: those that overlap the attack in at most ``threshold`` pixels.

    An approximation for speed, as in the paper: a path that it keeps may still be hit, and one that
    it drops may have been clear. An attack that is too long or too large to be drawn (see
    :func:`mgjax.avoidance.culling.rasterise.draw_attack`) culls nothing.

    Args:
        slices: of the graph, best as jax arrays.
        candidates: walks from the node in whose planar frame the attack is; time counts from there.
        scales: factor on the duration of each edge. [C, L]
        attack, crop: the attack, and the part of it that counts.
        form: which pictures are used; see :func:`mgjax.avoidance.culling.overlap.overlap`.
        threshold: most pixels of 4 cm, counted in each layer.
    """
    drawn = draw_attack(attack, crop)
    if drawn is None:
        return np.ones(len(candidates.length), bool)
    return overlap_pixels(slices, candidates, scales, drawn, crop, form=form) <= threshold


def overlap_pixels(
    slices: Slices,
    candidates: Candidates,
    scales: Float[np.ndarray, "C L"],
    drawn: Drawn,
    crop: Crop,
    *,
    form: Form,
) -> Int[np.ndarray, " C"]:
    """Pixels in which each candidate overlaps a drawn attack; shapes are padded to a few sizes."""
    count, longest = candidates.edges.shape
    pixels, span = padded_pixels(drawn, crop, form), 1
    if form == "paper":
        span = bucket_size(_most_played(slices, candidates, scales, crop), 4)
    tile, width = min(bucket_size(count, 32, 4), TILE), bucket_size(longest, 16)
    found: list[np.ndarray] = [np.zeros(0, np.int32)]
    for first in range(0, count, tile):
        last = min(first + tile, count)
        # Padded by hand, as np.pad takes longer than the kernel for few candidates.
        edges = np.full((tile, width), NO_EDGE, np.int32)
        length, played = np.zeros(tile, np.int32), np.ones((tile, width), np.float32)
        edges[: last - first, :longest] = candidates.edges[first:last]
        length[: last - first] = candidates.length[first:last]
        played[: last - first, :longest] = scales[first:last, :longest]
        counts = _overlap(slices, edges, length, played, pixels, form=form, span=span)
        found.append(np.asarray(counts)[: last - first])
    return np.concatenate(found)


def padded_pixels(drawn: Drawn, crop: Crop, form: Form) -> Pixels:
    """A drawn attack as the kernel reads it; for ``"paper"`` each pixel once, whatever its time."""
    if form == "paper":
        drawn = _timeless(drawn)
    counts = np.diff(drawn.first)
    shape = (bucket_size(len(counts), 1, 4), bucket_size(int(counts.max()), 64))
    number = np.repeat(np.arange(len(counts)), counts)
    place = np.arange(len(number)) - drawn.first[number]
    x, z = np.zeros((2, *shape), np.float32)
    layers = np.zeros(shape, np.uint16)
    for into, values in ((x, drawn.x), (z, drawn.z), (layers, drawn.layers)):
        into[number, place] = values
    times = pad_axis(drawn.times, shape[0]).astype(np.float32)
    return Pixels(
        times, np.asarray(crop.start, np.float32), np.asarray(crop.end, np.float32), x, z, layers
    )


def _timeless(drawn: Drawn) -> Drawn:
    """All bins in one."""
    pixels, number = np.unique(np.stack([drawn.x, drawn.z], axis=1), axis=0, return_inverse=True)
    layers = np.zeros(len(pixels), np.uint16)
    np.bitwise_or.at(layers, number, drawn.layers)
    x, z = np.ascontiguousarray(pixels.T)
    return Drawn(times=drawn.times[:1], first=np.array([0, len(pixels)]), x=x, z=z, layers=layers)


def _most_played(
    slices: Slices, candidates: Candidates, scales: Float[np.ndarray, "C L"], crop: Crop
) -> int:
    """Most edges that one candidate plays during the crop; by rounding perhaps some more."""
    edges = candidates.edges
    played = edges != NO_EDGE
    lasts = np.asarray(slices.seconds)[edges] * scales[:, : edges.shape[1]] * played
    ends = np.cumsum(lasts, axis=1)
    played &= (ends > crop.start - 1e-3) & (ends - lasts < crop.end + 1e-3)
    return int(played.sum(axis=1).max(initial=1))
