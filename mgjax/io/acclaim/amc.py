"""AMC motions: frames of an Acclaim ASF skeleton; :mod:`mgjax.io.acclaim.asf` has its angles."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from mgjax.core import quaternion
from mgjax.core.errors import FileFormatError
from mgjax.io.acclaim.asf import AsfFile
from mgjax.io.acclaim.sections import ROOT
from mgjax.io.reading.raw import RawMotion
from mgjax.io.text import (
    MAX_PLACE_M,
    check_size,
    is_count,
    is_plain,
    parse_number,
    quoted,
    read_text,
    reason,
    split_lines,
)

DEFAULT_FRAME_RATE = 120.0


def find_asf(amc: str | Path) -> Path:
    """The ASF file of an AMC file: the one whose name is its longest prefix, else the only one.

    ``14_02.amc`` has ``14.asf``; ``HDM_aa_walk_001.amc`` has ``HDM_aa.asf``; one with the whole
    name comes last. Capitals make no difference.
    """
    amc = Path(amc)
    try:
        amc.stat()
        beside = sorted(p for p in amc.parent.iterdir() if p.suffix.lower() == ".asf")
    except (OSError, ValueError) as error:
        raise FileFormatError(amc, None, reason(error), "a readable AMC file") from None
    words = amc.stem.lower().split("_")
    prefixes = ["_".join(words[:count]) for count in range(len(words) - 1, 0, -1)]
    prefixes.append(amc.stem.lower())
    stems = {p.stem.lower(): p for p in beside}
    named = next((stems[prefix] for prefix in prefixes if prefix in stems), None)
    if named is not None:
        return named
    if len(beside) != 1:
        names = ", ".join(p.name for p in beside) or "none"
        raise FileFormatError(
            amc, None, f"{names} beside it", f"{words[0]}.asf or a single .asf file"
        )
    return beside[0]


def read_amc(path: str | Path, asf: AsfFile) -> RawMotion:
    """Reads an AMC motion for an ASF skeleton, at 120 fps: AMC files state no rate.

    Raises:
        FileFormatError: names file and line, what stands there and what was expected.
    """
    columns, values, degrees = _read_frames(path, read_text(path, "AMC").rstrip(), asf)
    scale = np.pi / 180 if degrees else 1.0
    skeleton = asf.skeleton
    check_size(path, len(values), skeleton.num_joints)
    rotations = np.zeros((len(values), skeleton.num_joints, 4))
    rotations[..., 0] = 1
    root = np.tile(asf.root_position, (len(values), 1))
    for bone, first in columns.items():
        dof = asf.channels[bone]
        block = values[:, first : first + len(dof)]
        turns = [i for i, name in enumerate(dof) if name[0] == "r"][::-1]
        turn = quaternion.from_euler(
            block[:, turns] * scale, "".join(dof[i][1].upper() for i in turns)
        )
        axis = asf.axes[bone]
        local = quaternion.multiply(quaternion.multiply(axis, turn), quaternion.conjugate(axis))
        # The root's orientation is where it starts from, not only the frame of its angles.
        rotations[:, skeleton.index(bone)] = (
            quaternion.multiply(axis, turn) if bone == ROOT else local
        )
        for i, name in enumerate(dof):
            if name[0] == "t" and bone == ROOT:
                far = np.abs(block[:, i]) > MAX_PLACE_M / asf.unit.metres
                if far.any():
                    got = f"root {name} {block[np.argmax(far), i]:.3g} in frame {np.argmax(far)}"
                    raise FileFormatError(path, None, got, f"at most {MAX_PLACE_M:g} m")
                root[:, "xyz".index(name[1])] += block[:, i] * asf.unit.metres
    return RawMotion(
        path=Path(path),
        names=skeleton.names,
        parents=skeleton.parents,
        end_joints=skeleton.end_joints,
        offsets=np.asarray(skeleton.offsets, dtype=np.float64) / asf.unit.metres,
        lines=(0,) * skeleton.num_joints,
        root=root / asf.unit.metres,
        rotations=rotations,
        moving=None,
        frame_rate=DEFAULT_FRAME_RATE,
        unit=asf.unit,
        settled=True,
    )


def _read_frames(
    path: str | Path, text: str, asf: AsfFile
) -> tuple[dict[str, int], np.ndarray, bool]:
    """First column of each bone, [F, columns] values, and whether angles are degrees."""
    degrees = True
    columns: dict[str, int] = {}
    width = 0
    for bone, dof in asf.channels.items():
        columns[bone], width = width, width + len(dof)
    sizes = {bone: len(dof) for bone, dof in asf.channels.items()}
    frames: list[list[str]] = []
    starts: list[int] = []
    row: list[str] = []
    place = dict(columns)
    missing = 0
    blank = [""] * width
    lines = split_lines(text)
    for no, line in enumerate(lines, 1):
        words = line.split("#", 1)[0].split()
        if not words:
            continue
        size = sizes.get(words[0])
        if size is not None and frames:
            if len(words) != size + 1:
                raise FileFormatError(
                    path, no, f"{len(words) - 1} values", f"{size} for {quoted(words[0])}"
                )
            first = place[words[0]]
            if row[first] != "":
                raise FileFormatError(path, no, f"{quoted(words[0])} a second time", "once a frame")
            row[first : first + size] = words[1:]
            missing -= 1
        elif len(words) == 1 and is_count(words[0]):
            _check_complete(path, no, row, columns, missing)
            if starts and int(words[0]) != starts[-1] + 1:
                raise FileFormatError(path, no, f"frame {words[0]}", f"frame {starts[-1] + 1}")
            starts.append(int(words[0]))
            row, missing = blank.copy(), len(columns)
            frames.append(row)
        elif words[0].startswith(":") and not frames:
            degrees = words[0].upper() != ":RADIANS" and degrees
        else:
            expected = f"a bone of {asf.path.name} or a frame number" if frames else "frame 1"
            raise FileFormatError(path, no, quoted(words[0]), expected)
    if not frames:
        raise FileFormatError(path, None, "no frame", "an AMC file with at least one")
    _check_complete(path, len(lines), row, columns, missing)
    return columns, _to_numbers(path, text, frames), degrees


def _check_complete(
    path: str | Path, no: int, row: list[str], columns: dict[str, int], missing: int
) -> None:
    if missing:
        bone = next(bone for bone, first in columns.items() if row[first] == "")
        raise FileFormatError(
            path, no, f"a frame without {quoted(bone)}", "all bones in every frame"
        )


def _to_numbers(path: str | Path, text: str, frames: list[list[str]]) -> np.ndarray:
    try:
        values = np.array(frames, dtype=np.float64)
        if np.isfinite(values).all() and all(is_plain("".join(row)) for row in frames):
            return values
    except ValueError:
        pass
    for no, line in enumerate(split_lines(text), 1):
        words = line.split("#", 1)[0].split()
        if len(words) > 1 and not words[0].startswith(":"):
            for word in words[1:]:
                parse_number(path, no, word, f"a channel of {quoted(words[0])}")
    raise FileFormatError(path, None, "a value that is no number", "numbers")
