"""Clips with names, their labels, and the procedural set that comes with the package."""

from __future__ import annotations

from typing import TYPE_CHECKING

from mgjax._lazy import attach

if TYPE_CHECKING:
    from mgjax.clips.folder import load_clips as load_clips
    from mgjax.clips.labels import load_labels as load_labels
    from mgjax.clips.synthetic import synthetic_clips as synthetic_clips
    from mgjax.clips.types import Clip as Clip
    from mgjax.clips.types import Label as Label
    from mgjax.core.body.roles import find_roles as find_roles
    from mgjax.io.reading.read_as import ReadAs as ReadAs
else:
    __getattr__, __dir__, __all__ = attach(
        __name__,
        {
            "ReadAs": "mgjax.io.reading.read_as",
            "find_roles": "mgjax.core.body.roles",
            "Clip": "mgjax.clips.types",
            "Label": "mgjax.clips.types",
            "load_clips": "mgjax.clips.folder",
            "load_labels": "mgjax.clips.labels",
            "synthetic_clips": "mgjax.clips.synthetic",
        },
    )
