"""Half an hour with all four pages: memory, which controls were touched, what went wrong.

Starts ``mgjax view`` with ``throw``, ``sketch``, ``match`` and ``edit`` (on a copy of some embedded
clips), opens the pages in one Chromium and does at random what people do, on one page after the
other; every third deed works a control of the page, the one that was touched least. Memory counts
the processes of the servers once a minute; they are put to much of their use before the first
count. Run: ``python -m experiments.benchmarks.soak --minutes 30``.
"""

from __future__ import annotations

import argparse
import json
import random
import tempfile
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

from experiments.benchmarks.stage import BODY, WATCH, Viewed, memory_mb
from mgjax.clips.synthetic import synthetic_clips
from mgjax.io.bvh.write import save_bvh

WARM_S = 360.0
"""What is used for the first time in this time counts as warming up."""
CLIPS = ("duck", "sway", "jump")
"""Embedded clips that are edited."""
OPEN = "document.querySelectorAll('#side details').forEach((each) => { each.open = true; })"
CONTROLS = """() => {
  const found = {};
  for (const each of document.querySelectorAll('button, input, select')) {
    const there = each.dataset.name && !each.disabled && each.getClientRects().length;
    if (there && each.type !== 'file') {
      found[each.dataset.name] = { tag: each.localName, type: each.type };
    }
  }
  return found;
}"""
"""Controls that can be seen and are not disabled."""
SLIDE = """(each, share) => {
  const [low, high] = [Number(each.min), Number(each.max)];
  each.value = low + share * (high - low);
  each.dispatchEvent(new Event('input', { bubbles: true }));
  each.dispatchEvent(new Event('change', { bubbles: true }));
}"""
CHOOSE = """(each, share) => {
  each.selectedIndex = Math.floor(share * each.options.length);
  each.dispatchEvent(new Event('change', { bubbles: true }));
}"""
PLAYERS = """() => {
  const { stage } = mgjax;
  const there = [...stage.scene.actors.values()].filter((each) => each.track.pieces.length);
  return there.map((each) => {
    const [x, , z] = each.track.smoothRoot(stage.time, 0.1);
    return stage.project([x, 1.0, z]);
  });
}"""
THINGS = ("right-hand", "left-hand", "head", "bar", "obstacle")
WALKS = ("line", "s-curve", "circle", "square", "eight", "reaches")


class Person:
    """Someone who uses a page.

    Args:
        page: of an application.
        rng: draws what is done.
        done: counts it.
    """

    app = ""

    def __init__(self, page: Any, rng: random.Random, done: Counter[str]) -> None:
        self.page, self.rng, self.done = page, rng, done
        self.touched: Counter[str] = Counter()
        self.seen: set[str] = set()
        self.turn = 0
        self.begin()

    def begin(self) -> None:
        """What there has to be on a page that was just opened."""

    def deeds(self) -> dict[Callable[[], None], float]:
        """What is done, and how often."""
        raise NotImplementedError

    def act(self) -> None:
        """A control, or one of the deeds."""
        self.turn += 1
        deeds = self.deeds()
        deed = self.rng.choices(list(deeds), list(deeds.values()))[0]
        if self.turn % 3 == 0:
            deed = self.touch
        deed()
        self.done[f"{self.app}: {deed.__name__}"] += 1
        self.page.wait_for_timeout(self.rng.uniform(500, 1500))

    def touch(self) -> None:
        """The control that was touched least."""
        self.page.evaluate(OPEN)
        found = self.page.evaluate(CONTROLS)
        self.seen.update(found)
        least = min((self.touched[name] for name in found), default=0)
        name = self.rng.choice(sorted(name for name in found if self.touched[name] == least))
        kind = found[name]
        self.touched[name] += 1
        control = self.page.locator(f"[data-name='{name}']").first
        if kind["tag"] == "select":
            control.evaluate(CHOOSE, self.rng.random())
        elif kind["type"] == "range":
            control.evaluate(SLIDE, self.rng.random())
        elif kind["type"] in ("text", "number"):
            control.fill(self.rng.choice(["0.5", "1", "2"]), timeout=5000)
        else:
            control.evaluate("(each) => each.click()")

    def reload(self) -> None:
        """The page anew."""
        self.page.reload()
        self.page.wait_for_function("document.documentElement.dataset.ready")
        self.begin()


