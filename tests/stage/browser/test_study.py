"""The page that leads through a study, opened from a folder in a real browser."""

import pytest

from mgjax.avoidance.attacks.ball import ball_from
from mgjax.avoidance.study.reading import read_study
from mgjax.clips.synthetic import synthetic_clips
from mgjax.core.motion import cut
from mgjax.stage.html import page_html
from mgjax.stage.observers import index_html
from mgjax.stage.study import trial_show
from tests.avoidance.study.made import drawn_measures, key_text

SIZES = (4, 2)
"""Candidates of the trials."""


PLAYS = """async () => {
  while (!(window.mgjax?.player?.time > 0.1)) await new Promise((done) => setTimeout(done, 50));
  return window.mgjax.player.time;
}"""
"""The time that is shown once the page plays."""


@pytest.fixture
def folder(tmp_path):
    """Two trials whose candidates are pieces of one clip."""
    clip = next(clip for clip in synthetic_clips()[0] if clip.name == "walk")
    pages: list[tuple[str, int]] = []
    for number, count in enumerate(SIZES, 1):
        motions = [cut(clip.motion, 10 * k, 10 * k + 30) for k in range(count)]
        ball = ball_from(0.3, 1.2, arrives=0.6)
        show = trial_show(clip.skeleton, motions, ball, title=f"Trial {number}")
        (tmp_path / f"{number}.html").write_text(page_html(show, bare=True))
        pages.append((f"{number}.html", count))
    (tmp_path / "index.html").write_text(index_html("one", pages))
    return tmp_path


def test_an_observer_picks_goes_on_and_saves(chromium, folder):
    context = chromium.new_context(viewport={"width": 640, "height": 480}, offline=True)
    noted: list[str] = []
    context.on("weberror", lambda error: noted.append(str(error.error)))
    page = context.new_page()
    page.goto((folder / "index.html").as_uri())
    # The page of a trial allows no ``eval``, by which Playwright would wait for a function.
    plays = page.frames[1].evaluate(PLAYS)
    assert plays > 0.1
    assert page.locator("#picks button").all_text_contents() == ["A", "B", "C", "D"]
    page.click("#picks button:nth-child(2)")
    assert page.locator("#save").is_disabled(), "nobody has said who picks"
    page.fill("#observer", "Ann B.")
    page.click("#next")
    page.wait_for_function("document.querySelectorAll('#picks button').length === 2")
    page.click("#picks button:nth-child(2)")
    page.click("#picks button:nth-child(1)")
    page.reload()
    assert page.text_content("#where") == "Trial 2 of 2, 2 picked"
    assert page.locator("#picks [aria-pressed=true]").all_text_contents() == ["A"]
    with page.expect_download() as download:
        page.click("#save")
    download.value.save_as(folder / "picks.jsonl")
    context.close()
    measured = drawn_measures(2, seed=0)  # of four candidates, then of some
    (folder / "key.json").write_text(key_text(measured))
    study = read_study([folder / "key.json", folder / "picks.jsonl"])
    found = [(pick.trial, pick.observer, pick.place) for pick in study.picks]
    assert found == [("1", "Ann B.", 1), ("2", "Ann B.", 0)]
    assert noted == []
