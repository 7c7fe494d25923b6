from __future__ import annotations

import gc
import subprocess
import sys
import weakref
from dataclasses import replace

import numpy as np
import pytest
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from mgjax.clips.synthetic_skeleton import synthetic_skeleton
from mgjax.clips.types import Label
from mgjax.core.errors import ConfigError, GraphError, LabelError, MotionError, SkeletonError
from mgjax.core.kinematics import forward
from mgjax.core.motion import cut
from mgjax.graph.build import build_graph, joint_weights
from mgjax.graph.config import GraphConfig
from mgjax.graph.distances.distance import distance_matrix
from mgjax.graph.plants import planted_frames
from mgjax.graph.types import NO_CLIP, MotionGraph
from tests.graph.made import BODY, clip, march, places
from tests.reference import graph as reference
from tests.reference import kinematics

GRAPHS = ["made_graph", "real_graph"]


@pytest.fixture(params=GRAPHS)
def graph_and_labels(request) -> tuple[MotionGraph, dict[str, tuple[Label, ...]]]:
    source = request.param.removesuffix("_graph")
    return request.getfixturevalue(request.param), request.getfixturevalue(source)[1]


@pytest.fixture(params=GRAPHS)
def graph(request) -> MotionGraph:
    return request.getfixturevalue(request.param)


def label_frames(graph: MotionGraph, labels: dict[str, tuple[Label, ...]]) -> np.ndarray:
    """[P,3] clip, start and stop on the graph's axis of all labels that were given."""
    found = []
    for name, items in labels.items():
        k = graph.clip_names.index(name)
        for x in items:
            ends = (round(s * graph.frame_rate) for s in (x.start_s, x.end_s))
            found.append((k, *(int(graph.clip_starts[k]) + f for f in ends)))
    return np.array(sorted(found))


