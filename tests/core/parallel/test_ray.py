from __future__ import annotations

import os
import signal
from pathlib import Path

import pytest

from mgjax.core.errors import ConfigError
from mgjax.core.parallel.executors import executor
from mgjax.core.parallel.run import run_all

pytestmark = [
    pytest.mark.filterwarnings("ignore::ResourceWarning"),
    pytest.mark.filterwarnings("ignore::DeprecationWarning"),
    pytest.mark.filterwarnings("ignore::FutureWarning"),
]


def killed_once(task: tuple[int, str]) -> tuple[int, str | None]:
    """The worker that first does task 2 kills itself; the file tells that it did."""
    number, file = task
    if number == 2 and not Path(file).exists():
        Path(file).write_text("killed")
        os.kill(os.getpid(), signal.SIGKILL)
    return number * number, os.environ.get("PJRT_NPROC")


def fails(_: int) -> None:
    raise ValueError("of the work")


def test_a_killed_worker_is_tried_again_and_errors_are_passed_on(tmp_path):
    file = tmp_path / "killed"
    with executor("ray", 2) as pool:
        tasks = [(k, str(file)) for k in range(5)]
        results = dict(run_all(pool, killed_once, tasks))
        assert results == {k: (k * k, "1") for k in range(5)}
        assert file.exists()
        with pytest.raises(ValueError, match="of the work"):
            list(run_all(pool, fails, [1]))
        with pytest.raises(ConfigError, match="got a Ray cluster in this process"):
            executor("ray", 1).__enter__()
    with (
        pytest.raises(ConfigError, match=r"got no Ray cluster at 127.0.0.1:1 .*a running one"),
        executor("ray", 1, "127.0.0.1:1"),
    ):
        pass
