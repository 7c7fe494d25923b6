"""ASF/AMC in float64 with matrices, bone by bone, as the Acclaim format is described.

Bone i ends at  start + R_i · length · direction  with  R_i = R_parent · C_i · M_i · C_i⁻¹, where
C_i comes from ``axis`` and M_i from the channels. Angles listed ``rx ry rz`` are applied in that
order: Rz · Ry · Rx. Expects well-formed files.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tests.reference.kinematics import axis_rotation

ROOT_ORDER = ("tx", "ty", "tz", "rx", "ry", "rz")


def words(path: Path) -> list[list[str]]:
    lines = [line.split("#")[0].split() for line in Path(path).read_text().splitlines()]
    return [line for line in lines if line]


def applied_in_order(angles, letters) -> np.ndarray:
    result = np.eye(3)
    for angle, letter in zip(angles, letters, strict=True):
        result = axis_rotation(letter.upper(), angle) @ result
    return result


def read_skeleton(path: Path) -> dict:
    length, factor, section, bone = 1.0, np.pi / 180, "", {}
    root = {"dof": list(ROOT_ORDER), "position": np.zeros(3), "C": np.eye(3)}
    order, orientation = "XYZ", np.zeros(3)
    bones, parents = {}, {}
    for line in words(path):
        key = line[0].lower()
        if key.startswith(":"):
            section = key
        elif section == ":units" and key == "length":
            length = float(line[1])
        elif section == ":units" and key == "angle":
            factor = 1.0 if line[1].lower() == "rad" else np.pi / 180
        elif section == ":root" and key == "order":
            root["dof"] = [w.lower() for w in line[1:]]
        elif section == ":root" and key == "axis":
            order = line[1]
        elif section == ":root" and key == "position":
            root["position"] = np.array(line[1:4], float)
        elif section == ":root" and key == "orientation":
            orientation = np.array(line[1:4], float)
        elif section == ":bonedata" and key == "begin":
            bone = {"dof": []}
        elif section == ":bonedata" and key == "end":
            bones[bone["name"]] = bone
        elif section == ":bonedata" and key == "name":
            bone["name"] = line[1]
        elif section == ":bonedata" and key == "direction":
            bone["direction"] = np.array(line[1:4], float)
        elif section == ":bonedata" and key == "length":
            bone["length"] = float(line[1])
        elif section == ":bonedata" and key == "axis":
            angles = {x: float(v) * factor for x, v in zip("XYZ", line[1:4], strict=True)}
            letters = line[4].upper()
            bone["C"] = applied_in_order([angles[x] for x in letters], letters)
        elif section == ":bonedata" and key == "dof":
            bone["dof"] = [w.lower() for w in line[1:]]
        elif section == ":hierarchy" and key not in ("begin", "end"):
            for child in line[1:]:
                parents[child] = line[0]
    angles = dict(zip("XYZ", orientation * factor, strict=True))
    root["C"] = applied_in_order([angles[x] for x in order.upper()], order.upper())
    return {"root": root, "bones": bones, "parents": parents, "metres": 0.0254 / length}


def read_frames(path: Path) -> tuple[list[dict], float]:
    frames, factor = [], np.pi / 180
    for line in words(path):
        if line[0].upper() == ":RADIANS":
            factor = 1.0
        elif line[0].startswith(":"):
            continue
        elif len(line) == 1 and line[0].isdigit():
            frames.append({})
        else:
            frames[-1][line[0]] = np.array(line[1:], float)
    return frames, factor


def positions(asf: Path, amc: Path, every: int = 1) -> dict[str, np.ndarray]:
    """Metres: where each bone begins ([F,3] by its name) and ends (by ``<name>_end``)."""
    skeleton = read_skeleton(asf)
    frames, factor = read_frames(amc)
    metres, parents = skeleton["metres"], skeleton["parents"]
    found: dict[str, list] = {}
    for frame in frames[::every]:
        root = skeleton["root"]
        values = dict(zip(root["dof"], frame.get("root", []), strict=bool("root" in frame)))
        shift = np.array([values.get(name, 0.0) for name in ("tx", "ty", "tz")])
        turns = [name for name in root["dof"] if name[0] == "r"]
        turn = applied_in_order([values.get(n, 0.0) * factor for n in turns], [n[1] for n in turns])
        place = {"root": (root["position"] + shift) * metres}
        rotation = {"root": root["C"] @ turn}
        found.setdefault("root", []).append(place["root"])
        todo = list(parents)
        while todo:
            name = todo.pop(0)
            parent = parents[name]
            if parent not in place:
                todo.append(name)
                continue
            bone = skeleton["bones"][name]
            channels = frame.get(name, [])
            motion = applied_in_order([v * factor for v in channels], [d[1] for d in bone["dof"]])
            rotation[name] = rotation[parent] @ bone["C"] @ motion @ bone["C"].T
            direction = bone["direction"] / np.linalg.norm(bone["direction"])
            start = place[parent]
            place[name] = start + rotation[name] @ direction * bone["length"] * metres
            found.setdefault(name, []).append(start)
            found.setdefault(f"{name}_end", []).append(place[name])
    return {name: np.array(rows) for name, rows in found.items()}
