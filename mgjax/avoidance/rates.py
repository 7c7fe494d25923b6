"""How finely motion is written and checked, and what counts as clear."""

from __future__ import annotations

FAR = 1e6
"""Clearance where no attack is ever near, m: large, but finite."""


EXPORT_RATE = 120.0
"""Frames per second of written motions."""


CHECK_RATE = 240.0
"""Moments per second of the check and of the written volumes: every written frame, and between."""


CLEAR_M = 0.001
"""Least clearance that counts as clear: other ways of interpolating differ by less."""
