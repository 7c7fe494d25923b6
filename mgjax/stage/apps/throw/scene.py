"""The live scene from scratch."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from mgjax.stage.apps.throw.lane import COLOURS, RATE, Lane
from mgjax.stage.show.body import body_of
from mgjax.stage.show.frames import frames_of
from mgjax.stage.show.types import Actor, Show

BACK_S = 0.3
"""So much of the past is there, too: the page is a little behind."""


def live_show(lanes: Sequence[Lane], now: float) -> Show:
    """The characters with the frames around ``now``, s, that are final."""
    actors: list[Actor] = []
    for lane in lanes:
        lane.tick()
        final = int(np.floor(lane.planner.timeline.deadline * RATE))
        first = max(int(np.floor((now - BACK_S) * RATE)), 0)
        times = np.arange(first, max(final, first + 1) + 1) / RATE
        motion = replace(lane.planner.timeline.sample(times), frame_rate=RATE)
        actors.append(
            Actor(
                id=lane.actor_id,
                body=0,
                frames=frames_of(motion, start=float(times[0]), rate=RATE, delta=False),
                colour=COLOURS[lane.number],
                note="" if len(lanes) == 1 else "AB"[lane.number],
            )
        )
    body = body_of(lanes[0].prepared.graph.skeleton)
    return Show(title="Throw", seconds=0.0, bodies=[body], actors=actors)
