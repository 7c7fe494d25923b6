"""Executors by name: this process, its threads or devices, other processes, a Ray cluster."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from contextlib import contextmanager
from typing import Any, Literal

from mgjax.core.errors import ConfigError

Name = Literal["serial", "threads", "devices", "processes", "ray"]


class SerialExecutor(Executor):
    """Runs each call at once, in this process."""

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        future: Future[Any] = Future()
        try:
            future.set_result(fn(*args, **kwargs))
        except Exception as error:
            future.set_exception(error)
        return future


@contextmanager
def executor(
    name: Name = "serial",
    workers: int | None = None,
    address: str | None = None,
    device: str | None = None,
) -> Iterator[Executor]:
    """An executor, which ends with the context; what is not begun by then is not done.

    Args:
        name: ``"serial"``, this process; ``"threads"`` of it; ``"devices"``, one of its threads for
            each jax device; ``"processes"``, spawned ones of this machine, each with one thread for
            compiled code; ``"ray"``, a Ray cluster (extra ``cluster``), one thread a worker, too.
        workers: how many; None: as many as there are processors, or devices. Of a cluster that is
            running already it says nothing.
        address: of a running Ray cluster; None: one of this machine, which ends with the context.
        device: kind of the devices, such as ``"gpu"``; None: what jax takes by itself.

    Raises:
        ConfigError: no worker, an address or a device that does not fit the name or is not there,
            or no Ray.
    """
    if workers is not None and workers < 1:
        raise ConfigError(got=f"{workers} workers", expected="1 or more")
    if address is not None and name != "ray":
        raise ConfigError(got=f"an address for {name}", expected="one for ray only")
    if device is not None and name != "devices":
        raise ConfigError(got=f"a device for {name}", expected="one for devices only")
    made = _make(name, workers, address, device)
    try:
        yield made
    finally:
        made.shutdown(wait=True, cancel_futures=True)


def _make(name: Name, workers: int | None, address: str | None, device: str | None) -> Executor:
    if name == "devices":
        from mgjax.core.parallel.devices import device_pool

        return device_pool(device, workers)
    workers = workers or os.cpu_count() or 1
    if name == "processes":
        from mgjax.core.parallel.processes import process_pool

        return process_pool(workers)
    if name == "ray":
        from mgjax.core.parallel.ray_cluster import RayExecutor

        return RayExecutor(workers, address)
    return ThreadPoolExecutor(workers) if name == "threads" else SerialExecutor()
