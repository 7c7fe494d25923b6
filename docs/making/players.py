"""The pages' players: what moves in them, made from the embedded clips when the site is built."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path

from mgjax.ballsport import build_scene
from mgjax.ballsport.scene.file import load_scene
from mgjax.cli.demo import throw_balls
from mgjax.clips import synthetic_clips
from mgjax.core.xla.compilation import enable_cache
from mgjax.graph import MotionGraph, build_graph
from mgjax.graph.config import EMBEDDED
from mgjax.hybrid import make_sketch, make_target, reach
from mgjax.stage.html import save_html
from mgjax.stage.show.throws import throws_show

ROOT = Path(__file__).resolve().parents[2]
BALLS = 3


@cache
def graph() -> MotionGraph:
    """Of the embedded clips."""
    clips, labels = synthetic_clips()
    return build_graph(clips, labels=labels, config=EMBEDDED)


def avoidance(path: Path) -> None:
    """Balls one after another, each avoided."""
    throws, motion, _ = throw_balls(graph(), BALLS, seed=0)
    save_html(path, throws_show(graph(), motion, throws, title="Thrown at, and missed"))


def ballsport(path: Path) -> None:
    """The scene of three players."""
    save_html(path, build_scene(load_scene(ROOT / "configs" / "ballsport" / "three.toml")))


def hybrid(path: Path) -> None:
    """A walk along a curve; the right hand reaches for a place beside it."""
    sketch = make_sketch([[0, 0], [0, 3], [2, 5], [5, 5]], spline=True)
    target = make_target("right_hand", place=[0.3, 1.6, 4.0], when="passing")
    save_html(
        path, reach(graph(), sketch, (target,)), title="Along a curve, and a hand that reaches"
    )


PLAYERS: dict[str, Callable[[Path], None]] = {
    "avoidance": avoidance,
    "ballsport": ballsport,
    "hybrid": hybrid,
}


def make(folder: Path) -> None:
    """Makes those that are not there, or older than the package."""
    sources = [p for p in (ROOT / "mgjax").rglob("*.*") if p.suffix in (".py", ".js", ".css")]
    newest = max(p.stat().st_mtime for p in sources)
    folder.mkdir(parents=True, exist_ok=True)
    for name, made in PLAYERS.items():
        path = folder / f"{name}.html"
        if not path.exists() or path.stat().st_mtime < newest:
            enable_cache()
            made(path)
