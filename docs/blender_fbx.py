"""GLB to FBX and back, by Blender: `blender --background --python docs/blender_fbx.py -- IN OUT`.

IN and OUT are files ending in .glb and .fbx. Also runs in a Python that has Blender as a module
(`pip install bpy`, for the one version of Python that its Blender has): `python docs/blender_fbx.py
IN OUT`. The frame rate of the scene becomes that of the file where a GLB of mgjax tells it.
"""

from __future__ import annotations

import json
import struct
import sys
from pathlib import Path

import bpy


def main(words: list[str]) -> int:
    """Converts one file; returns the exit status."""
    names = words[words.index("--") + 1 :] if "--" in words else words[1:]
    if len(names) != 2 or not Path(names[0]).is_file():
        print("usage: blender_fbx.py IN.glb OUT.fbx, or IN.fbx OUT.glb", file=sys.stderr)
        return 2
    source, target = (Path(name).resolve() for name in names)
    kinds = source.suffix.lower(), target.suffix.lower()
    if kinds == (".glb", ".fbx"):
        empty_scene()
        rate = stated_rate(source)
        set_rate(rate)
        bpy.ops.import_scene.gltf(filepath=str(source))
        fit_range()
        bpy.ops.export_scene.fbx(
            filepath=str(target), add_leaf_bones=False, bake_anim_simplify_factor=0.0
        )
    elif kinds == (".fbx", ".glb"):
        empty_scene()
        bpy.ops.import_scene.fbx(filepath=str(source), anim_offset=0.0)
        fit_range()
        bpy.ops.export_scene.gltf(filepath=str(target), export_format="GLB")
    else:
        print(f"blender_fbx.py: cannot turn {kinds[0]} into {kinds[1]}", file=sys.stderr)
        return 2
    return 0


def empty_scene() -> None:
    """Without the cube, camera and lamp that Blender begins with, and with both formats known."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    for name in ("io_scene_gltf2", "io_scene_fbx"):
        bpy.ops.preferences.addon_enable(module=name)


def stated_rate(path: Path) -> float:
    """Frames per second that mgjax tells beside an animation, or 30."""
    data = path.read_bytes()
    (size,) = struct.unpack_from("<I", data, 12)
    document = json.loads(data[20 : 20 + size])
    extras = (document.get("animations") or [{}])[0].get("extras", {})
    return float(extras.get("frame_rate", 30.0))


def set_rate(rate: float) -> None:
    """Blender's rate is a whole number over a base."""
    whole = max(round(rate), 1)
    bpy.context.scene.render.fps = whole
    bpy.context.scene.render.fps_base = whole / rate


def fit_range() -> None:
    """From the first frame of any action to the last."""
    ranges = [action.frame_range for action in bpy.data.actions]
    if ranges:
        bpy.context.scene.frame_start = int(min(first for first, _ in ranges))
        bpy.context.scene.frame_end = int(max(last for _, last in ranges) + 0.5)


if __name__ == "__main__":
    sys.exit(main(sys.argv))
