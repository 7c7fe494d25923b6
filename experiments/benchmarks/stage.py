"""The live page under a real clock: late answers, missing frames, memory, in a browser of its own.

Starts ``mgjax view throw``, opens the page in Chromium and throws balls that are known some time
ahead. It reports how soon the page could be used; the share of answers that came too late; the
longest time for which the page had no frame for what it was to show; from a click to the first
picture with its ball; what went wrong. ``--app`` and ``--cold`` measure the start only, of another
application or with an empty cache of compiled programs. Run:
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
import tempfile
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

    def __init__(self, *arguments: str, cache: str | None = None) -> None:
        environment = dict(os.environ) if cache is None else os.environ | {"MGJAX_CACHE": cache}
        self.begun = time.perf_counter()
        command = [sys.executable, "-m", "mgjax", "view", *arguments, "--port", "0", "--no-browser"]
        self.process = subprocess.Popen(
            command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )
        assert self.process.stdout is not None
        self.address = self.process.stdout.readline().strip()

    def end(self) -> str:
        """Interrupts it; what its log says."""
        self.process.send_signal(signal.SIGINT)
        return self.process.communicate(timeout=60)[1]


def start(app: str, *, cold: bool) -> float:
    """Seconds from the command until the page of an application can be used."""
    from playwright.sync_api import sync_playwright

    from mgjax.stage.film import ARGUMENTS, find_browser

    with tempfile.TemporaryDirectory() as empty, sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=str(find_browser()), args=list(ARGUMENTS)
        )
        context = browser.new_context(viewport={"width": 960, "height": 540}, bypass_csp=True)
        page = context.new_page()
        viewed = Viewed(app, cache=empty if cold else None)
        page.goto(viewed.address)
        page.wait_for_function("document.documentElement.dataset.ready", timeout=600_000)
        if app == "throw":
            page.wait_for_function(BODY, timeout=600_000)
        seconds = time.perf_counter() - viewed.begun
        browser.close()
        viewed.end()
    return seconds


def run(throws: int, notice: float, seed: int) -> dict[str, Any]:
    """Throws so many balls in a page."""
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
        while thrown < throws:
            place = page.evaluate(BODY)
            if place is not None:
                page.mouse.click(*place)
                thrown += 1
            page.wait_for_timeout(rng.uniform(800, 2600))
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
    parser.add_argument("--app", default="throw", help="throw, sketch, match or edit")
    parser.add_argument("--cold", action="store_true", help="start with an empty cache")
    parser.add_argument("--throws", type=int, default=40)
    parser.add_argument("--notice", type=float, default=0.8, help="s from a throw to the body")
    parser.add_argument("--seed", type=int, default=0)
    arguments = parser.parse_args()
    if arguments.app != "throw" or arguments.cold:
        found = {"usable_s": start(arguments.app, cold=arguments.cold)}
    else:
        found = run(arguments.throws, arguments.notice, arguments.seed)
    print(json.dumps(found, indent=1))


if __name__ == "__main__":
    main()
