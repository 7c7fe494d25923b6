"""Half an hour of throwing, sketching and reloading: memory, answers, what went wrong.

Starts ``mgjax view throw`` and ``mgjax view sketch``, opens both pages in one Chromium and does at
random what people do, each page half of the time. Memory counts the processes of both servers once
a minute; both are put to much of their use before the first count. Run:
``python -m experiments.benchmarks.soak --minutes 30``.
"""

from __future__ import annotations

import argparse
import json
import random
import time
from collections import Counter
from typing import Any

from experiments.benchmarks.stage import BODY, WATCH, Viewed, memory_mb

WARM_S = 180.0
"""What is used for the first time in this time counts as warming up."""
THINGS = ("right-hand", "left-hand", "head", "bar", "obstacle")
WALKS = ("line", "s-curve", "circle", "square", "eight", "reaches")


class Thrower:
    """Someone who throws balls."""

    def __init__(self, page: Any, rng: random.Random, done: Counter[str]) -> None:
        self.page, self.rng, self.done = page, rng, done
        page.wait_for_function(BODY, timeout=300_000)
        page.evaluate(WATCH)

    def act(self) -> None:
        """One deed, most often a throw."""
        deeds = {
            self.throw: 12, self.slide: 2, self.orbit: 2, self.theme: 1, self.replay: 2,
            self.reload: 1,
        }  # fmt: skip
        deed = self.rng.choices(list(deeds), list(deeds.values()))[0]
        deed()
        self.done[f"throw: {deed.__name__}"] += 1

    def throw(self) -> None:
        """A click on the body."""
        place = self.page.evaluate(BODY)
        if place is not None:
            self.page.mouse.click(*place)
        self.page.wait_for_timeout(self.rng.uniform(600, 2000))

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
        if not self.page.evaluate("mgjax.player.live"):
            self.page.click("[data-name=back-to-live]")
            self.page.wait_for_function("mgjax.player.live")

    def reload(self) -> None:
        """The page anew."""
        self.page.reload()
        self.page.wait_for_function("document.documentElement.dataset.ready")
        self.page.wait_for_function(BODY)
        self.page.evaluate(WATCH)


class Sketcher:
    """Someone who draws paths and puts things beside them."""

    def __init__(self, page: Any, rng: random.Random, done: Counter[str]) -> None:
        self.page, self.rng, self.done = page, rng, done

    def act(self) -> None:
        """One deed, most often a path."""
        deeds = {
            self.draw: 5, self.ready_made: 3, self.place: 5, self.undo: 2, self.clear: 1,
            self.reload: 1,
        }  # fmt: skip
        deed = self.rng.choices(list(deeds), list(deeds.values()))[0]
        deed()
        self.done[f"sketch: {deed.__name__}"] += 1
        self.page.wait_for_timeout(self.rng.uniform(800, 2500))

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

    def reload(self) -> None:
        """The page anew."""
        self.page.reload()
        self.page.wait_for_function("document.documentElement.dataset.ready")

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


def run(minutes: float, seed: int) -> dict[str, Any]:
    """Uses both pages for so long."""
    from playwright.sync_api import sync_playwright

    from mgjax.stage.film import ARGUMENTS, find_browser

    rng, done, troubles = random.Random(seed), Counter[str](), list[str]()
    served = [Viewed("throw"), Viewed("sketch")]
    memory: list[list[float]] = []
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=str(find_browser()), args=list(ARGUMENTS)
        )
        context = browser.new_context(viewport={"width": 960, "height": 540}, bypass_csp=True)
        users: list[Thrower | Sketcher] = []
        for viewed, user in zip(served, (Thrower, Sketcher), strict=True):
            page = context.new_page()
            page.on("pageerror", lambda error: troubles.append(str(error)))
            page.on("console", lambda m: troubles.append(m.text) if m.type == "error" else None)
            page.goto(viewed.address)
            page.wait_for_function("document.documentElement.dataset.ready", timeout=300_000)
            users.append(user(page, rng, done))
        begun = time.perf_counter()
        counted, turns = 0, 0
        while (now := time.perf_counter() - begun) < WARM_S + 60 * minutes:
            user = users[turns // 8 % 2]  # eight deeds in a row on one page
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
