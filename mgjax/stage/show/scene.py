"""Players who pass a ball to one another."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from mgjax.ballsport.ball.physics import Net
from mgjax.ballsport.scene.ball_track import BallTrack
from mgjax.ballsport.scene.build import Scene
from mgjax.ballsport.scene.report import scene_json
from mgjax.stage.show.body import body_of
from mgjax.stage.show.frames import frames_of
from mgjax.stage.show.types import Actor, Ball, Colour, Show, Span, Thing

COLOURS: tuple[Colour, ...] = ("blue", "orange", "green", "purple", "sky", "yellow")
"""Of the players, in turn."""
_NET_M = 4.0
"""Half the width of a net."""


def scene_show(scene: Scene, *, title: str = "Passing a ball") -> Show:
    """Players, ball and net; passes on the timeline, with their warps and misses."""
    report = scene_json(scene)
    actors = [
        Actor(
            id=name, body=0, frames=frames_of(motion), colour=COLOURS[i % len(COLOURS)], note=name
        )
        for i, (name, motion) in enumerate(scene.motions.items())
    ]
    rate = scene.frame_rate
    return Show(
        title=title,
        words=scene_words(report),
        seconds=(len(scene.ball.places) - 1) / rate,
        bodies=[body_of(scene.skeleton)],
        actors=actors,
        balls=[_ball(scene.ball, rate, float(scene.config.physics.radius))],
        things=net_things(scene.config.net),
        spans=pass_spans(report),
        notes=scene_notes(report),
        moments=[
            (f"{event.who} misses", float(event.time))
            for event in scene.ball.events
            if event.what == "miss"
        ],
    )


def _ball(track: BallTrack, rate: float, radius: float) -> Ball:
    """The ball at every other frame of 60 a second, and at each event."""
    step = max(round(rate / 30), 1)
    frames = np.unique(np.append(np.arange(0, len(track.places), step), len(track.places) - 1))
    rows = {float(f) / rate: track.places[f] for f in frames}
    rows |= {float(event.time): np.asarray(event.place) for event in track.events}
    times = sorted(rows)
    return Ball(
        id="ball",
        radius=radius,
        times=np.array(times),
        places=np.array([rows[time] for time in times]),
        colour="yellow",
    )


def net_things(net: Net | None) -> list[Thing]:
    """The net across the court, if there is one."""
    if net is None:
        return []
    heading, height = float(net.heading), float(net.height)
    along = np.array([math.cos(heading), 0.0, -math.sin(heading)])
    middle = np.array([float(net.x), height, float(net.z)])
    ends = [(middle + side * _NET_M * along).tolist() for side in (-1, 1)]
    return [Thing(id="net", shape="net", place=ends[0], end=ends[1], colour="grey")]


def scene_words(report: dict[str, Any]) -> str:
    """How many passes were made."""
    made, missed = int(report["passes_made"]), int(report["passes_missed"])
    text = f"{made} of {made + missed} passes made"
    off = 1000 * report["worst"]["arrival_miss_m"]
    return f"{text}; the ball arrives within {off:.2f} mm of the foot"


def pass_spans(report: dict[str, Any]) -> list[Span]:
    """One span for each pass and throw, in the row of who gets the ball."""
    spans: list[Span] = []
    for row in [*report["throws"], *report["passes"]]:
        missed = "arrival_miss_m" not in row
        by = f"from {row['by']}" if row["by"] else "thrown in"
        text = f"{by}, {int(row['bounces'])} bounces"
        if missed:
            text += f": {row['status']}, {row['miss_m']:.2f} m off"
        elif "time_warp" in row:
            text += f", links × {row['time_warp']:.2f}"
        spans.append(
            Span(
                row=f"to {row['to']}" if row["to"] else "to nobody",
                start=row["start_s"],
                end=row["arrives_s"],
                text=text,
                colour="red" if missed else "grey" if not row["by"] else "green",
            )
        )
    return sorted(spans, key=lambda span: (span.row, span.start))


def scene_notes(report: dict[str, Any]) -> list[tuple[str, str]]:
    """The worst of everything."""
    worst = report["worst"]
    notes = [
        ("passes missed", str(int(report["passes_missed"]))),
        ("kicks changed", f"{100 * report['mean_kick_change']:.0f} % of the bone's speed"),
        ("pace of links", f"{worst['time_warp']:.2f} at most"),
        ("ball to foot", f"{1000 * worst['surface_gap_m']:.2f} mm at most"),
        ("drift", f"{100 * worst['drift_m']:.0f} cm at most"),
    ]
    if worst["least_distance_to_others_m"] is not None:
        notes.append(("ball to others", f"{worst['least_distance_to_others_m']:.2f} m at least"))
    return notes
