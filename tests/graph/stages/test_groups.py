from __future__ import annotations

import numpy as np

from mgjax.graph.stages.groups import Group, group_clips, unique_keys


def groups_of(lengths: dict[str, int], known: list[list[str]] | None = None) -> list[Group]:
    stops = np.cumsum(list(lengths.values()))
    starts = stops - list(lengths.values())
    return group_clips(list(lengths), starts, stops, known or [], gap=1, entries=100)


def members(groups: list[Group]) -> set[frozenset[str]]:
    return {frozenset(group.members) for group in groups}


def test_clips_are_packed_with_their_gaps_and_a_long_one_is_alone():
    found = groups_of({"a": 60, "b": 250, "c": 39, "d": 38, "e": 58})
    # 61 + 39 fill a group to the last entry; 40 would not have fitted beside 61.
    assert members(found) == {frozenset("ad"), frozenset("b"), frozenset("ce")}


def test_frames_are_those_of_the_members_in_their_order():
    lengths = {"a": 60, "b": 250, "c": 30}
    found = {group.members: group for group in groups_of(lengths)}
    np.testing.assert_array_equal(found["a", "c"].frames, [*range(60), *range(310, 340)])
    assert found["a", "c"].lengths == (60, 30)


def test_groups_stay_when_clips_are_added_or_moved():
    lengths = {"a": 60, "b": 60, "c": 30, "d": 30}
    first = groups_of(lengths)
    known = [list(group.members) for group in first]
    later = groups_of({"new": 20, "d": 30, "c": 30, "b": 60, "a": 60}, known)
    assert members(later) == members(first) | {frozenset(["new"])}
    assert {g.key for g in first} < {g.key for g in later}


def test_a_group_that_lost_a_clip_is_packed_anew():
    known = [["a", "c"], ["b", "d"]]
    assert members(groups_of({"a": 60, "b": 60, "d": 30}, known)) == {
        frozenset("a"),
        frozenset("bd"),
    }


def test_many_small_groups_are_packed_together_with_what_is_new():
    known = [[name] for name in "abcde"]
    small = dict.fromkeys("abcde", 19)
    assert members(groups_of(small, known)) == {frozenset(name) for name in "abcde"}
    assert members(groups_of(small | {"f": 19}, known)) == {frozenset("abcdf"), frozenset("e")}
    four = dict.fromkeys("abcd", 19)
    assert len(groups_of(four | {"f": 19}, known[:4])) == 5


def test_equal_clips_are_told_apart():
    assert unique_keys(["x", "y", "x", "x"]) == ["x", "y", "x+1", "x+2"]
