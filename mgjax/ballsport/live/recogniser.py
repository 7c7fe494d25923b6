"""A scene driven live: each kick of a received body decides the next pass."""

from __future__ import annotations

from bisect import bisect_left
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mgjax.ballsport.clipset.build import ClipSet
from mgjax.ballsport.clipset.match import Matcher
from mgjax.ballsport.config import FEET, AnalysisConfig, MatchConfig
from mgjax.ballsport.hits.bones import BoneHit, LiveAnalysis
from mgjax.ballsport.hits.motion_vectors import MotionVectors, leg_length
from mgjax.core.errors import ConfigError
from mgjax.sensor.clock import Clock, clock
from mgjax.sensor.frames import SensorFrame

_REMEMBERED = 4096
"""Frames whose arrival is known; a hit is over and decided long before."""

BRIDGE_S = 0.1
"""A bone that is missing for longer is taken to be where it was held."""
_NEAR_S = 1e-4
"""Stamps are rounded to four bytes; a frame this little before an even step is taken for it."""


@dataclass(frozen=True, kw_only=True)
class PassDecision:
    """A kick that was seen, and the stored hit that a player does for it.

    Attributes:
        bone: what hit, such as ``"right_foot"``.
        kind: toss, pass or attack, that of the stored hit.
        hit: number of the stored hit in the clip set.
        distance: D_m to it.
        speed_m_s: the largest of the live bone.
        start_s: first frame of the live S_H, by the sender's clock.
        fastest_s: F_S, likewise.
        end_s: last frame of S_H, likewise.
        decided_s: the newest frame when it was decided, likewise.
        latency_s: from the arrival of the last frame of S_H to the decision, by the clock of this
            machine.
        latency_from_fastest_s: from the arrival of F_S, likewise.
        compute_s: part of both that was spent on finding and comparing, after the arrival of the
            frame that made the kick certain.
    """

    bone: str
    kind: str
    hit: int
    distance: float
    speed_m_s: float
    start_s: float
    fastest_s: float
    end_s: float
    decided_s: float
    latency_s: float
    latency_from_fastest_s: float
    compute_s: float


class LiveDriver:
    """Finds kicks in received frames and the stored hits they resemble.

    Frames come at irregular times. Positions in between, at the even steps that the analysis
    needs, are found linearly, so a lost frame is bridged. So are frames with bones that were held,
    but for at most ``BRIDGE_S``: a held foot of a kick is decimetres off. Where the sender starts
    anew, what was open is finished, and the analysis begins again.

    Args:
        clips: the stored hits; their frame rate is that of the analysis.
        bones: what can hit; all of them have to be in the clip set.
        analysis: thresholds.
        match: weights of the comparison.
        clock: the one that stamps arrivals.

    Raises:
        ConfigError: a bone that no stored hit hits with, or a threshold that cannot be.
    """

    def __init__(
        self,
        clips: ClipSet,
        *,
        bones: Sequence[str] = FEET,
        analysis: AnalysisConfig | None = None,
        match: MatchConfig | None = None,
        clock: Clock = clock,
    ) -> None:
        self._clock = clock
        self._clips, self._bones, self._config = clips, tuple(bones), analysis
        self._rate = clips.motion.frame_rate
        self._matcher = Matcher(clips, match)
        missing = [bone for bone in bones if bone not in self._matcher.bones]
        if missing:
            raise ConfigError(
                f"got no stored hit of {missing[0]}, expected hits of {', '.join(bones)}"
            )
        for bone in self._bones:  # compiles now what must not be waited for at the first kick
            first = clips.hit_bone.index(bone)
            one = MotionVectors(
                displacements=np.asarray(clips.vectors.displacements)[first],
                seconds=np.asarray(clips.vectors.seconds)[first],
                v_max=np.asarray(np.asarray(clips.vectors.v_max)[first]),
            )
            self._matcher.match(one, bone, clips.leg_length)
        self._analysis: LiveAnalysis | None = None
        self._stream = -1

    def push(self, frame: SensorFrame) -> list[PassDecision]:
        """Takes a received frame; returns what was decided by it, mostly nothing."""
        decided: list[PassDecision] = []
        if frame.stream != self._stream:
            decided = self.finish()
            self._begin(frame)
        assert self._analysis is not None
        self._arrivals.append((frame.time_s, frame.arrival_s))
        before, now = self._newest, frame
        if frame.held and frame.time_s - before.time_s < BRIDGE_S:
            return decided
        self._newest = frame
        while (at := self._origin + self._analysis.num_frames / self._rate) <= now.time_s + _NEAR_S:
            part = 1.0
            if now.time_s > before.time_s:
                part = (at - before.time_s) / (now.time_s - before.time_s)
            places = before.positions + part * (now.positions - before.positions)
            hits = self._analysis.push(places)
            decided += [self._decide(hit, frame.arrival_s) for hit in hits]
        return decided

    def finish(self) -> list[PassDecision]:
        """The stream is over: what the kicks decide that were still open."""
        if self._analysis is None:
            return []
        hits, now = self._analysis.finish(), self._clock()
        decided = [self._decide(hit, now) for hit in hits]
        self._analysis = None
        self._stream = -1
        return decided

    def _begin(self, frame: SensorFrame) -> None:
        self._stream = frame.stream
        self._analysis = LiveAnalysis(
            frame.body, self._rate, bones=self._bones, config=self._config
        )
        self._legs = leg_length(frame.body)
        self._origin = frame.time_s
        self._newest = frame
        self._arrivals: deque[tuple[float, float]] = deque(maxlen=_REMEMBERED)

    def _decide(self, kick: BoneHit, arrival_s: float) -> PassDecision:
        match = self._matcher.match(kick.vector, kick.bone, self._legs)
        now = self._clock()
        start, fastest, end = (
            self._origin + frame / self._rate
            for frame in (kick.hit.start, kick.hit.fastest, kick.hit.stop - 1)
        )
        return PassDecision(
            bone=kick.bone,
            kind=self._clips.hit_kind[match.hit],
            hit=match.hit,
            distance=match.distance,
            speed_m_s=float(kick.vector.v_max),
            start_s=start,
            fastest_s=fastest,
            end_s=end,
            decided_s=self._newest.time_s,
            latency_s=now - self._arrival(end),
            latency_from_fastest_s=now - self._arrival(fastest),
            compute_s=now - arrival_s,
        )

    def _arrival(self, time_s: float) -> float:
        """When the first frame at or after a time of the sender arrived."""
        times = [time for time, _ in self._arrivals]
        return self._arrivals[min(bisect_left(times, time_s - 1e-6), len(times) - 1)][1]
