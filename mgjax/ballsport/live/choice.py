"""A scene whose passes are decided by kicks in front of a motion sensor."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator

from mgjax.ballsport.clipset.repertoire import Repertoire
from mgjax.ballsport.config import AnalysisConfig, MatchConfig
from mgjax.ballsport.live.recogniser import LiveDriver, PassDecision
from mgjax.ballsport.scene.types import Asked
from mgjax.sensor.clock import Clock, clock
from mgjax.sensor.frames import FrameSource, SensorFrame


class SensorChoice:
    """Chooses the hit of each pass whose kind is "any": that which the next live kick resembles.

    Given to :func:`mgjax.ballsport.scene.build.build_scene` as ``choose``. A touch is asked for
    when the ball is about to be launched to it; then this waits for the next kick. A kick that the
    player cannot do there is left out. Once the time is over, or without a kick, the scene decides
    itself.

    Args:
        moves: of the scene; its hits are what live kicks are compared with.
        receiver: of the sensor.
        seconds: how long to listen in all.
        analysis: how kicks are found.
        match: how they are compared with the stored hits.
        clock: that of the receiver.

    Raises:
        ConfigError: a threshold or weight that cannot be.
    """

    def __init__(
        self,
        moves: Repertoire,
        receiver: FrameSource,
        seconds: float,
        *,
        analysis: AnalysisConfig | None = None,
        match: MatchConfig | None = None,
        clock: Clock = clock,
    ) -> None:
        bones = tuple(dict.fromkeys(moves.clips.hit_bone))
        self._driver = LiveDriver(
            moves.clips, bones=bones, analysis=analysis, match=match, clock=clock
        )
        self._frames: Iterator[SensorFrame] = receiver.frames(seconds)
        self._waiting: deque[PassDecision] = deque()
        self._over = False
        self.taken: list[tuple[int, PassDecision]] = []
        """Number of the touch, and the kick that decided it."""

    def __call__(self, asked: Asked) -> int | None:
        while True:
            while self._waiting:
                decision = self._waiting.popleft()
                if decision.hit in asked.hits:
                    self.taken.append((asked.touch, decision))
                    return decision.hit
            if self._over:
                return None
            self._listen()

    def _listen(self) -> None:
        """Hears until there is a kick or the time is over."""
        for frame in self._frames:
            self._waiting += self._driver.push(frame)
            if self._waiting:
                return
        self._over = True
        self._waiting += self._driver.finish()
