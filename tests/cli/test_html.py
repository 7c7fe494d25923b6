"""Pages that commands write beside their results."""

from pathlib import Path

from mgjax.cli import arguments
from mgjax.clips.synthetic import synthetic_clips
from mgjax.core.motion import cut
from mgjax.io.bvh.write import save_bvh
from tests.cli.conftest import refused, run


def motion_file(folder: Path) -> Path:
    clip = synthetic_clips()[0][0]
    path = folder / "one.bvh"
    save_bvh(path, clip.skeleton, cut(clip.motion, 0, 20))
    return path


def test_convert_writes_a_page(tmp_path):
    page = tmp_path / "page.html"
    assert run("convert", motion_file(tmp_path), "--out", page).status == 0
    assert "<title>one.bvh</title>" in page.read_text()


def test_convert_writes_pages_of_a_folder(tmp_path):
    motion_file(tmp_path)
    ran = run("convert", tmp_path, "--to", ".html", "--out", tmp_path / "pages")
    assert ran.status == 0
    assert [path.name for path in (tmp_path / "pages").iterdir()] == ["one.html"]


def test_info_writes_a_page(tmp_path):
    out = tmp_path / "info"
    assert run("info", motion_file(tmp_path), "--html", "--out", out).status == 0
    assert {path.name for path in out.iterdir()} == {"index.html", "info.json"}


def test_info_needs_a_place_for_it(tmp_path):
    refused(run("info", motion_file(tmp_path), "--html"), "--out DIR")


def test_each_command_with_a_result_has_it():
    for command in ("Avoid", "Walk", "Scene", "Coverage", "Build", "Info"):
        assert getattr(arguments, command).html is False
