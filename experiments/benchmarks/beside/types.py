"""A peer, what it is asked to do, and the same work for mgjax."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from types import ModuleType
from typing import Any

from experiments.benchmarks.beside.calls import Calls


@dataclass(frozen=True, kw_only=True)
class Job:
    """Work that both halves do.

    Attributes:
        data: arguments of the peer's ``set_up``, as JSON has them.
        ours: mgjax's half.
        tolerance: largest miss that counts as met.
        each: solves in one call; times are per solve.
    """

    data: dict[str, Any]
    ours: Calls
    tolerance: float
    each: int = 1


@dataclass(frozen=True, kw_only=True)
class Work:
    """A kind of work.

    Attributes:
        words: what is done, for people.
        make: the work from a seed and a number of items.
    """

    words: str
    make: Callable[[int, int], Job]


@dataclass(frozen=True, kw_only=True)
class Peer:
    """A public peer.

    Attributes:
        name: by which it is chosen.
        packages: what is installed for it, it first; none: it is where mgjax is.
        alone: installed after these, without the packages it names itself.
        present: where nothing is installed: the package that has it.
        theirs: the module with its half: ``set_up(**data)`` returns its calls.
        works: by a short name.
    """

    name: str
    theirs: ModuleType
    works: dict[str, Work]
    packages: tuple[str, ...] = ()
    alone: tuple[str, ...] = ()
    present: str = ""

    @property
    def installed(self) -> tuple[str, ...]:
        """All that is installed, or is there already, the peer first."""
        return (*self.alone, *self.packages, *([self.present] if self.present else []))

    @property
    def distributions(self) -> tuple[str, ...]:
        """The same without versions."""
        return tuple(re.split(r"[<>=!~\[]", each)[0] for each in self.installed)
