"""Targets that one-sided joint limits allow."""

from __future__ import annotations

import json

import numpy as np

from mgjax.core.body.joint_limits import clamp, joint_limits, random_rotations
from mgjax.core.kinematics import forward
from mgjax.core.skeleton import Skeleton
from mgjax.hybrid import REACHED
from mgjax.hybrid.ik.tree import fabrik_tree
from tests.cases.inputs import case_file, cases


def solve(case: dict, targets: np.ndarray) -> None:
    """All targets are reached from the identity, within the limits."""
    offsets = np.array(case["offsets"], np.float32)
    count, parents, ends = len(offsets), tuple(case["parents"]), tuple(case["ends"])
    limits = limits_of(case)
    start = np.zeros((len(targets), count, 4), np.float32)
    start[..., 0] = 1
    base = np.zeros((len(targets), 3), np.float32)
    local, status = fabrik_tree(
        offsets, base, start, targets[:, None].astype(np.float32),
        parents=parents, ends=ends, limits=limits, tolerance=case["tolerance"],
    )  # fmt: skip
    assert (np.asarray(status) == REACHED).all()
    local = np.asarray(local)
    miss = np.linalg.norm(ends_of(case, local) - targets, axis=-1)
    assert miss.max() < case["tolerance"] + 1e-6
    np.testing.assert_allclose(np.asarray(clamp(local, limits))[:, :-1], local[:, :-1], atol=1e-4)


def limits_of(case: dict):
    """A bone points to the next joint."""
    bones = np.roll(np.array(case["offsets"]), -1, axis=0)
    return joint_limits(bones, swing=case["swing"], twist=case["twist"], across=case["across"])


def ends_of(case: dict, local: np.ndarray) -> np.ndarray:
    offsets = np.array(case["offsets"], np.float32)
    names = tuple(map(str, range(len(offsets))))
    chain = Skeleton(names=names, parents=tuple(case["parents"]), offsets=offsets)
    places, _ = forward(chain, np.zeros((len(local), 3), np.float32), local)
    return np.asarray(places)[:, case["ends"][0]]


def test_both_are_reached() -> None:
    entries = json.loads(case_file("ik/one_sided_limits.json").read_text(encoding="utf-8"))
    assert len(entries) == 2
    for entry in entries:
        solve(entry, np.array([entry["target"]]))


def test_more_of_the_same_kind() -> None:
    entry, *_ = json.loads(case_file("ik/one_sided_limits.json").read_text(encoding="utf-8"))
    for seed in range(4):
        rng = np.random.default_rng(seed)
        solve(entry, ends_of(entry, random_rotations(rng, 200, limits_of(entry))))


def test_all_cases_are_tested() -> None:
    case_file("expected.json")
    assert {entry["input"] for entry in cases("ik")} == {"ik/one_sided_limits.json"}