class Thrower(Person):
    """Someone who throws balls."""

    app = "throw"

    def begin(self) -> None:
        self.page.wait_for_function(BODY, timeout=300_000)
        self.page.evaluate(WATCH)

    def deeds(self) -> dict[Callable[[], None], float]:
        return {
            self.throw: 12, self.slide: 2, self.orbit: 2, self.theme: 1, self.replay: 2,
            self.reload: 1,
        }  # fmt: skip

    def throw(self) -> None:
        """A click on the body."""
        self.live()
        place = self.page.evaluate(BODY)
        if place is not None:
            self.page.mouse.click(*place)

    def slide(self) -> None:
        """Moves a slider."""
        name, low, high = self.rng.choice(
            [("speed", 5, 12), ("notice", 0.8, 2), ("radius", 0.06, 0.2)]
        )
        self.page.locator(f"[data-name={name}]").first.evaluate(
            "(e, v) => { e.value = v; e.dispatchEvent(new Event('input')); }",
            self.rng.uniform(low, high),
        )

    def orbit(self) -> None:
        """Looks from elsewhere."""
        self.page.evaluate("mgjax.stage.camera.orbit(40, 10), mgjax.stage.wake()")

    def theme(self) -> None:
        """Light to dark and back."""
        self.page.locator("[data-name=theme]").click()

    def replay(self) -> None:
        """The last throw again, for a moment, or its ghosts."""
        self.page.click(f"[data-name={self.rng.choice(['ghosts', 'replay'])}]")
        self.page.wait_for_timeout(1500)
        self.live()

    def live(self) -> None:
        """Back to what is played now, in time as it is."""
        if not self.page.evaluate("mgjax.player.live"):
            self.page.click("[data-name=back-to-live]")
            self.page.wait_for_function("mgjax.player.live")
        self.page.locator("[data-name=pace-1]").evaluate("(each) => each.click()")


class Sketcher(Person):
    """Someone who draws paths and puts things beside them."""

    app = "sketch"

    def deeds(self) -> dict[Callable[[], None], float]:
        return {
            self.draw: 5, self.ready_made: 3, self.place: 5, self.undo: 2, self.clear: 1,
            self.reload: 1,
        }  # fmt: skip

    def draw(self) -> None:
        """A drag on the floor."""
        self.page.click("[data-name=tool-draw]")
        x, z = self.rng.uniform(-1, 1), self.rng.uniform(-1, 1)
        spots = [self.on_page(x, z)]
        for _ in range(10):
            x, z = x + self.rng.uniform(-0.2, 0.5), z + self.rng.uniform(-0.2, 0.5)
            spots.append(self.on_page(x, z))
        self.page.mouse.move(*spots[0])
        self.page.mouse.down()
        for spot in spots[1:]:
            self.page.mouse.move(*spot)
        self.page.mouse.up()

    def ready_made(self) -> None:
        """One of the paths that are offered."""
        self.page.click(f"[data-name=ready-{self.rng.choice(WALKS)}]")

    def place(self) -> None:
        """Something on the floor."""
        self.page.click(f"[data-name=tool-{self.rng.choice(THINGS)}]")
        self.page.mouse.click(*self.on_page(self.rng.uniform(-1, 3), self.rng.uniform(-1, 3)))

    def undo(self) -> None:
        """One step back, where there is one."""
        self._press("Undo")

    def clear(self) -> None:
        """Everything away."""
        self._press("Clear")

    def _press(self, label: str) -> None:
        button = self.page.get_by_role("button", name=label, exact=True)
        if button.is_enabled():
            button.click()

    def on_page(self, x: float, z: float) -> tuple[float, float]:
        box = self.page.locator("#canvas").bounding_box()
        px, py = self.page.evaluate(f"mgjax.stage.project([{x}, 0, {z}])")
        inside_x = min(max(px, 5), box["width"] - 5)
        inside_y = min(max(py, 5), box["height"] - 5)
        return box["x"] + inside_x, box["y"] + inside_y


class Player(Person):
    """Someone who says where the ball goes."""

    app = "match"

    def deeds(self) -> dict[Callable[[], None], float]:
        return {self.point: 8, self.orbit: 1, self.reload: 0.5}

    def point(self) -> None:
        """A click on a player."""
        places = self.page.evaluate(PLAYERS)
        if places:
            self.page.mouse.click(*self.rng.choice(places))

    def orbit(self) -> None:
        """Looks from elsewhere."""
        self.page.evaluate("mgjax.stage.camera.orbit(40, 0), mgjax.stage.wake()")


