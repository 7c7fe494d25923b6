"""What the README shows in Python runs as it stands, and does what it says."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from mgjax.io.load import load_motion

README = Path(__file__).resolve().parent.parent / "README.md"


@pytest.mark.long
def test_the_first_example_avoids_and_says_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    blocks = re.findall(r"```python\n(.*?)```", README.read_text(), flags=re.DOTALL)
    assert blocks
    monkeypatch.chdir(tmp_path)
    exec(compile(blocks[0], "README.md", "exec"), {"__name__": "readme"})
    said = capsys.readouterr()
    assert said.out.startswith("avoided 0.")
    assert "distances" in said.err  # how far the graph is
    _, motion = load_motion(tmp_path / "avoided.bvh")
    assert motion.num_frames > 60
