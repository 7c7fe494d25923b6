"""Many calls of one function through an executor, a bounded number of them at a time."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Executor, Future, wait
from itertools import islice
from typing import Any, TypeVar

from mgjax.core.errors import WorkerError

T = TypeVar("T")
R = TypeVar("R")

AHEAD = 32
"""Calls that are waiting or running at a time: their arguments are in memory."""


def run_all(
    executor: Executor, work: Callable[[T], R], tasks: Iterable[T], *, ahead: int = AHEAD
) -> Iterator[tuple[int, R]]:
    """Results in the order in which they are ready, each with the number of its task.

    Args:
        executor: where to.
        work: a function of a module, which can be found by name in another process.
        tasks: are made as they are needed.
        ahead: calls at a time. An executor that works at once has one.

    Raises:
        WorkerError: a worker was ended, or had no memory left. Other errors of ``work`` are passed
            on. In either case calls that have not begun are not made.
    """
    numbered = enumerate(tasks)
    waiting: dict[Future[Any], int] = {}
    try:
        while True:
            for number, task in islice(numbered, ahead - len(waiting)):
                waiting[executor.submit(work, task)] = number
                if all(future.done() for future in waiting):
                    break
            if not waiting:
                return
            ready = wait(waiting, return_when=FIRST_COMPLETED).done
            for future in sorted(ready, key=lambda each: waiting[each]):
                yield waiting.pop(future), future.result()
    except BrokenExecutor:
        got = "the end of a worker process (killed, perhaps for want of memory)"
        raise WorkerError(got=got, expected="workers that live: fewer of them, say") from None
    except (MemoryError, RuntimeError) as error:
        if not isinstance(error, MemoryError) and "RESOURCE_EXHAUSTED" not in str(error):
            raise
        raise WorkerError(
            got="no memory left in a worker", expected="enough: fewer workers, say"
        ) from None
    finally:
        for future in waiting:
            future.cancel()
