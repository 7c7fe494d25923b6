"""Measures of seams beside the same measures of uncut capture."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from scipy.stats import rankdata

from mgjax.core import planar
from mgjax.core.body.capsules import pair_distances
from mgjax.core.contacts import foot_joints
from mgjax.graph.feet.legs import foot_chains
from mgjax.graph.types import NO_CLIP, MotionGraph
from mgjax.quality.subject import subject_of

WINDOW_S = 0.4
"""Length of the windows of which the jerk is taken."""
CONTACT_M = 0.05
"""A toe lower than this is in contact."""
SKATE_M = 0.025
"""A joint lower than this skates (MANN)."""
CHUNK = 256
"""Seams of which the limbs are tested against each other at once."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Tracks:
    """Joint positions around seams, or of uncut motion at the same places.

    Attributes:
        places: m. [M, F, J, 3]
        floors: height of the ankles and toes when they are down, of the clips of each. [M, 4]
        first, last: frames between which the seams lie.
    """

    places: Float[np.ndarray, "M F J 3"]
    floors: Float[np.ndarray, "M 4"]
    first: int
    last: int


@dataclass(frozen=True, kw_only=True, eq=False)
class Capture:
    """What the capture itself does.

    Attributes:
        jerk: 99.9 % quantile of the normalised jerk of each joint. [J]
        apart: least distance of each pair of capsules, m. [P]
    """

    jerk: Float[np.ndarray, " J"]
    apart: Float[np.ndarray, " P"]


def seam_edges(graph: MotionGraph, around: int) -> np.ndarray:
    """Transitions with so many frames of their clips before and after them."""
    edges = np.flatnonzero(graph.edge_clip == NO_CLIP)
    leave, arrive = _ends(graph, edges)
    clips = [graph.node_clip[ends[edges]] for ends in (graph.edge_source, graph.edge_target)]
    ok = leave - around >= graph.clip_starts[clips[0]]
    ok &= leave + graph.window + around < graph.clip_stops[clips[0]]
    ok &= arrive - graph.window - around >= graph.clip_starts[clips[1]]
    return edges[ok & (arrive + around < graph.clip_stops[clips[1]])]


def seam_tracks(graph: MotionGraph, edges: np.ndarray, around: int) -> Tracks:
    """Transitions with so many frames before and after."""
    leave, arrive = _ends(graph, edges)
    before = graph.positions[leave[:, None] + np.arange(-around, 0)]
    inside = graph.positions[graph.edge_starts[edges][:, None] + np.arange(graph.window)]
    after = planar.apply(
        graph.edge_exit[edges][:, None, None],
        graph.positions[arrive[:, None] + np.arange(around + 1)],
    )
    low = floors_of(graph)
    clips = [graph.node_clip[ends[edges]] for ends in (graph.edge_source, graph.edge_target)]
    return Tracks(
        places=np.concatenate([before, inside, np.asarray(after)], axis=1),
        floors=np.maximum(low[clips[0]], low[clips[1]]),
        first=around - 1,
        last=around + graph.window,
    )


def uncut_tracks(graph: MotionGraph, edges: np.ndarray, around: int) -> Tracks:
    """The two clips of each transition at the same places, played on."""
    leave, arrive = _ends(graph, edges)
    step = np.arange(-around, graph.window + around + 1)
    starts = np.concatenate([leave, arrive - graph.window])
    clip = np.searchsorted(graph.clip_starts, starts, side="right") - 1
    return Tracks(
        places=graph.positions[starts[:, None] + step],
        floors=floors_of(graph)[clip],
        first=around - 1,
        last=around + graph.window,
    )


def floors_of(graph: MotionGraph) -> Float[np.ndarray, "K 4"]:
    """The lowest 1 % of the heights of the ankles and toes of each clip."""
    heights = graph.positions[:, feet_of(graph), 1]
    spans = zip(graph.clip_starts, graph.clip_stops, strict=True)
    return np.stack([np.quantile(heights[a:b], 0.01, axis=0) for a, b in spans])


def feet_of(graph: MotionGraph) -> list[int]:
    """Both toes, both ankles."""
    return [*foot_joints(graph.skeleton), *foot_chains(graph.skeleton).ankles]


