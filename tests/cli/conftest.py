"""The command line, run in this process, and small clips to run it on."""

from __future__ import annotations

import contextlib
import io
import json
import shutil
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from mgjax.cli import main
from mgjax.clips.synthetic import synthetic_clips
from mgjax.io.bvh.write import save_bvh

USED = ("steps", "duck", "sway", "crouch_jump")


@dataclass(frozen=True, kw_only=True)
class Ran:
    """What a command left: its exit status and what it printed."""

    status: int
    out: str
    err: str

    @property
    def json(self) -> dict[str, Any]:
        """The one object on stdout."""
        assert self.out.count("\n") == 1, self.out
        return json.loads(self.out, parse_constant=lambda word: pytest.fail(f"{word} in JSON"))


def run(*arguments: object) -> Ran:
    """Runs ``mgjax`` with these arguments."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            status = main([str(argument) for argument in arguments])
        except SystemExit as stop:
            status = int(stop.code or 0)
    return Ran(status=status, out=out.getvalue(), err=err.getvalue())


def refused(ran: Ran, *words: str, out: Path | None = None) -> str:
    """Asserts one clear line with exit status 2, and that nothing was written."""
    assert (ran.status, ran.out) == (2, ""), ran
    assert ran.err.count("\n") == 1, ran.err
    assert ran.err.startswith("mgjax: ")
    assert "got " in ran.err or "cannot be written" in ran.err, ran.err
    assert "expected" in ran.err, ran.err
    for word in words:
        assert word in ran.err, (word, ran.err)
    if out is not None:
        assert not out.exists(), sorted(out.rglob("*"))
    return ran.err


@pytest.fixture(scope="session")
def clips_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Four made clips as BVH files, their labels beside them."""
    folder = tmp_path_factory.mktemp("clips")
    clips, labels = synthetic_clips()
    for clip in clips:
        if clip.name in USED:
            save_bvh(folder / f"{clip.name}.bvh", clip.skeleton, clip.motion)
    document = {
        f"{name}.bvh": [
            {"start_s": x.start_s, "end_s": x.end_s, "kind": x.kind, "direction": x.direction}
            for x in items
        ]
        for name, items in labels.items()
        if name in USED
    }
    (folder / "labels.json").write_text(json.dumps({"clips": document}, indent=1))
    (folder / "graph.toml").write_text("threshold_m = 0.05\n")
    return folder


@pytest.fixture(scope="session")
def built(clips_folder: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Ran]:
    """The folder of a built graph, and what the command printed."""
    out = tmp_path_factory.mktemp("built") / "deep" / "graph"
    ran = run(
        *("build", "--clips", clips_folder, "--labels", clips_folder / "labels.json"),
        *("--config", clips_folder / "graph.toml", "--out", out, "--json"),
    )
    assert ran.status == 0, ran.err
    return out, ran


@pytest.fixture
def one_clip(clips_folder: Path, tmp_path: Path) -> Path:
    """A folder of one's own with one clip and its labels, to be spoiled."""
    folder = tmp_path / "one"
    folder.mkdir()
    for name in ("duck.bvh", "labels.json"):
        shutil.copy(clips_folder / name, folder / name)
    document = json.loads((folder / "labels.json").read_text())["clips"]
    labels = {"clips": {"duck.bvh": document["duck.bvh"]}}
    (folder / "labels.json").write_text(json.dumps(labels, indent=1))
    return folder
