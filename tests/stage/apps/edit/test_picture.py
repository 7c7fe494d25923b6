"""The arrays of the picture, and a transition's figures, against the graph they are made of."""

import numpy as np
import pytest

from mgjax.clips.types import Label
from mgjax.core.errors import GraphError
from mgjax.core.kinematics import global_positions
from mgjax.graph.types import NO_CLIP
from mgjax.graph.walk import unroll
from mgjax.stage.apps.edit.picture import graph_picture, kept_spans
from mgjax.stage.apps.edit.seam import AROUND_S, seam_of


@pytest.fixture(scope="module")
def transitions(graph):
    return np.flatnonzero(graph.edge_clip == NO_CLIP)


def test_transitions_leave_and_arrive_where_the_graph_says(graph, some, transitions):
    drawn = graph_picture(graph, some[1])["transitions"]
    np.testing.assert_array_equal(drawn["edge"], transitions)
    for ends, side in ((graph.edge_source, "from"), (graph.edge_target, "to")):
        clip, frame = drawn[f"{side}_clip"], drawn[f"{side}_frame"]
        np.testing.assert_array_equal(
            graph.clip_starts[clip] + frame, graph.node_frame[ends[transitions]]
        )
        assert (frame <= (graph.clip_stops - graph.clip_starts)[clip]).all()
    np.testing.assert_array_equal(drawn["distance"], graph.edge_distance[transitions])


def test_what_is_kept_of_a_clip_is_what_its_pieces_cover(graph):
    covered = np.zeros(int(graph.clip_stops[-1]), bool)
    for edge in np.flatnonzero(graph.edge_clip != NO_CLIP):
        covered[graph.edge_starts[edge] : graph.edge_stops[edge]] = True
    drawn = np.zeros_like(covered)
    for start, (a, b) in zip(graph.clip_starts, kept_spans(graph), strict=True):
        drawn[start + a : start + b] = True
    np.testing.assert_array_equal(drawn, covered)


def test_labels_are_kept_or_lost_as_the_report_counts(graph, some):
    labels = graph_picture(graph, some[1])["labels"]
    assert sum(x["kept"] for x in labels) == graph.report["labels_kept"]
    assert sum(x["enterable"] for x in labels) == graph.report["labels_enterable"]
    asked = sum(len(items) for items in some[1].values())
    assert len(labels) == asked
    for drawn in labels:
        name = graph.clip_names[drawn["clip"]]
        spans = [(round(30 * x.start_s), round(30 * x.end_s)) for x in some[1][name]]
        assert (drawn["start"], drawn["stop"]) in spans


def test_a_label_that_the_graph_does_not_hold_is_drawn_where_it_was(graph, some):
    last = int(graph.clip_stops[0] - graph.clip_starts[0])
    name = graph.clip_names[0]
    lost = Label(start_s=(last - 3) / 30, end_s=last / 30, kind="end", genuine=False)
    labels = {**some[1], name: (*some[1].get(name, ()), lost)}
    found = [x for x in graph_picture(graph, labels)["labels"] if x["kind"] == "end"]
    assert found == [
        {
            "clip": 0,
            "start": last - 3,
            "stop": last,
            "kind": "end",
            "direction": "",
            "genuine": False,
            "kept": False,
            "enterable": False,
        }
    ]


def test_a_transition_is_played_between_its_clips(graph, transitions):
    for edge in transitions[:: len(transitions) // 5]:
        seam = seam_of(graph, int(edge))
        around = round(AROUND_S * graph.frame_rate)
        first = round(seam.start * graph.frame_rate)
        last = round(seam.stop * graph.frame_rate)
        assert first <= around
        assert last - first == graph.window
        walked = unroll(graph, [int(edge)])
        np.testing.assert_allclose(
            np.asarray(seam.motion.local_rotations)[first : last + 1, 1:],
            walked.local_rotations[:, 1:],
            atol=1e-6,
        )
        step = np.linalg.norm(
            np.diff(global_positions(graph.skeleton, seam.motion), axis=0), axis=-1
        )
        assert step[max(first - 1, 0) : last + 1].max() < 0.35  # nothing jumps at the seams
        leaves = graph.node_frame[graph.edge_source[edge]]
        name, second = seam.leaves
        start = graph.clip_starts[graph.clip_names.index(name)]
        assert start + round(second * graph.frame_rate) == leaves
        assert seam.distance == pytest.approx(float(graph.edge_distance[edge]))


@pytest.mark.long
def test_slides_are_on_the_average_what_the_build_reports(graph, transitions):
    slides = np.array([seam_of(graph, int(edge)).slide for edge in transitions])
    assert slides[:, 0].mean() == pytest.approx(graph.report["foot_slide_before"], rel=1e-3)
    assert slides[:, 1].mean() == pytest.approx(graph.report["foot_slide_after"], rel=1e-3)


def test_jerk_of_a_motion_that_only_accelerates_is_none_and_of_a_kick_is_by_hand(graph):
    """At 30 Hz, one frame off by 1 mm changes the acceleration by 3 · 0.001 · 900 m/s²."""
    from mgjax.stage.apps.edit.seam import peak_jerk

    t = np.arange(12.0)
    falls = np.zeros((12, 2, 3))
    falls[:, :, 1] = 0.5 * t[:, None] ** 2
    assert peak_jerk(falls, 30.0) == pytest.approx(0.0, abs=1e-6)
    falls[6, 1, 0] += 0.001
    assert peak_jerk(falls, 30.0) == pytest.approx(3 * 0.001 * 900 * 30)


@pytest.mark.parametrize("edge", [-1, 10**6])
def test_other_edges_are_no_transitions(graph, edge):
    with pytest.raises(GraphError, match="expected a transition"):
        seam_of(graph, edge)
    with pytest.raises(GraphError, match="expected a transition"):
        seam_of(graph, int(np.flatnonzero(graph.edge_clip != NO_CLIP)[0]))
