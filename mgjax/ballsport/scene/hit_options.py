"""Which stored hits a touch may be made with, and whether the user's motion decides among them."""

from __future__ import annotations

from mgjax.ballsport.clipset.repertoire import Repertoire
from mgjax.ballsport.scene.config import SceneConfig
from mgjax.ballsport.scene.types import Asked, Choose
from mgjax.core.errors import ConfigError


def possible_hits(config: SceneConfig, moves: Repertoire, number: int) -> list[int]:
    """Stored hits of the kind and bone that a pass asks for; the last touch is a toss.

    Raises:
        ConfigError: there is none.
    """
    last = number == len(config.passes)
    kind = "toss" if last else config.passes[number].kind
    bone = "any" if last else config.passes[number].bone
    clips = moves.clips
    hits = [
        hit
        for hit in moves.touch
        if kind in ("any", clips.hit_kind[hit]) and bone in ("any", clips.hit_bone[hit])
    ]
    if not hits:
        raise ConfigError(f"touch {number + 1}: got no stored {kind} by {bone}, expected one")
    return hits


def unasked_hits(config: SceneConfig, moves: Repertoire, number: int) -> list[int]:
    """Stored hits among which the scene itself chooses: attacks only where they are asked for."""
    hits = possible_hits(config, moves, number)
    if number < len(config.passes) and config.passes[number].kind == "any":
        kinds = moves.clips.hit_kind
        return [hit for hit in hits if kinds[hit] != "attack"] or hits
    return hits


def user_may_decide(config: SceneConfig, choose: Choose | None, number: int) -> bool:
    """Whether the user's motion may decide a touch: somebody is asked, and its kind is "any"."""
    passes = config.passes
    return choose is not None and number < len(passes) and passes[number].kind == "any"


def user_hit(
    config: SceneConfig,
    moves: Repertoire,
    choose: Choose | None,
    *,
    number: int,
    player: str,
    deadline_s: float,
) -> int | None:
    """The hit that the user's motion decides; None where the scene chooses itself.

    Raises:
        ConfigError: the answer is none of the hits that are possible.
    """
    if choose is None or not user_may_decide(config, choose, number):
        return None
    hits = possible_hits(config, moves, number)
    hit = choose(Asked(touch=number, player=player, deadline_s=deadline_s, hits=tuple(hits)))
    if hit is not None and hit not in hits:
        raise ConfigError(f"touch {number + 1}: got hit {hit}, expected one of {hits}")
    return hit
