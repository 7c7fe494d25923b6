"""What the documentation shows is so: its code runs, in one folder, page after page."""

from __future__ import annotations

import json
import shlex
import tomllib
from pathlib import Path

import pytest
import tyro

from mgjax.cli.main import Command, main
from tests.docs.pages import NOT_RUN, ROOT, Block, blocks, outside_fences, pages

LANGUAGES = {"python", "sh", "toml", "json", "csv", "text"}
CANNOT_RUN = {
    "README.md": ["makes an environment"],
    "docs/index.md": ["makes an environment", "makes an environment", "needs a network"],
    "docs/howto/page.md": ["serves a page until it is stopped"],
    "docs/howto/python.md": ["minutes of computing"] * 3,
    "docs/howto/label.md": ["serves a page until it is stopped"],
    "docs/howto/sensor.md": ["installs a package", "needs a sensor"],
    "docs/howto/export.md": ["needs Blender"],
    "docs/formats.md": ["needs Blender"],
    "docs/scaling.md": ["needs a cluster and a GPU"],
    "docs/study.md": ["needs picks of observers"],
}
"""All that is shown and not run, and why."""


def all_blocks() -> list[Block]:
    return [block for page in pages() for block in blocks(page)]


def command_lines(block: Block) -> list[list[str]]:
    lines = block.text.replace("\\\n", " ").split("\n")
    return [words for line in lines if (words := shlex.split(line, comments=True))]


@pytest.mark.parametrize("page", pages())
def test_code_is_fenced_and_says_what_it_is(page: str) -> None:
    assert {block.language for block in blocks(page)} <= LANGUAGES
    before = ""
    for number, line in outside_fences(page):
        code = line.startswith("    ") and not before.strip()
        assert not code, f"{page}:{number}: code without a fence"
        before = line


def test_all_but_a_few_run() -> None:
    marked = {page: [b.not_run for b in blocks(page) if b.not_run] for page in pages()}
    assert {page: reasons for page, reasons in marked.items() if reasons} == CANNOT_RUN
    for page in pages():  # a mark that is not just above a block would be forgotten
        marks = [line for _, line in outside_fences(page) if NOT_RUN.search(line)]
        assert len(marks) == len(marked[page])


def test_files_are_read() -> None:
    for block in all_blocks():
        if block.language == "toml":
            tomllib.loads(block.text)
        elif block.language == "json":
            json.loads(block.text)


def test_commands_that_are_not_run_have_arguments_that_there_are() -> None:
    lines = [words for b in all_blocks() if b.not_run for words in command_lines(b)]
    commands = [words[1:] for words in lines if words[0] == "mgjax"]
    assert commands
    config = (tyro.conf.FlagCreatePairsOff, tyro.conf.HelptextFromCommentsOff)
    for words in commands:
        tyro.cli(Command, args=words, config=config)  # pyright: ignore[reportArgumentType]


@pytest.mark.long
def test_every_block_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "configs").symlink_to(ROOT / "configs")
    for page in pages()[1:]:  # README.md has a test of its own
        names = {"__name__": page}
        for block in blocks(page):
            if block.not_run:
                continue
            if block.title:
                Path(block.title).write_text(block.text)
            elif block.language == "python":
                code = "\n" * (block.line - 1) + block.text
                exec(compile(code, str(ROOT / page), "exec"), names)
            elif block.language == "sh":
                for words in command_lines(block):
                    assert words[0] == "mgjax", f"{block}: {words[0]}"
                    assert main(words[1:]) == 0, f"{block}: {shlex.join(words)}"
