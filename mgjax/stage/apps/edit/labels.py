"""The labels of all clips: from a file or from memory, edited, saved or handed to the page."""

from __future__ import annotations

from itertools import count
from pathlib import Path
from typing import Any

from mgjax.clips.types import Labels
from mgjax.core.errors import ConfigError
from mgjax.stage.apps.edit.labels_file import LabelsFile, labels_text
from mgjax.stage.apps.edit.library import Library
from mgjax.stage.apps.edit.table import Extent, Interval, LabelTable, check_place

KINDS = ("duck", "sway", "sidestep", "jump", "twist", "crouch", "lean_back")
DIRECTIONS = ("", "left", "right")


class LabelBook:
    """The labels that are edited, and where they are kept.

    Args:
        library: the clips.
        path: the labels file, or None for labels that only memory holds.
        given: the labels at the beginning, where there is no file.

    Raises:
        LabelError: the file is none of labels.
    """

    def __init__(self, library: Library, path: Path | None, given: Labels | None = None) -> None:
        self._library = library
        self._path = path
        self.file: LabelsFile | None = None
        if path is None:
            ids = count()
            self.table = LabelTable(
                {
                    name: tuple(Interval(id=next(ids), label=label) for label in items)
                    for name, items in (given or {}).items()
                }
            )
        else:
            self.read()

    def read(self) -> None:
        """Reads the file, anew if it was read before: what is not saved is lost then."""
        folder = self._library.folder
        if self._path is None or folder is None:
            raise ConfigError(got="labels that are in no file", expected="a labels file")
        file = LabelsFile(self._path, folder, self._library.names)
        self.file, self.table = file, LabelTable(file.intervals)

    def save(self, *, overwrite: bool = False) -> str:
        """Writes the file; returns what there is to say.

        Raises:
            OutputError: it cannot be written, or was changed by somebody else.
        """
        if self.file is None:
            raise ConfigError(got="labels that are in no file", expected="a download")
        self.file.save(self.table, overwrite=overwrite)
        self.table.mark_saved()
        number = sum(len(items) for items in self.table.labels().values())
        return f"Saved {number} labels in {self.file.path}."

    def download(self) -> str:
        """The text of a labels file, for the page to keep."""
        self.table.mark_saved()
        return labels_text(self.table.labels())

    def kinds(self) -> list[str]:
        """The kinds to choose from: those that are known, and those in use."""
        used = {label.kind for items in self.table.labels().values() for label in items}
        return [*KINDS, *sorted(used - set(KINDS))]

    def directions(self) -> list[str]:
        """Likewise the directions."""
        used = {label.direction for items in self.table.labels().values() for label in items}
        return [*DIRECTIONS, *sorted(used - set(DIRECTIONS))]

    def rows(self, clip: str) -> list[dict[str, Any]]:
        """The labels of a clip for the page."""
        return [
            {
                "id": i.id,
                "start_s": i.label.start_s,
                "end_s": i.label.end_s,
                "kind": i.label.kind,
                "direction": i.label.direction,
                "genuine": i.label.genuine,
            }
            for i in self.table.of(clip)
        ]

    def problem(self, clip: str, extent: Extent) -> str:
        """What is wrong with the labels of a clip, or ""."""
        items = sorted(self.table.of(clip), key=lambda i: i.label.start_s)
        for number, item in enumerate(items):
            start, stop = (extent.frame(s) for s in (item.label.start_s, item.label.end_s))
            try:
                check_place(items[:number], extent, start, stop)
            except ConfigError as error:
                return str(error)
        return ""
