"""Lists of lists in compressed rows: the items of key k are ``items[first[k]:first[k + 1]]``."""

from __future__ import annotations

import numpy as np
from jaxtyping import Int


def expand_rows(
    first: Int[np.ndarray, " K1"], keys: Int[np.ndarray, " Q"]
) -> tuple[Int[np.ndarray, " R"], Int[np.ndarray, " R"]]:
    """All items of some keys, one key after the other.

    Args:
        first: position of each key's first item, and the number of all items.
        keys: whose items are asked for; a key may be there more than once.

    Returns:
        For each item the row of ``keys`` that it belongs to, and its position among all items.
    """
    begins = first[keys]
    counts = first[keys + 1] - begins
    row = np.repeat(np.arange(len(keys)), counts)
    return row, np.arange(len(row)) + (begins - (np.cumsum(counts) - counts))[row]
