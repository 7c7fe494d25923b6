"""Which joint is a joint's twin on the other side of the body."""

from __future__ import annotations

from mgjax.core.body.names import read_name
from mgjax.core.skeleton import Skeleton


def mirror_joints(skeleton: Skeleton) -> tuple[int, ...]:
    """Each joint's twin on the other side, or the joint itself where it has none.

    Twins have the same name but for the side, wherever in the name that stands; ends of bones are
    twins where their joints are.
    """
    ends = set(skeleton.end_joints)
    sided: dict[tuple[object, ...], list[int]] = {}
    for joint, name in enumerate(skeleton.names):
        hint = read_name(name)
        if hint.side and joint not in ends:
            sided.setdefault(hint.words, []).append(joint)
    twins = list(range(skeleton.num_joints))
    for two in sided.values():
        sides = {read_name(skeleton.names[j]).side for j in two}
        if len(two) == 2 and len(sides) == 2:
            twins[two[0]], twins[two[1]] = two[1], two[0]
    _pair_ends(skeleton, twins)
    return tuple(twins)


def _pair_ends(skeleton: Skeleton, twins: list[int]) -> None:
    """Ends of twins are twins, in the order in which they hang on their joints."""
    below: dict[int, list[int]] = {}
    for end in skeleton.end_joints:
        below.setdefault(skeleton.parents[end], []).append(end)
    for joint, ends in below.items():
        others = below.get(twins[joint], [])
        if len(ends) == len(others):
            for end, other in zip(ends, others, strict=True):
                twins[end] = other
