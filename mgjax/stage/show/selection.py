"""An attack and what the character did about it."""

from __future__ import annotations

from dataclasses import asdict

import numpy as np

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.choice.results import Choice
from mgjax.avoidance.choice.selection import Selection
from mgjax.avoidance.timing.walk_warps import natural_starts, part_moments
from mgjax.graph.types import MotionGraph
from mgjax.stage.show.body import body_of
from mgjax.stage.show.frames import frames_of
from mgjax.stage.show.types import Actor, Ball, Show, Span
from mgjax.stage.show.walk import edge_spans, floor_path
from mgjax.stage.show.words import DROPPED, avoided_words, energy_bars


def selection_show(
    graph: MotionGraph, attack: Attack, selection: Selection, *, title: str = "A throw"
) -> Show:
    """The motion of a selection, its attack, and why it was chosen.

    Time begins where the character has to react ("now"); places are in the planar frame of its pose
    then. An attack that is parried ends where it is met.
    """
    if selection.parry is not None:
        attack = selection.parry.left_of(attack)
    starts = np.asarray(selection.timing.when(natural_starts(graph, selection.walk)))
    spans = edge_spans(graph, selection.walk, starts, path_length=selection.path_length)
    moments: list[tuple[str, float]] = [("now", 0.0)]
    if selection.part is not None:
        kind = part_words(graph, selection.part)
        captured = part_moments(graph, selection.walk, selection.path_length, selection.part)
        first, _, last = (float(t) for t in selection.timing.when(captured))
        spans.append(Span(row="avoidance", start=first, end=last, text=kind, colour="green"))
        moments.append(("begins", first))
    if selection.crop is not None:
        moments.append(("ball passes", selection.crop.middle))
    if selection.parry is not None:
        moments.append(("parried", selection.parry.time))
    seconds = (selection.motion.num_frames - 1) / selection.motion.frame_rate
    energy = selection.energy
    return Show(
        title=title,
        words=selection_words(graph, selection),
        seconds=seconds,
        bodies=[body_of(graph.skeleton)],
        actors=[Actor(id="body", body=0, frames=frames_of(selection.motion))],
        balls=attack_balls(attack),
        lines=[floor_path("path", selection.motion)],
        spans=spans,
        bars=[] if energy is None else energy_bars(asdict(energy)),
        notes=selection_notes(selection),
        moments=[(text, at) for text, at in moments if 0 <= at <= seconds],
    )


def part_words(graph: MotionGraph, part: int) -> str:
    """What an avoidance part does, such as ``duck`` or ``sway left``."""
    return f"{graph.label_kind[part]} {graph.label_direction[part]}".strip().replace("_", " ")


def selection_words(graph: MotionGraph, choice: Choice) -> str:
    """What came of an attack, in one sentence."""
    kind = None if choice.part is None else part_words(graph, choice.part)
    limb = None if choice.parry is None else choice.parry.limb
    return avoided_words(choice.status, kind, choice.clearance_m, limb)


def selection_notes(choice: Choice) -> list[tuple[str, str]]:
    """Figures of a choice: candidates, why they were dropped, time scale, clearance."""
    notes = [("candidates", str(choice.candidates))]
    for name, words in DROPPED.items():
        if count := getattr(choice.dropped, name):
            notes.append((words, str(count)))
    if choice.time_scale is not None:
        notes.append(("time scale", f"{choice.time_scale:.2f}"))
    if choice.clearance_m is not None:
        notes.append(("clearance", f"{100 * choice.clearance_m:.1f} cm"))
    if choice.parry is not None:
        moved, turned = choice.parry.largest_m, choice.parry.largest_deg
        notes.append(("arm led by", f"{100 * moved:.0f} cm, {turned:.0f}°"))
    if choice.clear_until is not None:
        notes.append(("clear until", f"{choice.clear_until:.2f} s"))
    return notes


def attack_balls(attack: Attack, *, name: str = "ball", now: float = 0.0) -> list[Ball]:
    """A ball for each sphere of an attack, there from its first moment after now to its last."""
    balls: list[Ball] = []
    for sphere, (start, stop) in enumerate(zip(*attack.lifetimes, strict=True)):
        begin = max(float(start), 0.0)
        if stop < begin:
            continue
        inside = attack.times[(attack.times > begin) & (attack.times < stop)]
        times = np.unique(np.concatenate([[begin], inside, [float(stop)]]))
        places = attack.at(times)[:, sphere]
        kept = _bends(times, places)
        balls.append(
            Ball(
                id=f"{name}{sphere}" if len(attack.radii) > 1 else name,
                radius=float(attack.radii[sphere]),
                times=times[kept] + now,
                places=places[kept],
            )
        )
    return balls


def _bends(times: np.ndarray, places: np.ndarray) -> np.ndarray:
    """The moments without which a straight way between the others would be off by 1 mm."""
    kept = [0]
    last = len(times) - 1
    while kept[-1] < last:
        begin, end = kept[-1], min(kept[-1] + 1, last)
        while end < last and _straight(times, places, begin, end + 1):
            end += 1
        kept.append(end)
    return np.array(kept)


def _straight(times: np.ndarray, places: np.ndarray, begin: int, end: int) -> bool:
    inner = slice(begin + 1, end)
    share = (times[inner] - times[begin]) / (times[end] - times[begin])
    line = places[begin] + share[:, None] * (places[end] - places[begin])
    return bool(np.abs(places[inner] - line).max(initial=0.0) < 1e-3)
