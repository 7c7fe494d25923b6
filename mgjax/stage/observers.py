"""The folder that observers of a study get: pages and clips, nothing given away."""

from __future__ import annotations

import html
import json
from dataclasses import replace
from pathlib import Path

import numpy as np

from mgjax.avoidance.study.format import FORMAT, attack_json
from mgjax.avoidance.study.trials import LETTERS, Trial
from mgjax.core.motion import Motion
from mgjax.core.skeleton import Skeleton
from mgjax.io.bvh.write import save_bvh
from mgjax.stage.bundle import short_text
from mgjax.stage.html import page_html
from mgjax.stage.study import QUESTION, trial_show

THINNED = 2
"""Every second frame of the written motion is shown: 60 a second."""

_PAGE = """<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>Observer study</title>
<link rel="icon" href="data:,">
<style>{style}</style>
</head>
<body class="study">
<header>
<h1>{question}</h1>
<span id="where" role="status"></span>
<button id="back">Back</button>
<button id="next">Next</button>
</header>
<iframe id="view" title="The trial"></iframe>
<footer>
<div id="picks" role="group" aria-label="{question}"></div>
<label>Observer <input id="observer" maxlength="40" autocomplete="off"></label>
<button id="save">Save picks</button>
</footer>
<script type="application/json" id="study-payload">{payload}</script>
<script>{script}</script>
</body>
</html>
"""


def write_observers(folder: Path, skeleton: Skeleton, study: str, trials: list[Trial]) -> None:
    """Writes ``index.html``, which leads through the trials, and a folder for each of them.

    ``trials/01/`` has ``index.html``, which plays all candidates, ``A.bvh``, ``B.bvh`` … and
    ``attack.json``, the attack in the frame in which all clips begin.

    Args:
        folder: is made.
        skeleton: of the motions.
        study: its name, which picks carry.
        trials: candidates in the order in which they stand.
    """
    folder.mkdir()
    digits = max(len(str(len(trials))), 2)
    pages: list[tuple[str, int]] = []
    for trial in trials:
        place = f"trials/{trial.number:0{digits}d}"
        write_trial(folder / place, skeleton, trial)
        pages.append((f"{place}/index.html", len(trial.ways)))
    (folder / "index.html").write_text(index_html(study, pages), encoding="utf-8")


def index_html(study: str, pages: list[tuple[str, int]]) -> str:
    """The page that leads through the trials.

    Args:
        study: its name.
        pages: of the trials, and how many candidates each has.
    """
    rows = [{"page": page, "letters": list(LETTERS[:count])} for page, count in pages]
    payload = json.dumps({"format": FORMAT, "study": study, "trials": rows})
    return _PAGE.format(
        style=short_text("stage.css") + short_text("study.css"),
        question=html.escape(QUESTION),
        payload=payload.replace("<", "\\u003c"),
        script=short_text("study.js"),
    )


def write_trial(folder: Path, skeleton: Skeleton, trial: Trial) -> None:
    """Writes the page, the clips and the attack of a trial."""
    folder.mkdir(parents=True)
    motions = equally_long([thinned(way.selection.motion) for way in trial.ways])
    show = trial_show(skeleton, motions, trial.attack, title=f"Trial {trial.number}")
    (folder / "index.html").write_text(page_html(show, bare=True), encoding="utf-8")
    for letter, motion in zip(LETTERS, motions, strict=False):
        save_bvh(folder / f"{letter}.bvh", skeleton, motion)
    (folder / "attack.json").write_text(json.dumps(attack_json(trial.attack)) + "\n")


def thinned(motion: Motion) -> Motion:
    """Every second frame."""
    return replace(
        motion,
        root_translation=np.asarray(motion.root_translation)[::THINNED],
        local_rotations=np.asarray(motion.local_rotations)[::THINNED],
        frame_rate=motion.frame_rate / THINNED,
    )


def equally_long(motions: list[Motion]) -> list[Motion]:
    """All cut to the shortest: lengths give nothing away."""
    count = min(motion.num_frames for motion in motions)
    return [
        replace(
            motion,
            root_translation=motion.root_translation[:count],
            local_rotations=motion.local_rotations[:count],
        )
        for motion in motions
    ]
