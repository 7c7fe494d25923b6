"""Pictures of what was found: throws, coverage, walks and scenes."""

from __future__ import annotations

from typing import TYPE_CHECKING

from mgjax._lazy import attach

if TYPE_CHECKING:
    from mgjax.pictures.coverage import coverage_figure as coverage_figure
    from mgjax.pictures.scene import scene_figure as scene_figure
    from mgjax.pictures.walk import distances as distances
    from mgjax.pictures.walk import hands_above as hands_above
    from mgjax.pictures.walk import top_view as top_view
else:
    __getattr__, __dir__, __all__ = attach(
        __name__,
        {
            "coverage_figure": "mgjax.pictures.coverage",
            "distances": "mgjax.pictures.walk",
            "hands_above": "mgjax.pictures.walk",
            "scene_figure": "mgjax.pictures.scene",
            "top_view": "mgjax.pictures.walk",
        },
    )