def measured(graph: MotionGraph, tracks: Tracks, capture: Capture) -> dict[str, np.ndarray]:
    """Each measure of each track.

    ``jerky``: share of windows and joints above the capture's quantile; ``jerk``: the largest
    normalised jerk by that quantile, its log; ``velocity_jump``, m/s; ``contact_speed``, m/s;
    ``skate_cm``; ``sink``: m under the floor of the clips; ``depth``: m of a limb in another or in
    the torso beyond what the capture has.
    """
    rate, places = graph.frame_rate, tracks.places
    joints = _turning(graph)
    near = slice(tracks.first - 1, tracks.last + 2)
    length = round(WINDOW_S * rate)
    start = max(tracks.first - length, 0)
    jerk = normalised_jerk(places[:, start : tracks.last + length + 1], rate)[..., joints]
    above = jerk / capture.jerk[joints]
    change = np.diff(places[:, near], n=2, axis=1) * rate
    feet = places[:, tracks.first : tracks.last + 1][:, :, feet_of(graph)]
    steps = np.diff(feet, axis=1)
    speed = np.linalg.norm(steps[:, :, :2], axis=-1) * rate
    contact = feet[:, :-1, :2, 1] < CONTACT_M
    height = np.maximum(feet[:, :-1, :, 1] - tracks.floors[:, None], 0.0)
    slide = np.linalg.norm(steps[..., [0, 2]], axis=-1) * (2 - 2 ** (height / SKATE_M))
    return {
        "jerky": (above > 1).mean(axis=(1, 2)),
        "jerk": np.log(above.max(axis=(1, 2))),
        "velocity_jump": np.linalg.norm(change, axis=-1).max(axis=(1, 2)),
        "contact_speed": (speed * contact).sum(axis=(1, 2)) / np.maximum(contact.sum((1, 2)), 1),
        "skate_cm": 100 * np.where(height < SKATE_M, slide, 0.0).mean(axis=(1, 2)),
        "sink": np.maximum(tracks.floors[:, None] - feet[..., 1], 0.0).max(axis=(1, 2)),
        "depth": np.concatenate(list(_depths(graph, tracks, capture))),
    }


def capture_of(graph: MotionGraph) -> Capture:
    """The capture's own extremes, over all clips."""
    spans = list(zip(graph.clip_starts, graph.clip_stops, strict=True))
    jerk = [
        normalised_jerk(graph.positions[None, a:b], graph.frame_rate)[0]
        for a, b in spans
        if b - a > round(WINDOW_S * graph.frame_rate) + 1
    ]
    pairs = subject_of(graph.skeleton)[0].pairs
    stop = int(graph.clip_stops.max())
    apart = [
        np.asarray(pair_distances(pairs, graph.positions[i : min(i + 1024, stop)])).min(axis=0)
        for i in range(0, stop, 1024)
    ]
    return Capture(
        jerk=np.quantile(np.concatenate(jerk), 0.999, axis=0), apart=np.min(apart, axis=0)
    )


def normalised_jerk(places: Float[np.ndarray, "M F J 3"], rate: float) -> np.ndarray:
    """[M, F', J] T⁵ ∫ |jerk|² dt / path² of all windows of 0.4 s."""
    length = round(WINDOW_S * rate)
    x = places.astype(np.float64)
    jerk = (np.diff(x, n=3, axis=1) ** 2).sum(axis=-1) * rate**5
    path = np.linalg.norm(np.diff(x, axis=1), axis=-1)
    totals = [
        np.concatenate([np.zeros_like(y[:, :1]), np.cumsum(y, axis=1)], axis=1)
        for y in (jerk, path)
    ]
    at = np.arange(x.shape[1] - length)
    # A window has two differences of the third order less than steps.
    squares = (totals[0][:, at + length - 2] - totals[0][:, at]) * length / (length - 2)
    travelled = np.maximum(totals[1][:, at + length] - totals[1][:, at], 1e-4)
    return (length / rate) ** 5 * squares / travelled**2


def auc(uncut: np.ndarray, seams: np.ndarray) -> float:
    """How well a measure tells seams from uncut motion: 0.5 not at all, 1 always."""
    ranks = rankdata(np.concatenate([uncut, seams]))[len(uncut) :].sum()
    area = (ranks - len(seams) * (len(seams) + 1) / 2) / (len(uncut) * len(seams))
    return float(max(area, 1 - area))


def _depths(graph: MotionGraph, tracks: Tracks, capture: Capture) -> Iterator[np.ndarray]:
    pairs = subject_of(graph.skeleton)[0].pairs
    allowed = np.minimum(capture.apart, 0.0)
    inside = tracks.places[:, tracks.first : tracks.last + 1]
    for i in range(0, len(inside), CHUNK):
        part = inside[i : i + CHUNK]
        apart = np.asarray(pair_distances(pairs, part.reshape(-1, *part.shape[2:])))
        yield (allowed - apart).clip(0).max(axis=1).reshape(part.shape[:2]).max(axis=1)


def _ends(graph: MotionGraph, edges: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    nodes = graph.edge_source[edges], graph.edge_target[edges]
    return graph.node_frame[nodes[0]], graph.node_frame[nodes[1]]


def _turning(graph: MotionGraph) -> np.ndarray:
    ends = set(graph.skeleton.end_joints)
    return np.array([j for j in range(graph.skeleton.num_joints) if j not in ends])
