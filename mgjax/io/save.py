"""Saving a motion as any file that is understood; the suffix says which."""

from __future__ import annotations

import importlib
from pathlib import Path

from mgjax.core.errors import ConfigError, printable
from mgjax.core.motion import Motion
from mgjax.core.skeleton import Skeleton

WRITERS = {
    ".bvh": ("mgjax.io.bvh.write", "save_bvh"),
    ".csv": ("mgjax.io.csv.write", "save_csv"),
    ".glb": ("mgjax.io.gltf.write", "save_glb"),
    ".npz": ("mgjax.io.npz.write", "save_npz"),
    ".usd": ("mgjax.io.usd.write", "save_usd"),
    ".usda": ("mgjax.io.usd.write", "save_usd"),
    ".usdc": ("mgjax.io.usd.write", "save_usd"),
    ".vrma": ("mgjax.io.gltf.vrma", "save_vrma"),
}
"""For each suffix the module and the function that writes it, imported only when it is needed."""


def check_suffix(path: str | Path) -> str:
    """The suffix of a file to be written; :class:`ConfigError` if there is no writer for it."""
    suffix = Path(path).suffix.lower()
    if suffix not in WRITERS:
        raise ConfigError(
            got=f"a file of type {suffix!r} to write",
            expected=f"one of {', '.join(WRITERS)}",
            place=printable(path),
        )
    return suffix


def save_motion(path: str | Path, skeleton: Skeleton, motion: Motion) -> None:
    """Writes a motion: ``.bvh``, ``.csv``, ``.glb``, ``.npz``, ``.usd[ac]`` or ``.vrma``.

    Raises:
        ConfigError: no such format, or a package that it needs is not installed.
        SkeletonError: the skeleton is not valid, or cannot be told in this format.
        MotionError: the motion does not fit the skeleton or is not finite.
        OutputError: the file cannot be written.
    """
    module, name = WRITERS[check_suffix(path)]
    getattr(importlib.import_module(module), name)(path, skeleton, motion)
