"""A scene as settings: who stands where, and who passes to whom. Neither jax nor numpy here."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from itertools import combinations

from mgjax.ballsport.ball.physics import BallPhysics, Net
from mgjax.ballsport.config import (
    FEET,
    HIT_BONES,
    KINDS,
    MAX_SPEED_M_S,
    MOST_BOUNCES,
    AnalysisConfig,
    ClipSetConfig,
    KindConfig,
    MatchConfig,
    TransitionConfig,
    validate_clip_set,
    validate_match,
)
from mgjax.core.errors import ConfigError
from mgjax.core.ranges import Ranges, check_range, check_ranges

CLOSEST_M = 1.0
"""Least distance of two players: less than that and a leg swings through the other body."""


@dataclass(frozen=True, kw_only=True)
class Player:
    """Who, and where on the floor.

    Attributes:
        name: also that of the written file.
        x, z: m.
    """

    name: str
    x: float
    z: float


@dataclass(frozen=True, kw_only=True)
class Pass:
    """One pass.

    Attributes:
        by, to: names of players.
        kind: of the hit it is made with: toss, pass or attack; "any": the user's motion decides,
            or where there is none the stored toss or pass that needs the least change of the
            ball's speed; attacks are for those who ask for them.
        bone: what hits, such as ``"left_foot"``; "any": what suits best.
        bounces: between the two hits.
    """

    by: str
    to: str
    kind: str = "any"
    bone: str = "any"
    bounces: int = 1


@dataclass(frozen=True, kw_only=True)
class SceneConfig:
    """Everything a scene is made of.

    Attributes:
        players: on the floor, in any order.
        passes: each begins where the one before ended.
        physics: of the ball.
        net: across the court; passes go over it.
        throw_in: where the ball comes from at the beginning, and after a pass that could not be, m;
            None: over the middle between the players.
        max_speed: largest kick speed, m/s.
        frame_rate: of all motion, frames per second.
        seed: of the embedded clips.
        takes: embedded kicks of each kind and foot.
        clips: folder with captured kicks; "": the embedded ones alone.
        exclude: glob patterns of captured clips to leave out.
        end_s: motion after the last hit, s.
        bones: what can hit; the embedded kicks are those of feet.
        analysis: how hits are found, in the clips and before the sensor.
        kinds: what a captured hit counts as.
        transition: how link motions are joined.
        match: how a kick before the sensor is compared with the stored hits.
    """

    players: tuple[Player, ...] = ()
    passes: tuple[Pass, ...] = ()
    physics: BallPhysics = field(default_factory=BallPhysics)
    net: Net | None = None
    throw_in: tuple[float, float, float] | None = None
    max_speed: float = MAX_SPEED_M_S
    frame_rate: float = 60.0
    seed: int = 0
    takes: int = 3
    clips: str = ""
    exclude: tuple[str, ...] = ()
    end_s: float = 2.0
    bones: tuple[str, ...] = FEET
    analysis: AnalysisConfig = field(default_factory=AnalysisConfig)
    kinds: KindConfig = field(default_factory=KindConfig)
    transition: TransitionConfig = field(default_factory=TransitionConfig)
    match: MatchConfig = field(default_factory=MatchConfig)

    @property
    def clip_set(self) -> ClipSetConfig:
        """What its clip set is made of."""
        return ClipSetConfig(
            frame_rate=self.frame_rate,
            bones=self.bones,
            analysis=self.analysis,
            kinds=self.kinds,
            transition=self.transition,
        )


_RANGES: Ranges = {
    "max_speed": (1e-3, 100.0),
    "frame_rate": (20.0, 240.0),
    "takes": (1, 20),
    "end_s": (0.0, 60.0),
    "seed": (0, 2**32 - 1),
}
_PLACE_M = (-1000.0, 1000.0)


def validate_scene(config: SceneConfig) -> None:
    """Raises :class:`ConfigError` unless the scene can be begun."""
    if len(config.players) < 2 or not config.passes:
        raise ConfigError(
            f"got {len(config.players)} players and {len(config.passes)} passes,"
            " expected at least two players and one pass"
        )
    names = [player.name for player in config.players]
    for name in names:
        if not name or not name.replace("-", "").replace("_", "").isalnum():
            raise ConfigError(f"got the player {name!r}, expected a name of letters and digits")
        if names.count(name) > 1:
            raise ConfigError(f"got two players called {name!r}, expected different names")
    for player in config.players:
        check_ranges(player, {"x": _PLACE_M, "z": _PLACE_M}, f"{player.name}.")
    for a, b in combinations(config.players, 2):
        distance = math.hypot(a.x - b.x, a.z - b.z)
        if distance < CLOSEST_M:
            raise ConfigError(
                f"got {a.name} and {b.name} {distance:.2f} m apart,"
                f" expected at least {CLOSEST_M:g} m"
            )
    before = None
    for number, item in enumerate(config.passes, 1):
        _validate_pass(item, number, names, before)
        before = item
    _validate_numbers(config)


def _validate_pass(item: Pass, number: int, names: list[str], before: Pass | None) -> None:
    place = f"pass {number}"
    for name in (item.by, item.to):
        if name not in names:
            raise ConfigError(f"{place}: got {name!r}, expected a player: {', '.join(names)}")
    if item.by == item.to:
        raise ConfigError(f"{place}: got a pass from {item.by!r} to itself, expected two players")
    if before is not None and item.by != before.to:
        raise ConfigError(
            f"{place}: got a pass by {item.by!r}, expected one by {before.to!r}, who has the ball"
        )
    if item.kind not in (*KINDS, "any"):
        raise ConfigError(f"{place}: got {item.kind!r}, expected {', '.join(KINDS)} or any")
    if item.bone not in (*HIT_BONES, "any"):
        raise ConfigError(f"{place}: got {item.bone!r}, expected {', '.join(HIT_BONES)} or any")
    if not 0 <= item.bounces <= MOST_BOUNCES:
        raise ConfigError(f"{place}: got {item.bounces} bounces, expected 0 … {MOST_BOUNCES}")


def _validate_numbers(config: SceneConfig) -> None:
    check_ranges(config, _RANGES)
    validate_clip_set(config.clip_set)
    validate_match(config.match, "match.")
    if config.throw_in is not None:
        low = float(config.physics.radius)  # else the ball lies in the ground
        for name, value in zip("xyz", config.throw_in, strict=True):
            bounds = (low, _PLACE_M[1]) if name == "y" else _PLACE_M
            check_range(f"throw_in, {name}", value, *bounds)
