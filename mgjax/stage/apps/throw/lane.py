"""One character of the page: its planner, what is sent of it, and the balls thrown at it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.body.spheres import sphere_centres
from mgjax.avoidance.config import AvoidanceConfig
from mgjax.avoidance.play.answers import Answer, Found
from mgjax.avoidance.play.clocks import Searches
from mgjax.avoidance.play.planner import Planner
from mgjax.avoidance.prepared import Prepared
from mgjax.core.kinematics import forward, planar_frames
from mgjax.core.motion import Motion
from mgjax.stage.apps.throw.clock import Ahead, SessionClock
from mgjax.stage.apps.throw.contact import Contact, first_contact, track
from mgjax.stage.serve.session import Send
from mgjax.stage.show.frames import frames_of
from mgjax.stage.show.types import Ball, Colour, show_value

AHEAD_S = 0.2
"""So much earlier than it is shown a motion is decided on, so that none is ever missing."""
GRACE_S = 0.1
"""So much later where a search is under way."""
BUFFER_S = 0.6
"""At most so much is sent ahead: what is decided beyond may be long."""
RATE = 30.0
_LEAST_FRAMES = 3
_URGENT_S = 0.12
_KEPT = 12
"""Throws that are kept for replay and study."""
COLOURS: tuple[Colour, ...] = ("blue", "green")


@dataclass(eq=False)
class Throw:
    """A ball thrown at a character, and what is known of it so far."""

    number: int
    attack: Attack
    found: Found | None = None
    contact: Contact | None = None
    answer: Answer | None = None

    @property
    def ball_id(self) -> str:
        return f"ball{self.number}"


class Lane:
    """A character that plays on and gets out of the way.

    Args:
        number: of the character, from 0.
        prepared: of the graph.
        clock: of the session.
        searches: where it searches.
        send: to the page.
        tell: told of a throw when its search or its check has ended.
        config: settings of its searches.
        seed: of its random walk.
        start: planar frame at which it begins. [3]
    """

    def __init__(
        self,
        number: int,
        prepared: Prepared,
        clock: SessionClock,
        searches: Searches,
        send: Send,
        tell: Callable[[Lane, Throw], None],
        *,
        config: AvoidanceConfig,
        seed: int,
        start: Float[np.ndarray, "3"],
    ) -> None:
        self.number, self.prepared, self.config = number, prepared, config
        self._clock, self._send, self._tell = clock, send, tell
        self.throws: list[Throw] = []
        self._answered = 0
        self._next = int(np.ceil(clock.now() * RATE))
        self.planner = Planner(
            prepared,
            clock=Ahead(clock, AHEAD_S),
            searches=searches,
            config=config,
            seed=seed,
            start=start,
            begin=clock.now(),
            grace=GRACE_S,
            on_found=self._found,
        )

    @property
    def actor_id(self) -> str:
        return f"character{self.number}"

    @property
    def busy(self) -> bool:
        """Whether a ball is under way."""
        return any(throw.answer is None for throw in self.throws)

    def configure(self, config: AvoidanceConfig) -> None:
        """Searches from now on have these settings."""
        self.planner.configure(config)
        self.config = config

    def tick(self) -> None:
        """Decides, sends what is new, and answers what is over."""
        final = self.planner.advance()
        now = self._clock.now()
        last = int(np.floor(min(final, now + BUFFER_S + AHEAD_S) * RATE))
        fresh = last + 1 - self._next
        if fresh >= _LEAST_FRAMES or (fresh > 0 and self._next / RATE < now + _URGENT_S):
            self._send_frames(self._next, last)
            self._next = last + 1
        for answer in self.planner.answers[self._answered :]:
            throw = next((t for t in self.throws if t.number == answer.number), None)
            if throw is not None:
                throw.answer = answer
                self._tell(self, throw)
        self._answered = len(self.planner.answers)

    def throw(self, attack: Attack) -> Throw:
        """A ball of the world; its search begins."""
        throw = Throw(number=self.planner.attacks, attack=attack)
        self.throws = [*self.throws[-_KEPT + 1 :], throw]
        self.planner.attack(attack)
        self.show_ball(throw)
        # What was sent ahead is shown in any case.
        sent = np.arange(int(self._clock.now() * RATE), self._next) / RATE
        if len(sent):
            self._look_for_contacts(sent)
        return throw

    def predicted_root(self, when: float) -> Float[np.ndarray, "3"]:
        """Where the root will be if the character goes on as it does, m."""
        line = self.planner.timeline
        end = min(when, max(line.deadline, 0.0))
        begin = max(end - 0.5, 0.0)
        root = line.sample(np.array([begin, max(end, begin + 1e-3)])).root_translation
        pace = (root[1] - root[0]) / max(end - begin, 1e-3) if end > begin + 0.05 else np.zeros(3)
        return np.asarray(root[1] + pace * max(when - end, 0.0), np.float64)

    def frame_now(self) -> Float[np.ndarray, "3"]:
        """Planar frame of the body as it is shown now. [3]"""
        motion = self.planner.timeline.sample(np.array([self._clock.now()]))
        positions, _ = forward(
            self.prepared.graph.skeleton, motion.root_translation, motion.local_rotations
        )
        frames = planar_frames(self.prepared.graph.skeleton, np.asarray(positions))
        return np.asarray(frames[0], np.float64)

    def show_ball(self, throw: Throw) -> None:
        """Sends a ball's whole way, as far as it is known."""
        times, places = track(throw.attack, throw.contact, float(throw.attack.radii[0]))
        ball = Ball(
            id=f"{self.actor_id}-{throw.ball_id}",
            radius=float(throw.attack.radii[0]),
            times=times,
            places=places,
            colour="orange" if throw.contact is None else "red",
        )
        self._send({"type": "put", "kind": "balls", "item": show_value(ball)})

    def close(self) -> None:
        """Ends its searches."""
        self.planner.close()

    def _send_frames(self, first: int, last: int) -> None:
        times = np.arange(first, last + 1) / RATE
        motion = self.planner.timeline.sample(times)
        frames = frames_of(
            replace(motion, frame_rate=RATE), start=float(times[0]), rate=RATE, delta=False
        )
        self._send({"type": "frames", "actor": self.actor_id, "frames": show_value(frames)})
        self._look_for_contacts(times)

    def _look_for_contacts(self, times: Float[np.ndarray, " T"]) -> None:
        """Balls that meet what was just sent fly on from there."""
        open_throws = [
            t
            for t in self.throws
            if t.contact is None and t.attack.start <= times[-1] and t.attack.end >= times[0]
        ]
        if not open_throws:
            return
        if times[0] > 0:
            times = np.concatenate([[max(times[0] - 1 / RATE, 0.0)], times])
        centres = self._spheres(self.planner.timeline.sample(times))
        for throw in open_throws:
            contact = first_contact(throw.attack, self.prepared.tables.spheres, times, centres)
            if contact is not None:
                throw.contact = contact
                self.show_ball(throw)

    def _spheres(self, motion: Motion) -> Float[np.ndarray, "T S 3"]:
        skeleton = self.prepared.graph.skeleton
        positions, _ = forward(skeleton, motion.root_translation, motion.local_rotations)
        return np.asarray(sphere_centres(self.prepared.tables.spheres, np.asarray(positions)))

    def _found(self, found: Found) -> None:
        throw = next((t for t in self.throws if t.number == found.number), None)
        if throw is not None:
            throw.found = found
            self._tell(self, throw)
