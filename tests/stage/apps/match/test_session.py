"""A match behind the page, its clock moved by hand."""

from __future__ import annotations

import io
import json
import zipfile
from typing import Any

import numpy as np
import pytest

from mgjax.ballsport.clipset.repertoire import Repertoire
from mgjax.core.errors import ConfigError, MgjaxError
from mgjax.sensor.frames import SensorFrame
from mgjax.stage.apps.match.app import MatchApp, clips_of_user
from mgjax.stage.apps.match.export import match_show
from mgjax.stage.apps.match.session import MatchSession
from mgjax.stage.apps.match.source import ClipSource, SensorSource
from mgjax.stage.packet import pack, unpack


class PageOfMatch:
    """A page that plays what it is sent."""

    def __init__(self, moves: Repertoire, **options: Any) -> None:
        self.sent: list[dict[str, Any]] = []
        self.time = 0.0
        self.session = MatchSession(self.sent.append, moves, clips_of_user(""), **options)

    def ask(self, kind: str, /, **values: Any) -> None:
        self.session.receive({"type": kind, **values})

    def last(self, what: str) -> dict[str, Any]:
        """The newest note of a kind."""
        return next(m for m in reversed(self.sent) if m.get("what") == what)

    def notes(self, what: str) -> list[dict[str, Any]]:
        return [m for m in self.sent if m.get("what") == what]

    def of(self, kind: str) -> list[dict[str, Any]]:
        return [m for m in self.sent if m["type"] == kind]

    def play(self, seconds: float) -> None:
        """Plays on, never beyond what is known."""
        for _ in range(round(seconds / 0.1)):
            self.time = min(self.time + 0.1, self.last("played")["known"])
            self.ask("clock", game=self.last("match")["game"], time=self.time)

    @property
    def passes(self) -> list[tuple[str, str]]:
        return [(p["by"], p["to"]) for p in self.last("played")["passes"]]


@pytest.fixture
def page(moves: Repertoire) -> PageOfMatch:
    return PageOfMatch(moves)


def test_it_opens_with_all_there_is(page: PageOfMatch) -> None:
    """Ready, then a show with players, net and a mesh, which can be packed."""
    assert [m["type"] for m in page.sent[:2]] == ["ready", "show"]
    show = unpack(pack(page.sent[1]))["show"]
    assert [actor["id"] for actor in show["actors"]] == ["Ana", "Ben", "Cem"]
    assert [thing["shape"] for thing in show["things"]] == ["net"]
    assert show["bodies"][0]["mesh"]["triangles"].size > 1000
    assert page.last("played")["known"] >= 0.45


def test_it_plays_ahead_of_the_page(page: PageOfMatch) -> None:
    """What is certain is always half a second ahead, and frames follow without a gap."""
    page.play(8.0)
    assert page.time == pytest.approx(8.0)
    assert page.last("played")["known"] >= 8.45
    frames = [m["frames"] for m in page.of("frames") if m["actor"] == "Ana"]
    ends = [f["start"] + len(f["rotations"]) / f["rate"] for f in frames]
    np.testing.assert_allclose([f["start"] for f in frames[1:]], ends[:-1], atol=1e-9)
    assert len(page.passes) >= 4
    assert "arrives within 0.0" in page.last("played")["passes"][0]["words"]


def test_a_click_decides_the_next_pass(page: PageOfMatch) -> None:
    page.play(3.0)
    holder = page.last("wishes")["holder"]
    wanted = {"Ana": "Cem", "Ben": "Ana", "Cem": "Ben"}[holder]
    page.ask("wish", kind="attack", bounces="1", on=False)
    page.ask("pick", player=wanted)
    assert page.last("wishes")["picked"] == [wanted]
    page.play(8.0)
    made = [p for p in page.last("played")["passes"] if (p["by"], p["to"]) == (holder, wanted)][-1]
    assert (made["kind"], made["bounces"]) == ("attack", 1)


