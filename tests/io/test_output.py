from __future__ import annotations

from pathlib import Path

import pytest

from mgjax.core.errors import OutputError
from mgjax.io.output import output_folder, replace_file


def tree(folder: Path) -> dict[str, str]:
    return {p.name: p.read_text() for p in sorted(folder.iterdir()) if p.is_file()}


def test_replace_file(tmp_path):
    replace_file(tmp_path / "a", "one")
    replace_file(tmp_path / "a", b"two")
    assert tree(tmp_path) == {"a": "two"}


def test_files_appear_together_and_others_stay(tmp_path):
    out = tmp_path / "deep" / "out"
    with output_folder(out) as stage:
        (stage / "a").write_text("new")
        assert tree(out) == {}
    (out / "kept").write_text("kept")
    with output_folder(out) as stage:
        (stage / "a").write_text("newer")
        (stage / "b").write_text("b")
    assert tree(out) == {"a": "newer", "b": "b", "kept": "kept"}
    assert len(list(out.iterdir())) == 3


def fail_in(out: Path) -> None:
    with output_folder(out) as stage:
        (stage / "a").write_text("half")
        raise RuntimeError("on the way")


def test_nothing_half_written(tmp_path):
    with pytest.raises(RuntimeError, match="on the way"):
        fail_in(tmp_path / "deep" / "out")
    assert list(tmp_path.iterdir()) == []
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "a").write_text("old")
    with pytest.raises(RuntimeError, match="on the way"):
        fail_in(tmp_path / "out")
    assert tree(tmp_path / "out") == {"a": "old"}
    assert len(list((tmp_path / "out").iterdir())) == 1


def open_folder(path: str | Path) -> None:
    with output_folder(path):
        pass


def test_places_that_cannot_be_written(tmp_path):
    (tmp_path / "file").write_text("x")
    for path in (tmp_path / "file", tmp_path / "file" / "in", "nul\0byte", "x" * 300):
        with pytest.raises(OutputError, match="cannot be written") as error:
            open_folder(path)
        assert str(error.value).isprintable()
    assert tree(tmp_path) == {"file": "x"}