def cores(graph: MotionGraph, labels: dict[str, tuple[Label, ...]]) -> np.ndarray:
    """[P,3] of the same labels what no blend may touch: without a third of the frames at either
    end, or with more where all joints are slower than a fifth of the label's own peak."""
    clips = int(graph.clip_stops[-1])
    places_of = forward(
        graph.skeleton, graph.root_translation[:clips], graph.local_rotations[:clips]
    )
    p = np.asarray(places_of[0], dtype=np.float64)
    found = []
    for k, start, stop in label_frames(graph, labels):
        speeds = [np.linalg.norm(p[f + 1] - p[f], axis=-1).max() for f in range(start, stop - 1)]
        ends = []
        for run in (speeds, speeds[::-1]):
            quiet = 0
            while run and run[quiet] < 0.2 * max(speeds):
                quiet += 1
            ends.append(min(max(quiet, int(0.33 * (stop - start))), (stop - start - 1) // 2))
        found.append((k, start + ends[0], stop - ends[1]))
    return np.array(found)


def transitions_of(graph: MotionGraph) -> np.ndarray:
    return np.flatnonzero(graph.edge_clip == NO_CLIP)


def windows_of(graph: MotionGraph) -> tuple[np.ndarray, np.ndarray]:
    """First frames of the two windows of each transition."""
    edges = transitions_of(graph)
    leave = graph.node_frame[graph.edge_source[edges]]
    return leave, graph.node_frame[graph.edge_target[edges]] - graph.window


def test_no_node_lies_inside_the_core_of_a_label(graph_and_labels):
    graph, labels = graph_and_labels
    for k, start, stop in cores(graph, labels):
        inside = (graph.node_clip == k) & (graph.node_frame > start) & (graph.node_frame < stop)
        assert not inside.any()


def test_no_blend_touches_the_core_of_a_label(graph_and_labels):
    graph, labels = graph_and_labels
    for first in windows_of(graph):
        for _, start, stop in cores(graph, labels):
            assert not ((first < stop) & (first + graph.window > start)).any()


def test_every_kept_label_lies_in_exactly_one_edge(graph_and_labels):
    graph, labels = graph_and_labels
    pieces = graph.edge_clip != NO_CLIP
    given = label_frames(graph, labels)
    holders = []
    for k, start, stop in cores(graph, labels):
        inside = (graph.edge_clip == k) & (graph.edge_starts <= start) & (graph.edge_stops >= stop)
        touched = pieces & (graph.edge_starts < stop) & (graph.edge_stops > start)
        assert inside.sum() <= 1
        assert inside.sum() == touched.sum()  # never in part
        holders.append(np.flatnonzero(inside))
    kept = np.array([len(h) == 1 for h in holders])
    np.testing.assert_array_equal(graph.label_edge, np.concatenate(holders))
    # What blends overlap of an end is cut off at both, so that the middle stays where it is.
    edge = graph.label_edge
    cut = np.maximum(
        graph.edge_starts[edge] - given[kept, 1], given[kept, 2] - graph.edge_stops[edge]
    ).clip(0)
    np.testing.assert_array_equal(graph.label_starts, given[kept, 1] + cut)
    np.testing.assert_array_equal(graph.label_stops, given[kept, 2] - cut)
    assert (graph.label_starts < graph.label_stops).all()
    assert graph.report["labels_kept"] == kept.sum() == len(graph.label_kind)
    assert kept.mean() >= 0.9
    items = [
        x
        for name in graph.clip_names
        for x in sorted(labels.get(name, ()), key=lambda x: x.start_s)
    ]
    assert graph.label_kind == tuple(x.kind for x, k in zip(items, kept, strict=True) if k)
    assert graph.label_direction == tuple(
        x.direction for x, k in zip(items, kept, strict=True) if k
    )
    np.testing.assert_array_equal(
        graph.label_genuine, [x.genuine for x, k in zip(items, kept, strict=True) if k]
    )


def test_the_paper_s_form_leaves_labels_whole(made):
    config = GraphConfig(minima="all", label_quiet=0.0, label_overlap=0.0)
    graph = build_graph(made[0], labels=made[1], config=config)
    given = label_frames(graph, made[1])
    np.testing.assert_array_equal(graph.label_starts, given[:, 1])
    np.testing.assert_array_equal(graph.label_stops, given[:, 2])
    for first in windows_of(graph):
        for _, start, stop in given:
            assert not ((first < stop) & (first + graph.window > start)).any()


def test_ranges_add_transitions(made, made_graph):
    config = GraphConfig(threshold_m=made_graph.report["threshold_m"], range_frames=6)
    graph = build_graph(made[0], labels=made[1], config=config)
    few, many = (
        set(zip(*(x.tolist() for x in windows_of(g)), strict=True)) for g in (made_graph, graph)
    )
    assert few < many


def test_every_node_can_be_reached_and_left(graph):
    n = graph.num_nodes
    for ends in (graph.edge_source, graph.edge_target):
        assert set(ends.tolist()) == set(range(n))
    ones = np.ones(graph.num_edges)
    matrix = csr_array((ones, (graph.edge_source, graph.edge_target)), shape=(n, n))
    count, _ = connected_components(matrix, directed=True, connection="strong")
    assert count == 1


def test_out_edges_are_those_that_leave(graph):
    assert graph.out_first[0] == 0
    assert graph.out_first[-1] == graph.num_edges
    assert sorted(graph.out_edges.tolist()) == list(range(graph.num_edges))
    for node in range(graph.num_nodes):
        edges = graph.edges_from(node)
        assert (graph.edge_source[edges] == node).all()
        assert len(edges) >= 1


def test_pieces_of_clips_are_contiguous(graph):
    pieces = graph.edge_clip != NO_CLIP
    source, target = graph.edge_source[pieces], graph.edge_target[pieces]
    np.testing.assert_array_equal(graph.edge_starts[pieces], graph.node_frame[source])
    np.testing.assert_array_equal(graph.edge_stops[pieces], graph.node_frame[target])
    np.testing.assert_array_equal(graph.edge_clip[pieces], graph.node_clip[source])
    np.testing.assert_array_equal(graph.edge_clip[pieces], graph.node_clip[target])
    np.testing.assert_array_equal(target, source + 1)  # the next node, none in between
    assert (graph.edge_frames > 0).all()
    np.testing.assert_array_equal(graph.edge_exit[pieces], 0)
    np.testing.assert_array_equal(graph.edge_distance[pieces], 0)
    assert (np.diff(graph.node_frame) > 0).all()
    for node, k in zip(graph.node_frame, graph.node_clip, strict=True):
        assert graph.clip_starts[k] < node < graph.clip_stops[k]


def test_transitions_have_their_own_frames_after_the_clips(graph):
    edges = transitions_of(graph)
    assert len(edges) == graph.report["transitions"]
    clips = graph.clip_stops[-1]
    want = clips + (graph.window + 1) * np.arange(len(edges))
    np.testing.assert_array_equal(graph.edge_starts[edges], want)
    np.testing.assert_array_equal(graph.edge_stops[edges], want + graph.window)
    assert len(graph.root_translation) == clips + (graph.window + 1) * len(edges)
    distances = graph.edge_distance[edges]
    assert (np.diff(distances) >= 0).all()
    assert distances.max() <= np.float32(graph.body_scale * graph.report["threshold_m"])
    assert not (graph.edge_source[edges] == graph.edge_target[edges]).any()
    # Windows of one clip are at least half a second apart, and lie in their clips with a frame
    # before the first and one after the second.
    leave, first = windows_of(graph)
    a, b = graph.node_clip[graph.edge_source[edges]], graph.node_clip[graph.edge_target[edges]]
    assert (np.abs(leave - first)[a == b] >= round(0.5 * graph.frame_rate)).all()
    assert (leave > graph.clip_starts[a]).all()
    assert (leave + graph.window <= graph.clip_stops[a]).all()
    assert (first >= graph.clip_starts[b]).all()
    assert (first + graph.window < graph.clip_stops[b]).all()


def test_transitions_arrive_at_the_pose_of_their_target(graph):
    edges = transitions_of(graph)
    last = graph.edge_stops[edges]
    node = graph.node_frame[graph.edge_target[edges]]
    here, _ = forward(graph.skeleton, graph.root_translation[last], graph.local_rotations[last])
    there, _ = forward(graph.skeleton, graph.root_translation[node], graph.local_rotations[node])
    theta, x, z = graph.edge_exit[edges].astype(np.float64).T[:, :, None]
    mapped = np.stack(
        [
            there[..., 0] * np.cos(theta) + there[..., 2] * np.sin(theta) + x,
            there[..., 1],
            there[..., 2] * np.cos(theta) - there[..., 0] * np.sin(theta) + z,
        ],
        axis=-1,
    )
    assert np.abs(here - mapped).max() < 1e-4


def test_transitions_begin_near_the_clip_they_leave(graph):
    edges = transitions_of(graph)
    p, _ = forward(graph.skeleton, graph.root_translation, graph.local_rotations)
    first = p[graph.edge_starts[edges]]
    leave = p[graph.node_frame[graph.edge_source[edges]]]
    # 2.8 % of the way to the other clip, and the first of ten steps by which a foot is moved.
    away = np.linalg.norm(first - leave, axis=-1)
    assert away.mean() < 0.003
    assert away.max() < 0.1


def test_planes_of_the_nodes(graph):
    p, _ = forward(
        graph.skeleton,
        graph.root_translation[graph.node_frame],
        graph.local_rotations[graph.node_frame],
    )
    names = graph.skeleton.names
    left, right = names.index("lfemur"), names.index("rfemur")
    for node in range(0, graph.num_nodes, max(graph.num_nodes // 50, 1)):
        want = kinematics.heading(p[node, left], p[node, right])
        turn = graph.node_plane[node, 0] - want
        assert abs(np.sin(turn)) < 1e-4
        assert np.cos(turn) > 0
        np.testing.assert_allclose(graph.node_plane[node, 1:], p[node, 0, [0, 2]], atol=1e-5)


def test_distances_and_transforms_are_those_of_the_windows(graph):
    p, _ = forward(graph.skeleton, graph.root_translation, graph.local_rotations)
    edges = transitions_of(graph)
    leave, first = windows_of(graph)
    counted = np.ones(graph.skeleton.num_joints)
    counted[list(graph.skeleton.end_joints)] = 0
    w = reference.cloud_weights(counted, len(counted), graph.window)
    for m in np.linspace(0, len(edges) - 1, 25).astype(int):
        a, b = (reference.cloud(p, int(x[m]), graph.window) for x in (leave, first))
        squared = reference.squared_distance(a, b, w)
        assert abs(graph.edge_distance[edges[m]] ** 2 - squared) < 1e-5
        # The heading is that which brings them this near; the places of feet that stand in both
        # count more.
        got = np.asarray(graph.edge_exit[edges[m]], np.float64)
        turn = reference.align(a, b, w)[0]
        np.testing.assert_allclose(np.exp(1j * got[0]), np.exp(1j * turn), atol=2e-3)
        both = _planted_in_both(graph, int(leave[m]), int(first[m]))
        counting = (w.reshape(graph.window, -1) * graph.window + both).ravel()
        counting /= counting.sum()
        moved = kinematics.planar_apply(got, counting @ b)
        np.testing.assert_allclose(moved[[0, 2]], (counting @ a)[[0, 2]], atol=1e-4)


def _planted_in_both(graph: MotionGraph, row: int, column: int) -> np.ndarray:
    """[W,J] what balls and ankles count more where their foot stands in both windows."""
    names, step = graph.skeleton.names, np.arange(graph.window)
    u = (step + 0.5) / graph.window
    standing = graph.plants[row + step] & graph.plants[column + step]
    extra = np.zeros((graph.window, len(names)))
    for side, letter in enumerate("lr"):
        for joint in (f"{letter}foot", f"{letter}toes"):
            extra[:, names.index(joint)] = 8 * 6 * u * (1 - u) * standing[:, side]
    return extra


def test_the_report_is_that_of_the_graph(graph_and_labels):
    graph, labels = graph_and_labels
    report = graph.report
    total = sum(len(x) for x in labels.values())
    assert report["clips"] == len(graph.clip_names)
    assert report["frames"] == graph.clip_stops[-1]
    assert report["seconds_of_clips"] == pytest.approx(report["frames"] / graph.frame_rate)
    assert report["nodes"] == graph.num_nodes
    assert report["edges"] == graph.num_edges
    assert report["transitions"] <= report["candidates"] <= report["minima"]
    assert report["labels_total"] == total
    assert report["genuine_total"] == sum(x.genuine for items in labels.values() for x in items)
    assert report["genuine_kept"] == graph.label_genuine.sum()
    # A label can be entered if its middle comes within 2 s of the node before it.
    middle = (graph.label_starts + graph.label_stops) / 2 - graph.edge_starts[graph.label_edge]
    enterable = middle <= 2.0 * graph.frame_rate
    assert report["labels_enterable"] == enterable.sum()
    assert report["genuine_enterable"] == (enterable & graph.label_genuine).sum()
    assert 0 <= report["foot_slide_after"] <= report["foot_slide_before"]
    assert set(report["seconds"]) == {
        *("prepare", "distance", "prune", "transitions", "assemble", "connectivity")
    }
    assert all(x >= 0 for x in report["seconds"].values())


def test_real_capture_keeps_its_labels(real_graph):
    report = real_graph.report
    assert report["clips"] == 29
    assert report["labels_total"] == 88
    assert report["genuine_total"] == 18
    assert report["labels_kept"] >= 80
    assert report["labels_enterable"] == report["labels_kept"]
    assert report["threshold_m"] <= 0.16
    assert report["foot_slide_after"] < 0.6 * report["foot_slide_before"]
    assert report["notes"] == []


def test_the_graph_is_the_same_each_time(made, made_graph):
    again = build_graph(made[0], labels=made[1])
    for name, value in vars(made_graph).items():
        other = getattr(again, name)
        if isinstance(value, np.ndarray):
            np.testing.assert_array_equal(value, other)
            assert value.dtype == other.dtype
        elif name == "report":
            assert {**value, "seconds": 0} == {**other, "seconds": 0}
        elif name == "skeleton":
            assert value.names == other.names
        else:
            assert value == other


def test_where_a_clip_was_captured_does_not_matter(made, made_graph):
    far = [
        replace(c, motion=replace(c.motion, root_translation=c.motion.root_translation + shift))
        for c, shift in zip(made[0], np.float32([[64, 0, 0], [0, 0, -32], [0, 0, 0]]), strict=True)
    ]
    graph = build_graph(far, labels=made[1])
    assert graph.report["threshold_m"] == pytest.approx(made_graph.report["threshold_m"], abs=1e-4)
    assert graph.report["labels_kept"] == made_graph.report["labels_kept"]


def test_mirrored_copies(made, made_graph):
    graph = build_graph(made[0], labels=made[1], config=GraphConfig(mirror=True))
    names = [c.name for c in made[0]]
    assert graph.clip_names == (*names, *(f"{n}~mirrored" for n in names))
    assert graph.report["labels_total"] == 2 * made_graph.report["labels_total"]
    assert graph.report["genuine_total"] == 2 * made_graph.report["genuine_total"]
    assert graph.report["frames"] == 2 * made_graph.report["frames"]
    assert any("mirrored" in note for note in graph.report["notes"])
    assert sorted(graph.label_direction) == ["", "", "left", "left", "right", "right"]
    count = len(names)
    for k in range(count):
        a = slice(graph.clip_starts[k], graph.clip_stops[k])
        b = slice(graph.clip_starts[k + count], graph.clip_stops[k + count])
        plain, _ = forward(BODY, graph.root_translation[a], graph.local_rotations[a])
        other, _ = forward(BODY, graph.root_translation[b], graph.local_rotations[b])
        flipped = plain[:, BODY.index("lfoot")] * [-1, 1, 1]
        np.testing.assert_allclose(other[:, BODY.index("rfoot")], flipped, atol=1e-4)


def test_another_hierarchy_is_refused(made):
    names = tuple(n.replace("rtibia", "rshin") for n in BODY.names)
    other = replace(clip("odd", march(40)), skeleton=replace(BODY, names=names))
    with pytest.raises(SkeletonError, match="odd: got joint 'rshin' where the reference has"):
        build_graph([*made[0], other])


def test_the_skeleton_can_be_given(made):
    taller = replace(BODY, offsets=BODY.offsets * np.float32(1.25))
    graph = build_graph(made[0], labels=made[1], skeleton=taller)
    np.testing.assert_array_equal(graph.skeleton.offsets, taller.offsets)
    k = graph.clip_names.index("a")
    assert graph.root_translation[graph.clip_starts[k], 1] == pytest.approx(
        1.25 * made[0][0].motion.root_translation[0, 1], abs=1e-5
    )


def with_t_pose(motion, frames: int = 1):
    """The rest pose before the first frame, where the body stands then."""
    rest = np.tile(np.float32([1, 0, 0, 0]), (frames, BODY.num_joints, 1))
    root = np.repeat(motion.root_translation[:1], frames, axis=0) + np.float32([0.5, 0, 0])
    return replace(
        motion,
        root_translation=np.concatenate([root, motion.root_translation]),
        local_rotations=np.concatenate([rest, motion.local_rotations]),
    )


def bent(seed: int, **changes):
    """A march with arms held up, so that it is nowhere near the rest pose."""
    motion = cut(march(157, seed=seed, **changes), 7, 157)  # from a turning point of the legs
    rotations = motion.local_rotations.copy()
    for name in ("lhumerus", "rhumerus", "thorax"):
        rotations[:, BODY.index(name)] = np.float32([0.8, 0.6, 0, 0])
    return replace(motion, local_rotations=rotations)


def test_a_t_pose_is_cut_and_labels_stay_with_their_frames():
    plain = [clip("a", bent(1, ducks=(2.2,))), clip("b", bent(2))]
    labels = {"a": (Label(start_s=1.7, end_s=2.3, kind="duck"),)}
    later = {"a": (Label(start_s=1.7 + 1 / 30, end_s=2.3 + 1 / 30, kind="duck"),)}
    want = build_graph(plain, labels=labels)
    got = build_graph([clip("a", with_t_pose(bent(1, ducks=(2.2,)))), plain[1]], labels=later)
    assert [n for n in got.report["notes"] if n.startswith("a: T-pose")]
    np.testing.assert_array_equal(got.label_starts, want.label_starts)
    np.testing.assert_array_equal(got.label_stops, want.label_stops)
    np.testing.assert_array_equal(got.local_rotations, want.local_rotations)
    assert got.clip_names == want.clip_names


def test_a_clip_is_split_where_it_jumps():
    motion = bent(1, ducks=(1.0, 4.0))
    root = motion.root_translation.copy()
    root[80:, 0] += 3.0
    labels = {
        "a": (
            Label(start_s=0.7, end_s=1.3, kind="duck", direction="left"),
            Label(start_s=2.5, end_s=2.8, kind="sway"),  # frames 75 … 84, with the jump inside
            Label(start_s=3.7, end_s=4.3, kind="duck", direction="right"),
        )
    }
    clips = [clip("a", replace(motion, root_translation=root)), clip("b", bent(2))]
    graph = build_graph(clips, labels=labels, config=GraphConfig(keep=1.0))
    assert graph.clip_names == ("a#0", "a#1", "b")
    np.testing.assert_array_equal(graph.clip_stops - graph.clip_starts, [80, 70, 150])
    assert "a: split where it jumps, at 2.67 s" in graph.report["notes"]
    assert any("label 2.5 … 2.8 s left out" in note for note in graph.report["notes"])
    assert graph.report["labels_total"] == 3
    assert graph.label_direction == ("left", "right")
    # 21 … 39 and 111 … 129, but for what blends overlap of them, alike on both sides.
    np.testing.assert_array_equal(graph.label_starts + graph.label_stops, [60, 240])
    assert (graph.label_starts >= [21, 111]).all()


def test_a_build_is_watched_and_ends_with_what_the_watcher_raises(made, made_graph):
    told: list[tuple[float, str]] = []
    graph = build_graph(made[0], labels=made[1], watch=lambda *x: told.append(x))
    np.testing.assert_array_equal(graph.edge_target, made_graph.edge_target)
    shares = [share for share, _ in told]
    assert shares == sorted(shares)
    assert shares[0] >= 0
    assert shares[-1] < 1
    for text in {text for _, text in told}:

        def stop(share: float, now: str, text: str = text) -> None:
            if now == text:
                raise InterruptedError(text)

        with pytest.raises(InterruptedError, match=text):
            build_graph(made[0], labels=made[1], watch=stop)


def test_a_fixed_threshold(made, made_graph):
    chosen = made_graph.report["threshold_m"]
    same = build_graph(made[0], labels=made[1], config=GraphConfig(threshold_m=chosen))
    np.testing.assert_array_equal(same.edge_target, made_graph.edge_target)
    more = build_graph(made[0], labels=made[1], config=GraphConfig(threshold_m=1.5 * chosen))
    assert more.report["transitions"] > same.report["transitions"]
    assert more.report["threshold_m"] == 1.5 * chosen


def test_a_threshold_that_leaves_nothing_names_one_that_works(made):
    clips, labels = made
    with pytest.raises(GraphError) as caught:
        build_graph(clips, labels=labels, config=GraphConfig(threshold_m=1e-4))
    text = str(caught.value)
    assert "got an empty graph at threshold 0.0001 m, expected at least 0." in text
    works = float(text.rsplit(" ", 2)[1])
    graph = build_graph(clips, labels=labels, config=GraphConfig(threshold_m=works))
    assert graph.num_edges > 0
    with pytest.raises(GraphError, match="empty graph"):
        build_graph(clips, labels=labels, config=GraphConfig(threshold_m=works - 2e-5))


def test_a_normalised_threshold(made):
    clips, labels = made
    graph = build_graph(clips, labels=labels, config=GraphConfig(normalised=0.2))
    p, w = [places(c.motion) for c in clips], joint_weights(BODY, "uniform")
    largest = max(distance_matrix(a, b, window=10, weights=w).max() for a in p for b in p)
    assert graph.report["threshold_m"] * graph.body_scale == pytest.approx(0.2 * largest, abs=1e-4)
    with pytest.raises(GraphError) as caught:
        build_graph(clips, labels=labels, config=GraphConfig(normalised=1e-5))
    works = float(str(caught.value).rsplit("normalised ", 1)[1].rstrip(")"))
    assert build_graph(clips, labels=labels, config=GraphConfig(normalised=works)).num_edges > 0


def test_clips_that_never_lead_back():
    rising = march(60)
    root = rising.root_translation + np.linspace(0, 30, 60)[:, None] * np.float32([0, 1, 0])
    once = clip("once", replace(rising, root_translation=root.astype(np.float32)))
    config = GraphConfig(threshold_m=1e-3, self_gap_s=5.0)
    with pytest.raises(GraphError, match="at no threshold do these lead back"):
        build_graph([once], config=config)


def test_the_automatic_threshold_says_what_can_be_reached(made):
    with pytest.raises(GraphError, match=r"got \d of 3 labels|got none of 3 labels"):
        build_graph(made[0], labels=made[1], config=GraphConfig(keep=1.0, max_threshold_m=0.002))


def test_without_labels_motion_is_kept(made):
    graph = build_graph(made[0], config=GraphConfig(keep=0.8))
    pieces = graph.edge_clip != NO_CLIP
    assert graph.edge_frames[pieces].sum() >= 0.8 * graph.report["frames"]
    assert graph.report["labels_total"] == 0


def test_clips_in_all_forms(made, made_graph):
    clips, labels = made
    mapping = {c.name: (c.skeleton, c.motion) for c in clips}
    assert build_graph(mapping, labels=labels).clip_names == made_graph.clip_names
    pairs = build_graph([(c.skeleton, c.motion) for c in clips], config=GraphConfig(keep=0.5))
    assert pairs.clip_names == ("clip0", "clip1", "clip2")


def test_other_rates_and_windows(made):
    clips, labels = made
    weights = {"lfoot": 1.0, "rfoot": 1.0, "thorax": 2.0}
    config = GraphConfig(frame_rate=15.0, window_s=0.2, neighbourhood=2, weights=weights)
    graph = build_graph(clips, labels=labels, config=config)
    assert graph.frame_rate == 15.0
    assert graph.window == 3
    assert graph.report["frames"] == sum(-(-c.motion.num_frames // 2) for c in clips)


def test_without_foot_clean_up(made, made_graph):
    graph = build_graph(made[0], labels=made[1], config=GraphConfig(clean_feet=False))
    np.testing.assert_array_equal(graph.edge_target, made_graph.edge_target)
    assert graph.report["foot_slide_after"] == 0
    assert not np.array_equal(graph.local_rotations, made_graph.local_rotations)


@pytest.mark.parametrize(
    "change",
    [
        {"frame_rate": 0.0},
        {"frame_rate": float("nan")},
        {"window_s": -1.0},
        {"neighbourhood": 0},
        {"self_gap_s": -0.1},
        {"self_gap_s": float("inf")},
        {"threshold_m": 0.0},
        {"threshold_m": float("nan")},
        {"normalised": 2.0},
        {"keep": 1.5},
        {"max_threshold_m": 0.0},
        {"horizon_s": 0.0},
        {"threshold_m": 0.1, "normalised": 0.1},
        {"weights": "all"},
        {"weights": {"lfemur": -1.0}},
        {"weights": {"lfemur": 0.0}},
    ],
)
def test_settings_out_of_range(made, change):
    with pytest.raises(ConfigError) as caught:
        build_graph(made[0], config=GraphConfig(**change))
    assert "\n" not in str(caught.value)
    assert next(iter(change)) in str(caught.value)


def test_positions_and_plants_are_kept(made_graph):
    graph = replace(made_graph)
    positions = np.asarray(
        forward(graph.skeleton, graph.root_translation, graph.local_rotations)[0]
    )
    np.testing.assert_array_equal(graph.positions, positions)
    assert graph.positions is graph.positions
    np.testing.assert_array_equal(made_graph.plants, planted_frames(made_graph))
    assert made_graph.plants is made_graph.plants
    dead = weakref.ref(graph)
    del graph
    gc.collect()
    assert dead() is None


def test_configurations_import_no_arrays():
    script = "import sys, mgjax.graph as g; g.GraphConfig(); sys.exit('numpy' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", script], check=False).returncode == 0


def test_weights():
    uniform = joint_weights(BODY, "uniform")
    assert (uniform[list(BODY.end_joints)] == 0).all()
    assert uniform.sum() == pytest.approx(1.0)
    table = joint_weights(BODY, {"head": 3.0, "lfoot": 1.0})
    assert table[BODY.index("head")] == pytest.approx(0.75)
    assert table.sum() == pytest.approx(1.0)
    names = {"lfemur", "ltibia", "lhumerus", "lradius", "rfemur", "rtibia", "rhumerus", "rradius"}
    whole = synthetic_skeleton()
    limbs = joint_weights(whole, "limbs")
    assert {n for n, w in zip(whole.names, limbs, strict=True) if w} == names
    with pytest.raises(SkeletonError, match="no joint 'tail'"):
        joint_weights(BODY, {"tail": 1.0})


def test_clips_that_cannot_be_used(made):
    clips, labels = made
    with pytest.raises(GraphError, match="no clips"):
        build_graph([])
    with pytest.raises(MotionError, match="two clips are called 'a'"):
        build_graph([clips[0], clips[0]])
    with pytest.raises(LabelError, match="labels for 'nowhere'"):
        build_graph(clips, labels={"nowhere": labels["a"]})
    broken = clips[0].motion.root_translation.copy()
    broken[7] = np.nan
    motion = replace(clips[0].motion, root_translation=broken)
    with pytest.raises(MotionError, match="not finite in frame 7"):
        build_graph([clip("a", motion)])
    with pytest.raises(GraphError, match="kept at most"):
        build_graph([clip("short", cut(clips[0].motion, 0, 5))])
