"""CandidateBatch, attacks and pictures that culling is tested with."""

from __future__ import annotations

import numpy as np

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.attacks.crop import Crop, crop_attack
from mgjax.avoidance.candidates.enumerate import Candidates
from mgjax.avoidance.culling.pictures import (
    Form,
    Pictures,
    unpack,
)
from mgjax.avoidance.culling.rasterise import (
    LAYERS,
    PIXEL_M,
    Drawn,
    draw_attack,
)
from mgjax.graph.types import NO_EDGE, MotionGraph

RATE = 30.0
FORMS: tuple[Form, ...] = ("paper", "binned")


def crop_of(attack: Attack) -> Crop:
    crop = crop_attack(attack, radius=1.0, height=2.3)
    assert crop is not None
    return crop


def drawn_of(attack: Attack, crop: Crop) -> Drawn:
    drawn = draw_attack(attack, crop)
    assert drawn is not None
    return drawn


def pixel_set(pictures: Pictures, number: int) -> set:
    layer, row, column = np.nonzero(unpack(pictures, number))
    column, row = column + pictures.corner[number, 0], row + pictures.corner[number, 1]
    return set(zip(layer.tolist(), column.tolist(), row.tolist(), strict=True))


def attack_set(drawn: Drawn, number: int) -> set:
    here = slice(drawn.first[number], drawn.first[number + 1])
    columns, rows = (np.floor(x[here] / PIXEL_M).astype(int).tolist() for x in (drawn.x, drawn.z))
    found = {
        (layer, column, row)
        for column, row, word in zip(columns, rows, drawn.layers[here].tolist(), strict=True)
        for layer in range(LAYERS)
        if word >> layer & 1
    }
    assert len(set(zip(columns, rows, strict=True))) == len(columns)  # each once
    return found


def random_walks(graph: MotionGraph, count: int, longest: int, seed: int) -> Candidates:
    """CandidateBatch from node 0 with 1 … ``longest`` edges; their parts do not matter here."""
    rng = np.random.default_rng(seed)
    edges = np.full((count, longest), NO_EDGE)
    length = rng.integers(1, longest + 1, count)
    for row in range(count):
        node = 0
        for slot in range(length[row]):
            edges[row, slot] = rng.choice(graph.edges_from(node))
            node = int(graph.edge_target[edges[row, slot]])
    return Candidates(edges=edges, length=length, part=np.zeros(count, int), overflow=0)


def random_scales(candidates: Candidates, seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    scales = np.exp(rng.uniform(-1, 1, candidates.edges.shape)).astype(np.float32)
    return np.where(rng.random(scales.shape) < 0.5, 1, scales).astype(np.float32)


def limb(seed: int) -> Attack:
    """Three spheres, of which one comes later and one goes sooner."""
    rng = np.random.default_rng(seed)
    times = np.linspace(0.2, 0.7, 11)
    ways = np.cumsum(rng.normal(scale=0.08, size=(11, 3, 3)), axis=0)
    ways = ways + np.array([0.0, 1.0, 0.1])
    return Attack(
        times=times,
        centres=ways,
        radii=np.array([0.05, 0.08, 0.11]),
        starts=times[[0, 4, 0]],
        stops=times[[10, 10, 6]],
    )
