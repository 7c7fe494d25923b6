"""The labels file: read, and written so that all that was not edited stays as it stands."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from itertools import count
from pathlib import Path
from typing import Any

from mgjax.clips.labels import clip_places, parse_labels, read_label
from mgjax.clips.types import Label, Labels
from mgjax.core.errors import LabelError, OutputError, printable
from mgjax.io.output import replace_file
from mgjax.io.text import read_text
from mgjax.stage.apps.edit.table import Interval, Intervals, LabelTable

_LONGEST_INT = 4000
"""Digits of a whole number that Python reads without complaint."""


class LabelsFile:
    """A labels file as it was when it was read.

    Args:
        path: where it lies, or is going to lie.
        folder: the folder of the clips.
        names: the clips, as paths relative to their folder.

    Attributes:
        intervals: by clip.
        strange: clips that the file names but that are not among ``names``.

    Raises:
        LabelError: the file is there but is none of labels.
    """

    def __init__(self, path: Path, folder: Path, names: Sequence[str]) -> None:
        self.path = path
        self._folder = folder
        self._names = tuple(names)
        self._known = {(folder / name).resolve(): name for name in names}
        self._bytes = _bytes_of(path)
        self._text = "" if self._bytes is None else read_text(path, "labels")
        self._document: dict[str, Any] = {"clips": {}}
        self.intervals: dict[str, Intervals] = {}
        self.strange: list[str] = []
        self._clip_of_key: dict[str, str] = {}
        if self.there:
            checked = parse_labels(path)
            self._document = json.loads(self._text, parse_int=_whole)
            self._read(checked)

    @property
    def there(self) -> bool:
        """Whether the file was there."""
        return self._bytes is not None

    def changed_on_disk(self) -> bool:
        """Whether somebody else wrote it since it was read, or took it away."""
        return _bytes_of(self.path) != self._bytes

    def text(self, table: LabelTable) -> str:
        """What is to stand in the file.

        Intervals that were not edited, further keys of those that were, and the clips that are not
        here stay.
        """
        clips: dict[str, Any] = {}
        left = {name: list(table.of(name)) for name in table.clips()}
        for key, raw in self._document["clips"].items():
            name = self._clip_of_key.get(key)
            if name is None:
                clips[key] = raw
                continue
            # Those made here go to the first of several keys of one clip.
            own = [i for i in left.get(name, []) if i.key in ("", key)]
            left[name] = [i for i in left.get(name, []) if i.key not in ("", key)]
            clips[key] = [written(i) for i in own]
        for name, items in left.items():
            if items:
                key = self._key_for(name)
                clips[key] = [*clips.get(key, ()), *(written(i) for i in items)]
        return _dumps({**self._document, "clips": clips}, self._text)

    def save(self, table: LabelTable, *, overwrite: bool = False) -> None:
        """Writes the file whole, or not at all.

        Raises:
            OutputError: it cannot be written, or somebody else has and ``overwrite`` is not said.
        """
        if not overwrite and self.changed_on_disk():
            raise OutputError(
                f"{printable(self.path)}: got a file that was changed since it was read,"
                " expected the one that was read; overwrite it, or read it again"
            )
        text = self.text(table)
        replace_file(self.path.resolve(), text)
        self._bytes, self._text = text.encode(), text

    def _read(self, checked: Mapping[str, Any]) -> None:
        ids = count()
        for key, items in checked.items():
            name = self._name(key)
            if name is None:
                self.strange.append(key)
                continue
            if not isinstance(items, list):
                raise LabelError(self.path, None, f"{key!r:.60}: {items!r:.40}", "a list")
            raws = self._document["clips"][key]
            found = tuple(
                Interval(
                    id=next(ids), label=read_label(self.path, key, n, item), key=key, raw=raws[n]
                )
                for n, item in enumerate(items)
            )
            self._clip_of_key[key] = name
            self.intervals[name] = self.intervals.get(name, ()) + found

    def _name(self, key: str) -> str | None:
        try:
            places = clip_places(self.path, key, self._folder)
        except (OSError, ValueError):  # a name that no file can have
            return None
        return next((self._known[p] for p in places if p in self._known), None)

    def _key_for(self, name: str) -> str:
        """How the file is to call a clip that it has not named yet."""
        for key, known in self._clip_of_key.items():
            if known == name:
                return key
        here, clip = self.path.absolute().parent, (self._folder / name).absolute()
        if clip.is_relative_to(here):
            key = clip.relative_to(here).as_posix()
            if self._name(key) == name:
                return key
        return name


def written(interval: Interval) -> dict[str, Any]:
    """An interval as JSON: what stands in the file, with that changed which was edited."""
    label = interval.label
    if interval.raw is None:
        new: dict[str, Any] = {"start_s": label.start_s, "end_s": label.end_s, "kind": label.kind}
        if label.direction:
            new["direction"] = label.direction
        return {**new, "genuine": label.genuine}
    raw = dict(interval.raw)
    for key in ("start_s", "end_s", "kind"):
        if raw[key] != getattr(label, key):
            raw[key] = getattr(label, key)
    stands = raw.get("direction", "")
    if label.direction != ("" if stands == "none" else stands):
        raw["direction"] = label.direction or "none"
    if label.genuine != raw.get("genuine", True):
        raw["genuine"] = label.genuine
    return raw


def labels_text(labels: Labels | Mapping[str, Sequence[Label]]) -> str:
    """A labels file of clips that no file names yet."""
    made = {
        name: [written(Interval(id=0, label=label)) for label in items]
        for name, items in labels.items()
    }
    return _dumps({"clips": made}, "")


def _whole(digits: str) -> int | float:
    return int(digits) if len(digits) < _LONGEST_INT else float(digits)


def _dumps(document: dict[str, Any], like: str) -> str:
    """JSON indented as another text is."""
    indent = re.search(r"\n([ \t]+)\S", like)
    space = indent.group(1) if indent else (None if like.strip() else 1)
    text = json.dumps(document, indent=space, ensure_ascii=bool(like) and like.isascii())
    try:
        text.encode()
    except UnicodeEncodeError:  # half a pair of surrogates, which stands there as an escape
        text = json.dumps(document, indent=space)
    text += "\n" if like.endswith("\n") or not like else ""
    return text.replace("\n", "\r\n") if "\r\n" in like else text


def _bytes_of(path: Path) -> bytes | None:
    try:
        return path.read_bytes()
    except OSError:
        return None
