"""Motion graphs: which pieces of motion can follow one another, and walks over them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from mgjax._lazy import attach

if TYPE_CHECKING:
    from mgjax.core.parallel.executors import executor as executor
    from mgjax.graph.build import build_graph as build_graph
    from mgjax.graph.config import GraphConfig as GraphConfig
    from mgjax.graph.distances.distance import distance_matrix as distance_matrix
    from mgjax.graph.files import load_graph as load_graph
    from mgjax.graph.files import save_graph as save_graph
    from mgjax.graph.stages.stages import Stages as Stages
    from mgjax.graph.stages.stages import stage_store as stage_store
    from mgjax.graph.types import MotionGraph as MotionGraph
    from mgjax.graph.walk import Walk as Walk
    from mgjax.graph.walk import make_walk as make_walk
    from mgjax.graph.walk import random_walk as random_walk
    from mgjax.graph.walk import unroll as unroll
    from mgjax.io.stages import StageStore as StageStore
else:
    __getattr__, __dir__, __all__ = attach(
        __name__,
        {
            "make_walk": "mgjax.graph.walk",
            "random_walk": "mgjax.graph.walk",
            "executor": "mgjax.core.parallel.executors",
            "build_graph": "mgjax.graph.build",
            "distance_matrix": "mgjax.graph.distances.distance",
            "GraphConfig": "mgjax.graph.config",
            "load_graph": "mgjax.graph.files",
            "MotionGraph": "mgjax.graph.types",
            "save_graph": "mgjax.graph.files",
            "Stages": "mgjax.graph.stages.stages",
            "StageStore": "mgjax.io.stages",
            "stage_store": "mgjax.graph.stages.stages",
            "unroll": "mgjax.graph.walk",
            "Walk": "mgjax.graph.walk",
        },
    )
