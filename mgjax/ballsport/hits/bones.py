"""All hits of a moving body, bone by bone: from a whole motion, or live, frame by frame."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from mgjax.ballsport.config import FEET, AnalysisConfig, analysis_for_body, validate_analysis
from mgjax.ballsport.hits.detect import Hit, hit_joint, mark, sections
from mgjax.ballsport.hits.motion_vectors import MotionVectors, motion_vector
from mgjax.ballsport.hits.smoothing import half_width
from mgjax.ballsport.hits.stream import HitStream
from mgjax.core.body.height import body_scale
from mgjax.core.body.roles import require_roles
from mgjax.core.errors import MotionError
from mgjax.core.kinematics import planar_frames
from mgjax.core.skeleton import Skeleton


@dataclass(frozen=True, kw_only=True)
class BoneHit:
    """A hit and what is known about it.

    Attributes:
        bone: what hits, such as ``"right_foot"``.
        hit: its frames.
        vector: its motion vector.
    """

    bone: str
    hit: Hit
    vector: MotionVectors


def analyse(
    skeleton: Skeleton,
    positions: Float[np.ndarray, "F J 3"],
    frame_rate: float,
    *,
    bones: Sequence[str] = FEET,
    config: AnalysisConfig | None = None,
) -> list[BoneHit]:
    """Finds the hits of all bones in a whole motion, in order of their beginnings; maybe none.

    Args:
        skeleton: of the motion.
        positions: of all joints, Y up over the floor, m.
        frame_rate: frames per second.
        bones: what can hit; see :func:`mgjax.ballsport.hits.detect.hit_joint`.
        config: thresholds of an adult.
    """
    config = config or AnalysisConfig()
    validate_analysis(config)
    config = analysis_for_body(config, body_scale(skeleton))
    planes = np.asarray(planar_frames(skeleton, positions))
    hits: list[BoneHit] = []
    for bone in bones:
        path = np.asarray(positions[:, hit_joint(skeleton, bone)], np.float64)
        for hit in sections(mark(path, frame_rate, config), frame_rate, config):
            heading = float(planes[hit.start, 0])
            vector = motion_vector(hit, path, heading, frame_rate, config)
            hits.append(BoneHit(bone=bone, hit=hit, vector=vector))
    return sorted(hits, key=lambda x: x.hit.start)


class LiveAnalysis:
    """Finds the hits of all bones live, each as soon as it is certain.

    In the end they are those of :func:`analyse`; see :class:`HitStream` for the delay.

    Args:
        skeleton: of the body.
        frame_rate: frames per second.
        bones: what can hit.
        config: thresholds of an adult.
    """

    def __init__(
        self,
        skeleton: Skeleton,
        frame_rate: float,
        *,
        bones: Sequence[str] = FEET,
        config: AnalysisConfig | None = None,
    ) -> None:
        self._skeleton, self._rate = skeleton, frame_rate
        config = config or AnalysisConfig()
        validate_analysis(config)
        self._config = analysis_for_body(config, body_scale(skeleton))
        self._streams = {bone: HitStream(frame_rate, self._config) for bone in bones}
        self._joints = {bone: hit_joint(skeleton, bone) for bone in bones}
        self._hips = [0, *require_roles(skeleton, ("left_hip", "right_hip"))]
        self._kept = list(dict.fromkeys([*self._hips, *self._joints.values()]))
        self._frames: deque[np.ndarray] = deque(
            maxlen=max(stream.kept_frames for stream in self._streams.values())
        )
        self._received = 0

    @property
    def num_frames(self) -> int:
        """Frames received so far."""
        return self._received

    def push(self, positions: Float[np.ndarray, "J 3"]) -> list[BoneHit]:
        """Takes the joint positions of the next frame, m; returns the hits that are certain now.

        Raises:
            MotionError: a hip or a hit bone has no finite place; the frame is not taken.
        """
        frame = np.asarray(positions[self._kept], np.float64)
        if not np.isfinite(frame).all():
            raise MotionError("got a body without finite places, expected finite numbers")
        self._frames.append(frame)
        self._received += 1
        return self._collect(
            {
                bone: stream.push(frame[self._kept.index(self._joints[bone])])
                for bone, stream in self._streams.items()
            }
        )

    def finish(self) -> list[BoneHit]:
        """The stream is over: the hits that were still open."""
        return self._collect({bone: stream.finish() for bone, stream in self._streams.items()})

    def _collect(self, new_hits: dict[str, list[Hit]]) -> list[BoneHit]:
        hits = [
            BoneHit(bone=bone, hit=hit, vector=self._vector(bone, hit))
            for bone, new in new_hits.items()
            for hit in new
        ]
        return sorted(hits, key=lambda x: x.hit.start)

    def _vector(self, bone: str, hit: Hit) -> MotionVectors:
        """From the frames of the hit and so many around it as smoothing and speed look at."""
        first = self._received - len(self._frames)
        around = half_width(self._rate, self._config.smoothing_s) + 1
        begin = max(hit.start - around, first)
        stop = min(hit.stop + around, self._received)
        part = np.array([self._frames[f - first] for f in range(begin, stop)])
        body = np.zeros((1, self._skeleton.num_joints, 3), np.float32)
        body[0, self._kept] = part[hit.start - begin]
        heading = float(np.asarray(planar_frames(self._skeleton, body))[0, 0])
        path = part[:, self._kept.index(self._joints[bone])]
        return motion_vector(hit.shifted(-begin), path, heading, self._rate, self._config)
