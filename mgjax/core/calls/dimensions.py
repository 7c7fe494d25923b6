"""Shapes against their description, such as ``*b J 3``: sizes, names, and as many as there are."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

Sizes = dict[str, tuple[Any, str]]
"""By name of a dimension: its size, and the argument that it is of."""


def shown_shape(shape: tuple[int, ...]) -> str:
    """A shape as it is written in descriptions."""
    return f"[{', '.join(map(str, shape))}]"


def fitting(dims: str) -> Callable[[tuple[int, ...], str, Sizes], str]:
    """What says what is wrong with a shape; "" where nothing is.

    Args:
        dims: sizes, names and at most one ``*name`` or ``...``, separated by spaces. ``_`` and
            sums of names are any size.

    Returns:
        A function of a shape, of the argument that has it, and of known sizes, to which it adds.
    """
    tokens = dims.split()
    many = [i for i, token in enumerate(tokens) if token.startswith(("*", "..."))]
    least = len(tokens) - len(many)
    fixed = {token: int(token) for token in tokens if token.isdecimal()}
    names = {token: token.lstrip("*") for token in tokens}
    names = {t: name for t, name in names.items() if name.isidentifier() and name != "_"}

    def fit(shape: tuple[int, ...], argument: str, sizes: Sizes) -> str:
        if len(shape) < least or (not many and len(shape) > least):
            return f" ({least} dimensions)"
        parts: list[Any] = list(shape)
        if many:
            at, extra = many[0], len(shape) - least
            parts[at : at + extra] = [shape[at : at + extra]]
        for token, size in zip(tokens, parts, strict=True):
            if token in fixed:
                if size != fixed[token]:
                    return f" ({size} where {token} belong)"
            elif token in names:
                known = sizes.setdefault(names[token], (size, argument))
                if known[0] != size:
                    shown = shown_shape(known[0]) if isinstance(known[0], tuple) else known[0]
                    return f" with {names[token]} = {shown}, as {known[1]} has"
        return ""

    return fit