def test_it_waits_until_it_is_told(page: PageOfMatch) -> None:
    """Without a click the ball goes to nobody; with one it is thrown in again."""
    page.ask("wish", kind="any", bounces="1", on=False)
    page.play(10.0)
    wishes = page.last("wishes")
    assert wishes["waits"]
    count = len(page.passes)
    assert page.passes[-1][1] == ""
    assert "waits" in page.last("played")["passes"][-1]["words"]
    wanted = next(name for name in ("Ana", "Ben") if name != wishes["holder"])
    page.ask("pick", player=wanted)
    assert not page.last("wishes")["waits"]
    page.play(6.0)
    assert page.passes[count : count + 2] == [
        ("", wishes["holder"]), (wishes["holder"], wanted),
    ]  # fmt: skip


def test_a_click_is_taken_back(page: PageOfMatch) -> None:
    with pytest.raises(ConfigError, match="nobody clicked"):
        page.ask("unpick")
    holder = page.last("wishes")["holder"]
    page.ask("pick", player="Ben" if holder == "Ana" else "Ana")
    page.ask("unpick")
    assert page.last("wishes")["picked"] == []


def test_a_replayed_clip_kicks_for_the_user(page: PageOfMatch) -> None:
    """Its body is shown, its kick matched and played beside it, and a pass made like that."""
    page.play(2.0)
    page.ask("replay", clip="kick_pass_right")
    page.play(9.0)
    said = [note["text"] for note in page.notes("user")]
    (matched,) = [text for text in said if "matched kick" in text]
    assert matched.startswith("right foot, ")
    assert " m/s; matched kick " in matched
    put = {m["item"].get("id"): m["item"] for m in page.of("put") if m["kind"] == "actors"}
    assert put["user"]["note"] == "kick_pass_right"
    number = int(matched.split("matched kick ")[1].split()[0])
    assert put["matched"]["note"].startswith(f"kick {number}:")
    user = [m["frames"] for m in page.of("frames") if m["actor"] == "user"]
    assert sum(len(f["rotations"]) for f in user) > 80
    words = [p["words"] for p in page.last("played")["passes"]]
    assert sum("kicked as you did" in text for text in words) == 1


def test_a_paused_page_holds_the_match_up(page: PageOfMatch) -> None:
    page.play(2.0)
    known, sent = page.last("played")["known"], len(page.sent)
    for _ in range(20):
        page.ask("clock", game=1, time=page.time)
    page.ask("clock", game=1, time=0.3)
    assert page.last("played")["known"] == known
    assert len(page.sent) == sent


@pytest.mark.parametrize(("count", "net"), [(6, False), (6, True), (3, False)])
def test_another_pitch_begins_anew(page: PageOfMatch, count: int, net: bool) -> None:
    page.play(1.0)
    page.ask("pitch", players=count, net=net)
    assert len(page.of("show")[-1]["show"]["actors"]) == count
    assert page.last("match")["game"] == 2
    page.ask("clock", game=1, time=50.0)  # the page had not heard of it
    assert page.last("played")["known"] < 3.0
    page.time = 0.0
    page.play(4.0)
    assert len(page.passes) >= 2


def test_what_is_saved_is_what_scene_writes(page: PageOfMatch) -> None:
    with pytest.raises(ConfigError, match="no pass yet"):
        page.ask("export", what="zip")
    page.play(6.0)
    page.ask("export", what="zip")
    (file,) = page.of("file")
    archive = zipfile.ZipFile(io.BytesIO(file["data"].tobytes()))
    names = ["Ana.bvh", "Ben.bvh", "Cem.bvh", "ball.csv", "timeline.json"]
    assert sorted(archive.namelist()) == names
    timeline = json.loads(archive.read("timeline.json"))
    assert [(row["by"], row["to"]) for row in timeline["passes"]] == [
        pair for pair in page.passes if all(pair)
    ]
    assert archive.read("ball.csv").startswith(b"t,x,y,z,event\n")


