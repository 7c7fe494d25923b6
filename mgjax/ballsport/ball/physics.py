"""The ball's physics and the court's net, as settings. Neither jax nor numpy is imported here."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

from mgjax.core.errors import ConfigError
from mgjax.core.ranges import Ranges, check_ranges

if TYPE_CHECKING:
    Number: TypeAlias = Any  # checkers follow what is computed with it without it
else:
    from mgjax.core.traced import Number

_PHYSICS: Ranges = {
    "gravity": (1e-3, 1e3),
    "drag": (0.0, 100.0),
    "restitution": (0.0, 1.0),
    "radius": (0.0, 10.0),
}
_NET: Ranges = {
    "x": (-1e6, 1e6),
    "z": (-1e6, 1e6),
    "heading": (-1e6, 1e6),
    "height": (0.0, 100.0),
}


@dataclass(frozen=True, kw_only=True)
class BallPhysics:
    """How a ball flies and bounces (Choi et al. 2019, §4, eqs 3–5; the values are the paper's).

    The ground is the plane y = 0; the ball touches it when its centre is one radius above. A bounce
    reverses the vertical velocity times ``restitution``; there is no spin and no loss along the
    ground. The numbers are traced, ``drag_law`` is static.

    Deviation:
        The paper gives an air resistance of 0.2 without its law. The default reads it as linear,
        a = −drag · v; quadratic is a = −drag · |v| v.

    Attributes:
        gravity: m/s², > 0.
        drag: air resistance, ≥ 0: 1/s where it is linear, 1/m where it is quadratic (a football
            has about 0.013 1/m).
        restitution: speed after a bounce over speed before it, 0 … 1.
        radius: of the ball, m, ≥ 0.
        drag_law: ``"linear"`` (flown in closed form) or ``"quadratic"`` (integrated).

    Raises:
        ConfigError: a number out of range, an unknown law. Numbers in jax arrays are not looked at.
    """

    gravity: Number = 9.8
    drag: Number = 0.2
    restitution: Number = 0.7
    radius: Number = 0.11
    drag_law: Literal["linear", "quadratic"] = "linear"

    def __post_init__(self) -> None:
        check_ranges(self, _PHYSICS)
        if self.drag_law not in ("linear", "quadratic"):
            raise ConfigError(f"got drag_law = {self.drag_law!r}, expected linear or quadratic")


@dataclass(frozen=True, kw_only=True)
class Net:
    """A net across the court: an upright plane that a ball crosses only above ``height``.

    Attributes:
        x, z: a point of the net on the floor, m.
        heading: direction across the net, rad: the net's normal is (sin, 0, cos) of it, so that 0
            means a net along X that is crossed along Z.
        height: of its upper edge, m, ≥ 0.

    Raises:
        ConfigError: a number out of range.
    """

    x: Number = 0.0
    z: Number = 0.0
    heading: Number = 0.0
    height: Number = 1.0

    def __post_init__(self) -> None:
        check_ranges(self, _NET)
