"""Paths from one link motion to another: which sections to leave and enter by, and how long."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from mgjax.ballsport.clipset.repertoire import Repertoire

NO_HOP = -1


@dataclass(frozen=True, kw_only=True, eq=False)
class LinkPaths:
    """Many paths on from where a player is.

    Attributes:
        frames: from where the player is to the entry of the last link motion. [C]
        cost: D_p of a frame in each section on it, summed, m. [C]
        hops: first frames of the sections left and entered, in order; ``NO_HOP`` behind them.
            [C, H, 2]
    """

    frames: Int[np.ndarray, " C"]
    cost: Float[np.ndarray, " C"]
    hops: Int[np.ndarray, "C H 2"]

    @property
    def entry(self) -> Int[np.ndarray, " C"]:
        """Frame of the clip set at which the last link motion is entered."""
        last = np.maximum((self.hops[:, :, 0] != NO_HOP).sum(axis=1) - 1, 0)
        return self.hops[np.arange(len(last)), last, 1]

    def picked(self, rows: np.ndarray) -> LinkPaths:
        """The link paths in some rows."""
        return LinkPaths(frames=self.frames[rows], cost=self.cost[rows], hops=self.hops[rows])


_MOST_HOPS = 4
_NEAREST = 6
"""Places of the idle motion that are gone to from one place: those with the smoothest sections."""


def find_link_paths(
    moves: Repertoire,
    run: int,
    frame: int,
    earliest: int,
    targets: np.ndarray,
    *,
    turn: int,
    most: int,
) -> LinkPaths:
    """All paths with at most one stop in the idle motion and, where one is asked for, one turn.

    Args:
        moves: what can be done.
        run: that is being played.
        frame: of the clip set, from which ``frames`` of the result counts.
        earliest: frame of the clip set from which on the run may be left.
        targets: parts to arrive in.
        turn: degrees in between; 0: none.
        most: largest number of frames.
    """
    own, rest = np.flatnonzero(moves.runs == run), np.array([moves.rest])
    here = _here(frame)
    now = np.array([earliest])
    idle = _best(_hop(moves, here, now, own, moves.idle, most, nearest=_NEAREST))
    again = idle.entry + moves.window
    if not turn:
        direct = _hop(moves, here, now, own, targets, most)
        return _together(direct, _hop(moves, idle, again, moves.idle, targets, most))
    soon = _turned(moves, _best(_hop(moves, here, now, own, rest, most)), turn)
    late = _turned(moves, _best(_hop(moves, idle, again, moves.idle, rest, most)), turn)
    direct = _from_rest(moves, _together(soon, late), targets)
    waiting = _best(_from_rest(moves, soon, _near_rest(moves)))
    later = _hop(moves, waiting, waiting.entry + moves.window, moves.idle, targets, most)
    paths = _together(direct, later)
    return paths.picked(paths.frames <= most)


def _best(paths: LinkPaths) -> LinkPaths:
    """Keeps the cheapest of the paths that come to one frame after as long."""
    order = np.lexsort((paths.cost, paths.frames, paths.entry))
    key = np.stack([paths.entry[order], paths.frames[order]], axis=1)
    new = np.ones(len(order), bool)
    new[1:] = (key[1:] != key[:-1]).any(axis=1)
    return paths.picked(order[new])


def _near_rest(moves: Repertoire) -> np.ndarray:
    """Parts of the idle motion that follow best on the rest pose."""
    return moves.idle[np.argsort(moves.distance[moves.rest, moves.idle])[:_NEAREST]]


def _here(frame: int) -> LinkPaths:
    """No hop yet; the entry of it is where the player is."""
    hops = np.full((1, _MOST_HOPS, 2), NO_HOP, np.int64)
    hops[0, 0, 1] = frame
    return LinkPaths(frames=np.zeros(1, np.int64), cost=np.zeros(1), hops=hops)


def _count(paths: LinkPaths) -> np.ndarray:
    return (paths.hops[:, :, 0] != NO_HOP).sum(axis=1)


def _hop(
    moves: Repertoire,
    paths: LinkPaths,
    earliest: np.ndarray,
    parts: np.ndarray,
    targets: np.ndarray,
    most: int,
    nearest: int = 0,
) -> LinkPaths:
    """One more hop: from the parts of the run that was entered last to the targets.

    ``nearest``: to so many from each part; 0: to all.
    """
    leave, distance = (x[parts][:, targets] for x in (moves.leave, moves.distance))
    usable = np.isfinite(distance)
    if nearest:
        usable &= np.argsort(np.argsort(distance, axis=1), axis=1) < nearest
    frames = paths.frames[:, None, None] + leave - paths.entry[:, None, None]
    fits = usable & (leave >= earliest[:, None, None]) & (frames <= most)
    row, part, target = np.nonzero(fits)
    cost = paths.cost[row] + moves.distance[parts[part], targets[target]]
    arrive = moves.arrive[parts[part], targets[target]]
    return _added(paths, row, frames[fits], cost, leave[part, target], arrive)


def _added(
    paths: LinkPaths,
    row: np.ndarray,
    frames: np.ndarray,
    cost: np.ndarray,
    leave: np.ndarray,
    arrive: np.ndarray,
) -> LinkPaths:
    hops, count = paths.hops[row].copy(), _count(paths)[row]
    hops[np.arange(len(row)), count] = np.stack([leave, arrive], axis=-1)
    return LinkPaths(frames=frames, cost=cost, hops=hops)


def _turned(moves: Repertoire, paths: LinkPaths, turn: int) -> LinkPaths:
    """Paths that end in the rest pose, played on through a turn up to the section after it."""
    start, stop = moves.turns[turn]
    hops, last = paths.hops.copy(), _count(paths) - 1
    hops[np.arange(len(last)), last, 1] = start
    frames = paths.frames + stop - moves.window - start
    return LinkPaths(frames=frames, cost=paths.cost, hops=hops)


def _from_rest(moves: Repertoire, paths: LinkPaths, targets: np.ndarray) -> LinkPaths:
    """On from the end of a turn, whose last frames are the rest pose."""
    row = np.repeat(np.arange(len(paths.frames)), len(targets))
    target = np.tile(targets, len(paths.frames))
    leaves = {start: stop - moves.window for start, stop in moves.turns.values()}
    leave = np.array([leaves[int(e)] for e in paths.entry], np.int64)[row]
    cost = paths.cost[row] + moves.distance[moves.rest, target]
    return _added(paths, row, paths.frames[row], cost, leave, moves.arrive[moves.rest, target])


def _together(a: LinkPaths, b: LinkPaths) -> LinkPaths:
    return LinkPaths(
        frames=np.concatenate([a.frames, b.frames]),
        cost=np.concatenate([a.cost, b.cost]),
        hops=np.concatenate([a.hops, b.hops]),
    )
