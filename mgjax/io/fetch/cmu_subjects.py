"""What is known offline of the CMU Graphics Lab Motion Capture Database.

How many motions a subject has is counted in the index of the database that B. Hahne compiled in
July 2008 (``cmu-mocap-index-text.txt`` of his BVH conversions). AMC files state no frame rate. The
database's pages state one for every motion; 120 is usual, and 60 is what they state for the salsa
of subjects 60 and 61. Whether others differ is not known here: :mod:`mgjax.io.fetch.cmu` asks.
"""

from __future__ import annotations

USUAL_RATE = 120.0

RATES = {60: 60.0, 61: 60.0}
"""Frames per second of the subjects that are known to differ from the usual ones."""

# fmt: off
LAST = {
    1: 14, 2: 10, 3: 4, 5: 20, 6: 15, 7: 12, 8: 11, 9: 12, 10: 6, 11: 1, 12: 4, 13: 42, 14: 37,
    15: 14, 16: 58, 17: 10, 18: 15, 19: 15, 20: 13, 21: 13, 22: 25, 23: 25, 24: 1, 25: 1, 26: 11,
    27: 11, 28: 19, 29: 25, 30: 23, 31: 21, 32: 22, 33: 2, 34: 2, 35: 34, 36: 37, 37: 1, 38: 4,
    39: 14, 40: 12, 41: 11, 42: 1, 43: 3, 45: 1, 46: 1, 47: 1, 49: 22, 54: 27, 55: 28, 56: 8,
    60: 15, 61: 15, 62: 25, 63: 1, 64: 30, 69: 75, 70: 13, 74: 20, 75: 20, 76: 11, 77: 34, 78: 35,
    79: 96, 80: 73, 81: 18, 82: 18, 83: 68, 85: 15, 86: 15, 87: 5, 88: 11, 89: 6, 90: 36, 91: 62,
    93: 8, 94: 16, 102: 33, 103: 8, 104: 57, 105: 62, 106: 34, 107: 14, 108: 28, 111: 41, 113: 29,
    114: 16, 115: 10, 118: 32, 120: 22, 122: 68, 123: 13, 124: 13, 125: 7, 126: 14, 127: 38,
    128: 11, 131: 14, 132: 56, 133: 26, 134: 15, 135: 11, 136: 33, 137: 42, 138: 55, 139: 34,
    140: 9, 141: 34, 142: 22, 143: 42, 144: 34,
}
"""Number of the last motion of each subject."""
# fmt: on

FIRST = {40: 2, 41: 2}
"""Number of the first motion, where it is not 1."""


def motion_name(subject: int, motion: int) -> str:
    """As the database writes it, such as ``14_02``."""
    return f"{subject:02d}_{motion:02d}"


def known_motions(subject: int) -> list[str]:
    """Names of the motions that the index has of a subject."""
    return [motion_name(subject, i) for i in range(FIRST.get(subject, 1), LAST[subject] + 1)]
