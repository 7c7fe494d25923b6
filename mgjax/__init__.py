"""Motion graphs for characters that react: avoid, kick, walk and reach, in JAX.

Importing this package does no work; names are loaded when they are first used.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from mgjax._lazy import attach

__version__ = "0.1.0"

if TYPE_CHECKING:
    from mgjax import avoidance as avoidance
    from mgjax import ballsport as ballsport
    from mgjax import clips as clips
    from mgjax import core as core
    from mgjax import graph as graph
    from mgjax import hybrid as hybrid
    from mgjax import io as io
    from mgjax import quality as quality
    from mgjax.core.errors import MgjaxError as MgjaxError
    from mgjax.core.kinematics import global_positions as global_positions
    from mgjax.core.motion import Motion as Motion
    from mgjax.core.motion import cut as cut
    from mgjax.core.motion import mirror as mirror
    from mgjax.core.motion import resample as resample
    from mgjax.core.skeleton import Skeleton as Skeleton
    from mgjax.core.xla.compilation import enable_cache as enable_cache
    from mgjax.io.bvh.write import save_bvh as save_bvh
    from mgjax.io.load import load_motion as load_motion
    from mgjax.io.save import save_motion as save_motion
    from mgjax.stage.html import save_html as save_html
else:
    __getattr__, __dir__, __all__ = attach(
        __name__,
        {
            "resample": "mgjax.core.motion",
            "mirror": "mgjax.core.motion",
            "cut": "mgjax.core.motion",
            "enable_cache": "mgjax.core.xla.compilation",
            "avoidance": "mgjax.avoidance",
            "ballsport": "mgjax.ballsport",
            "clips": "mgjax.clips",
            "core": "mgjax.core",
            "global_positions": "mgjax.core.kinematics",
            "graph": "mgjax.graph",
            "hybrid": "mgjax.hybrid",
            "io": "mgjax.io",
            "quality": "mgjax.quality",
            "load_motion": "mgjax.io.load",
            "MgjaxError": "mgjax.core.errors",
            "Motion": "mgjax.core.motion",
            "save_bvh": "mgjax.io.bvh.write",
            "save_html": "mgjax.stage.html",
            "save_motion": "mgjax.io.save",
            "Skeleton": "mgjax.core.skeleton",
        },
    )
    __all__ += ["__version__"]
