"""The user's body beside the pitch: shown as it moves, its kicks recognised and matched."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

from mgjax.ballsport.clipset.repertoire import Repertoire
from mgjax.ballsport.live.recogniser import LiveDriver, PassDecision
from mgjax.core import planar
from mgjax.core.kinematics import planar_frames
from mgjax.core.motion import Motion, cut, sample
from mgjax.core.skeleton import Skeleton
from mgjax.sensor.frames import SensorFrame
from mgjax.stage.apps.match.source import Source
from mgjax.stage.show.body import body_of
from mgjax.stage.show.frames import frames_of
from mgjax.stage.show.types import Actor, Body, Frames

RATE = 30.0
_DELAY_S = 0.25
"""How much later than it comes a pose is shown, so that it is there in time."""
_OFF_S = 0.6
"""A stream that runs so far before or behind the match is shown anew from now on."""
_PIECE = 4
"""Frames that are sent at least."""
_AROUND_S = 0.4
"""What is shown of a stored clip before and after its hit, s."""


class UserBody:
    """Takes frames of a source and gives what is to be shown, and kicks.

    Args:
        source: of the frames.
        moves: the stored hits.
        spot: planar frame at which the body begins.
    """

    def __init__(self, source: Source, moves: Repertoire, spot: Float[np.ndarray, "3"]) -> None:
        self.source, self._spot = source, spot
        self.skeleton: Skeleton | None = None
        bones = tuple(dict.fromkeys(moves.clips.hit_bone))
        self._driver = LiveDriver(moves.clips, bones=bones)
        self._poses: list[tuple[float, np.ndarray, np.ndarray]] = []
        self._shift = 0.0
        self._sent = -np.inf

    @property
    def body(self) -> Body | None:
        """As the page draws it, once it is known."""
        return None if self.skeleton is None else body_of(self.skeleton)

    def hear(self, now_s: float) -> list[PassDecision]:
        """Takes what has come by a second of the match; returns the kicks in it."""
        decided: list[PassDecision] = []
        for frame in self.source.frames(now_s):
            decided += self._driver.push(frame)
            self._keep(frame, now_s)
        return decided

    def finish(self) -> list[PassDecision]:
        """The source is over: the kicks that were still open."""
        return self._driver.finish()

    def shown(self) -> Frames | None:
        """Poses that were not given before, at :data:`RATE`; None where they are too few."""
        if len(self._poses) < 2:
            return None
        times, places, turns = zip(*self._poses, strict=True)
        first = max(self._sent + 1 / RATE, times[0])
        count = int((times[-1] - first) * RATE + 1e-6) + 1
        if count < _PIECE:
            return None
        grid = first + np.arange(count) / RATE
        where = np.interp(grid, times, np.arange(len(times)))
        motion = Motion(
            root_translation=np.array(places, np.float32),
            local_rotations=np.array(turns, np.float32),
            frame_rate=RATE,
        )
        self._sent = float(grid[-1])
        self._poses = self._poses[-2:]
        return frames_of(sample(motion, where), start=first, rate=RATE, delta=False)

    def _keep(self, frame: SensorFrame, now_s: float) -> None:
        """Remembers a pose, turned to where the body is to stand, with its second of the match."""
        at = frame.time_s + self._shift
        new = self.skeleton is None or frame.body is not self.skeleton
        if new or not now_s - _OFF_S < at < now_s + _DELAY_S + _OFF_S:
            self._shift = now_s + _DELAY_S - frame.time_s
            at = now_s + _DELAY_S
            self._poses = []
            self._sent = -np.inf
        if new:
            self.skeleton = frame.body
            here = np.asarray(planar_frames(frame.body, frame.positions[None]), np.float64)[0]
            self._moved = np.asarray(planar.compose(self._spot, planar.inverse(here)))
        if self._poses and at <= self._poses[-1][0]:
            return
        place, turn = planar.apply_pose(self._moved, frame.positions[0], frame.rotations[0])
        turns = np.asarray(frame.rotations).copy()
        turns[0] = np.asarray(turn)
        self._poses.append((at, np.asarray(place), turns))


def matched_actor(
    moves: Repertoire, hit: int, spot: Float[np.ndarray, "3"], start_s: float
) -> Actor:
    """A stored hit, played at a place from a second on."""
    clips, rate = moves.clips, moves.frame_rate
    around = round(_AROUND_S * rate)
    clip = int(clips.hit_clip[hit])
    begin = int(clips.hit_starts[hit])
    first = max(begin - around, int(clips.clip_starts[clip]))
    stop = min(int(clips.hit_stops[hit]) + around, int(clips.clip_stops[clip]))
    moved = np.asarray(planar.compose(spot, planar.inverse(np.asarray(clips.planes[begin]))))
    part = cut(clips.motion, first, stop)
    root, turn = planar.apply_pose(moved, part.root_translation, part.local_rotations[:, 0])
    turns = np.asarray(part.local_rotations).copy()
    turns[:, 0] = np.asarray(turn)
    motion = Motion(
        root_translation=np.asarray(root, np.float32),
        local_rotations=turns.astype(np.float32),
        frame_rate=rate,
    )
    return Actor(
        id="matched",
        body=0,
        frames=frames_of(motion, start=start_s, rate=rate, delta=False),
        colour="orange",
        note=f"kick {hit}: {clips.hit_kind[hit]}",
    )


def kick_words(kick: PassDecision) -> str:
    """A kick that was seen, in words."""
    return (
        f"{kick.bone.replace('_', ' ')}, {kick.kind}, {kick.speed_m_s:.1f} m/s;"
        f" matched kick {kick.hit} at distance {kick.distance:.2f}"
    )
