"""Folders of ``avoid`` and ``demo``."""

from __future__ import annotations

import zipfile
from pathlib import Path
from typing import Any

import numpy as np

from mgjax.core.errors import FileFormatError
from mgjax.io.load import load_motion
from mgjax.stage.show.body import body_of
from mgjax.stage.show.frames import frames_of
from mgjax.stage.show.standing import standing
from mgjax.stage.show.types import Actor, Ball, Bar, Show, Span
from mgjax.stage.show.walk import floor_path
from mgjax.stage.show.words import DROPPED, avoided_words, energy_bars, status_colour

_ABSENT_M = 500.0
"""A sphere that is not there is written as 1 km away."""


def avoid_folder(path: Path, result: dict[str, Any]) -> Show:
    """``result.json``, ``motion.bvh`` and ``volumes.npz`` of ``mgjax avoid``."""
    skeleton, motion = standing(*load_motion(path / "motion.bvh"))
    seconds = (motion.num_frames - 1) / motion.frame_rate
    spans, moments = walk_spans(result["walk"]), [("now", 0.0)]
    if result["part"] is not None:
        kind = kind_of(result["part"])
        first, last = float(result["part"]["start_s"]), float(result["part"]["end_s"])
        spans.append(Span(row="avoidance", start=first, end=last, text=kind, colour="green"))
        moments.append(("begins", first))
    if result["attack"] is not None:
        moments.append(("ball passes", float(result["attack"]["t_attack"])))
    if result.get("parry"):
        moments.append(("parried", float(result["parry"]["time_s"])))
    return Show(
        title="A throw",
        words=result_words(result),
        seconds=seconds,
        bodies=[body_of(skeleton)],
        actors=[Actor(id="body", body=0, frames=frames_of(motion))],
        balls=_balls(path / "volumes.npz"),
        lines=[floor_path("path", motion)],
        spans=spans,
        bars=bars_of(result["energy"]),
        notes=notes_of(result),
        moments=[(text, at) for text, at in moments if 0 <= at <= seconds],
    )


def demo_folder(path: Path, result: dict[str, Any]) -> Show:
    """``result.json`` and ``motion.bvh`` of ``mgjax demo``."""
    skeleton, motion = standing(*load_motion(path / "motion.bvh"))
    balls: list[Ball] = []
    spans: list[Span] = []
    for number, row in enumerate(result["balls"], 1):
        balls += [
            Ball(
                id=f"ball {number}.{i}",
                radius=float(flight["radius_m"]),
                times=np.array(flight["times_s"], float),
                places=np.array(flight["places_m"], float).reshape(-1, 3),
            )
            for i, flight in enumerate(row["flight"])
        ]
        if row["part"] is not None:
            part, now = row["part"], float(row["now_s"])
            colour = status_colour(row["status"])
            spans.append(
                Span(
                    row="avoidance", start=now + part["start_s"], end=now + part["end_s"],
                    text=kind_of(part), colour=colour,
                )
            )  # fmt: skip
    rows = result["balls"]
    return Show(
        title="mgjax demo",
        words=f"{int(result['avoided'])} of {len(rows)} balls avoided",
        seconds=(motion.num_frames - 1) / motion.frame_rate,
        bodies=[body_of(skeleton)],
        actors=[Actor(id="body", body=0, frames=frames_of(motion))],
        balls=balls,
        lines=[floor_path("path", motion)],
        spans=spans,
        notes=[(f"ball {number}", result_words(row)) for number, row in enumerate(rows, 1)],
    )


def kind_of(part: dict[str, Any]) -> str:
    """What an avoidance part does, such as ``duck``."""
    return f"{part['kind']} {part['direction']}".strip().replace("_", " ")


def result_words(result: dict[str, Any]) -> str:
    """The sentence of :func:`mgjax.stage.show.words.avoided_words`."""
    kind = None if result["part"] is None else kind_of(result["part"])
    limb = result["parry"]["limb"] if result.get("parry") else None
    return avoided_words(result["status"], kind, result["clearance_m"], limb)


def bars_of(energy: dict[str, Any] | None) -> list[Bar]:
    """Energies, if there are any."""
    if energy is None:
        return []
    return energy_bars({name: float(value) for name, value in energy.items()})


def notes_of(result: dict[str, Any]) -> list[tuple[str, str]]:
    """Candidates, why they were dropped, time scale, clearance."""
    notes = [("candidates", str(int(result["candidates"])))]
    dropped = {words: int(result["dropped"][name]) for name, words in DROPPED.items()}
    notes += [(words, str(count)) for words, count in dropped.items() if count]
    if result["time_scale"] is not None:
        notes.append(("time scale", f"{result['time_scale']:.2f}"))
    if result["clearance_m"] is not None:
        notes.append(("clearance", f"{100 * result['clearance_m']:.1f} cm"))
    return notes


def walk_spans(rows: list[dict[str, Any]]) -> list[Span]:
    """What a walk plays when; edges of one clip as one span."""
    spans: list[Span] = []
    for row in rows:
        blend = " > " in row["clip"]
        text = "transition" if blend else row["clip"].rsplit("/", 1)[-1].rsplit(".", 1)[0]
        colour = "sky" if blend else "blue" if row.get("path") else "grey"
        start, end = float(row["start_s"]), float(row["end_s"])
        if spans and (spans[-1].text, spans[-1].colour) == (text, colour):
            start = spans.pop().start
        spans.append(Span(row="walk", start=start, end=end, text=text, colour=colour))
    return spans


def _balls(path: Path) -> list[Ball]:
    try:
        with np.load(path, allow_pickle=False) as arrays:
            times, centres = arrays["times"], arrays["attack_centres"]
            radii = arrays["attack_radii"]
    except (OSError, ValueError, KeyError, zipfile.BadZipFile) as error:
        got = f"no volumes ({type(error).__name__})"
        raise FileFormatError(path, None, got, "what avoid writes") from None
    balls: list[Ball] = []
    for sphere, radius in enumerate(radii.tolist()):
        there = np.abs(centres[:, sphere]).max(axis=1) < _ABSENT_M
        if there.any():
            step = max(int(there.sum()) // 300, 1)
            kept = np.flatnonzero(there)
            kept = np.unique(np.append(kept[::step], kept[-1]))
            balls.append(
                Ball(
                    id=f"ball{sphere}", radius=float(radius), times=times[kept],
                    places=centres[kept, sphere],
                )
            )  # fmt: skip
    return balls
