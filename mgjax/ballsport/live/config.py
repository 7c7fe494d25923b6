"""How kicks before a motion sensor are recognised. Neither jax nor numpy is imported here."""

from __future__ import annotations

from dataclasses import dataclass, field

from mgjax.ballsport.config import (
    FEET,
    AnalysisConfig,
    ClipSetConfig,
    KindConfig,
    MatchConfig,
    validate_clip_set,
    validate_match,
)
from mgjax.core.ranges import Ranges, check_ranges


@dataclass(frozen=True, kw_only=True)
class ListenConfig:
    """The stored hits, and how live ones are found and compared with them.

    Attributes:
        frame_rate: at which motion is looked at, frames per second.
        bones: what can hit; the embedded kicks are those of feet.
        seed: of the embedded kicks.
        takes: embedded kicks of each kind and foot.
        analysis: how hits are found.
        kinds: what a hit without a kind counts as.
        match: weights of the comparison.
    """

    frame_rate: float = 60.0
    bones: tuple[str, ...] = FEET
    seed: int = 0
    takes: int = 2
    analysis: AnalysisConfig = field(default_factory=AnalysisConfig)
    kinds: KindConfig = field(default_factory=KindConfig)
    match: MatchConfig = field(default_factory=MatchConfig)

    @property
    def clip_set(self) -> ClipSetConfig:
        """What the stored hits are made of."""
        return ClipSetConfig(
            frame_rate=self.frame_rate, bones=self.bones, analysis=self.analysis, kinds=self.kinds
        )


_RANGES: Ranges = {"frame_rate": (20.0, 240.0), "seed": (0, 2**32 - 1), "takes": (1, 20)}


def validate_listen(config: ListenConfig) -> None:
    """Raises :class:`ConfigError` naming the first setting that cannot be."""
    check_ranges(config, _RANGES)
    validate_clip_set(config.clip_set)
    validate_match(config.match, "match.")
