"""Clips in groups of about one tile of frames, which stay as they are when clips are added."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mgjax.graph.stages.stages import Stages
from mgjax.graph.timeline import ClipTimeline
from mgjax.io.content_key import content_key

STAGE = "groups"

_OPEN = 16
"""Groups that are being filled at a time."""

_SMALL = 4
"""So many groups may be less than half full; with more of them, new clips join theirs."""


@dataclass(frozen=True, kw_only=True)
class Group:
    """Clips that are compared together.

    Attributes:
        key: names their content.
        members: names of the content of each.
        frames: of all of them, one after another, on the axis of all clips. [G]
        lengths: frames of each member.
    """

    key: str
    members: tuple[str, ...]
    frames: np.ndarray
    lengths: tuple[int, ...]


def corpus_groups(
    timeline: ClipTimeline, masks: Sequence[np.ndarray], stages: Stages, *, gap: int
) -> list[Group]:
    """Those of earlier builds, as far as all their clips are there, and new ones for the rest.

    Args:
        timeline: all clips.
        masks: what counts of a clip beside its motion. [F] each
        stages: where the groups of earlier builds are kept.
        gap: entries between two clips.
    """
    spans = [slice(a, b) for a, b in zip(timeline.starts, timeline.stops, strict=True)]
    motions = (timeline.root, timeline.rotations, timeline.plants, *masks)
    keys = unique_keys([content_key(*(each[span] for each in motions)) for span in spans])
    name = content_key(gap, stages.entries)
    kept = stages.load(STAGE, name)
    known = [] if kept is None else kept[1]["groups"]
    groups = group_clips(
        keys, timeline.starts, timeline.stops, known, gap=gap, entries=stages.entries
    )
    members = [list(group.members) for group in groups]
    if any(each not in known for each in members):
        rest = [each for each in known if each not in members]
        stages.save(STAGE, name, {}, {"groups": members + rest})
    return groups


def unique_keys(keys: Sequence[str]) -> list[str]:
    """The same keys, where the second of two equal ones has ``+1`` behind it, and so on."""
    seen: Counter[str] = Counter()
    unique = []
    for key in keys:
        unique.append(f"{key}+{seen[key]}" if seen[key] else key)
        seen[key] += 1
    return unique


def group_clips(
    keys: Sequence[str],
    starts: np.ndarray,
    stops: np.ndarray,
    known: Sequence[Sequence[str]] = (),
    *,
    gap: int,
    entries: int,
) -> list[Group]:
    """Groups of clips in the order of their keys.

    Args:
        keys: names of the content of the clips, each once.
        starts, stops: frames of the clips on their common axis.
        known: groups of earlier times, those preferred first; one that is whole stays as it is.
        gap: entries between two clips.
        entries: most of a group, with gaps; a longer clip is alone.
    """
    place = {key: number for number, key in enumerate(keys)}
    size = {key: int(stops[k] - starts[k]) + gap for key, k in place.items()}
    rest = dict.fromkeys(keys)
    chosen: list[list[str]] = []
    for members in known:
        if members and all(key in rest for key in members):
            chosen.append(list(members))
            for key in members:
                del rest[key]
    small = [m for m in chosen if sum(size[key] for key in m) < entries // 2]
    if rest and len(small) > _SMALL:
        chosen = [m for m in chosen if m not in small]
        rest |= dict.fromkeys(key for members in small for key in members)
    chosen += _packed(list(rest), size, entries)
    return sorted(
        (_group([place[key] for key in m], m, starts, stops) for m in chosen), key=lambda g: g.key
    )


def _packed(keys: list[str], size: dict[str, int], entries: int) -> list[list[str]]:
    """Each clip goes into the first open group that has room for it."""
    groups: list[list[str]] = []
    opened: list[tuple[list[str], list[int]]] = []
    for key in keys:
        for members, room in opened:
            if size[key] <= room[0]:
                members.append(key)
                room[0] -= size[key]
                break
        else:
            groups.append([key])
            opened.append((groups[-1], [entries - size[key]]))
            opened = opened[-_OPEN:]
    return groups


def _group(numbers: list[int], members: list[str], starts: np.ndarray, stops: np.ndarray) -> Group:
    spans = [np.arange(starts[k], stops[k]) for k in numbers]
    return Group(
        key=content_key(members),
        members=tuple(members),
        frames=np.concatenate(spans),
        lengths=tuple(len(span) for span in spans),
    )
