"""Culling: candidates whose body is where the attack is are dropped before they are judged (§5.2).

slices = jax.device_put(build_slices(tables))        # once for a graph
keep = cull(slices, candidates, scales, attack, crop, form="binned", threshold=32)
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import jax
import numpy as np
from jaxtyping import Bool, Float, Int

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.attacks.crop import Crop
from mgjax.avoidance.attacks.transform import of_size
from mgjax.avoidance.body.device_tables import DeviceTables, PartColumn
from mgjax.avoidance.body.volumes import read_edges
from mgjax.avoidance.candidates.batch import CandidateBatch, pad_candidates
from mgjax.avoidance.candidates.enumerate import Candidates
from mgjax.avoidance.config import AvoidanceConfig
from mgjax.avoidance.culling.overlap import overlap_pixels
from mgjax.avoidance.culling.pictures import Form, Slices
from mgjax.avoidance.culling.rasterise import draw_attack
from mgjax.avoidance.timing.time_scale import OK, Timing, scale_limits, time_scale
from mgjax.core.arrays import Array
from mgjax.core.xla.padding import pad_axis

PIXELS: dict[Form, int] = {"paper": 96, "binned": 32}
"""Most pixels in which a candidate that is kept overlaps the attack. Where false culls and false
keeps of ``experiments/avoidance/culling.py`` balance."""


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
        threshold: most pixels, 4 cm for an adult, counted in each layer.
    """
    drawn = draw_attack(of_size(attack, 1 / float(slices.scale)), crop)
    if drawn is None:
        return np.ones(len(candidates.length), bool)
    return overlap_pixels(slices, candidates, scales, drawn, crop, form=form) <= threshold


def without_culled(
    slices: Slices,
    device: DeviceTables,
    candidates: Candidates,
    attack: Attack,
    crop: Crop,
    config: AvoidanceConfig,
    *,
    frame_rate: float,
) -> tuple[Candidates, int]:
    """The candidates that are kept, and how many are dropped, by the form that ``config`` names.

    Those that cannot be timed are kept: nothing is known of when they would play what.
    """
    count = len(candidates.length)
    if not count or config.culling == "none":
        return candidates, 0
    form: Form = config.culling
    status, scales = timing_of(device, candidates, crop, config, frame_rate=frame_rate)
    keep = cull(
        slices,
        candidates,
        scales,
        attack,
        crop,
        form=form,
        threshold=PIXELS[form],
    )
    keep = keep | (status != OK)
    kept = replace(
        candidates,
        edges=candidates.edges[keep],
        length=candidates.length[keep],
        part=candidates.part[keep],
    )
    return kept, int(count - keep.sum())


def timing_of(
    device: DeviceTables,
    candidates: Candidates,
    crop: Crop,
    config: AvoidanceConfig,
    *,
    frame_rate: float,
) -> tuple[Int[np.ndarray, " C"], Float[np.ndarray, "C L"]]:
    """Status and scales of candidates (eqs 2–3), without their energies."""
    timing = _timing(
        device,
        pad_candidates(candidates),
        np.asarray(crop.middle, dtype=np.float32),
        scale_limits(config.energy, config.limit_scale),
        half_frame=0.5 / frame_rate,
    )
    count, width = candidates.edges.shape
    scales = np.asarray(timing.scales)[:width, :count].T
    return np.asarray(timing.status)[:count], pad_axis(scales, width, axis=1, value=1)


@partial(jax.jit, static_argnames="half_frame")
def _timing(
    tables: DeviceTables,
    walks: CandidateBatch,
    t_attack: Float[Array, ""],
    limits: tuple[Array, Array],
    *,
    half_frame: float,
) -> Timing:
    read = read_edges(tables, walks.edges)
    return time_scale(
        read.seconds,
        read.slow_down > 0,
        read.speed_up > 0,
        walks.length,
        tables.parts[walks.part, PartColumn.CENTRE],
        t_attack,
        half_frame=half_frame,
        limits=limits,
    )
