"""What the README shows in Python runs as it stands, and does what it says."""

from __future__ import annotations

from pathlib import Path

import pytest

from mgjax.io.load import load_motion
from tests.docs.pages import blocks


def test_it_is_short() -> None:
    (block,) = [block for block in blocks("README.md") if block.language == "python"]
    assert len(block.text.split("\n")) <= 12  # ten lines, one between, and the end


@pytest.mark.long
def test_the_example_avoids_and_says_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (block,) = [block for block in blocks("README.md") if block.language == "python"]
    monkeypatch.chdir(tmp_path)
    exec(compile(block.text, "README.md", "exec"), {"__name__": "readme"})
    said = capsys.readouterr()
    assert said.out.startswith("avoided 0.")
    assert "distances" in said.err  # how far the graph is
    _, motion = load_motion(tmp_path / "avoided.bvh")
    assert motion.num_frames > 60
