from __future__ import annotations

from dataclasses import replace

import jax
import numpy as np
import pytest

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.attacks.ball import ball_attack
from mgjax.avoidance.attacks.crop import Crop, crop_attack
from mgjax.avoidance.body.edge_tables import EdgeTables, edge_tables
from mgjax.avoidance.body.spheres import BodySpheres
from mgjax.avoidance.candidates.enumerate import Candidates, enumerate_candidates
from mgjax.avoidance.culling import cull as slices_cull
from mgjax.avoidance.culling.cull import cull, overlap_pixels, padded_pixels
from mgjax.avoidance.culling.overlap import overlap, play
from mgjax.avoidance.culling.pictures import (
    Form,
    Pictures,
    Slices,
    build_slices,
    picture_bytes,
    unpack,
)
from mgjax.avoidance.culling.rasterise import (
    LAYERS,
    MAX_ATTACK_BINS,
    PIXEL_M,
    Drawn,
    draw_attack,
    stamp,
    stamp_width,
)
from mgjax.graph.types import NO_EDGE, MotionGraph
from tests.avoidance.made import make_graph, random_graph, throw
from tests.reference import slices as reference

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
    """Walks from node 0 with 1 … ``longest`` edges; their parts do not matter here."""
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


@pytest.fixture(scope="module")
def small() -> tuple[MotionGraph, EdgeTables, Slices]:
    graph = random_graph(3)
    tables = edge_tables(graph, RATE)
    return graph, tables, build_slices(tables)


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
    big = ball_attack(here + np.array([5.0, 30.0, 0.0]), here, speed=10.0, arrives=1.0, radius=20.0)
    slow = ball_attack(here + np.array([2.0, 0.0, 0.0]), here, speed=0.2, arrives=12.0)
    fast = ball_attack(
        here + np.array([900.0, 0.0, 0.0]), here, speed=1000.0, arrives=1.0, radius=0.001
    )
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


@pytest.fixture(scope="module")
def thrown(made_graph: MotionGraph) -> tuple[Slices, list]:
    """Slices of the graph of clips, and candidates with scales for some balls."""
    tables = edge_tables(made_graph, RATE)
    rng = np.random.default_rng(2)
    cases: list = []
    while len(cases) < 3:
        attack = throw(rng)
        crop = crop_of(attack)
        node = int(rng.integers(made_graph.num_nodes))
        found = enumerate_candidates(made_graph, tables, node, crop.middle, window=1.0, capacity=40)
        if len(found.length) >= 10:
            cases.append((found, random_scales(found, len(cases)), attack, crop))
    return build_slices(tables), cases


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
    monkeypatch.setattr(slices_cull, "TILE", 8)
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


def test_cull_keeps_up_to_the_threshold(thrown: tuple[Slices, list]) -> None:
    slices, cases = thrown
    walks, scales, attack, crop = cases[0]
    for form in FORMS:
        counts = overlap_pixels(slices, walks, scales, drawn_of(attack, crop), crop, form=form)
        middle = int(np.median(counts))
        for threshold in (0, middle, int(counts.max())):
            keep = cull(slices, walks, scales, attack, crop, form=form, threshold=threshold)
            assert (keep == (counts <= threshold)).all()
        assert counts.max() > counts.min()


def test_no_candidates(thrown: tuple[Slices, list]) -> None:
    slices, cases = thrown
    _, _, attack, crop = cases[0]
    empty = np.zeros(0, np.int64)
    walks = Candidates(edges=np.full((0, 1), NO_EDGE), length=empty, part=empty, overflow=0)
    scales = np.ones((0, 1), np.float32)
    for form in FORMS:
        assert cull(slices, walks, scales, attack, crop, form=form, threshold=0).shape == (0,)


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


def test_capture(capture, real_graph: MotionGraph) -> None:
    """On real capture: every bin of an edge is within its picture, and the size is modest."""
    slices = build_slices(edge_tables(real_graph, RATE))
    assert picture_bytes(slices.binned) + picture_bytes(slices.paper) < 60e6
    rng = np.random.default_rng(0)
    for edge in rng.integers(0, real_graph.num_edges, 5):
        first = int(slices.first_bin[edge])
        bins = [pixel_set(slices.binned, first + b) for b in range(int(slices.bins[edge]))]
        assert pixel_set(slices.paper, int(edge)) == set().union(*bins)
