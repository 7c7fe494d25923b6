"""Labels that are edited: never over one another, and every step can be taken back."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mgjax.clips.types import Label
from mgjax.core.errors import ConfigError
from mgjax.stage.apps.edit.table import Extent, Interval, LabelTable

CLIP = Extent(frames=100, rate=30.0)


def made(*spans: tuple[float, float]) -> LabelTable:
    items = tuple(
        Interval(id=n, label=Label(start_s=a, end_s=b, kind="duck"))
        for n, (a, b) in enumerate(spans)
    )
    return LabelTable({"one": items})


def spans(table: LabelTable, extent: Extent = CLIP) -> list[tuple[int, int]]:
    labels = [i.label for i in table.of("one")]
    return [(extent.frame(x.start_s), extent.frame(x.end_s)) for x in labels]


def test_a_new_label_lies_in_its_frames():
    table = made()
    label = table.add("one", CLIP, 3, 10, kind="sway", direction="left", genuine=False).label
    assert (label.start_s, label.end_s) == (0.1, 0.333333)
    assert (label.kind, label.direction, label.genuine) == ("sway", "left", False)
    assert spans(table) == [(3, 10)]


@pytest.mark.parametrize(
    ("start", "stop", "what"),
    [
        (5, 12, "overlaps duck 0.33 … 0.67 s"),
        (12, 15, "overlaps"),
        (19, 25, "overlaps"),
        (0, 50, "overlaps"),
        (-1, 5, "outside the clip"),
        (90, 101, "outside the clip"),
        (30, 30, "without a frame"),
        (31, 30, "without a frame"),
    ],
)
def test_what_cannot_be_is_said_and_changes_nothing(start, stop, what):
    table = made((10 / 30, 20 / 30))
    with pytest.raises(ConfigError, match=what):
        table.add("one", CLIP, start, stop, kind="duck")
    assert spans(table) == [(10, 20)]
    assert not table.changed
    assert not table.can_undo


def test_touching_is_legal():
    table = made((10 / 30, 20 / 30))
    table.add("one", CLIP, 5, 10, kind="duck")
    table.add("one", CLIP, 20, 25, kind="duck")
    assert spans(table) == [(5, 10), (10, 20), (20, 25)]


def test_an_end_that_stays_in_its_frame_stays_exactly():
    table = made((0.3401, 0.6601))
    new = table.change("one", CLIP, 0, start=10, stop=25).label
    assert new.start_s == 0.3401
    assert new.end_s == CLIP.seconds(25)


def test_a_change_of_kind_moves_nothing_though_labels_of_the_file_overlap():
    table = made((0.0, 1.0), (0.5, 1.5))
    table.change("one", CLIP, 0, kind="jump")
    assert [i.label.kind for i in table.of("one")] == ["jump", "duck"]
    with pytest.raises(ConfigError, match="overlaps"):
        table.change("one", CLIP, 0, stop=29)
    table.change("one", CLIP, 0, stop=15)
    assert spans(table) == [(0, 15), (15, 45)]


def test_a_change_that_changes_nothing_is_no_step():
    table = made((0.0, 1.0))
    table.change("one", CLIP, 0, start=0, stop=30, kind="duck")
    assert not table.can_undo


def test_unknown_labels_and_steps_are_refused():
    table = made((0.0, 1.0))
    for wrong in (
        lambda: table.delete("one", 7),
        lambda: table.delete("two", 0),
        lambda: table.change("one", CLIP, 7, kind="jump"),
        table.undo,
        table.redo,
    ):
        with pytest.raises(ConfigError, match="expected"):
            wrong()


def test_what_is_saved_is_not_changed_and_undo_comes_back_to_it():
    table = made((0.0, 1.0))
    table.delete("one", 0)
    assert table.changed
    table.mark_saved()
    assert not table.changed
    assert table.undo() == "one"
    assert table.changed
    assert table.redo() == "one"
    assert not table.changed


@given(
    frame=st.integers(0, 10**6),
    rate=st.one_of(st.floats(1, 1000), st.sampled_from([29.97, 59.94, 1 / 0.0333333])),
)
def test_seconds_mean_the_frame(frame, rate):
    extent = Extent(frames=10**6, rate=rate)
    assert extent.frame(extent.seconds(frame)) == frame


STEP = st.one_of(
    st.tuples(st.just("add"), st.integers(-2, 40), st.integers(-2, 42)),
    st.tuples(st.just("change"), st.integers(0, 8), st.integers(-2, 42), st.integers(-2, 42)),
    st.tuples(st.just("kind"), st.integers(0, 8), st.sampled_from(["duck", "jump"])),
    st.tuples(st.just("delete"), st.integers(0, 8)),
    st.tuples(st.just("undo")),
    st.tuples(st.just("redo")),
)


def do(table: LabelTable, extent: Extent, step: tuple) -> None:
    name, *more = step
    if name == "add":
        table.add("one", extent, *more, kind="duck")
    elif name == "change":
        table.change("one", extent, more[0], start=more[1], stop=more[2])
    elif name == "kind":
        table.change("one", extent, more[0], kind=more[1])
    elif name == "delete":
        table.delete("one", more[0])
    else:
        getattr(table, name)()


@given(steps=st.lists(STEP, max_size=30), rate=st.sampled_from([29.97, 30.0, 120.0]))
def test_no_steps_lead_to_an_overlap_and_all_are_undone(steps, rate):
    extent = Extent(frames=40, rate=rate)
    table = LabelTable()
    past = [table.of("one")]
    future: list[tuple] = []
    for step in steps:
        before = table.of("one")
        try:
            do(table, extent, step)
        except ConfigError:
            assert table.of("one") == before
            continue
        now = table.of("one")
        if step[0] == "undo":
            future.append(past.pop())
            assert now == past[-1]
        elif step[0] == "redo":
            past.append(future.pop())
            assert now == past[-1]
        elif now != before:
            past.append(now)
            future.clear()
        ordered = sorted(spans(table, extent))
        assert all(0 <= a < b <= 40 for a, b in ordered)
        assert all(one[1] <= two[0] for one, two in zip(ordered, ordered[1:], strict=False))
        assert len({i.id for i in now}) == len(now)
    while table.can_undo:
        table.undo()
    assert table.of("one") == ()
