"""Worker processes of this machine. Importing this imports neither jax nor numpy."""

from __future__ import annotations

import multiprocessing
import signal
from concurrent.futures import ProcessPoolExecutor

from mgjax.core.xla.compilation import enable_cache, one_thread


def process_pool(workers: int) -> ProcessPoolExecutor:
    """Spawned processes, each with one thread for compiled code and the common program cache."""
    context = multiprocessing.get_context("spawn")
    return ProcessPoolExecutor(workers, mp_context=context, initializer=begin_worker)


def begin_worker() -> None:
    """What a worker does before its first call: before jax is there."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent says when to end
    one_thread()
    enable_cache()
