"""The show of whatever can be shown."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from mgjax.core.errors import MgjaxError
from mgjax.core.shown import origin_of
from mgjax.stage.show.types import Show

_EXPECTED = (
    "a motion, clip, selection, walk, result of a path or of reaching, scene, coverage,"
    " a pair of skeleton and motion, or the path of a motion file or of a command's folder"
)


def show_of(thing: Any) -> Show:
    """The show of a thing.

    Motions, selections, walks, paths, reaches and coverages know what they were made of where this
    library made them (:mod:`mgjax.core.shown`).

    Raises:
        MgjaxError: it is nothing that can be shown, or what it was made of is not known.
    """
    if isinstance(thing, Show):
        return thing
    if isinstance(thing, str | Path):
        from mgjax.stage.show.folder import show_of_folder

        return show_of_folder(thing)
    if isinstance(thing, tuple) and len(thing) == 2:
        from mgjax.stage.show.motion import motion_show

        return motion_show(*thing)
    make = _MAKERS.get(type(thing).__name__)
    if make is None:
        raise MgjaxError(got=f"{type(thing).__name__!r}", expected=_EXPECTED)
    return make(thing)


def _motion(thing: Any) -> Show:
    from mgjax.stage.show.motion import motion_show

    (skeleton,) = _made_of(thing, "its skeleton", "(skeleton, motion)")
    return motion_show(skeleton, thing)


def _clip(thing: Any) -> Show:
    from mgjax.stage.show.motion import motion_show

    return motion_show(thing.skeleton, thing.motion, title=thing.name)


def _selection(thing: Any) -> Show:
    from mgjax.stage.show.selection import selection_show

    graph, attack = _made_of(thing, "its graph and attack", "select(…)")
    return selection_show(graph, attack, thing)


def _walk(thing: Any) -> Show:
    from mgjax.stage.show.walk import walk_show

    (graph,) = _made_of(thing, "its graph", "make_walk(…)")
    return walk_show(graph, thing)


def _path(thing: Any) -> Show:
    from mgjax.stage.show.paths import path_show

    graph, sketch = _made_of(thing, "its graph and sketch", "follow(…)")
    return path_show(graph, sketch, thing)


def _reach(thing: Any) -> Show:
    from mgjax.stage.show.paths import reach_show

    graph, sketch = _made_of(thing, "its graph and sketch", "reach(…)")
    return reach_show(graph, sketch, thing)


def _scene(thing: Any) -> Show:
    from mgjax.stage.show.scene import scene_show

    return scene_show(thing)


def _coverage(thing: Any) -> Show:
    from mgjax.stage.show.coverage import coverage_show

    (graph,) = _made_of(thing, "its graph", "measure_coverage(…)")
    return coverage_show(graph, thing)


def _made_of(thing: Any, what: str, maker: str) -> tuple[Any, ...]:
    found = origin_of(thing)
    if found is None:
        name = type(thing).__name__
        raise MgjaxError(got=f"a {name} without {what}", expected=f"what {maker} returns")
    return found


_MAKERS: dict[str, Callable[[Any], Show]] = {
    "Motion": _motion,
    "Clip": _clip,
    "Selection": _selection,
    "Walk": _walk,
    "PathResult": _path,
    "ReachResult": _reach,
    "Scene": _scene,
    "Coverage": _coverage,
}
