from __future__ import annotations

from dataclasses import replace

import jax
import numpy as np
import pytest

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.attacks.crop import Crop
from mgjax.avoidance.body.edge_tables import EdgeTables, edge_tables
from mgjax.avoidance.body.spheres import BodySpheres
from mgjax.avoidance.candidates.enumerate import Candidates
from mgjax.avoidance.culling import overlap as overlap_module
from mgjax.avoidance.culling.cull import cull
from mgjax.avoidance.culling.overlap import overlap, overlap_pixels, padded_pixels, play
from mgjax.avoidance.culling.pictures import (
    Form,
    Slices,
    build_slices,
    unpack,
)
from mgjax.avoidance.culling.rasterise import (
    LAYERS,
    PIXEL_M,
    Drawn,
)
from mgjax.graph.types import NO_EDGE, MotionGraph
from tests.avoidance.culling.made import (
    FORMS,
    RATE,
    crop_of,
    drawn_of,
    limb,
    random_scales,
    random_walks,
)
from tests.avoidance.made import make_graph, throw
from tests.reference import slices as reference


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("kind", ["ball", "limb"])
def test_counts_are_those_of_the_definition(
    small: tuple[MotionGraph, EdgeTables, Slices], seed: int, kind: str
) -> None:
    graph, tables, slices = small
    rng = np.random.default_rng(seed)
    walks = random_walks(graph, 16, 4, seed)
    scales = random_scales(walks, seed)
    attack = limb(seed) if kind == "limb" else throw(rng, arrives=0.6, height=1.0)
    crop = crop_of(attack)
    drawn = drawn_of(attack, crop)
    expected = reference.attack_pixels(attack, crop)
    counter = reference.Overlap(tables)
    total = dict.fromkeys(FORMS, 0)
    for form in FORMS:
        counts = overlap_pixels(slices, walks, scales, drawn, crop, form=form)
        for row, count in enumerate(counts.tolist()):
            walk = (walks.edges[row, : walks.length[row]], scales[row, : walks.length[row]])
            if form == "paper":
                least, most = counter.paper(*walk, expected, crop)
            else:
                least, most = counter.binned(*walk, expected)
            assert least <= count <= most
            assert most - least <= 5 + count // 10
            total[form] += count
    assert total["binned"] > 20
    assert total["paper"] > 20


def test_counts_by_hand() -> None:
    # The body is one sphere of 10 cm that jumps by 60 cm sideways in the middle of edge 1, 0.2 s
    # after its beginning. Edge 0 turns the frame by 90°, so that (0.02, 0.50) is (0.50, −0.02) from
    # its beginning: the middle of a pixel, through which a ball of 10 cm flies in layer 4.
    graph = make_graph([(0, 1, 3), (1, 0, 12)], [(1, 3, 9)])
    tables = edge_tables(graph, RATE)
    zero = np.zeros(1, np.int64)
    radii = np.array([0.1], np.float32)
    spheres = BodySpheres(
        names=("one",), first=zero, second=zero, share=np.zeros(1, np.float32), radii=radii
    )
    pool = np.tile(np.array([0.02, 1.125, 0.50], np.float32), (len(tables.pool), 1))
    later = tables.pool_first[1] + 7
    pool[later:, 0] += 0.6
    step = tables.step.copy()
    step[0] = (np.pi / 2, 0.0, 0.0)
    tables = replace(tables, spheres=spheres, pool=pool, step=step)
    slices = build_slices(tables)
    walk = Candidates(
        edges=np.array([[0, 1]]), length=np.array([2]), part=np.zeros(1, int), overflow=0
    )
    scales = np.ones((1, 2), np.float32)

    def counts(times: tuple[float, float], scale: float = 1.0) -> dict[str, int]:
        centres = np.array([[[0.0, 1.125, -0.02]], [[1.0, 1.125, -0.02]]])
        attack = Attack(times=np.array(times), centres=centres, radii=np.array([0.1]))
        crop = Crop(start=times[0], end=times[1])
        drawn = drawn_of(attack, crop)
        return {
            form: int(
                overlap_pixels(slices, walk, scales * np.float32(scale), drawn, crop, form=form)[0]
            )
            for form in FORMS
        }

    # While the sphere is there all its pixels are met: the 21 with i² + j² ≤ 6.25.
    early = counts((0.15, 0.2))
    assert early == {"paper": 21, "binned": 21}
    # After the jump whole-edge pictures still say so.
    late = counts((0.4, 0.45))
    assert late == {"paper": 21, "binned": 0}
    # Played at half the speed the jump comes later.
    assert counts((0.4, 0.45), 2.0) == {"paper": 21, "binned": 21}
    # After the end of the walk nothing is known; edge 0's body is in another place.
    assert counts((0.6, 0.65)) == {"paper": 0, "binned": 0}
    assert counts((0.0, 0.05)) == {"paper": 0, "binned": 0}


