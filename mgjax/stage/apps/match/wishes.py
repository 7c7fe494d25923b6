"""What the user wants: who gets the ball next, by which kind of kick, with how many bounces."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from mgjax.ballsport.config import KINDS
from mgjax.ballsport.scene.config import Pass
from mgjax.core.errors import ConfigError

ANY = "any"
BOUNCES = (ANY, "0", "1", "2")
MOST_PICKED = 8
"""Players that can be clicked ahead."""
_BACK = 0.35
"""How likely a ball goes back to where it came from, beside to somebody else."""
_OFTEN = {"0": 0.2, "1": 0.6, "2": 0.2}
"""How often 0, 1 and 2 bounces are taken where nobody said."""


@dataclass(kw_only=True)
class Wishes:
    """Who was clicked, and how passes are to be made until something else is said.

    Attributes:
        players: by name.
        kind: toss, pass, attack or any.
        bounces: "0", "1", "2" or any.
        on: the game goes on by itself where nobody was clicked.
        picked: who gets the ball next, and then.
        kicked: the user's body has kicked, so that a pass has to be.
        before: who passed last.
        ready: numbers of bounces among which the game itself chooses; asked each time.
    """

    players: Sequence[str]
    rng: np.random.Generator
    kind: str = ANY
    bounces: str = ANY
    on: bool = True
    picked: list[str] = field(default_factory=list)
    kicked: bool = False
    before: str = ""
    ready: Callable[[], Sequence[str]] = lambda: BOUNCES[1:]

    def pick(self, name: str, holder: str) -> None:
        """Somebody was clicked.

        Args:
            name: of the player.
            holder: who passes next, as far as that is known.

        Raises:
            ConfigError: no such player, one who has the ball then, or too many of them.
        """
        if name not in self.players:
            raise ConfigError(got=f"the player {name!r}", expected=", ".join(self.players))
        if name == (self.picked[-1] if self.picked else holder):
            raise ConfigError(got=f"{name}, who has the ball then", expected="another player")
        if len(self.picked) == MOST_PICKED:
            raise ConfigError(
                got=f"{MOST_PICKED + 1} passes ahead", expected=f"up to {MOST_PICKED}"
            )
        self.picked.append(name)

    def next_pass(self, by: str) -> Pass | None:
        """The next pass of a player; None where the game waits for a click."""
        if not (self.picked or self.on or self.kicked):
            return None
        to = self.picked.pop(0) if self.picked else self._somebody(by)
        kind = ANY if self.kicked else self.kind
        self.kicked, self.before = False, by
        return Pass(by=by, to=to, kind=kind, bounces=self._bounces())

    def _somebody(self, by: str) -> str:
        others = [name for name in self.players if name != by]
        share = np.array([_BACK if name == self.before else 1.0 for name in others])
        return str(self.rng.choice(others, p=share / share.sum()))

    def _bounces(self) -> int:
        if self.bounces != ANY:
            return int(self.bounces)
        known = list(self.ready()) or ["1"]
        often = np.array([_OFTEN[bounces] for bounces in known])
        return int(self.rng.choice(known, p=often / often.sum()))


KINDS_OR_ANY = (ANY, *KINDS)
