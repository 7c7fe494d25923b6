"""The live page under a real clock: late answers, missing frames, memory, in a browser of its own.

Starts ``mgjax view throw``, opens the page in Chromium and throws balls that are known some time
ahead, with every control touched now and then (``--minutes`` for a soak). It reports how soon the
page could be used; the share of answers that came too late; the longest time for which the page had
no frame for what it was to show; from a click to the first picture with its ball; the memory
of all processes at the beginning and at the end; what went wrong. Run:
``python -m experiments.benchmarks.stage --throws 100``.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

BODY = """() => {
  const { stage } = mgjax;
  const actor = stage.scene.actors.get('character0');
  if (!actor || !actor.track.pieces.length) return null;
  const [x, , z] = actor.track.smoothRoot(stage.time, 0.1);
  return stage.project([x, 1.2, z]);
}"""
WATCH = """() => {
  const seen = { late: 0, answers: 0, hit: 0, lack: 0, thrown: 0, last: 0 };
  Object.assign(seen, { pictures: [], shown: [] });
  mgjax.seen = seen;
  const { stage, link } = mgjax;
  link.on('note', (note) => {
    if (note.event !== 'answer') return;
    seen.answers += 1;
    seen.late += note.late ? 1 : 0;
    seen.hit += note.hit ? 1 : 0;
  });
  stage.onFrame((now) => {
    const actor = stage.scene.actors.get('character0');
    if (mgjax.player.live && actor) seen.lack = Math.max(seen.lack, stage.time - actor.track.end);
    if (seen.last) seen.pictures.push(now - seen.last);
    seen.last = now;
    if (seen.thrown && stage.scene.balls.size > seen.balls) {
      seen.shown.push(performance.now() - seen.thrown);
      seen.thrown = 0;
    }
  });
  stage.onClick(() => {
    seen.thrown = performance.now();
    seen.balls = stage.scene.balls.size;
  });
}"""


def memory_mb(pid: int) -> float:
    """Resident memory of a process and all below it, MB."""
    total = 0.0
    for each in [pid, *below(pid)]:
        try:
            pages = int(Path(f"/proc/{each}/statm").read_text().split()[1])
        except OSError:
            continue
        total += pages * os.sysconf("SC_PAGE_SIZE") / 2**20
    return total


def below(pid: int) -> list[int]:
    """The processes that a process started, and theirs."""
    try:
        tasks = list(Path(f"/proc/{pid}/task").iterdir())
        children = [int(c) for t in tasks for c in (t / "children").read_text().split()]
    except OSError:
        return []
    return children + [each for child in children for each in below(child)]


def processor_s(pid: int) -> float:
    """Processor time that a process and those below it have used, s."""
    ticks = 0
    for each in [pid, *below(pid)]:
        try:
            fields = Path(f"/proc/{each}/stat").read_text().rpartition(")")[2].split()
        except OSError:
            continue
        ticks += int(fields[11]) + int(fields[12])
    return ticks / os.sysconf("SC_CLK_TCK")


class Viewed:
    """A running ``mgjax view``."""

    def __init__(self, *arguments: str) -> None:
        self.begun = time.perf_counter()
        command = [sys.executable, "-m", "mgjax", "view", *arguments, "--port", "0", "--no-browser"]
        self.process = subprocess.Popen(
            command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )
        assert self.process.stdout is not None
        self.address = self.process.stdout.readline().strip()

    def end(self) -> str:
        """Interrupts it; what its log says."""
        self.process.send_signal(signal.SIGINT)
        return self.process.communicate(timeout=60)[1]


def touch(page: Any, rng: random.Random) -> None:
    """Does one thing that a person might do beside throwing."""
    deeds = [
        lambda: page.locator("[data-name=speed]").first.evaluate(
            "(e, v) => { e.value = v; e.dispatchEvent(new Event('input')); }", rng.uniform(5, 12)
        ),
        lambda: page.locator("[data-name=notice]").evaluate(
            "(e, v) => { e.value = v; e.dispatchEvent(new Event('input')); }", rng.uniform(0.8, 2)
        ),
        lambda: page.evaluate("mgjax.stage.camera.orbit(40, 10), mgjax.stage.wake()"),
        lambda: page.locator("[data-name=theme]").click(),
        lambda: replay(page, rng),
        lambda: reload(page),
    ]
    rng.choice(deeds)()


def replay(page: Any, rng: random.Random) -> None:
    """The last throw again, for a moment."""
    page.click("[data-name=ghosts]" if rng.random() < 0.5 else "[data-name=replay]")
    page.wait_for_timeout(1500)
    if not page.evaluate("mgjax.player.live"):
        page.click("[data-name=back-to-live]")
        page.wait_for_function("mgjax.player.live")


def reload(page: Any) -> None:
    """The page anew, watched as before."""
    kept = page.evaluate("mgjax.seen")
    page.reload()
    page.wait_for_function("document.documentElement.dataset.ready")
    page.wait_for_function(BODY)
    page.evaluate(WATCH)
    page.evaluate("(kept) => Object.assign(mgjax.seen, kept, { last: 0, thrown: 0 })", kept)


def run(throws: int, minutes: float, notice: float, seed: int) -> dict[str, Any]:
    """Throws balls in a page for as long, or as many."""
    from playwright.sync_api import sync_playwright

    from mgjax.stage.film import ARGUMENTS, find_browser

    rng = random.Random(seed)
    viewed = Viewed("throw")
    troubles: list[str] = []
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=str(find_browser()), args=list(ARGUMENTS)
        )
        context = browser.new_context(viewport={"width": 960, "height": 360}, bypass_csp=True)
        page = context.new_page()
        page.on("pageerror", lambda error: troubles.append(str(error)))
        page.on("console", lambda m: troubles.append(m.text) if m.type == "error" else None)
        page.goto(viewed.address)
        page.wait_for_function("document.documentElement.dataset.ready", timeout=300_000)
        page.wait_for_function(BODY)
        usable = time.perf_counter() - viewed.begun
        page.evaluate(WATCH)
        page.locator("[data-name=notice]").evaluate(
            "(e, v) => { e.value = v; e.dispatchEvent(new Event('input')); }", notice
        )
        memory = [memory_mb(viewed.process.pid)]
        begun, used = time.perf_counter(), processor_s(viewed.process.pid)
        thrown = 0
        while thrown < throws or time.perf_counter() - begun < 60 * minutes:
            place = page.evaluate(BODY)
            if place is not None:
                page.mouse.click(*place)
                thrown += 1
            page.wait_for_timeout(rng.uniform(800, 2600))
            if minutes and rng.random() < 0.25:
                touch(page, rng)
            if thrown % 20 == 0:
                memory.append(memory_mb(viewed.process.pid))
        seconds = time.perf_counter() - begun
        page.wait_for_timeout(4000)
        memory.append(memory_mb(viewed.process.pid))
        used = processor_s(viewed.process.pid) - used
        seen = page.evaluate("mgjax.seen")
        stats = page.evaluate("mgjax.stage.stats()")
        browser.close()
    log = viewed.end()
    pictures = np.array(seen["pictures"] or [np.nan])
    return {
        "usable_s": usable,
        "seconds": seconds,
        "throws": thrown,
        "answers": seen["answers"],
        "late": seen["late"],
        "hit": seen["hit"],
        "lacking_s": max(seen["lack"], 0.0),
        "picture_ms": {"median": float(np.median(pictures)), "worst": float(pictures.max())},
        "click_to_ball_ms": {
            "median": float(np.median(seen["shown"] or [np.nan])),
            "worst": float(np.max(seen["shown"] or [np.nan])),
        },
        "server_cores": used / seconds,
        "memory_mb": memory,
        "quality": stats,
        "troubles": troubles,
        "log": log,
    }


def main() -> None:
    """Reads the arguments, runs, and prints one JSON object."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])  # type: ignore[union-attr]
    parser.add_argument("--throws", type=int, default=40)
    parser.add_argument("--minutes", type=float, default=0.0, help="a soak of so long")
    parser.add_argument("--notice", type=float, default=0.8, help="s from a throw to the body")
    parser.add_argument("--seed", type=int, default=0)
    arguments = parser.parse_args()
    found = run(arguments.throws, arguments.minutes, arguments.notice, arguments.seed)
    print(json.dumps(found, indent=1))


if __name__ == "__main__":
    main()
