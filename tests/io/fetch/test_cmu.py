from __future__ import annotations

from pathlib import Path

import pytest

from mgjax.clips.folder import load_clips
from mgjax.core.errors import ConfigError, FetchError, OutputError
from mgjax.io.fetch.cmu import ask, fetch_subject, rates_toml, subjects_in_words
from mgjax.io.fetch.cmu_subjects import LAST, RATES, known_motions
from tests.io.fetch.server import AMC, ASF, Database, served


@pytest.fixture(autouse=True)
def no_proxy(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("no_proxy", "127.0.0.1")


def test_a_subject_comes_once(tmp_path: Path) -> None:
    with served(Database({"07_01": 120, "07_02": 120, "08_01": 120})) as database:
        fetched = fetch_subject(7, tmp_path, server=database.address + "/")
        assert (fetched.new, fetched.there, fetched.missing) == (3, 0, ())
        assert fetched.size == len(ASF) + 2 * (len(AMC) - 1)
        assert fetched.folder == tmp_path / "07"
        names = sorted(p.name for p in fetched.folder.iterdir())
        assert names == ["07.asf", "07_01.amc", "07_02.amc"]
        assert (fetched.folder / "07_02.amc").read_text() == AMC.format(1)
        asked = len(database.asked)
        again = fetch_subject(7, tmp_path, server=database.address)
        assert (again.new, again.there, again.size) == (0, 3, 0)
        assert database.asked[asked:] == ["/search.php"]


def test_what_was_stopped_goes_on(tmp_path: Path) -> None:
    with served(Database({"07_01": 120, "07_02": 120})) as database:
        database.cut = {"/subjects/07/07_02.amc"}
        with pytest.raises(FetchError, match=f" bytes of {len(AMC) - 1}, exp") as caught:
            fetch_subject(7, tmp_path, server=database.address)
        assert "2 of 3 files are there" in str(caught.value)
        assert sorted(p.name for p in (tmp_path / "07").iterdir()) == ["07.asf", "07_01.amc"]
        database.cut.clear()
        fetched = fetch_subject(7, tmp_path, server=database.address)
        assert (fetched.new, fetched.there) == (1, 2)


def test_rates_are_those_of_the_page_and_read_with_the_clips(tmp_path: Path) -> None:
    with served(Database({"60_01": 60, "60_02": 120, "61_01": 60, "61_02": 60})) as database:
        for number in (60, 61):
            assert fetch_subject(number, tmp_path, server=database.address).subject.stated
    clips, _ = load_clips(tmp_path)
    rates = {clip.name: clip.motion.frame_rate for clip in clips}
    assert rates == {
        "60/60_01.amc": 60,
        "60/60_02.amc": 120,
        "61/61_01.amc": 60,
        "61/61_02.amc": 60,
    }
    assert (tmp_path / "61" / "clips.toml").read_text() == "frame_rate = 60\n"


def test_a_page_that_says_nothing(tmp_path: Path) -> None:
    with served(Database({"09_01": None, "09_02": 120})) as database:
        assert ask(9, database.address).rates == {"09_01": 120, "09_02": 120}
        assert not ask(9, database.address).stated
        known = ask(60, database.address)  # its page has no motions
        assert known.rates == dict.fromkeys(known_motions(60), 60.0)
        assert not known.stated
    with served(Database({"11_01": 120})) as database:
        del database.files["/subjects/11/11_01.amc"]
        fetched = fetch_subject(11, tmp_path, server=database.address)
        assert (fetched.missing, fetched.new) == (("11_01",), 1)


def test_what_is_not_capture_is_not_kept(tmp_path: Path) -> None:
    with served(Database({"07_01": 120})) as database:
        database.files["/subjects/07/07.asf"] = "<html>please log in</html>"
        with pytest.raises(FetchError, match="something else"):
            fetch_subject(7, tmp_path, server=database.address)
        assert list((tmp_path / "07").iterdir()) == []
        del database.files["/subjects/07/07.asf"]
        with pytest.raises(FetchError, match="404"):
            fetch_subject(7, tmp_path, server=database.address)


def test_no_server(tmp_path: Path) -> None:
    with served(Database({})) as database:
        address = database.address
    with pytest.raises(FetchError, match="no connection"):
        fetch_subject(7, tmp_path / "new", server=address)
    assert not (tmp_path / "new").exists()
    with pytest.raises(FetchError):
        fetch_subject(7, tmp_path / "new", server="no address")


def test_what_cannot_be(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="subject 4, expected one of 1–3, 5–43, 45–47"):
        fetch_subject(4, tmp_path)
    (tmp_path / "file").write_text("")
    with served(Database({"07_01": 120})) as database, pytest.raises(OutputError):
        fetch_subject(7, tmp_path / "file", server=database.address)


def test_what_is_known_offline() -> None:
    assert set(RATES) <= set(LAST) <= set(range(1, 145))
    assert known_motions(41)[0] == "41_02"
    assert known_motions(102)[-1] == "102_33"
    assert subjects_in_words().endswith("118, 120, 122–128, 131–144")
    assert rates_toml({"05_01": 120.0, "05_02": 60.0}) == '["05_02.amc"]\nframe_rate = 60\n'
