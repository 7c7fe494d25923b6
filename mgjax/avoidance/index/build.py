"""Building the grid index (§5.1): walks within the horizon, and volumes of the parts they lead to.

The avoidance volume of a path is that of its part, moved by a planar transform, so heights stay.
Each part is therefore rasterised once, seen from above, with one bit for each cell of height; which
cells a path has is read from that when an attack asks for it.
"""

from __future__ import annotations

import time

import numpy as np

from mgjax.avoidance.body.edge_tables import EdgeTables, edge_tables, of_size
from mgjax.avoidance.index.index import GridIndex
from mgjax.avoidance.index.paths import part_middles, stored_paths
from mgjax.avoidance.index.rasterise import part_volumes
from mgjax.avoidance.index.walk_table import smallest
from mgjax.graph.fingerprint import fingerprint
from mgjax.graph.types import MotionGraph

CAPACITY = 6
"""Most walks to a part that a node keeps whole; the others are put together when asked for."""


def build_index(
    graph: MotionGraph,
    *,
    horizon: float = 2.0,
    rate: float = 30.0,
    capacity: int = CAPACITY,
    progress: bool = False,
) -> GridIndex:
    """The index of all paths with t_avoid ≤ horizon at natural speed (§5.1).

    Args:
        graph: a motion graph with labelled avoidance parts.
        horizon: s.
        rate: moments per second at which a part's volume is sampled: its start, 1/rate s later and
            so on, and its end. Between the frames of the graph it is interpolated.
        capacity: most walks of a node that are stored whole: it decides how large the index is and
            how quick a look-up, not what it finds.
        progress: shows a bar.
    """
    return index_of_tables(
        graph,
        edge_tables(graph, graph.frame_rate),
        horizon=horizon,
        rate=rate,
        capacity=capacity,
        progress=progress,
    )


def index_of_tables(
    graph: MotionGraph,
    tables: EdgeTables,
    *,
    horizon: float,
    rate: float,
    capacity: int,
    progress: bool,
) -> GridIndex:
    """The index of a graph whose body volumes are those of given tables; see :func:`build_index`.

    Between the samples of the tables the volumes are interpolated. Cells grow with the body: all is
    done at the size of an adult.
    """
    tables = of_size(tables, 1 / graph.body_scale)
    clock = [time.perf_counter()]
    paths = stored_paths(graph, tables, horizon, capacity)
    clock.append(time.perf_counter())
    soon = np.flatnonzero(part_middles(graph, tables) <= horizon * 2 * graph.frame_rate + 1e-6)
    parts = part_volumes(tables, rate, soon, progress=progress)
    clock.append(time.perf_counter())
    report = {
        "paths": paths.count,
        "arrivals": len(paths.arrivals.end),
        "jumps": len(paths.jumps.end),
        "parts": len(soon),
        "rate": rate,
        "capacity": capacity,
        **dict(zip(("paths_s", "parts_s"), np.diff(clock).tolist(), strict=True)),
    }
    return GridIndex(
        horizon=horizon,
        scale=graph.body_scale,
        half_frames=2 * graph.frame_rate,
        fingerprint=fingerprint(graph),
        report=report,
        complete=paths.limit.astype(np.int32),
        nearest=smallest(paths.nearest),
        arrivals=paths.arrivals,
        jumps=paths.jumps,
        parts=parts,
    )
