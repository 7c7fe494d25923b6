from __future__ import annotations

from concurrent.futures import Executor, Future, ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool

import pytest

from mgjax.core.errors import ConfigError, WorkerError
from mgjax.core.parallel.executors import SerialExecutor, executor
from mgjax.core.parallel.run import run_all


def square(x: int) -> int:
    if x < 0:
        raise ValueError("negative")
    return x * x


class Broken(Executor):
    """Each call ends with an error, as it comes from where the work is done."""

    def __init__(self, error: Exception) -> None:
        self.error = error

    def submit(self, fn, /, *args, **kwargs) -> Future:
        future: Future = Future()
        future.set_exception(self.error)
        return future


def test_results_come_with_the_numbers_of_their_tasks():
    assert list(run_all(SerialExecutor(), square, range(5))) == [(k, k * k) for k in range(5)]
    with ThreadPoolExecutor(3) as pool:
        assert dict(run_all(pool, square, range(100), ahead=4)) == {k: k * k for k in range(100)}


def test_tasks_are_made_as_they_are_needed():
    made = []
    tasks = (made.append(k) or k for k in range(50))
    results = run_all(SerialExecutor(), square, tasks)
    assert next(results) == (0, 0)
    assert made == [0]
    waiting: list[Future] = []

    class Slow(Executor):
        def submit(self, fn, /, *args, **kwargs) -> Future:
            waiting.append(Future())
            if len(waiting) == 7:
                waiting[3].set_result("fourth")
            return waiting[-1]

    made.clear()
    results = run_all(Slow(), square, (made.append(k) or k for k in range(50)), ahead=7)
    assert next(results) == (3, "fourth")
    assert len(made) == 7
    results.close()
    assert all(future.cancelled() for k, future in enumerate(waiting) if k != 3)


def test_no_task_gives_nothing():
    assert list(run_all(SerialExecutor(), square, [])) == []


def test_an_error_of_the_work_is_passed_on():
    with pytest.raises(ValueError, match="negative"):
        list(run_all(SerialExecutor(), square, [1, -1]))
    with pytest.raises(RuntimeError, match="another"):
        list(run_all(Broken(RuntimeError("another")), square, [1]))


@pytest.mark.parametrize(
    ("error", "said"),
    [
        (BrokenProcessPool("gone"), "got the end of a worker process .*expected workers that live"),
        (MemoryError(), "got no memory left in a worker"),
        (RuntimeError("RESOURCE_EXHAUSTED: 3 GB"), "got no memory left in a worker"),
    ],
)
def test_a_worker_that_ends_is_one_clear_line(error, said):
    with pytest.raises(WorkerError, match=said) as caught:
        list(run_all(Broken(error), square, [1]))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("serial", 0), "got 0 workers, expected 1 or more"),
        (("processes", 1, "auto"), "got an address for processes, expected one for ray only"),
        (("serial", 1, None, "cpu"), "got a device for serial, expected one for devices only"),
        (("devices", 1, None, "abacus"), "got device 'abacus', expected one that jax sees: cpu"),
    ],
)
def test_what_is_no_executor(arguments, said):
    with pytest.raises(ConfigError, match=said), executor(*arguments):
        pass


def test_executors_of_this_process():
    for name in ("serial", "threads", "devices"):
        with executor(name, 2) as made:
            assert made.submit(square, 3).result() == 9
