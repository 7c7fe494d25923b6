"""The pictures of the stage: the moving one of README.md, pages of results, and the applications.

    python -m experiments.pictures.make [--applications OUT]

The moving picture and the pages come from Python objects through :mod:`mgjax.stage.film`; with
``--applications`` each application is started and photographed at two sizes. All need a Chromium.
"""

from __future__ import annotations

import argparse
import io
from dataclasses import replace
from pathlib import Path

import numpy as np
from PIL import Image

from experiments.pictures.applications import photograph
from mgjax.avoidance.attacks.ball import ball_from
from mgjax.avoidance.choice.selection import select
from mgjax.avoidance.config import AvoidanceConfig
from mgjax.avoidance.play.timeline import Timeline
from mgjax.avoidance.rates import EXPORT_RATE
from mgjax.clips.synthetic import synthetic_clips
from mgjax.graph.build import build_graph
from mgjax.graph.config import GraphConfig
from mgjax.graph.feet.course import turned
from mgjax.graph.types import MotionGraph
from mgjax.hybrid.paths.search import follow
from mgjax.hybrid.paths.sketch import make_sketch
from mgjax.io.output import replace_file
from mgjax.stage.film import pictures, pixels_of
from mgjax.stage.show.of import show_of
from mgjax.stage.show.throws import Thrown, throws_show
from mgjax.stage.show.types import Show

HERE = Path(__file__).parent
MOVING = HERE / "throws.gif"
SIZE, RATE, COLOURS = (640, 360), 12, 128
HEIGHTS_M = (1.4, 1.5, 0.9)
TRIES = 120
PAGE = (1180, 664)


def main() -> None:
    """Makes all pictures anew."""
    parser = argparse.ArgumentParser(description="Pictures of the stage.")
    parser.add_argument("--applications", type=Path, help="folder for pictures of applications")
    arguments = parser.parse_args()
    clips, labels = synthetic_clips()
    graph = build_graph(clips, labels=labels, config=GraphConfig(threshold_m=0.05))
    show = dodged(graph)
    save_moving(MOVING, show, seconds=show.seconds)
    sketch = make_sketch([[0, 0], [0, 3], [2, 5], [5, 5]], spline=True, obstacles=[[1.0, 5.5, 0.3]])
    save_page(HERE / "page_path.png", show_of(follow(graph, sketch)), 6.0)
    if arguments.applications is not None:
        photograph(arguments.applications)
        for app in ("throw", "sketch", "match", "edit"):
            small = Image.open(arguments.applications / f"{app}_wide.png").convert("RGB")
            data = io.BytesIO()
            small.quantize(128).save(data, "png", optimize=True)
            replace_file(HERE / f"page_{app}.png", data.getvalue())


def dodged(graph: MotionGraph) -> Show:
    """Balls one after another, all of them avoided: others are thrown until they are."""
    # The motions follow one another at natural speed, as their walks are.
    config = AvoidanceConfig(warp="linear", refine="off")
    rng = np.random.default_rng(0)
    line = Timeline(graph, int(rng.integers(graph.num_nodes)))
    throws: list[Thrown] = []
    for tried in range(TRIES):
        height = HEIGHTS_M[len(throws)]
        ball = ball_from(float(rng.uniform(-1.3, 1.3)), height)
        place, now = line.frame_at_end(), line.end
        feet = turned(line.feet_at_end(), -float(place[0]))
        chosen = select(graph, line.node, ball, config=config, seed=tried, begin=feet)
        if chosen.status != "avoided" or not 0.01 < (chosen.clearance_m or 0.0) < 0.4:
            if not throws:
                line = Timeline(graph, int(rng.integers(graph.num_nodes)))
            continue
        throws.append(Thrown(now=now, attack=ball, selection=chosen, place=place))
        for edge, scale in zip(chosen.walk.edges, chosen.walk.scales, strict=True):
            line.append(int(edge), float(scale))
        if len(throws) == len(HEIGHTS_M):
            break
    times = np.arange(int(np.ceil(line.end * EXPORT_RATE - 1e-6)) + 1) / EXPORT_RATE
    motion = replace(line.sample(times), frame_rate=EXPORT_RATE)
    return throws_show(graph, motion, throws, title="Throws")


def save_moving(path: Path, show: Show, *, seconds: float) -> None:
    """A GIF that goes on for ever."""
    times = (np.arange(int(seconds * RATE)) / RATE).tolist()
    frames = [Image.fromarray(pixels_of(data)) for data in pictures(show, times, size=SIZE)]
    palette = _together(frames).quantize(COLOURS)
    few = [frame.quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames]
    data = io.BytesIO()
    few[0].save(
        data, "gif", save_all=True, append_images=few[1:], duration=round(1000 / RATE), loop=0,
        optimize=True,
    )  # fmt: skip
    replace_file(path, data.getvalue())
    print(f"{path.name}: {len(few)} frames, {len(data.getvalue()) / 1e6:.2f} MB", flush=True)


def _together(frames: list[Image.Image]) -> Image.Image:
    """Some frames in one picture, with much of the ball's colour: the ball is small."""
    some = frames[:: max(len(frames) // 8, 1)]
    whole = Image.new("RGB", (SIZE[0], SIZE[1] * len(some) + 40), (230, 159, 0))
    for number, frame in enumerate(some):
        whole.paste(frame, (0, SIZE[1] * number))
    return whole


def save_page(path: Path, show: Show, time: float) -> None:
    """A picture of the whole page, with its words, in few colours."""
    (picture,) = pictures(show, [float(time)], size=PAGE, plain=False)
    data = io.BytesIO()
    Image.open(io.BytesIO(picture)).convert("RGB").quantize(128).save(data, "png", optimize=True)
    replace_file(path, data.getvalue())
    print(f"{path.name}: {len(data.getvalue()) / 1e3:.0f} kB", flush=True)


if __name__ == "__main__":
    main()
