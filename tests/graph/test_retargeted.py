"""Clips of several skeletons in one graph."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mgjax.clips.synthetic import synthetic_clips
from mgjax.clips.types import Clip
from mgjax.core.errors import SkeletonError
from mgjax.core.kinematics import forward
from mgjax.graph.build import build_graph
from mgjax.graph.config import GraphConfig
from mgjax.graph.files import load_graph, save_graph
from mgjax.graph.plants import planted_frames
from mgjax.graph.types import NO_CLIP, MotionGraph
from mgjax.io.load import load_motion
from tests.clips.retarget.bodies import mixamo, xsens

MADE = {clip.name: clip for clip in synthetic_clips()[0]}


def others() -> list[Clip]:
    return [mixamo(MADE["walk"]), xsens(MADE["walk_curve"])]


def between(graph: MotionGraph, kinds: dict[str, str]) -> set[tuple[str, str]]:
    """Between which kinds of clips there are transitions."""
    edges = np.flatnonzero(graph.edge_clip == NO_CLIP)
    of = [kinds[name] for name in graph.clip_names]
    ends = (graph.node_clip[e[edges]] for e in (graph.edge_source, graph.edge_target))
    return {(of[a], of[b]) for a, b in zip(*ends, strict=True)}


def test_made_clips_of_three_skeletons(tmp_path):
    clips = [MADE["steps"], *others()]
    with pytest.raises(SkeletonError, match="--retarget"):
        build_graph(clips)
    graph = build_graph(clips, config=GraphConfig(retarget=True, threshold_m=0.12))
    assert graph.skeleton.names == MADE["steps"].skeleton.names
    rows = graph.report["retargeted"]
    assert [row["clip"] for row in rows] == ["walk", "walk_curve"]
    assert all(row["foot_slide_after_m"] <= row["foot_slide_before_m"] + 1e-6 for row in rows)
    kinds = {"steps": "made", "walk": "mixamo", "walk_curve": "xsens"}
    links = between(graph, kinds)
    assert {(a, b) for a in kinds.values() for b in kinds.values()} <= links
    save_graph(tmp_path / "graph", graph)
    assert load_graph(tmp_path / "graph").report["retargeted"] == rows


def test_captured_clips_of_four_skeletons(capture):
    folders = {
        "cmu": ("locomotion/cmu16/16_16.amc", "locomotion/cmu16/16_47.amc"),
        "bandai": ("bandai/set1/walk_normal_001.bvh", "bandai/set1/walk_active_001.bvh"),
    }
    clips, kinds = others(), {"walk": "mixamo", "walk_curve": "xsens"}
    for kind, files in folders.items():
        for file in files:
            skeleton, motion = load_motion(capture / file)
            clips.insert(0, Clip(name=file, skeleton=skeleton, motion=motion))
            kinds[file] = kind
    config = GraphConfig(retarget=True, threshold_m=0.12)
    graph = build_graph(clips, config=config, skeleton=clips[2].skeleton)
    assert len(graph.report["retargeted"]) == 4
    # One component: from each kind to another, and from that back.
    links = between(graph, kinds)
    reached = {kind: {kind} for kind in set(kinds.values())}
    for _ in reached:
        for a, b in links:
            reached[a] |= reached[b]
    assert all(found == set(kinds.values()) for found in reached.values()), links
    assert_stands(graph)


def assert_stands(graph: MotionGraph) -> None:
    """In every frame of the clips: feet on the floor, legs and arms not turned over."""
    stop = int(graph.clip_stops[-1])
    places = np.asarray(graph.positions)[:stop]
    roles = {n: graph.skeleton.index(n) for n in graph.skeleton.names}
    assert places[..., 1].min() > -0.05
    on = planted_frames(graph)[:stop]
    for start, end in zip(graph.clip_starts, graph.clip_stops, strict=True):
        assert on[start:end].any(axis=1).mean() > 0.3
    _, turns = forward(graph.skeleton, graph.root_translation[:stop], graph.local_rotations[:stop])
    assert np.isfinite(np.asarray(turns)).all()
    for low, high in (("root", "thorax"), ("ltibia", "root"), ("rtibia", "root")):
        assert (places[:, roles[high], 1] > places[:, roles[low], 1]).all()
    for side in "lr":
        # Knees are ahead of the line from hip to ankle, in the direction of the toes.
        hip, knee, ankle, toes = (
            places[:, roles[side + n]] for n in ("femur", "tibia", "foot", "toes")
        )
        way = ankle - hip
        share = ((knee - hip) * way).sum(-1) / (way * way).sum(-1)
        bend = knee - hip - share[:, None] * way
        out = np.linalg.norm(bend, axis=-1) > 0.05
        assert ((bend * (toes - ankle)).sum(-1)[out] > 0).mean() > 0.98


def test_mirrored_too():
    clips = [replace(MADE["steps"]), *others()]
    graph = build_graph(clips, config=GraphConfig(retarget=True, mirror=True, threshold_m=0.12))
    assert len(graph.report["retargeted"]) == 2
    assert "walk~mirrored" in graph.clip_names
