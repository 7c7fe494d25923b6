from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.attacks.ball import ball_attack
from mgjax.avoidance.attacks.crop import Crop
from mgjax.avoidance.body.edge_tables import EdgeTables, edge_tables
from mgjax.avoidance.culling.cull import cull
from mgjax.avoidance.culling.overlap import overlap_pixels
from mgjax.avoidance.culling.pictures import (
    Slices,
    build_slices,
    picture_bytes,
)
from mgjax.avoidance.culling.rasterise import (
    LAYERS,
    MAX_ATTACK_BINS,
    draw_attack,
    stamp,
    stamp_width,
)
from mgjax.graph.types import MotionGraph
from tests.avoidance.culling.made import (
    FORMS,
    RATE,
    attack_set,
    crop_of,
    drawn_of,
    limb,
    pixel_set,
    random_walks,
)
from tests.avoidance.made import random_graph, throw
from tests.reference import slices as reference


def test_pictures_are_those_of_the_definition(
    small: tuple[MotionGraph, EdgeTables, Slices],
) -> None:
    graph, tables, slices = small
    edge = int(np.argmax(np.where(slices.bins <= 4, slices.bins, 0)))
    assert slices.bins[edge] > 1
    for number in range(int(slices.bins[edge])):
        expected = reference.bin_pixels(tables, edge, number)
        assert pixel_set(slices.binned, int(slices.first_bin[edge]) + number) == expected
    assert pixel_set(slices.paper, edge) == reference.edge_pixels(tables, edge)
    assert slices.bins.tolist() == [reference.bins_of(tables, e) for e in range(graph.num_edges)]


def test_a_picture_of_an_edge_is_the_union_of_its_bins(
    small: tuple[MotionGraph, EdgeTables, Slices],
) -> None:
    graph, _, slices = small
    for edge in range(graph.num_edges):
        first = int(slices.first_bin[edge])
        bins = [pixel_set(slices.binned, first + b) for b in range(int(slices.bins[edge]))]
        assert pixel_set(slices.paper, edge) == set().union(*bins)
        assert len(bins[0]) > 100
    for pictures in (slices.paper, slices.binned):
        assert pictures.words[0] == 0
        area = pictures.size.prod(axis=1)
        assert pictures.first.tolist() == (1 + np.cumsum(area) - area).tolist()
        assert len(pictures.words) == 1 + area.sum()
        assert picture_bytes(pictures) == 2 * len(pictures.words) + 20 * len(area)


@pytest.mark.parametrize("radius", [0.05, 0.12, 0.3, 1.3])
def test_spheres_in_layers(radius: float) -> None:
    rng = np.random.default_rng(0)
    centres = rng.uniform((-1, -0.3, -1), (1, 2.6, 1), (6, 3))
    columns, rows, words = stamp(centres, np.full(6, radius), stamp_width(radius))
    for i, centre in enumerate(centres):
        found = {
            (layer, int(columns[i, c]), int(rows[i, r]))
            for r, c in zip(*np.nonzero(words[i]), strict=True)
            for layer in range(LAYERS)
            if words[i, r, c] >> layer & 1
        }
        assert found == reference.pixels_of(centre, radius)


def test_layers_by_hand() -> None:
    # 10 cm around (0.02, 0.30, 0.02), the middle of pixel (0, 0): layer 1 has its equator, and in
    # layer 0, 5 cm under its middle, the section has a radius of √(0.1² − 0.05²) = 8.7 cm.
    columns, rows, words = stamp(np.array([[0.02, 0.3, 0.02]]), np.array([0.1]), stamp_width(0.1))
    at = {(int(c), int(r)): (i, j) for j, c in enumerate(columns[0]) for i, r in enumerate(rows[0])}
    expected = {(0, 0): 3, (2, 0): 3, (2, 1): 2, (1, 1): 3, (2, 2): 0, (-2, 0): 3, (3, 0): 0}
    for pixel, word in expected.items():
        if pixel in at:
            i, j = at[pixel]
            assert words[0, i, j] == word, pixel
        else:
            assert word == 0


@pytest.mark.parametrize("kind", ["ball", "gravity", "limb"])
def test_attacks_are_drawn_by_the_definition(kind: str) -> None:
    rng = np.random.default_rng(1)
    attack = limb(1) if kind == "limb" else throw(rng, gravity=kind == "gravity")
    crop = crop_of(attack)
    drawn = drawn_of(attack, crop)
    expected = reference.attack_pixels(attack, crop)
    assert len(drawn.times) == len(expected)
    for number, (middle, pixels) in enumerate(expected):
        assert drawn.times[number] == pytest.approx(middle)
        assert attack_set(drawn, number) == pixels


def test_attacks_that_are_not_drawn() -> None:
    here = np.array([0.0, 1.0, 0.0])
    big = ball_attack(here + np.array([5.0, 30.0, 0.0]), here, speed=10.0, arrives=1.0)
    big = replace(big, radii=np.array([20.0]))
    slow = ball_attack(here + np.array([2.0, 0.0, 0.0]), here, speed=0.2, arrives=12.0)
    ends = here + np.array([[[900.0, 0.0, 0.0]], [[-100.0, 0.0, 0.0]]])
    fast = Attack(times=np.array([0.0, 1.0]), centres=ends, radii=np.array([0.001]))
    long = Crop(start=0.0, end=0.05 * MAX_ATTACK_BINS + 0.1)
    assert draw_attack(big, Crop(start=0.9, end=1.1)) is None
    assert draw_attack(slow, long) is None
    assert draw_attack(fast, Crop(start=0.0, end=1.0)) is None
    graph = random_graph(3)
    slices = build_slices(edge_tables(graph, RATE))
    walks = random_walks(graph, 3, 4, 0)
    for attack, crop in ((big, Crop(start=0.9, end=1.1)), (slow, long)):
        ones = np.ones(walks.edges.shape, np.float32)
        assert cull(slices, walks, ones, attack, crop, form="binned", threshold=0).all()
    # An instant, and a place above all layers.
    moment = drawn_of(slow, Crop(start=12.0, end=12.0))
    assert len(moment.times) == 1
    assert moment.first[1] > 20
    above = replace(slow, centres=slow.centres + np.array([0.0, 5.0, 0.0]))
    nothing = drawn_of(above, Crop(start=11.9, end=12.0))
    assert nothing.first.tolist() == [0, 0, 0]
    ones = np.ones(walks.edges.shape, np.float32)
    for form in FORMS:
        crop = Crop(start=11.9, end=12.0)
        assert not overlap_pixels(slices, walks, ones, nothing, crop, form=form).any()
