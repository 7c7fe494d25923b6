"""All jax devices of one kind as an executor: each has a thread, whose calls are computed there."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from queue import SimpleQueue
from typing import Any

import jax

from mgjax.core.errors import ConfigError


def device_pool(kind: str | None = None, workers: int | None = None) -> ThreadPoolExecutor:
    """A thread for each device.

    Args:
        kind: ``"cpu"``, ``"gpu"`` …; None: what jax takes by itself.
        workers: devices that are used, the first ones; None: all.

    Raises:
        ConfigError: jax sees no such device.
    """
    try:
        devices = jax.devices(kind)[:workers]
    except RuntimeError:
        seen = ", ".join(sorted({device.platform for device in jax.devices()}))
        raise ConfigError(got=f"device {kind!r}", expected=f"one that jax sees: {seen}") from None
    free: SimpleQueue[Any] = SimpleQueue()
    for device in devices:
        free.put(device)

    def begin() -> None:
        # For the rest of the thread: nobody leaves this context.
        jax.default_device(free.get()).__enter__()

    return ThreadPoolExecutor(len(devices), initializer=begin)
