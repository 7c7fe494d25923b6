"""Reading one clip, or taking what was read of the same file before."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from mgjax.core.errors import FileFormatError
from mgjax.core.motion import Motion
from mgjax.core.skeleton import Skeleton
from mgjax.io.acclaim.amc import find_asf
from mgjax.io.content_key import content_key
from mgjax.io.load import read_capture
from mgjax.io.reading.capture import Capture
from mgjax.io.reading.interpret import BODY_M
from mgjax.io.reading.read_as import ReadAs
from mgjax.io.stages import StageStore

STAGE = "read"


@dataclass(frozen=True, kw_only=True)
class ReadClip:
    """What is taken from a file.

    Attributes:
        skeleton, motion: metres, Y up.
        reading: how it was read, ready for JSON.
        notes: what else there is to say, a line each.
    """

    skeleton: Skeleton
    motion: Motion
    reading: dict[str, Any]
    notes: tuple[str, ...]


def read_clip(
    path: Path, way: ReadAs, *, need_body: bool = False, store: StageStore | None = None
) -> ReadClip:
    """Reads a motion file.

    Args:
        path: the file.
        way: what is known of it.
        need_body: a file without a body, or with one no person has, is refused.
        store: keeps what was read, named by the content of the files.

    Raises:
        FileFormatError: it cannot be read, or has no body where one is needed.
        OutputError: what was read cannot be kept.
    """
    key = "" if store is None else _key(path, way, need_body)
    kept = None if store is None else store.load(STAGE, key)
    if kept is not None:
        return _unpacked(*kept)
    capture = read_capture(path, way)
    if need_body:
        check_body(path, capture, way)
    clip = ReadClip(
        skeleton=capture.skeleton,
        motion=capture.motion,
        reading={**capture.reading.as_dict(), "said": way.as_dict()},
        notes=tuple(note.text for note in capture.reading.notes),
    )
    if store is not None:
        _keep(store, key, clip)
    return clip


def check_body(path: Path, capture: Capture, read_as: ReadAs) -> None:
    """Raises :class:`FileFormatError` for what is no body, or none of a size that people have."""
    tall = capture.reading.height_m
    if tall is None:
        four = any(note.kind == "four_legs" for note in capture.reading.notes)
        got = "a body on four legs" if four else "no body on two legs"
        wanted = "hip, knee and ankle of two legs (--roles names them), or --no-body"
        raise FileFormatError(path, None, got, wanted)
    low, high = BODY_M
    if read_as.units is None and not low <= tall <= high:
        raise FileFormatError(
            path,
            None,
            f"a body of {tall:.2f} m in the {capture.unit.name}",
            f"{low:g} … {high:g} m; if it is right, say the unit: --units",
        )


def _key(path: Path, way: ReadAs, need_body: bool) -> str:
    """Names the content of all files that are read for a clip, and how they are."""
    files = [path, way.body_model]
    if path.suffix.lower() == ".amc":
        files.append(way.asf or find_asf(path))
    contents = [content_key(file.read_bytes()) for file in files if file and file.is_file()]
    return content_key(contents, path.suffix.lower(), way.as_dict(), need_body)


def _keep(store: StageStore, key: str, clip: ReadClip) -> None:
    skeleton, motion = clip.skeleton, clip.motion
    arrays = {
        "offsets": np.asarray(skeleton.offsets),
        "root_translation": np.asarray(motion.root_translation),
        "local_rotations": np.asarray(motion.local_rotations),
    }
    plain = {
        "names": skeleton.names,
        "parents": skeleton.parents,
        "end_joints": skeleton.end_joints,
        "roles": skeleton.roles,
        "frame_rate": motion.frame_rate,
        "reading": clip.reading,
        "notes": clip.notes,
    }
    store.save(STAGE, key, arrays, plain)


def _unpacked(arrays: dict[str, np.ndarray], plain: dict[str, Any]) -> ReadClip:
    skeleton = Skeleton(
        names=tuple(plain["names"]),
        parents=tuple(plain["parents"]),
        offsets=arrays["offsets"],
        end_joints=tuple(plain["end_joints"]),
        roles=tuple((role, joint) for role, joint in plain["roles"]),
    )
    motion = Motion(
        root_translation=arrays["root_translation"],
        local_rotations=arrays["local_rotations"],
        frame_rate=plain["frame_rate"],
    )
    notes = tuple(plain["notes"])
    return ReadClip(skeleton=skeleton, motion=motion, reading=plain["reading"], notes=notes)
