"""What was given at start: which application, and the only folders it reads and writes."""

from __future__ import annotations

import json
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any


@dataclass(frozen=True, kw_only=True)
class Options:
    """Options of a view, as the command line has them.

    Attributes:
        app: ``throw``, ``sketch``, ``match``, ``edit``, or ``show`` for a result.
        graph: folder of a graph, or None for the embedded clips'.
        clips: folder of clips, or None.
        labels: file of labelled intervals, or None for ``labels.json`` in ``clips``.
        result: folder or file to show, of the application ``show``.
    """

    app: str
    graph: Path | None = None
    clips: Path | None = None
    labels: Path | None = None
    result: Path | None = None


def to_text(options: Options) -> str:
    """Options as JSON."""
    values = {f.name: getattr(options, f.name) for f in fields(options)}
    return json.dumps({k: str(v) if isinstance(v, Path) else v for k, v in values.items()})


def from_text(text: str) -> Options:
    """Options from JSON."""
    values: dict[str, Any] = json.loads(text)
    app = values.pop("app")
    return Options(app=app, **{k: None if v is None else Path(v) for k, v in values.items()})