class Editor(Person):
    """Someone who labels clips."""

    app = "edit"

    def deeds(self) -> dict[Callable[[], None], float]:
        return {self.open: 4, self.type: 3, self.reload: 0.3}

    def open(self) -> None:
        """A clip of the list, or another entry."""
        entries = self.page.locator(".mg-entry:visible")
        if entries.count():
            entries.nth(self.rng.randrange(entries.count())).click()

    def type(self) -> None:
        """Keys of the timeline."""
        self.page.keyboard.press(self.rng.choice([" ", "ArrowRight", "ArrowLeft", "Control+z"]))


def written(folder: Path) -> Path:
    """Some embedded clips with their labels, as files."""
    clips, labels = synthetic_clips()
    document: dict[str, Any] = {"clips": {}}
    for clip in clips:
        if clip.name in CLIPS:
            save_bvh(folder / f"{clip.name}.bvh", clip.skeleton, clip.motion)
            document["clips"][f"{clip.name}.bvh"] = [
                {"start_s": x.start_s, "end_s": x.end_s, "kind": x.kind} for x in labels[clip.name]
            ]
    (folder / "labels.json").write_text(json.dumps(document))
    return folder


PEOPLE: tuple[type[Person], ...] = (Thrower, Sketcher, Player, Editor)


def run(minutes: float, seed: int) -> dict[str, Any]:
    """Uses all pages for so long."""
    with tempfile.TemporaryDirectory() as folder:
        clips = str(written(Path(folder)))
        served = [
            Viewed(person.app, *(("--clips", clips) if person is Editor else ()))
            for person in PEOPLE
        ]
        return _used(served, minutes, seed)


def _used(served: list[Viewed], minutes: float, seed: int) -> dict[str, Any]:
    from playwright.sync_api import sync_playwright

    from mgjax.stage.film import ARGUMENTS, find_browser

    rng, done, troubles = random.Random(seed), Counter[str](), list[str]()
    memory: list[list[float]] = []
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=str(find_browser()), args=list(ARGUMENTS)
        )
        context = browser.new_context(viewport={"width": 960, "height": 540}, bypass_csp=True)
        users: list[Person] = []
        for viewed, user in zip(served, PEOPLE, strict=True):
            page = context.new_page()
            page.on("pageerror", lambda error: troubles.append(str(error)))
            page.on("console", lambda m: troubles.append(m.text) if m.type == "error" else None)
            page.on("dialog", lambda dialog: dialog.accept())
            page.goto(viewed.address)
            page.wait_for_function("document.documentElement.dataset.ready", timeout=300_000)
            users.append(user(page, rng, done))
        begun = time.perf_counter()
        counted, turns = 0, 0
        while (now := time.perf_counter() - begun) < WARM_S + 60 * minutes:
            user = users[turns // 8 % len(users)]  # eight deeds in a row on one page
            if turns % 8 == 0:
                user.page.bring_to_front()
            user.act()
            turns += 1
            if now >= WARM_S + 60 * counted:
                memory.append([memory_mb(viewed.process.pid) for viewed in served])
                counted += 1
        memory.append([memory_mb(viewed.process.pid) for viewed in served])
        browser.close()
    logs = [viewed.end() for viewed in served]
    first, last = (sum(memory[k]) for k in (0, -1))
    return {
        "minutes": minutes,
        "deeds": dict(sorted(done.items())),
        "touched": {user.app: dict(sorted(user.touched.items())) for user in users},
        "untouched": {user.app: sorted(user.seen - set(user.touched)) for user in users},
        "memory_mb": memory,
        "memory_change": last / first - 1,
        "troubles": troubles,
        "logs": logs,
    }


def main() -> None:
    """Reads the arguments, runs, and prints one JSON object."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])  # type: ignore[union-attr]
    parser.add_argument("--minutes", type=float, default=30.0)
    parser.add_argument("--seed", type=int, default=0)
    arguments = parser.parse_args()
    print(json.dumps(run(arguments.minutes, arguments.seed), indent=1))


if __name__ == "__main__":
    main()
