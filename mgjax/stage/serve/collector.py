"""The collector of garbage, held off the picture: a full run stops all for a third of a second.

jax leaves millions of objects behind when it traces and compiles. Those that are there for good are
frozen: the collector does not look at them again.
"""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager


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
