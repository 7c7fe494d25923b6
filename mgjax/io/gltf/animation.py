"""The animation of a GLB file, evaluated at any times (glTF 2.0, section 3.11 and appendix C)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float

from mgjax.core import quaternion
from mgjax.io.gltf.accessors import read_accessor
from mgjax.io.gltf.document import Document

_WIDTHS = {"translation": 3, "rotation": 4, "scale": 3}
_SNAP = 1e-3
"""A time this near to a key, as a share of the gap between keys, is meant to be at the key."""


@dataclass(frozen=True, kw_only=True)
class Track:
    """How one property of one node moves.

    Attributes:
        times: of the keys, s, rising.
        values: at the keys; rotations wxyz.
        before, after: tangents that arrive at and leave the keys, per second; splines only.
        step: held until the next key instead of going there.
    """

    times: Float[np.ndarray, " K"]
    values: Float[np.ndarray, "K width"]
    before: Float[np.ndarray, "K width"] | None
    after: Float[np.ndarray, "K width"] | None
    step: bool


Tracks = dict[tuple[int, str], Track]
"""By node and property: ``translation``, ``rotation`` or ``scale``."""


def animated_nodes(document: Document) -> list[set[int]]:
    """For each animation, the nodes that it moves."""
    count = len(document.objects(document.json, "nodes"))
    moved: list[set[int]] = []
    for item in document.objects(document.json, "animations"):
        targets = [
            document.object(channel, "target") for channel in document.objects(item, "channels")
        ]
        moved.append(
            {
                document.whole(target, "node", count, None)
                for target in targets
                if "node" in target and document.text(target, "path", "") in _WIDTHS
            }
        )
    return moved


def read_tracks(document: Document, animation: dict[str, Any], wanted: set[int]) -> Tracks:
    """The tracks of the wanted nodes."""
    samplers = document.objects(animation, "samplers")
    count = len(document.objects(document.json, "nodes"))
    tracks: Tracks = {}
    for channel in document.objects(animation, "channels"):
        target = document.object(channel, "target")
        path = document.text(target, "path", "none")
        if path not in _WIDTHS or "node" not in target:
            continue
        node = document.whole(target, "node", count, None)
        if node in wanted:
            sampler = samplers[document.whole(channel, "sampler", len(samplers), None)]
            tracks[node, path] = _read_track(document, sampler, path)
    return tracks


def _read_track(document: Document, sampler: dict[str, Any], path: str) -> Track:
    accessors = len(document.objects(document.json, "accessors"))
    times = read_accessor(document, document.whole(sampler, "input", accessors, None), 1)[:, 0]
    width = _WIDTHS[path]
    values = read_accessor(document, document.whole(sampler, "output", accessors, None), width)
    kind = document.text(sampler, "interpolation", "LINEAR")
    if kind not in ("LINEAR", "STEP", "CUBICSPLINE"):
        document.refuse(f"interpolation {kind!r}", "LINEAR, STEP or CUBICSPLINE")
    spline = kind == "CUBICSPLINE"
    if not len(times) or len(values) != len(times) * (3 if spline else 1):
        got = f"{len(times)} times and {len(values)} values of a {kind} sampler"
        document.refuse(got, "as many values, or three for each time of a CUBICSPLINE")
    if times[0] < 0 or (np.diff(times) <= 0).any():
        document.refuse("times of keys that do not rise", "rising times from 0 s on")
    if path == "rotation":
        values = values[:, [3, 0, 1, 2]]
    before, after = (values[0::3], values[2::3]) if spline else (None, None)
    values = values[1::3] if spline else values
    if path == "rotation":
        values = _unit(document, values)
    return Track(times=times, values=values, before=before, after=after, step=kind == "STEP")


def _unit(document: Document, values: np.ndarray) -> np.ndarray:
    """Unit quaternions; those that are, up to float32, stay just as they are."""
    lengths = np.linalg.norm(values, axis=-1, keepdims=True)
    if not ((lengths > 0.5) & (lengths < 2)).all():
        document.refuse("a rotation that is no unit quaternion", "unit quaternions")
    return np.where(np.abs(lengths - 1) <= 5e-6, values, values / lengths)


def evaluate(track: Track, path: str, times: np.ndarray) -> np.ndarray:
    """[T, width] values at the given times; before the first key and after the last they hold."""
    keys = track.times
    if len(keys) == 1:
        return np.repeat(track.values, len(times), axis=0)
    low = np.clip(np.searchsorted(keys, times, side="right") - 1, 0, len(keys) - 2)
    gap = keys[low + 1] - keys[low]
    share = (times - keys[low]) / gap
    # Keys are stored as float32: the grid's times miss them by up to that rounding.
    near = np.minimum(_SNAP + np.finfo(np.float32).eps * np.abs(times) / gap, 0.5)
    share = np.where(np.abs(share - np.round(share)) <= near, np.round(share), share)
    share = np.clip(share, 0.0, 1.0)[:, None]
    at_start, at_end = share == 0, share == 1
    first, second = track.values[low], track.values[low + 1]
    if track.step:
        between = first
    elif track.before is not None and track.after is not None:
        between = _hermite(
            first, track.after[low] * gap[:, None], second, track.before[low + 1] * gap[:, None],
            share,
        )  # fmt: skip
        between = quaternion.normalise(between) if path == "rotation" else between
    elif path == "rotation":
        between = quaternion.slerp(first, second, share[:, 0])
    else:
        between = first * (1 - share) + second * share
    return np.asarray(np.where(at_start, first, np.where(at_end, second, between)))


def _hermite(
    first: np.ndarray, leaving: np.ndarray, second: np.ndarray, arriving: np.ndarray, t: np.ndarray
) -> np.ndarray:
    """Cubic Hermite spline; tangents are per gap."""
    return (
        (2 * t**3 - 3 * t**2 + 1) * first
        + (t**3 - 2 * t**2 + t) * leaving
        + (3 * t**2 - 2 * t**3) * second
        + (t**3 - t**2) * arriving
    )


def key_rate(tracks: Sequence[Track], stated: float | None) -> float | None:
    """Frames per second of the grid on which all keys lie, 20 … 1000, or None.

    Args:
        tracks: whose keys are looked at.
        stated: what the file says of itself; taken where the keys lie on its grid, which they do
            not where a program has moved them since.
    """
    times = np.unique(np.concatenate([track.times for track in tracks]))
    if stated is not None and _on_grid(times, stated):
        return stated
    gaps = np.diff(times)
    if not gaps.size:
        return None
    smallest = float(gaps.min())
    count = round(float(times[-1]) / smallest)
    rate = count / float(times[-1])
    whole = float(round(rate))
    if whole > 0 and _on_grid(times, whole):
        rate = whole
    return rate if 20 <= rate <= 1000 and _on_grid(times, rate) else None


def _on_grid(times: np.ndarray, rate: float) -> bool:
    frames = times * rate
    miss = np.abs(frames - np.round(frames))
    return bool((miss <= 0.02 + 4 * np.finfo(np.float32).eps * frames).all())
