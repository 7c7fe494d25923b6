"""Table 1 of the paper: how long a search takes with and without index and slices.

python -m experiments.avoidance.table1 --config configs/avoidance/table1.toml --set clips=DIR
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from experiments.avoidance.graphs import graph_of
from mgjax.avoidance.index.build import build_index
from mgjax.avoidance.index.files import FILE_NAME, load_index
from mgjax.avoidance.index.index import GridIndex
from mgjax.bench.selection import MANY, condition_rows, random_balls
from mgjax.core.xla.compilation import one_thread
from mgjax.graph.types import MotionGraph
from mgjax.runs.experiment import Results, experiment

PAPER_MS = {(True, True): 14.0, (False, True): 225.0, (True, False): 18.0, (False, False): 496.0}
"""Index and slices → milliseconds."""
PAPER_CANDIDATES = {True: 5, False: 100}
PAPER_ANSWERED, PAPER_ENDED = 0.9, 0.5


@dataclass(frozen=True, kw_only=True)
class Config:
    """Settings.

    Attributes:
        graph: folder of a graph; "" for that of the embedded clips.
        clips: folder of clips with its labels.json, of which a graph is built; "": the graph.
        exclude: globs on paths below the folder of clips that are left out.
        balls: 10 m/s from any side, 0.5–1.7 m high, there in 1.2 s, at random nodes.
        repeats: calls per ball and condition.
        moments: random moments of a random walk at which an attack becomes known.
        seed: draws all of them.
    """

    graph: str = ""
    clips: str = ""
    exclude: tuple[str, ...] = ("bvh_converted/*",)
    balls: int = 200
    repeats: int = 3
    moments: int = 10_000
    seed: int = 0

    @classmethod
    def smoke(cls) -> dict[str, Any]:
        """A few balls at the embedded clips."""
        return {"graph": "", "clips": "", "balls": 4, "repeats": 1, "moments": 200}


def run(config: Config) -> Results:
    graph = graph_of(config.graph, config.clips, config.exclude)
    index = _index(graph, "" if config.clips else config.graph)
    balls = random_balls(graph, config.balls, config.seed)
    rows = condition_rows(graph, index, balls, repeats=config.repeats, progress=True)
    left = remaining_seconds(graph, config.moments, config.seed)
    for row in rows:
        row["ends_before_the_edge"] = float((left * 1e3 > row["median_ms"]).mean())
        row["paper_ms"] = PAPER_MS[row["index"], row["slices"]]
    plain = next(row for row in rows if row["index"] and not row["slices"])
    answered = plain.get("answered_by_the_index", {}).get("share", 0.0)
    holds = plain["index_holds_candidates"]
    metrics = {
        "candidates": {_name(row): row["candidates"] for row in rows},
        "avoided": {_name(row): row["avoided"] for row in rows},
        "index_holds_candidates": holds,
        "answered_by_the_index": answered,
        "median_rest_of_an_edge_s": float(np.median(left)),
        "index_bytes": index.nbytes,
        "index": {k: v for k, v in index.report.items() if not k.endswith("_s")},
    }
    lines = [_line(row) for row in rows]
    ended = rows[-1]["ends_before_the_edge"]
    lines += [
        f"the index holds candidates for {100 * holds:.0f} % of the attacks (paper"
        f" {100 * PAPER_ANSWERED:.0f} %), one that avoids for {100 * answered:.0f} %",
        f"of searches without it {100 * ended:.0f} % end before the edge being played (paper"
        f" {100 * PAPER_ENDED:.0f} %)",
    ]
    return Results(
        metrics=metrics,
        timings={"rows": rows},
        figures={"table1": lambda: _figure(rows)},
        lines=tuple(lines),
    )


def _index(graph: MotionGraph, folder: str) -> GridIndex:
    """That beside the graph, if it was read; else it is built."""
    if folder and (Path(folder) / FILE_NAME).exists():
        return load_index(folder, graph)
    return build_index(graph)


def remaining_seconds(graph: MotionGraph, count: int, seed: int) -> np.ndarray:
    """What is left of the edge being played at random moments of a random walk, s. [M]"""
    rng = np.random.default_rng(seed)
    node, played = int(rng.integers(graph.num_nodes)), []
    for _ in range(max(count, 100)):
        edge = int(rng.choice(graph.edges_from(node)))
        played.append(graph.edge_frames[edge] / graph.frame_rate)
        node = int(graph.edge_target[edge])
    seconds = np.array(played)
    moments = rng.choice(seconds, size=count, p=seconds / seconds.sum())
    return moments * rng.uniform(size=count)


def _name(row: dict[str, Any]) -> str:
    words = [w for w, there in (("slices", row["slices"]), ("index", row["index"])) if there]
    return " and ".join(words) or "neither"


def _line(row: dict[str, Any]) -> str:
    text = (
        f"{_name(row):>16}: {row['median_ms']:.2f} ms, p95 {row['p95_ms']:.2f} ms (paper"
        f" {row['paper_ms']:.0f} ms), {row['candidates']:.0f} candidates, avoided"
        f" {100 * row['avoided']:.0f} %"
    )
    for group, label in (
        ("answered_by_the_index", "answered by the index"),
        (f"from_{MANY}_candidates", f"{MANY} candidates or more"),
    ):
        if group in row:
            some = row[group]
            text += f"; {label}: {some['median_ms']:.2f} ms, p95 {some['p95_ms']:.2f} ms"
    return text


def _figure(rows: list[dict[str, Any]]) -> Figure:
    figure = Figure(figsize=(7, 3.2), layout="constrained")
    axes = figure.subplots()
    places = np.arange(len(rows))
    axes.barh(places - 0.2, [r["paper_ms"] for r in rows], 0.38, color="#c9c9c9", label="paper")
    axes.barh(places + 0.2, [r["median_ms"] for r in rows], 0.38, color="#3b6fb6", label="here")
    for place, row in zip(places, rows, strict=True):
        for value, off in ((row["paper_ms"], -0.2), (row["median_ms"], 0.2)):
            axes.text(value * 1.08, place + off, f"{value:.3g}", va="center", fontsize=8)
    axes.set_xscale("log")
    axes.set_yticks(places, [_name(row) for row in rows])
    axes.invert_yaxis()
    axes.set_xlabel("milliseconds from an attack to the chosen path, median")
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(frameon=False, loc="lower right")
    return figure


if __name__ == "__main__":
    one_thread()
    experiment(run, Config)
