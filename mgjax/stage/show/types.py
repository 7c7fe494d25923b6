"""A show: bodies that move, balls that fly, lines and things, with the words that go with them.

Everything is in the world: metres, Y up, seconds from the show's beginning. :func:`show_value`
makes a show the plain value that :mod:`mgjax.stage.packet` packs and the page draws.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, fields, is_dataclass
from typing import Any, Literal

import numpy as np
from jaxtyping import Float, Integer

Colour = Literal["blue", "orange", "green", "purple", "red", "yellow", "sky", "grey"]
"""Names of the page's palette, which stays apart for the colour-blind, light and dark."""


@dataclass(frozen=True, kw_only=True, eq=False)
class BodyMesh:
    """A closed surface around a skeleton in its rest pose, root at the origin.

    Attributes:
        places: vertices, as numbers of ``unit`` metres. [V,3]
        unit: m.
        normals: unit vectors times 127. [V,3]
        joints: up to four joints that each vertex moves with. [V,4]
        weights: their shares times 255; they add up to 255. [V,4]
        triangles: counter-clockwise from outside. [T,3]
    """

    places: Integer[np.ndarray, "V 3"]
    unit: float
    normals: Integer[np.ndarray, "V 3"]
    joints: Integer[np.ndarray, "V 4"]
    weights: Integer[np.ndarray, "V 4"]
    triangles: Integer[np.ndarray, "T 3"]


@dataclass(frozen=True, kw_only=True, eq=False)
class Body:
    """A skeleton with its surface; the actors of a show share bodies."""

    parents: Integer[np.ndarray, " J"]
    offsets: Float[np.ndarray, "J 3"]
    names: Sequence[str]
    mesh: BodyMesh


@dataclass(frozen=True, kw_only=True, eq=False)
class Frames:
    """Poses at a fixed rate.

    Attributes:
        rate: frames a second.
        start: second of the show at which the first is shown.
        rotations: local rotations, wxyz, times 32767; with ``delta`` each frame from the second on
            is the difference to the one before it, modulo 2¹⁶. [F,J,4]
        root: place of the root, m. [F,3]
        delta: see ``rotations``.
    """

    rate: float
    start: float
    rotations: Integer[np.ndarray, "F J 4"]
    root: Float[np.ndarray, "F 3"]
    delta: bool = False


@dataclass(frozen=True, kw_only=True, eq=False)
class Actor:
    """A body that moves, and stands still before its first frame and after its last.

    A ``ghost`` is drawn see-through, and only while its frames last. ``note`` stands over the head.
    """

    id: str
    body: int
    frames: Frames
    colour: Colour = "blue"
    look: Literal["solid", "ghost"] = "solid"
    note: str = ""


@dataclass(frozen=True, kw_only=True, eq=False)
class Ball:
    """A ball that is there from its first to its last moment, straight in between. [K], [K,3]"""

    id: str
    radius: float
    times: Float[np.ndarray, " K"]
    places: Float[np.ndarray, "K 3"]
    colour: Colour = "orange"
    trail: bool = True


@dataclass(frozen=True, kw_only=True, eq=False)
class Line:
    """A line through points, drawn with a width in pixels; at 0 m it lies on the floor. [N,3]"""

    id: str
    points: Float[np.ndarray, "N 3"]
    colour: Colour = "grey"
    width: float = 3.0
    dashed: bool = False


@dataclass(frozen=True, kw_only=True, eq=False)
class Thing:
    """A ball, bar or post that stands in the world.

    Attributes:
        shape: ``sphere`` around ``place``; ``capsule`` from ``place`` to ``end``; ``cylinder``
            likewise, with flat ends; ``ring`` on the floor around ``place``; ``net`` is a sheet
            between the floor and the line from ``place`` to ``end``.
        drag: whether, and how, it is moved with the mouse: over the floor, or in space.
        note: stands beside it.
    """

    id: str
    shape: Literal["sphere", "capsule", "cylinder", "ring", "net"]
    place: Sequence[float]
    end: Sequence[float] | None = None
    radius: float = 0.05
    colour: Colour = "purple"
    drag: Literal["floor", "space"] | None = None
    note: str = ""


@dataclass(frozen=True, kw_only=True)
class Span:
    """An interval of the timeline under the picture, in a row of that name."""

    row: str
    start: float
    end: float
    text: str
    colour: Colour = "grey"


@dataclass(frozen=True, kw_only=True)
class Bar:
    """A number shown as a bar from 0 to ``of``."""

    name: str
    value: float
    of: float = 1.0
    colour: Colour = "blue"


@dataclass(frozen=True, kw_only=True, eq=False)
class Show:
    """All that is seen at once, and over time.

    Attributes:
        title: what it is, a few words.
        words: what came of it, one sentence; empty where there is nothing to say.
        seconds: how long it lasts.
        notes: further figures, name and value, in the order in which they are read.
        moments: named seconds, marked on the timeline.
    """

    title: str
    seconds: float
    words: str = ""
    bodies: Sequence[Body] = ()
    actors: Sequence[Actor] = ()
    balls: Sequence[Ball] = ()
    lines: Sequence[Line] = ()
    things: Sequence[Thing] = ()
    spans: Sequence[Span] = ()
    bars: Sequence[Bar] = ()
    notes: Sequence[tuple[str, str]] = ()
    moments: Sequence[tuple[str, float]] = ()
    kind: str = field(default="show", init=False)


def show_value(item: Any) -> Any:
    """A record of this module, or a list of them, as dicts, lists and arrays that can be packed."""
    if is_dataclass(item) and not isinstance(item, type):
        return {f.name: show_value(getattr(item, f.name)) for f in fields(item)}
    if isinstance(item, np.ndarray):
        return item.astype(np.float32) if item.dtype.kind == "f" else item
    if isinstance(item, list | tuple):
        return [show_value(value) for value in item]
    return item
