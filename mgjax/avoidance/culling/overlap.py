"""Counting the pixels that an attack and the bodies of many candidates have in common (§5.2).

Instead of turning pictures, the middle of each of the attack's pixels is mapped into the frame of
the edge that is played, and the picture's pixel there is read: what a graphics card does when it
draws a turned texture. One word holds all layers, so an attack of some hundred pixels takes as
many reads per candidate.
"""

from __future__ import annotations

import operator
from functools import partial, reduce
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import lax
from jaxtyping import Bool, Float, Int, Shaped

from mgjax.avoidance.attacks.crop import Crop
from mgjax.avoidance.candidates.enumerate import Candidates
from mgjax.avoidance.culling.pictures import BODY_BIN_S, Form, Pictures, Slices
from mgjax.avoidance.culling.rasterise import PIXEL_M, Drawn
from mgjax.core.arrays import Array
from mgjax.core.xla.padding import bucket_size, pad_axis
from mgjax.graph.types import NO_EDGE

CULL_TILE = 512
"""Most candidates in one call; calls are compiled for 32, 128 and this."""


class Pixels(NamedTuple):
    """A drawn attack, padded.

    Attributes:
        times: middle of each bin, s from the beginning of the walks. [B]
        start, end: of the crop, s.
        x, z: middle of each pixel, m. [B, Q]
        layers: 0 where there is none. [B, Q]
    """

    times: Float[Array, " B"]
    start: Float[Array, ""]
    end: Float[Array, ""]
    x: Float[Array, "B Q"]
    z: Float[Array, "B Q"]
    layers: Shaped[Array, "B Q"]


class PlayedEdges(NamedTuple):
    """When and where each edge of each candidate begins and ends; frames as (θ, x, z). [C, L]"""

    edges: Int[Array, "C L"]
    scales: Float[Array, "C L"]
    begins: Float[Array, "C L"]
    ends: Float[Array, "C L"]
    places: Float[Array, "C L 3"]


def overlap(
    slices: Slices,
    edges: Int[Array, "C L"],
    length: Int[Array, " C"],
    scales: Float[Array, "C L"],
    pixels: Pixels,
    *,
    form: Form,
    span: int,
) -> Int[Array, " C"]:
    """Pixels, over all layers, in which the attack and the body of each candidate overlap.

    ``"paper"``: a pixel of the attack counts where the body is at any time of any edge that is
    being played during the crop. ``"binned"``: each bin of the attack is compared with the body's
    bin at the same path time t, motion time (t − T_e)/s, and pixels are counted in each bin anew.
    What comes after the end of a path does not count.

    Args:
        slices: the pictures.
        edges: of each candidate, padded with ``NO_EDGE``. [C, L]
        length: edges of each.
        scales: factor on the duration of each edge.
        pixels: the attack; for ``"paper"`` all of it in one bin.
        form: which pictures are used.
        span: most edges of a candidate that are played during the crop; for ``"paper"``.
    """
    played = play(slices, edges, scales)
    if form == "paper":
        slot, inside = _during(played, length, pixels, span)
        number = jnp.take_along_axis(jnp.maximum(played.edges, 0), slot, axis=1)
        pictures = slices.paper
    else:
        slot, inside, number = _at_times(slices, played, length, pixels)
        pictures = slices.binned
    place = jnp.take_along_axis(played.places, slot[..., None], axis=1)
    if form == "paper":
        # One edge after the other: reading all at once and then joining them is not vectorised.
        at = [slice(k, k + 1) for k in range(span)]
        each = [_read(pictures, number[:, k], inside[:, k], place[:, k], pixels) for k in at]
        body = reduce(operator.or_, each)
    else:
        body = _read(pictures, number, inside, place, pixels)
    both = lax.population_count(body & pixels.layers[None])
    return jnp.sum(both.astype(jnp.int32), axis=(1, 2))


def play(slices: Slices, edges: Int[Array, "C L"], scales: Float[Array, "C L"]) -> PlayedEdges:
    """Begins, ends and frames of the edges of walks, from their own beginning."""
    inside = jnp.maximum(edges, 0)
    padding = edges == NO_EDGE
    durations = jnp.where(padding, 0.0, slices.seconds[inside] * scales)
    steps = jnp.where(padding[..., None], 0.0, slices.step[inside])
    # Sums of all before: as a product they are ten times faster than as a running sum.
    before = jnp.triu(jnp.ones((edges.shape[1],) * 2, dtype=durations.dtype), k=1)
    begins = durations @ before
    # Turns add up; with them known, so do the ways.
    turn = steps[..., 0] @ before
    c, s = jnp.cos(turn), jnp.sin(turn)
    x = (steps[..., 1] * c + steps[..., 2] * s) @ before
    z = (steps[..., 2] * c - steps[..., 1] * s) @ before
    return PlayedEdges(edges, scales, begins, begins + durations, jnp.stack([turn, x, z], axis=-1))


