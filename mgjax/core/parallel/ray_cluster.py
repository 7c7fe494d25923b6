"""A Ray cluster as an executor (extra ``cluster``)."""

from __future__ import annotations

import logging
import os
import socket
import sys
import warnings
from collections.abc import Callable
from concurrent.futures import BrokenExecutor, Executor, Future
from functools import cache
from typing import Any

from mgjax.core.errors import ConfigError
from mgjax.core.xla.compilation import enable_cache, one_thread

RETRIES = 3
"""How often a call is made anew whose worker was killed."""

ANSWER_S = 10.0
"""How long to wait for a cluster's first sign."""


class RayExecutor(Executor):
    """Calls run in workers of a cluster, each with one processor and one thread.

    A call whose worker is killed is made anew, ``RETRIES`` times; then, and where the cluster is
    gone, its future has a ``BrokenExecutor``.

    Args:
        workers: processors of a cluster of this machine, which is started and ends with it.
        address: of a running cluster instead, such as ``"auto"`` or ``"ray://host:10001"``; its
            machines need this package and the same version of jax.

    Raises:
        ConfigError: no Ray is installed, there is no cluster at the address, or this process has
            one already.
    """

    def __init__(self, workers: int, address: str | None = None) -> None:
        os.environ.setdefault("RAY_ACCEL_ENV_VAR_OVERRIDE_ON_ZERO", "0")
        try:
            import ray
            from ray import exceptions
        except ImportError:
            raise ConfigError(
                got="no Ray", expected="it installed: pip install 'mgjax[cluster]'"
            ) from None
        if ray.is_initialized():
            raise ConfigError(got="a Ray cluster in this process", expected="none yet")
        if address is not None:
            _check_reachable(address)
        self._ray, self._errors = ray, exceptions
        # Without this Ray hangs where workers cannot find the modules of the one who calls.
        variables = {"PYTHONPATH": os.pathsep.join(path for path in sys.path if path)}
        own: dict[str, Any] = {"num_cpus": workers, "include_dashboard": False}
        try:
            with warnings.catch_warnings():
                # Its servers are processes of their own: nothing of jax runs on in a fork.
                warnings.filterwarnings("ignore", r"os\.fork\(\) was called", RuntimeWarning)
                ray.init(
                    address=address or "local",
                    log_to_driver=False,
                    logging_level=logging.ERROR,
                    runtime_env={"env_vars": variables},
                    **({} if address else own),
                )
        except (ConnectionError, RuntimeError, ValueError, OSError) as error:
            why = (str(error).splitlines() or [type(error).__name__])[0]
            raise _none_at(address or "this machine", why) from None
        self._call = ray.remote(num_cpus=1, max_retries=RETRIES)(_call)

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        reference = self._call.remote(fn, args, kwargs)
        future: Future[Any] = Future()

        def done(inner: Future[Any]) -> None:
            if not future.set_running_or_notify_cancel():
                return
            error = inner.exception()
            if error is None:
                future.set_result(inner.result())
            else:
                future.set_exception(self._plain(error))

        reference.future().add_done_callback(done)
        return future

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        self._ray.shutdown()

    def _plain(self, error: BaseException) -> BaseException:
        """The error that the call raised; one of the cluster itself is a ``BrokenExecutor``."""
        errors = self._errors
        if isinstance(error, errors.RayTaskError):
            cause = getattr(error, "cause", None)
            return cause if isinstance(cause, BaseException) else error
        if isinstance(error, errors.OutOfMemoryError):
            return MemoryError(str(error))
        return BrokenExecutor(str(error)) if isinstance(error, errors.RayError) else error


def _check_reachable(address: str) -> None:
    """Raises where nobody answers at ``host:port``, for which Ray itself would wait for ever."""
    host, colon, port = address.rpartition("://")[2].rpartition(":")
    if not colon or not port.isdecimal():
        return
    try:
        socket.create_connection((host, int(port)), timeout=ANSWER_S).close()
    except (OSError, OverflowError) as error:
        raise _none_at(address, str(error)) from None


def _none_at(place: str, why: str) -> ConfigError:
    return ConfigError(got=f"no Ray cluster at {place} ({why:.100})", expected="a running one")


def _call(fn: Callable[..., Any], args: tuple[Any, ...], kwargs: dict[str, Any]) -> Any:
    _begin()
    return fn(*args, **kwargs)


@cache
def _begin() -> None:
    """What a worker does before its first call."""
    one_thread()
    enable_cache()