def test_a_saved_page_has_all_of_it(page: PageOfMatch) -> None:
    page.play(5.0)
    page.ask("export", what="html")
    (file,) = page.of("file")
    assert (file["name"], file["mime"]) == ("match.html", "text/html")
    assert file["data"].tobytes().startswith(b"<!doctype html>")
    show = match_show(page.session.game)
    frames = {actor.id: actor.frames for actor in show.actors}
    for name in ("Ana", "Ben", "Cem"):
        assert len(frames[name].rotations) / frames[name].rate == pytest.approx(
            show.seconds, abs=0.1
        )
    assert {span.row for span in show.spans} >= {"ball", "Ana"}
    assert show.words.endswith("passes, 0 of them missed")


class ByHand(SensorSource):
    """A sensor whose frames are those of a clip."""

    def __init__(self, clip: ClipSource) -> None:
        self.place, self.over, self.closed = "127.0.0.1:1", False, False
        self._clip, self.now = clip, 0.0

    def frames(self, now_s: float) -> Any:
        return self._clip.frames(self.now)

    @property
    def silence(self) -> str:
        return "no packet came"

    def close(self) -> None:
        self.closed = True


def test_a_sensor_is_heard_while_the_page_is_paused(moves: Repertoire) -> None:
    """Its frames come by its own clock; it is freed when it is switched off."""
    clip = clips_of_user("")["kick_attack_left"]
    sensor = ByHand(ClipSource(clip.skeleton, clip.motion, 0.0))
    page = PageOfMatch(moves, open_sensor=lambda: sensor)
    page.ask("sensor", on=True)
    assert "listening for a VMC sender on 127.0.0.1:1" in page.last("user")["text"]
    page.session.tick()
    assert page.last("user")["text"] == "no packet came"
    for _ in range(260):
        sensor.now += 1 / 60
        page.session.tick()
    assert page.last("user")["text"].startswith("left foot, ")
    page.ask("sensor", on=False)
    assert sensor.closed
    removed = [m["id"] for m in page.of("remove")]
    assert removed == ["user", "matched"]


def test_a_taken_port_is_said(moves: Repertoire) -> None:
    first = SensorSource(0)
    port = int(first.place.rpartition(":")[2])
    page = PageOfMatch(moves, open_sensor=lambda: SensorSource(port))
    with pytest.raises(ConfigError, match="expected a free port"):
        page.ask("sensor", on=True)
    first.close()
    page.ask("sensor", on=True)
    page.session.close()


@pytest.mark.parametrize(
    "message",
    [
        {"type": "fly"},
        {"type": "pick", "player": "Eve"},
        {"type": "pick", "player": 3},
        {"type": "wish", "kind": "header", "bounces": "1", "on": True},
        {"type": "wish", "kind": "any", "bounces": 1, "on": True},
        {"type": "wish", "kind": "any", "bounces": "1", "on": "yes"},
        {"type": "pitch", "players": 4, "net": True},
        {"type": "pitch", "players": 6},
        {"type": "replay", "clip": "../kick"},
        {"type": "export", "what": "/etc"},
        {"type": "clock", "game": 1, "time": float("nan")},
        {"type": "clock", "game": 1, "time": -1.0},
        {"type": "sensor"},
    ],
)
def test_what_cannot_be_changes_nothing(page: PageOfMatch, message: dict[str, Any]) -> None:
    before = len(page.sent)
    with pytest.raises(MgjaxError, match="expected"):
        page.session.receive(message)
    assert len(page.sent) == before


def test_the_application_is_ready_when_it_says_so() -> None:
    """Progress rises, and a session opens on the embedded kicks."""
    app = MatchApp("")
    shares: list[float] = []
    app.prepare(lambda share, text: shares.append(share))
    assert shares == sorted(shares)
    sent: list[dict[str, Any]] = []
    session = app.open(sent.append)
    assert sent[0] == {"type": "ready", "app": "match", "title": "Match", "options": {}}
    session.close()
    app.close()


def test_frames_of_a_clip_come_as_it_is_played() -> None:
    clip = clips_of_user("")["kick_toss_left"]
    source = ClipSource(clip.skeleton, clip.motion, 2.0)
    assert list(source.frames(1.9)) == []
    first: list[SensorFrame] = list(source.frames(3.0))
    assert 30 < len(first) < 62
    assert not source.over
    list(source.frames(60.0))
    assert source.over
