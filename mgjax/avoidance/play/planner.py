"""Real-time playback of a graph with a search for avoidance in the background (§6)."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from functools import partial
from threading import Event

import numpy as np
from jaxtyping import Float

from mgjax.avoidance.attacks.attack import Attack, validate_attack
from mgjax.avoidance.attacks.transform import after, in_frame, shifted
from mgjax.avoidance.choice.results import Status
from mgjax.avoidance.config import AvoidanceConfig, validate_config
from mgjax.avoidance.play.answers import Answer, Asked, Found, Pending, Thrown, answer_of
from mgjax.avoidance.play.clocks import Clock, Searches, SimulatedClock, SimulatedSearches, Ticket
from mgjax.avoidance.play.parried import outcome_of
from mgjax.avoidance.play.several_attacks import JointPath, find_path
from mgjax.avoidance.play.timeline import PlacedChange, Timeline
from mgjax.avoidance.prepared import Prepared, prepared_for
from mgjax.avoidance.rates import EXPORT_RATE
from mgjax.core.calls.door import checked
from mgjax.core.errors import AttackError, ConfigError
from mgjax.core.motion import Motion
from mgjax.graph.feet.course import turned
from mgjax.graph.types import MotionGraph


class Planner:
    """Plays a walk without end and gets the body out of the way of attacks.

    While nothing comes, the next edge is drawn at random. An attack starts a search for the node at
    which the edges decided so far end (mostly the end of the one being played), with the attack in
    that node's planar frame and its time counted from the beginning of the path. What the search
    finds is spliced in there; when the walk ends, after the attack is over, random play goes on.

    When the next edge has to be known before the search has ended, it is drawn at random (or comes
    from the path of an earlier attack). Candidates that do not start with it are dropped, and those
    that do lose it (§6). That leaves the same candidates as an enumeration from the node where the
    drawn edge ends: t_avoid and t_attack both shrink by its duration, so eq. 1 keeps the same
    walks, and s_time and energies follow from what remains. The search therefore begins again from
    that node (``restarts``), which also crops the attack around where the body will be by then. So
    that edges shorter than a search cannot postpone it for ever, edges are drawn ahead before a new
    beginning until twice the time is left that the search has had.

    Later attacks: the newest one is searched for. One whose search has not ended is superseded. All
    that are still under way join the search: of the candidates for the newest the best that is
    clear of every one of them is taken; if there is none, the newest counts. A path that would be
    hit replaces no other that is still being played. Where nothing avoids the newest an arm may
    parry it (``config.parry``); such a path replaces another only if it is clear of all others.

    Every attack is answered once, when it is over, by the exact check of the motion as it was
    played. All methods are to be called from one thread; only :meth:`finish` and :meth:`close`
    wait. What was played is kept (``timeline``), a few numbers for each edge.

    Args:
        graph: a motion graph with labelled avoidance parts, or what
            :func:`~mgjax.avoidance.prepared.prepare` made of one.
        clock: ``now()`` in seconds since playback began; default: a simulated one.
        searches: where searches run; default: simulated, without latency.
        config: settings of the search.
        seed: of the edges that are drawn, and of the first node.
        node: where the body stands at the beginning; default: drawn.
        start: its planar frame in the world; default: at the origin, heading +Z.
        begin: the beginning, s on the clock.
        grace: so much later :meth:`advance` decides an edge while a search is under way, s; for a
            clock that is ahead of what is shown.
        on_found: told of every search that ends in time, from within :meth:`frame`,
            :meth:`advance` or :meth:`attack`.
    """

    @checked
    def __init__(
        self,
        graph: MotionGraph | Prepared,
        *,
        clock: Clock | None = None,
        searches: Searches | None = None,
        config: AvoidanceConfig | None = None,
        seed: int = 0,
        node: int | None = None,
        start: Float[np.ndarray, "3"] | None = None,
        begin: float = 0.0,
        grace: float = 0.0,
        on_found: Callable[[Found], None] | None = None,
    ) -> None:
        if grace < 0:
            raise ConfigError(f"got a grace of {grace:g} s, expected 0 or more")
        self._on_found, self._grace = on_found, grace
        self._clock: Clock = clock or SimulatedClock()
        self._searches: Searches = searches or SimulatedSearches()
        self._config = config or AvoidanceConfig()
        validate_config(self._config)
        self._prepared = prepared_for(graph, self._config)
        self._graph = graph = self._prepared.graph
        self._rng = np.random.default_rng(seed)
        first = int(self._rng.integers(graph.num_nodes)) if node is None else node
        if not 0 <= first < graph.num_nodes:
            raise ConfigError(f"got node {first}, expected 0 … {graph.num_nodes - 1}")
        self.timeline = Timeline(graph, first, start, begin)
        self.answers: list[Answer] = []
        self.attacks = 0
        self._plan: deque[tuple[int, float]] = deque()
        self._under_way: list[Thrown] = []
        self._pending: Pending | None = None
        self._advance(begin)

    @checked
    def frame(self, when: float | None = None) -> Motion:
        """The pose at ``when`` seconds, default now, in the world, as a motion of one frame.

        Never waits for a search. Times in the past give what was shown then.
        """
        now = float(self._clock.now() if when is None else when)
        self._advance(now)
        return self.timeline.sample(np.array([now]))

    def advance(self) -> float:
        """Decides all that has to be known by now.

        Returns:
            Until when ``timeline`` is final, s; never earlier than now, less ``grace``.
        """
        self._advance(float(self._clock.now()), self._grace)
        return self.timeline.deadline

    @checked
    def configure(self, config: AvoidanceConfig) -> None:
        """Searches that begin from now on have these settings.

        Raises:
            ConfigError: a setting out of range, or one that the graph is not prepared for.
        """
        self._prepared = prepared_for(self._prepared, config)
        self._config = config

    @checked
    def attack(self, attack: Attack) -> int:
        """Makes an attack known now; returns its number.

        Args:
            attack: in the world, its times on the planner's clock. What lies in the past does not
                count.

        Raises:
            AttackError: the attack is malformed, over, or ends later than a minute from now.
        """
        now = float(self._clock.now())
        self._advance(now)
        validate_attack(shifted(attack, now))
        left = after(attack, now)
        if attack.end <= now or not len(left.radii):
            raise AttackError(f"got an attack that is over at {now:g} s, expected one under way")
        thrown = Thrown(number=self.attacks, known=now, attack=left)
        self.attacks += 1
        if self._pending is not None:
            self._pending.thrown.superseded = True
            self._pending.drop(now)
        self._under_way.append(thrown)
        self._begin_search(thrown, now)
        self._advance(now)
        return thrown.number

    def counts(self) -> dict[str, int]:
        """How many attacks there were; answered in which way; not yet; and how many hit at all."""
        found: dict[str, int] = {"attacks": self.attacks}
        for status in ("avoided", "parried", "hit", "superseded"):
            found[status] = sum(answer.status == status for answer in self.answers)
        found["open"] = len(self._under_way)
        found["touched"] = sum(answer.hit for answer in self.answers)
        found["restarts"] = sum(answer.restarts for answer in self.answers)
        return found

    def finish(self) -> list[Answer]:
        """Plays on until all attacks are over, waits for their checks and returns all answers.

        The clock need not move on; a search that is not done by then is late.
        """
        if self._under_way:
            end = max(thrown.attack.end for thrown in self._under_way) + 2 / EXPORT_RATE
            self._advance(max(end, self._clock.now()))
            self._collect(end, wait=True)
        return self.answers

    def close(self) -> None:
        """Ends the searches; a call that is running is waited for."""
        self._searches.close()

    def _advance(self, now: float, grace: float = 0.0) -> None:
        """All that happens up to ``now``, in its order: searches end, edges are decided."""
        while True:
            deadline = self.timeline.deadline
            if self._pending is not None:
                pending, latest = self._pending, min(now, deadline + grace)
                if pending.ticket.done(latest):
                    self._pending = None  # also if the search raises: playback can go on
                    self._accept(pending.thrown, pending.ticket.result(), latest)
                    continue
            waits = grace if self._pending is not None else 0.0
            if deadline + waits > now:
                break
            self._decide()
            if self._pending is not None:
                self._restart(deadline + waits)
        self._collect(min(now, self.timeline.deadline))

    def _decide(self) -> None:
        """The next edge: from the path that is being played, else a random one."""
        if self._plan:
            edge, scale = self._plan.popleft()
        else:
            edge, scale = int(self._rng.choice(self._graph.edges_from(self.timeline.node))), 1.0
        self.timeline.append(edge, scale)

    def _restart(self, now: float) -> None:
        """An edge was decided before the search ended: it begins again from where that ends."""
        assert self._pending is not None
        thrown, begun = self._pending.thrown, self._pending.begun
        self._pending.drop(now)
        thrown.restarts += 1
        until = min(now + 2 * (now - begun), thrown.attack.end)
        while self.timeline.deadline < until:
            self._decide()
        self._begin_search(thrown, now)

    def _begin_search(self, thrown: Thrown, now: float) -> None:
        """Hands in a search for the end of the decided edges, unless the attack is over by then."""
        self._pending = None
        line = self.timeline
        if thrown.attack.end <= line.end:
            if thrown.asked is None:
                thrown.search = "committed"
            return
        place = line.frame_at_end()
        others = [
            in_frame(other.attack, place, line.end)
            for other in self._under_way
            if other is not thrown and other.attack.end > line.end
        ]
        rest = line.between(now, line.end).seen_from(place, line.end)
        attack = in_frame(thrown.attack, place, line.end)
        feet = line.feet_at_end()
        thrown.asked = Asked(node=line.node, place=place, begins=line.end, attack=attack, feet=feet)
        dropped = Event()
        call = partial(
            find_path,
            self._prepared,
            line.node,
            attack,
            others,
            self._config,
            rest,
            turned(feet, -float(place[0])),
            wanted=lambda: not dropped.is_set(),
        )
        ticket = self._searches.submit(now, call)
        self._pending = Pending(thrown=thrown, ticket=ticket, begun=now, dropped=dropped)

    def _accept(self, thrown: Thrown, path: JointPath, now: float) -> None:
        thrown.search, thrown.waited = path.status, now - thrown.known
        good = path.status == Status.AVOIDED or (path.status == Status.PARRIED and path.joint)
        if path.walk is not None and (good or not self._plan):
            walk = path.walk
            self._plan = deque(zip(walk.edges.tolist(), walk.scales.tolist(), strict=True))
            asked = thrown.asked
            assert asked is not None
            change = None
            if path.change is not None:
                change = PlacedChange(
                    change=path.change, begins=asked.begins, angle=float(asked.place[0])
                )
            self.timeline.change(change, asked.begins)
        if self._on_found is not None:
            assert thrown.asked is not None
            self._on_found(Found(number=thrown.number, path=path, asked=thrown.asked))

    def _collect(self, now: float, *, wait: bool = False) -> None:
        """Has attacks that are over checked, and answers those whose check has ended."""
        left = []
        for thrown in self._under_way:
            # One written frame more: the check ends with the frame after the attack.
            if thrown.check is None and now >= thrown.attack.end + 1 / EXPORT_RATE:
                thrown.check = self._check(thrown, now)
            if thrown.check is None or not (wait or thrown.check.done(now)):
                left.append(thrown)
            else:
                self.answers.append(answer_of(thrown, thrown.check.result()))
        self._under_way = left

    def _check(self, thrown: Thrown, now: float) -> Ticket:
        """Hands in the exact check of what was played while the attack was there."""
        since = max(thrown.known, thrown.attack.start)
        last = thrown.attack.end + 1 / EXPORT_RATE
        piece = self.timeline.between(since - 1 / EXPORT_RATE, last, feet=True)
        call = partial(outcome_of, self._graph, piece, thrown.attack, since)
        return self._searches.submit(now, call, search=False)
