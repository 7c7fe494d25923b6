"""Memory of a worker: bounded by dropping programs, and seldom searched for garbage."""

from __future__ import annotations

import ctypes
import gc
import os
from pathlib import Path

import jax

MOST_MB = 2000
"""Of resident memory after a test; the largest test needs 1 GB more."""

LEAST_GAIN_MB = 500
"""By so much a process has to grow after programs were dropped before they are dropped again."""
_left_mb = 0.0


def collect_seldom() -> None:
    """Has Python look for garbage seldom, and never among what is imported by now.

    Tracing makes millions of small objects that live as long as their program; looking through
    them all again and again took a fifth of the time of tracing, and more the longer a run lasted.
    """
    gc.collect()
    gc.freeze()
    gc.set_threshold(50_000, 20, 20)


def resident_mb() -> float:
    """Memory of this process, MB; 0 where the system does not tell."""
    try:
        pages = int(Path("/proc/self/statm").read_text().split()[1])
    except OSError:
        return 0.0
    return pages * os.sysconf("SC_PAGE_SIZE") / 2**20


def drop_programs() -> None:
    """Has jax forget what it traced and compiled, and gives the memory back to the system.

    A program takes up to 30 MB. One that is needed again is read from the compilation cache.
    """
    jax.clear_caches()
    gc.collect()
    trim = getattr(ctypes.CDLL(None), "malloc_trim", None)  # of glibc: free() keeps the memory
    if trim is not None:
        trim(0)


def bound() -> None:
    """Drops programs where this process has grown too large, and by much since the last time.

    What tests share is not dropped; where that alone is large, dropping would be in vain.
    """
    global _left_mb
    if resident_mb() > max(MOST_MB, _left_mb + LEAST_GAIN_MB):
        drop_programs()
        _left_mb = resident_mb()