def _during(
    played: PlayedEdges, length: Array, pixels: Pixels, span: int
) -> tuple[Int[Array, "C K"], Bool[Array, "C K"]]:
    """The first ``span`` edges that are played at some time of the crop."""
    first = jnp.sum(played.ends <= pixels.start, axis=1)
    slot = first[:, None] + jnp.arange(span)[None, :]
    inside = slot < length[:, None]
    slot = jnp.minimum(slot, played.edges.shape[1] - 1)
    begins = jnp.take_along_axis(played.begins, slot, axis=1)
    return slot, inside & (begins <= pixels.end)


def _at_times(
    slices: Slices, played: PlayedEdges, length: Array, pixels: Pixels
) -> tuple[Int[Array, "C B"], Bool[Array, "C B"], Int[Array, "C B"]]:
    """The edge that is played in the middle of each bin, and the body's bin."""
    when = pixels.times[None, :]
    slot = jnp.sum(when[:, :, None] >= played.ends[:, None, :], axis=2)
    inside = slot < length[:, None]
    slot = jnp.minimum(slot, length[:, None] - 1)
    edge, begin, scale = (
        jnp.take_along_axis(x, slot, axis=1) for x in (played.edges, played.begins, played.scales)
    )
    moment = (when - begin) / scale
    edge = jnp.maximum(edge, 0)
    bin_of = jnp.clip((moment / BODY_BIN_S).astype(jnp.int32), 0, slices.bins[edge] - 1)
    return slot, inside, slices.first_bin[edge] + bin_of


def _read(
    pictures: Pictures,
    number: Int[Array, "C K"],
    inside: Bool[Array, "C K"],
    place: Float[Array, "C K 3"],
    pixels: Pixels,
) -> Shaped[Array, "C K Q"]:
    """The word of picture ``number`` under each of the attack's pixels; 0 outside the picture."""
    c, s = jnp.cos(place[..., 0])[..., None], jnp.sin(place[..., 0])[..., None]
    corner = pictures.corner[number].astype(jnp.float32)
    # From the world to columns and rows of the picture, in pixels.
    x, z = (pixels.x / PIXEL_M)[None], (pixels.z / PIXEL_M)[None]
    px, pz = place[..., 1:2] / PIXEL_M, place[..., 2:3] / PIXEL_M
    across = x * c - z * s - (px * c - pz * s + corner[..., :1])
    along = x * s + z * c - (px * s + pz * c + corner[..., 1:])
    size = pictures.size[number]
    width = jnp.where(inside, size[..., 0], 0)[..., None]
    column, row = jnp.floor(across).astype(jnp.int32), jnp.floor(along).astype(jnp.int32)
    inside = (column >= 0) & (column < width) & (row >= 0) & (row < size[..., 1:])
    at = pictures.first[number][..., None] + row * width + column
    return pictures.words[jnp.where(inside, at, 0)]


_overlap = partial(jax.jit, static_argnames=("form", "span"))(overlap)


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
    tile, width = min(bucket_size(count, 32, 4), CULL_TILE), bucket_size(longest, 16)
    counted: list[np.ndarray] = [np.zeros(0, np.int32)]
    for first in range(0, count, tile):
        last = min(first + tile, count)
        # Padded by hand, as np.pad takes longer than the kernel for few candidates.
        edges = np.full((tile, width), NO_EDGE, np.int32)
        length, played = np.zeros(tile, np.int32), np.ones((tile, width), np.float32)
        edges[: last - first, :longest] = candidates.edges[first:last]
        length[: last - first] = candidates.length[first:last]
        played[: last - first, :longest] = scales[first:last, :longest]
        counts = _overlap(slices, edges, length, played, pixels, form=form, span=span)
        counted.append(np.asarray(counts)[: last - first])
    return np.concatenate(counted)


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
    durations = np.asarray(slices.seconds)[edges] * scales[:, : edges.shape[1]] * played
    ends = np.cumsum(durations, axis=1)
    played &= (ends > crop.start - 1e-3) & (ends - durations < crop.end + 1e-3)
    return int(played.sum(axis=1).max(initial=1))