def unpacked(
    slices: Slices,
    walks: Candidates,
    scales: np.ndarray,
    drawn: Drawn,
    crop: Crop,
    form: Form,
) -> list[int]:
    """The counts from pictures as arrays of bool, with the kernel's own arithmetic for places."""
    found: list[int] = []
    pixels = padded_pixels(drawn, crop, form)
    laid = jax.tree.map(np.asarray, play(slices, walks.edges.astype(np.int32), scales))
    for row, length in enumerate(walks.length):
        marks = np.zeros((*pixels.x.shape, LAYERS), bool)
        for b in range(len(drawn.times) if form == "binned" else 1):
            for slot in range(length):
                begin, end = float(laid.begins[row, slot]), float(laid.ends[row, slot])
                edge = int(walks.edges[row, slot])
                if form == "binned":
                    if not begin <= pixels.times[b] < end:
                        continue
                    moment = (pixels.times[b] - begin) / scales[row, slot]
                    last = int(slices.bins[edge]) - 1
                    number = int(slices.first_bin[edge]) + min(int(moment / 0.1), last)
                    pictures = slices.binned
                else:
                    if end <= crop.start or begin > crop.end:
                        continue
                    number, pictures = edge, slices.paper
                picture = unpack(pictures, number)
                theta, px, pz = (float(v) for v in laid.places[row, slot])
                dx, dz = pixels.x[b] - px, pixels.z[b] - pz
                corner = pictures.corner[number]
                i = np.floor((dx * np.cos(theta) - dz * np.sin(theta)) / PIXEL_M) - corner[0]
                j = np.floor((dx * np.sin(theta) + dz * np.cos(theta)) / PIXEL_M) - corner[1]
                here = (i >= 0) & (j >= 0) & (i < picture.shape[2]) & (j < picture.shape[1])
                i, j = (np.where(here, v, 0).astype(int) for v in (i, j))
                marks[b] |= (picture[:, j, i] & here).T
        layers = np.asarray(pixels.layers)[..., None] >> np.arange(LAYERS, dtype=np.uint16)
        found.append(int((marks & (layers & 1 == 1)).sum()))
    return found


@pytest.mark.parametrize("form", FORMS)
def test_packed_as_unpacked(thrown: tuple[Slices, list], form: Form) -> None:
    slices, cases = thrown
    for walks, scales, attack, crop in cases:
        drawn = drawn_of(attack, crop)
        packed = overlap_pixels(slices, walks, scales, drawn, crop, form=form)
        plain = unpacked(slices, walks, scales, drawn, crop, form)
        # A middle on the border of two pixels may be read on either side.
        assert np.abs(packed - plain).max() <= 2
        assert (packed != plain).mean() < 0.1
        assert packed.max() > 20


@pytest.mark.parametrize("form", FORMS)
def test_padding_changes_nothing(
    thrown: tuple[Slices, list], form: Form, monkeypatch: pytest.MonkeyPatch
) -> None:
    slices, cases = thrown
    walks, scales, attack, crop = cases[0]
    drawn = drawn_of(attack, crop)
    expected = overlap_pixels(slices, walks, scales, drawn, crop, form=form)
    wide = replace(walks, edges=np.pad(walks.edges, ((0, 0), (0, 9)), constant_values=NO_EDGE))
    stretched = np.pad(scales, ((0, 0), (0, 9)), constant_values=3.0)
    assert (overlap_pixels(slices, wide, stretched, drawn, crop, form=form) == expected).all()
    order = np.random.default_rng(0).permutation(len(expected))[:7]
    some = Candidates(
        edges=walks.edges[order],
        length=walks.length[order],
        part=walks.part[order],
        overflow=0,
    )
    got = overlap_pixels(slices, some, scales[order], drawn, crop, form=form)
    assert (got == expected[order]).all()
    monkeypatch.setattr(overlap_module, "CULL_TILE", 8)
    assert (overlap_pixels(slices, walks, scales, drawn, crop, form=form) == expected).all()


@pytest.mark.parametrize("form", FORMS)
def test_jit_as_eager(thrown: tuple[Slices, list], form: Form) -> None:
    slices, cases = thrown
    walks, scales, attack, crop = cases[1]
    drawn = drawn_of(attack, crop)
    expected = overlap_pixels(slices, walks, scales, drawn, crop, form=form)
    pixels = padded_pixels(drawn, crop, form)
    got = overlap(
        jax.device_put(slices),
        jax.numpy.asarray(walks.edges.astype(np.int32)),
        jax.numpy.asarray(walks.length.astype(np.int32)),
        jax.numpy.asarray(scales),
        pixels,
        form=form,
        span=walks.edges.shape[1],
    )
    assert np.abs(np.asarray(got) - expected).max() <= 2


def test_a_walk_that_meets_the_ball_overlaps(thrown: tuple[Slices, list]) -> None:
    """What is hit deeply overlaps in both forms, and never more than the attack has pixels."""
    slices, cases = thrown
    for walks, scales, attack, crop in cases:
        drawn = drawn_of(attack, crop)
        most = int(np.bitwise_count(drawn.layers).sum())
        for form in FORMS:
            counts = overlap_pixels(slices, walks, scales, drawn, crop, form=form)
            assert counts.min() >= 0
            assert counts.max() <= most


def test_no_candidates(thrown: tuple[Slices, list]) -> None:
    slices, cases = thrown
    _, _, attack, crop = cases[0]
    empty = np.zeros(0, np.int64)
    walks = Candidates(edges=np.full((0, 1), NO_EDGE), length=empty, part=empty, overflow=0)
    scales = np.ones((0, 1), np.float32)
    for form in FORMS:
        assert cull(slices, walks, scales, attack, crop, form=form, threshold=0).shape == (0,)
