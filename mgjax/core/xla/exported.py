"""Traced programs kept on disk: a process that finds one there need not trace it anew.

jax's own cache keeps what XLA compiled, but to find it a function is traced and lowered first,
which takes several times as long as reading the result. What lowering gives (StableHLO) is kept
here, for functions that many processes have the same shapes of: those that first answers wait for.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import tempfile
from collections.abc import Callable
from functools import cache, wraps
from importlib.metadata import version
from pathlib import Path
from typing import Any, TypeVar

import jax
from jax import export
from jax.core import Tracer

from mgjax.core.xla.compilation import cache_folder

F = TypeVar("F", bound=Callable[..., Any])

_KEPT = 8
"""Versions of the package whose programs stay, those used last; each takes some 5 MB."""
_DIGEST = hashlib.sha256().digest_size
_SETTINGS = (
    "jax_enable_x64",
    "jax_default_matmul_precision",
    "jax_numpy_dtype_promotion",
    "jax_threefry_partitionable",
)


def exported(*static: str) -> Callable[[F], F]:
    """Decorator of a function that is jitted: tracing it takes what an earlier process has traced.

    What is kept is told apart by the source of the package, jax's version and settings, and the
    shapes, types and static arguments of the call. The first process traces and keeps it, so a
    program is the same whether it was found or not. Without jax's compilation cache
    (:func:`~mgjax.core.xla.compilation.enable_cache`), or where jax computes on anything but a
    processor, the function is traced as it is.

    Under ``jax.disable_jit`` it is called as it is, too.

    The jitted function can be called from Python only: ``vmap``, ``grad`` and other programs take
    the undecorated one.

    Args:
        static: names of the arguments that are not traced; their ``repr`` has to tell all of them.
    """

    def decorate(function: F) -> F:
        @wraps(function)
        def traced(*args: Any, **named: Any) -> Any:
            fixed = {name: named.pop(name) for name in static if name in named}
            leaves, tree = jax.tree.flatten((args, named))
            if not _keeps() or not all(isinstance(x, Tracer) for x in leaves):
                return function(*args, **named, **fixed)
            shapes = [jax.ShapeDtypeStruct(x.shape, x.dtype, weak_type=_weak(x)) for x in leaves]
            path = (
                _folder(cache_folder() / "programs")
                / f"{function.__name__}-{_key(function, tree, shapes, fixed)}.bin"
            )
            program = _read(path)
            if program is None:

                def plain(*flat: Any) -> Any:
                    inner, names = jax.tree.unflatten(tree, flat)
                    return function(*inner, **names, **fixed)

                program = export.export(jax.jit(plain, keep_unused=True))(*shapes)
                _write(path, bytes(program.serialize()))
            return program.call(*leaves)

        return traced  # type: ignore[return-value]

    return decorate


def _keeps() -> bool:
    return bool(jax.config.jax_compilation_cache_dir) and jax.default_backend() == "cpu"  # type: ignore[attr-defined]


def _weak(leaf: Any) -> bool:
    return bool(getattr(leaf.aval, "weak_type", False))


def _key(function: Callable[..., Any], tree: Any, shapes: list[Any], fixed: dict[str, Any]) -> str:
    settings = [getattr(jax.config, name) for name in _SETTINGS]
    kinds = [(x.shape, x.dtype.name, x.weak_type) for x in shapes]
    whole = repr((function.__module__, function.__qualname__, settings, str(tree), kinds, fixed))
    return hashlib.sha256(whole.encode()).hexdigest()[:24]


@cache
def _folder(root: Path) -> Path:
    """Where the programs of this version of package and jax are; those of old ones are removed."""
    folder = root / _source()
    try:
        folder.mkdir(parents=True, exist_ok=True)
        os.utime(folder)
        others = sorted(root.iterdir(), key=lambda path: path.stat().st_mtime, reverse=True)
        for old in others[_KEPT:]:
            shutil.rmtree(old, ignore_errors=True)
    except OSError:  # a cache that cannot be written: every process traces for itself
        pass
    return folder


@cache
def _source() -> str:
    """Tells versions of the package and of jax apart."""
    found = hashlib.sha256(repr((version("jax"), version("jaxlib"))).encode())
    package = Path(__file__).parents[2]
    for path in sorted(package.rglob("*.py")):
        found.update(str(path.relative_to(package)).encode())
        found.update(path.read_bytes())
    return found.hexdigest()[:16]


def _read(path: Path) -> export.Exported | None:
    """What was kept; None where there is nothing, or not what was written."""
    try:
        content = path.read_bytes()
    except OSError:
        return None
    told, program = content[:_DIGEST], content[_DIGEST:]
    if hashlib.sha256(program).digest() != told:
        return None
    return export.deserialize(bytearray(program))


def _write(path: Path, program: bytes) -> None:
    """Whole or not at all; a cache that cannot be written is left alone."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile(dir=path.parent, delete=False) as file:
            file.write(hashlib.sha256(program).digest() + program)
        os.replace(file.name, path)
    except OSError:
        return
