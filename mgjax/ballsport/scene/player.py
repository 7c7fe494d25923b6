"""One player of a scene: what has been played and is certain, and where the player then stands."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from jaxtyping import Float

from mgjax.ballsport.clipset.joining import join
from mgjax.ballsport.clipset.repertoire import TURN_DEG, Repertoire
from mgjax.ballsport.scene.kick import Kick
from mgjax.ballsport.scene.link_paths import NO_HOP, LinkPaths, find_link_paths
from mgjax.core import planar
from mgjax.core.motion import Motion, sample
from mgjax.core.timing.time_warp import even_warp

MOST_WARP = 1.12
"""Largest factor by which link motion before a hit is played faster or slower."""
SLACK_DEG = 12.0
"""A hit that is off by no more is not turned to; the ball leaves that much aside."""
LONG_S = 4.5
"""Longest way to a hit or to idling that is looked for, s."""
_LATE_COST = 0.1
"""What a second of waiting counts beside a metre of D_p where a player turns or goes to idle."""
_LINGER_S = 4.0
"""The idle motion is begun again before less than this is left of it, s."""


@dataclass(kw_only=True, eq=False)
class Actor:
    """A player. Times are frames of the scene, frames those of the clip set.

    Attributes:
        moves: what can be done.
        pieces: start and stop frames, for :func:`mgjax.ballsport.clipset.joining.join`; the last
            goes on as long as its run does.
        placements: planar transforms of the pieces.
        run: that is being played.
        frame: where in it the account stands.
        earliest: frame from which on the run may be left.
        time: when ``frame`` is played.
        source: number of ``frame`` in the joined motion, before any time warp.
        knots: pairs of source and time between which the motion is warped evenly.
        turns: time and degrees of the turns on the spot.
    """

    moves: Repertoire
    pieces: list[list[int]]
    placements: list[Float[np.ndarray, "3"]]
    run: int
    frame: int
    earliest: int
    time: int = 0
    source: int = 0
    knots: list[tuple[float, float]] = field(default_factory=lambda: [(0.0, 0.0)])
    turns: list[tuple[int, int]] = field(default_factory=list)

    @property
    def stand(self) -> Float[np.ndarray, "3"]:
        """Planar frame of the body where the account stands: heading, x and z."""
        plane = np.asarray(self.moves.clips.planes[self.frame], np.float64)
        return np.asarray(planar.compose(self.placements[-1], plane))

    def turn_to(self, heading: float) -> int:
        """The stored turn that leads nearest to a heading, degrees; 0: none."""
        off = np.degrees(_wrapped(heading - self.stand[0]))
        if abs(off) <= SLACK_DEG:
            return 0
        return int(np.clip(round(off / TURN_DEG) * TURN_DEG, -180, 180))

    def copy(self) -> Actor:
        """A player of its own that goes on from here."""
        return replace(
            self,
            pieces=[list(piece) for piece in self.pieces],
            placements=list(self.placements),
            knots=list(self.knots),
            turns=list(self.turns),
        )

    def link_paths(self, targets: np.ndarray, *, now: int, turn: int) -> LinkPaths:
        """The link paths to some parts that begin no earlier than now."""
        earliest = max(self.earliest, self.frame + now - self.time)
        most = max(now - self.time, 0) + round(LONG_S * self.moves.frame_rate)
        return find_link_paths(
            self.moves, self.run, self.frame, earliest, targets, turn=turn, most=most
        )

    def placed(self, hops: np.ndarray) -> Float[np.ndarray, "3"]:
        """The placement after some hops."""
        return self._placements(hops)[-1]

    def _placements(self, hops: np.ndarray) -> list[Float[np.ndarray, "3"]]:
        """The placement now, and after each hop."""
        out = [self.placements[-1]]
        for leave, enter in _real(hops):
            out.append(np.asarray(planar.compose(out[-1], self.moves.seam(leave, enter))))
        return out

    def go(self, paths: LinkPaths, row: int) -> None:
        """Goes one of the link paths, at the speed of the clips."""
        hops = _real(paths.hops[row])
        self.placements += self._placements(paths.hops[row])[1:]
        window = self.moves.window
        for leave, enter in hops:
            self.pieces[-1][1] = leave + window
            self.pieces.append([enter, enter])
        entry = hops[-1][1]
        owner = int(np.flatnonzero((self.moves.starts <= entry) & (entry < self.moves.stops))[0])
        self.run = int(self.moves.runs[owner])
        self.pieces[-1][1] = self.moves.run_stops[self.run]
        self._account(entry, int(paths.frames[row]))
        self.earliest = entry + window

    def idle_until(self, now: int, *, since: int = 0) -> None:
        """Sees to it that there is idle motion left after now; begins it again where not.

        What is played before ``since`` stays as it is.
        """
        linger = round(_LINGER_S * self.moves.frame_rate)
        idle = self.moves.idle
        while self.run != int(self.moves.runs[idle[0]]) or (
            self.frame + now - self.time + linger > self.moves.run_stops[self.run]
        ):
            early = idle[: max(1, len(idle) // 3)]
            paths = self.link_paths(early, now=max(self.time, since), turn=0)
            late = paths.frames / self.moves.frame_rate
            wait = np.maximum((now - self.time) / self.moves.frame_rate - late, 0.0)
            self.go(paths, int(np.argmin(paths.cost + _LATE_COST * (late + 2 * wait))))

    def leave_in_time(self, now: int) -> None:
        """Goes to the idle motion if the run cannot be left for it any more from now on."""
        idle = self.moves.idle
        leave = self.moves.leave[self.moves.runs == self.run][:, idle]
        if not (leave >= max(self.earliest, self.frame + now - self.time)).any():
            self.idle_until(max(now, self.time))

    def face(self, heading: float, *, now: int, tolerance: float) -> None:
        """Turns on the spot by stepping, if the heading is further off than the tolerance, rad."""
        if abs(_wrapped(heading - self.stand[0])) <= tolerance:
            return
        self.leave_in_time(now)
        turn = self.turn_to(heading)
        early = self.moves.idle[: max(1, len(self.moves.idle) // 2)]
        paths = self.link_paths(early, now=now, turn=turn)
        row = int(np.argmin(paths.cost + _LATE_COST * paths.frames / self.moves.frame_rate))
        enters = paths.hops[row, :, 1].tolist()
        begun = enters.index(self.moves.turns[turn][0])
        self.turns.append((self._when(paths.hops[row, : begun + 1]), turn))
        self.go(paths, row)

    def _when(self, hops: np.ndarray) -> int:
        """Time at which the last of some hops begins."""
        time, frame = self.time, self.frame
        for leave, enter in hops.tolist():
            time, frame = time + leave - frame, enter
        return time

    def hit(self, paths: LinkPaths, row: int, kick: Kick, *, now: int, time: int) -> float:
        """Goes one of the paths to a hit that meets the ball at a time; returns the warp.

        The warp is how many times faster than captured the link motion from now to the first frame
        of S_H is played. The hit itself is not warped.
        """
        clips = self.moves.clips
        begin = max(now, self.time)
        source = self.source + begin - self.time
        start = int(clips.hit_starts[kick.hit])
        self.go(paths, row)
        self.source += start - self.frame
        self.time = time - (kick.frame - start)
        warp = (self.source - source) / (self.time - begin)
        self.knots += [(float(source), float(begin)), (float(self.source), float(self.time))]
        stop = int(clips.hit_stops[kick.hit])
        self.frame, self.run = start, self.moves.after[kick.hit]
        self._account(stop, stop - start)
        self.pieces[-1][1] = self.moves.run_stops[self.run]
        self.earliest = stop
        return warp

    def _account(self, frame: int, later: int) -> None:
        self.frame, self.time, self.source = frame, self.time + later, self.source + later

    def motion(self, frames: int) -> tuple[Motion, Float[np.ndarray, "S 2"]]:
        """The motion of the scene's first frames, and the seams in it, start and stop in frames."""
        self.idle_until(frames)
        pieces = [(a, b) for a, b in self.pieces]
        clips, window = self.moves.clips, self.moves.window
        joined = join(clips, pieces, window=window, placement=self.placements[0])
        source, time = np.array([*self.knots, (self.source, self.time)], np.float64).T
        where = even_warp(time, source).at(np.arange(frames, dtype=np.float64))
        # The inverse of an even warp is another one.
        ends = joined.seams.ravel().astype(np.float64)
        seams = np.asarray(even_warp(source, time).at(ends)).reshape(-1, 2)
        return sample(joined.motion, where), seams[seams[:, 0] < frames]

    def part(self, start: int, stop: int) -> Motion:
        """The motion from one scene frame to another, the last left out, as :meth:`motion` has it.

        Only the pieces that are played then are joined; they have to be there.
        """
        source, time = np.array([*self.knots, (self.source, self.time)], np.float64).T
        where = even_warp(time, source).at(np.arange(start, stop, dtype=np.float64))
        window = self.moves.window
        lengths = [b - a - window for a, b in self.pieces[:-1]]
        begins = np.concatenate([[0], np.cumsum(lengths, dtype=np.int64)])
        certain = np.flatnonzero(begins + window <= where[0])  # blended into by then
        first = int(certain[-1]) if len(certain) else 0
        last = int(np.searchsorted(begins, where[-1] + 1, side="right"))
        pieces = [(a, b) for a, b in self.pieces[first:last]]
        placement = self.placements[first]
        joined = join(self.moves.clips, pieces, window=window, placement=placement)
        return sample(joined.motion, where - begins[first])


def new_actor(moves: Repertoire, stand: Sequence[float], begin: int) -> Actor:
    """A player who idles from some frame on, facing a heading over a place: (θ, x, z)."""
    plane = np.asarray(moves.clips.planes[begin], np.float64)
    first = np.asarray(planar.compose(np.array(stand, np.float64), planar.inverse(plane)))
    run = int(moves.runs[moves.idle[0]])
    return Actor(
        moves=moves,
        pieces=[[begin, moves.run_stops[run]]],
        placements=[first],
        run=run,
        frame=begin,
        earliest=begin + moves.window,
    )


def _wrapped(angle: float) -> float:
    return float((angle + np.pi) % (2 * np.pi) - np.pi)


def _real(hops: np.ndarray) -> list[tuple[int, int]]:
    return [(int(a), int(b)) for a, b in hops if a != NO_HOP]
