"""Rows of different lengths on one flat axis: compressed sparse rows, and their expansion."""

from __future__ import annotations

import numpy as np
from jaxtyping import Int


def row_starts(counts: Int[np.ndarray, " N"]) -> Int[np.ndarray, " N1"]:
    """Where each row begins on the flat axis: row n is ``starts[n] … starts[n + 1] − 1``.

    Args:
        counts: items of each row.

    Returns:
        Ascending from 0 to the number of items. [N + 1]
    """
    return np.concatenate([[0], np.cumsum(counts)])


def expand(counts: Int[np.ndarray, " N"]) -> tuple[Int[np.ndarray, " M"], Int[np.ndarray, " M"]]:
    """One entry for each item of rows of ``counts`` items: its row, and its number in the row.

    ``counts = [2, 0, 3]`` gives the rows ``[0, 0, 2, 2, 2]`` and the numbers ``[0, 1, 0, 1, 2]``.
    """
    row = np.repeat(np.arange(len(counts)), counts)
    return row, np.arange(len(row)) - (np.cumsum(counts) - counts)[row]


def expand_rows(
    starts: Int[np.ndarray, " N1"], keys: Int[np.ndarray, " K"]
) -> tuple[Int[np.ndarray, " M"], Int[np.ndarray, " M"]]:
    """All items of some rows of a table, one row after another.

    Args:
        starts: of all rows; see :func:`row_starts`.
        keys: the wanted rows, in any order and as often as wanted.

    Returns:
        For each item, which of ``keys`` it belongs to, and its place on the flat axis.
    """
    first = starts[keys]
    slot, rank = expand(starts[keys + 1] - first)
    return slot, first[slot] + rank
