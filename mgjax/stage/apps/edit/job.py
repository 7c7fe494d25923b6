"""Work in a thread of its own, so that the page is answered while it lasts."""

from __future__ import annotations

import threading
import traceback
from collections.abc import Callable
from typing import Any

from mgjax.core.errors import MgjaxError

Watch = Callable[[float, str], None]
"""Told how much is done, 0 … 1, and what is done next; raises :class:`Stopped` to end the work."""


class Stopped(Exception):
    """The work was stopped."""


class Job:
    """One piece of work.

    Args:
        work: gets a :data:`Watch`, which it has to call every now and then.
        name: of the thread.

    Attributes:
        share, text: how much is done, and what is done now.
        result: what the work returned, once it is over.
        error: the sentence that says why it has failed, or "".
    """

    def __init__(self, work: Callable[[Watch], Any], name: str) -> None:
        self.share, self.text = 0.0, ""
        self.result: Any = None
        self.error = ""
        self._stop = threading.Event()
        self._work = work
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)
        self._thread.start()

    @property
    def over(self) -> bool:
        """Whether the work has ended, in whatever way."""
        return not self._thread.is_alive()

    @property
    def stopped(self) -> bool:
        """Whether it was asked to stop."""
        return self._stop.is_set()

    def stop(self, wait: float = 0.0) -> None:
        """Asks the work to end, and waits for it so many seconds."""
        self._stop.set()
        self._thread.join(wait)

    def _watch(self, share: float, text: str) -> None:
        if self._stop.is_set():
            raise Stopped
        self.share, self.text = share, text

    def _run(self) -> None:
        try:
            self.result = self._work(self._watch)
        except Stopped:
            pass
        except MgjaxError as error:
            self.error = str(error)
        except Exception as error:  # the page says it, and the rest goes on
            traceback.print_exc()
            self.error = f"{self._thread.name} failed: {type(error).__name__}: {error}"[:300]
