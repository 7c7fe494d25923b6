"""Memory of the process that computes: garbage collected off the picture, free memory given back.

A full run of the collector stops all for a third of a second. jax leaves millions of objects behind
when it traces and compiles. Those that are there for good are frozen: the collector does not look
at them again.
"""

from __future__ import annotations

import ctypes
import gc
import sys
from collections.abc import Iterator
from contextlib import contextmanager


def give_back() -> None:
    """Returns memory that is free to the system, where the C library keeps it (glibc).

    Searches in threads of their own leave some 200 MB of holes behind within minutes. It takes
    about 10 ms for those, less than one right after the last time.
    """
    if sys.platform == "linux":
        trim = getattr(ctypes.CDLL(None), "malloc_trim", None)
        if trim is not None:
            trim(0)


def freeze() -> None:
    """Collects once, while nobody waits, and leaves out from now on what is left."""
    gc.collect()
    gc.freeze()


@contextmanager
def waiting_collector() -> Iterator[None]:
    """No collection within, as while programs are compiled beside the picture.

    What is left then is frozen without a look at it, garbage too: that is once, and bounded.
    """
    gc.disable()
    try:
        yield
    finally:
        gc.freeze()
        gc.enable()
