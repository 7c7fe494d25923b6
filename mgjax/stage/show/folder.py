"""What a command wrote, read back as a show; or a motion file."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from mgjax.core.errors import FileFormatError
from mgjax.io.json_text import parse_json
from mgjax.io.load import SUFFIXES, load_motion
from mgjax.io.text import read_text
from mgjax.stage.show.folders.avoid import avoid_folder, demo_folder
from mgjax.stage.show.folders.scene import scene_folder
from mgjax.stage.show.folders.walk import walk_folder
from mgjax.stage.show.motion import motion_show
from mgjax.stage.show.types import Show

_EXPECTED = "result.json or timeline.json of avoid, walk, scene or demo"
_NOT_ONE = f"a folder with {_EXPECTED}, or a motion file"


def show_of_folder(path: str | Path) -> Show:
    """The show of a folder that ``avoid``, ``walk``, ``scene`` or ``demo`` wrote, or of a motion.

    Raises:
        FileFormatError: it is neither, a file of it is missing or damaged.
    """
    path = Path(path)
    if path.is_file():
        if path.suffix.lower() not in SUFFIXES:
            raise FileFormatError(path, None, f"a file {path.suffix or 'without suffix'}", _NOT_ONE)
        skeleton, motion = load_motion(path)
        return motion_show(skeleton, motion, title=path.name)
    if not path.is_dir():
        raise FileFormatError(path, None, "nothing there", _NOT_ONE)
    readers: tuple[tuple[str, str, Callable[[Path, dict[str, Any]], Show]], ...] = (
        ("timeline.json", "passes", scene_folder),
        ("result.json", "balls", demo_folder),
        ("result.json", "clearance_m", avoid_folder),
        ("result.json", "mean_distance_m", walk_folder),
    )
    for name, key, read in readers:
        if not (path / name).is_file():
            continue
        text = read_text(path / name, "JSON")
        value = parse_json(path / name, text, expected=_EXPECTED)
        if isinstance(value, dict) and key in value:
            return _read(read, path, name, value)
    raise FileFormatError(path, None, "none of these files", _EXPECTED)


def _read(
    read: Callable[[Path, dict[str, Any]], Show], path: Path, name: str, value: dict[str, Any]
) -> Show:
    try:
        return read(path, value)
    except FileFormatError:
        raise
    except KeyError as error:
        got, expected = f"no {error.args[0]!r}", "all that the command writes"
        raise FileFormatError(path / name, None, got, expected) from None
    except (TypeError, ValueError, IndexError, AttributeError) as error:
        got = f"values of another kind ({str(error)[:80]})"
        raise FileFormatError(path / name, None, got, "what the command writes") from None
