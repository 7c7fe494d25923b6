"""``mgjax fetch``, from a server on this machine."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.cli.conftest import refused, run
from tests.io.fetch.server import Database, served


@pytest.fixture(autouse=True)
def cache(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    monkeypatch.setenv("no_proxy", "127.0.0.1")
    monkeypatch.setenv("MGJAX_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache"


def test_fetched_and_what_to_do_next(cache: Path) -> None:
    with served(Database({"07_01": 120, "60_01": 60})) as database:
        ran = run("fetch", "cmu", 7, 60, 7, "--server", database.address)
        assert (ran.status, ran.err) == (0, "")
        assert f"mgjax build --clips {cache / 'cmu' / '07'} --out out/cmu07" in ran.out
        assert "subject 60: 2 files, 2 of them new" in ran.out
        assert "60 fps, as the database states" in ran.out
        assert "NSF EIA-0196217" in ran.out
        (row,) = run("fetch", "cmu", 60, "--server", database.address, "--json").json["subjects"]
    assert (row["files"], row["new"], row["missing"]) == (2, 0, [])
    assert row["frame_rates"] == {"60_01": 60.0}


def test_bad_input(cache: Path) -> None:
    with served(Database({})) as database:
        address = database.address
    refused(run("fetch", "cmu", 7, "--server", address), "no connection", out=cache)
    refused(run("fetch", "cmu", 7, 4, "--server", address), "subject 4", "1–3, 5–43", out=cache)
    refused(run("fetch", "cmu"), "no subject", out=cache)
