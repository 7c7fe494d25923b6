"""How compiled programs are kept and run: the cache on disk, and threads."""

from __future__ import annotations

import os
from pathlib import Path


def cache_folder() -> Path:
    """``MGJAX_CACHE``, else ``mgjax`` in the user's cache folder."""
    named = os.environ.get("MGJAX_CACHE")
    if named:
        return Path(named).expanduser()
    home = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(home) / "mgjax"


def enable_cache() -> None:
    """Turns on jax's compilation cache for every program, also the quickly compiled ones.

    Call it before anything is compiled. jax 0.10.1 writes pages of harmless notes about CPU
    features on each load from the cache; they are switched off unless the user asks for them.
    """
    os.environ.setdefault("TF_CPP_MIN_LOG_LEVEL", "3")
    import jax

    jax.config.update("jax_compilation_cache_dir", str(cache_folder() / "jax"))
    jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.0)
    jax.config.update("jax_persistent_cache_min_entry_size_bytes", -1)


def one_thread() -> None:
    """Has compiled code run in one thread, unless the user has set ``PJRT_NPROC``.

    Call it before jax is used for the first time. Programs as small as a search then do not wait
    for other threads, which saves a tenth of a millisecond; large products take longer.
    """
    os.environ.setdefault("PJRT_NPROC", "1")


def threads() -> int:
    """Threads that compiled code runs in: those of ``PJRT_NPROC``, else all processors."""
    return int(os.environ.get("PJRT_NPROC") or os.cpu_count() or 1)
