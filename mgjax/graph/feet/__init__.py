"""Feet that stand still: in transitions, and in all that is played."""

from __future__ import annotations

from typing import TYPE_CHECKING

from mgjax._lazy import attach

if TYPE_CHECKING:
    from mgjax.graph.feet.legs import FootChains as FootChains
    from mgjax.graph.feet.legs import foot_chains as foot_chains
else:
    __getattr__, __dir__, __all__ = attach(
        __name__,
        {
            "foot_chains": "mgjax.graph.feet.legs",
            "FootChains": "mgjax.graph.feet.legs",
        },
    )
