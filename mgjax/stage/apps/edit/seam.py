"""A transition, played with what goes before and after it, and what is to be seen at its seams."""

from __future__ import annotations

from dataclasses import dataclass

import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from mgjax.core import planar
from mgjax.core.errors import GraphError, SkeletonError
from mgjax.core.kinematics import forward
from mgjax.core.motion import Motion
from mgjax.graph.blending.forms import blend_form
from mgjax.graph.blending.mixing import Window, mix
from mgjax.graph.feet.legs import foot_chains
from mgjax.graph.plants import foot_slide, inherited_frames
from mgjax.graph.types import NO_CLIP, MotionGraph

AROUND_S = 0.7
"""How much of the two clips is played before and after."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Seam:
    """A transition between two clips.

    Attributes:
        motion: of the clip that is left, the transition, and the clip it arrives in.
        start, stop: seconds of it between which the transition lies.
        leaves, arrives: the clips, with the second of each.
        distance: of the two windows, m RMS.
        slide: metres that planted feet travel per frame of it: as blended, and as it is. The
            clean-up of feet lies between.
        jerk: largest of a joint, from frame to frame, m/s³: over the transition with its seams, and
            over the same stretches of the two clips.
    """

    motion: Motion
    start: float
    stop: float
    leaves: tuple[str, float]
    arrives: tuple[str, float]
    distance: float
    slide: tuple[float, float] | None
    jerk: tuple[float, float]


def seam_of(graph: MotionGraph, edge: int) -> Seam:
    """A transition of a graph; :class:`GraphError` where the edge is none."""
    if not 0 <= edge < graph.num_edges or graph.edge_clip[edge] != NO_CLIP:
        raise GraphError(got=f"edge {edge}", expected="a transition")
    leave = int(graph.node_frame[graph.edge_source[edge]])
    arrive = int(graph.node_frame[graph.edge_target[edge]])
    clips = [int(graph.node_clip[ends[edge]]) for ends in (graph.edge_source, graph.edge_target)]
    around = round(AROUND_S * graph.frame_rate)
    before = max(leave - around, int(graph.clip_starts[clips[0]]))
    after = min(arrive + around, int(graph.clip_stops[clips[1]]) - 1)
    first = int(graph.edge_starts[edge])
    parts = [
        _pick(graph, np.arange(before, leave)),
        _pick(graph, np.arange(first, first + graph.window)),
        _pick(graph, np.arange(arrive, after + 1), graph.edge_exit[edge]),
    ]
    motion = _motion(graph, *(np.concatenate(x) for x in zip(*parts, strict=True)))
    rate = graph.frame_rate
    at = (leave - before, leave - before + graph.window)
    return Seam(
        motion=motion,
        start=at[0] / rate,
        stop=at[1] / rate,
        leaves=(graph.clip_names[clips[0]], (leave - int(graph.clip_starts[clips[0]])) / rate),
        arrives=(graph.clip_names[clips[1]], (arrive - int(graph.clip_starts[clips[1]])) / rate),
        distance=float(graph.edge_distance[edge]),
        slide=_slides(graph, edge, leave, arrive),
        jerk=_jerks(graph, motion, at, leave, arrive),
    )


def _pick(
    graph: MotionGraph, frames: np.ndarray, place: np.ndarray | None = None
) -> tuple[np.ndarray, np.ndarray]:
    root, rotations = graph.root_translation[frames], graph.local_rotations[frames].copy()
    if place is not None:
        moved, turned = planar.apply_pose(place, root, rotations[:, 0])
        root, rotations[:, 0] = np.asarray(moved), np.asarray(turned)
    return root, rotations


def _motion(graph: MotionGraph, root: np.ndarray, rotations: np.ndarray) -> Motion:
    return Motion(
        root_translation=np.asarray(root, np.float32),
        local_rotations=np.asarray(rotations, np.float32),
        frame_rate=graph.frame_rate,
    )


def _slides(graph: MotionGraph, edge: int, leave: int, arrive: int) -> tuple[float, float] | None:
    """Slide of planted feet from the frame before a blend to that of arrival; None without legs."""
    begin = arrive - graph.window
    step = np.arange(-1, graph.window + 1)
    try:
        frames = inherited_frames(np.asarray(leave), np.asarray(begin), step, graph.window)
        plants = graph.plants[frames]
    except ValueError:  # no feet
        return None
    before = _pick(graph, np.arange(leave - 1, leave))
    first = int(graph.edge_starts[edge])
    cleaned = _pick(graph, np.arange(first, first + graph.window + 1))
    turn = graph.edge_exit[edge]
    blended = _blended(graph, leave, begin, turn)
    slides = []
    for root, rotations in (blended, cleaned):
        whole = _motion(
            graph, np.concatenate([before[0], root]), np.concatenate([before[1], rotations])
        )
        slides.append(foot_slide(graph.skeleton, whole, plants)[0])
    return slides[0], slides[1]


def _blended(
    graph: MotionGraph, leave: int, begin: int, turn: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Root and rotations of a transition before its feet were cleaned."""
    form = blend_form(graph.report.get("blend", "paper"), graph.window)
    step = np.arange(graph.window + 1)
    # The frame after the first window does not count, so any will do after the last clip.
    frames = np.minimum(leave + step, len(graph.root_translation) - 1), begin + step
    parts = [(*_pick(graph, x), graph.positions[x]) for x in frames]
    first, second = (Window(*(jnp.asarray(y) for y in part)) for part in parts)
    try:
        legs = foot_chains(graph.skeleton) if form.support else None
    except SkeletonError:  # nor had the builder any
        legs = None
    root, rotations = mix(
        graph.skeleton,
        legs,
        first,
        second,
        jnp.asarray((graph.plants[frames[0]] & graph.plants[frames[1]])[:-1]),
        jnp.asarray(turn),
        jnp.asarray(form.decay),
        continuous=form.continuous,
    )
    return np.asarray(root), np.asarray(rotations)


def _jerks(
    graph: MotionGraph, motion: Motion, at: tuple[int, int], leave: int, arrive: int
) -> tuple[float, float]:
    """Peaks over a transition and two frames on both sides, and of the clips over the same."""

    root, rotations = np.asarray(motion.root_translation), np.asarray(motion.local_rotations)
    here = np.asarray(forward(graph.skeleton, root, rotations)[0])
    own = []
    for frame in (leave, arrive - graph.window):
        clip = int(np.searchsorted(graph.clip_starts, frame, side="right")) - 1
        start = max(frame - 2, int(graph.clip_starts[clip]))
        stop = min(frame + graph.window + 3, int(graph.clip_stops[clip]))
        own.append(peak_jerk(graph.positions[start:stop], graph.frame_rate))
    around = here[max(at[0] - 2, 0) : at[1] + 3]
    return peak_jerk(around, graph.frame_rate), max(own)


def peak_jerk(places: Float[np.ndarray, "F J 3"], rate: float) -> float:
    """The largest jerk of a joint, by differences from frame to frame, m/s³; 0 below 4 frames."""
    jerk = np.diff(places.astype(np.float64), n=3, axis=0) * rate**3
    return float(np.linalg.norm(jerk, axis=-1).max()) if len(jerk) else 0.0
