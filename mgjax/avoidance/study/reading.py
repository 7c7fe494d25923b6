"""Reading keys and picks; what does not fit together is refused with its file and line."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

from mgjax.avoidance.config import AvoidanceConfig, EnergyConfig, validate_config
from mgjax.avoidance.study.format import FORMAT, digest
from mgjax.avoidance.study.trials import LETTERS
from mgjax.core.errors import ConfigError, FileFormatError, printable
from mgjax.io.json_text import parse_json, shown
from mgjax.io.settings import changed
from mgjax.io.text import read_text

MEASURES = ("penetration", "d", "d0", "displacement", "s_time")
"""Of a candidate, in the order in which :class:`Known` has them."""
_HELD = ("form", "d0", "D_move", "E_time", "w_speed_up")
"""Settings that are not fitted: they have to be the same for all trials."""


@dataclass(frozen=True, kw_only=True)
class Known:
    """What a fit needs of a trial.

    Attributes:
        number: in its study.
        measures: of each candidate, as ``MEASURES``, of an adult's size.
        taken: place of the candidate that the search took.
        settings: of the search.
    """

    number: int
    measures: tuple[tuple[float, ...], ...]
    taken: int
    settings: EnergyConfig


@dataclass(frozen=True, kw_only=True)
class Pick:
    """What an observer picked: the place of a candidate in the trial of that name."""

    trial: str
    observer: str
    place: int


@dataclass(frozen=True, kw_only=True)
class Study:
    """Trials by name, and all picks; one at most for each observer and trial."""

    trials: dict[str, Known]
    picks: list[Pick]

    @property
    def settings(self) -> EnergyConfig:
        """Those of the first trial."""
        return next(iter(self.trials.values())).settings


def read_study(paths: Sequence[str | Path]) -> Study:
    """Reads files of picks, and the key of those that were exported.

    Args:
        paths: in any order; at most one is a key. Picks of the live page need none.

    Raises:
        FileFormatError: no JSON, another format, picks of another study or without a key, an
            unknown trial, a candidate that was not there, two picks of one observer.
        ConfigError: two keys, no picks, or trials that other settings were used for.
    """
    documents = [(path, *_objects(path)) for path in paths]
    keys = [(path, objects[0][1]) for path, is_key, objects in documents if is_key]
    if len(keys) > 1:
        raise ConfigError(got=f"{len(keys)} keys", expected="one, and files of picks")
    trials: dict[str, Known] = {}
    study: str | None = None
    if keys:
        study, trials = _key(*keys[0])
    picks: dict[tuple[str, str], Pick] = {}
    for path, is_key, objects in documents:
        for line, record in [] if is_key else objects:
            name, known = _trial_of(path, line, record, study, trials)
            trials[name] = known
            place = _letter(path, line, record, "pick", len(known.measures))
            observer = record.get("observer")
            if not isinstance(observer, str) or not observer.strip():
                raise FileFormatError(path, line, _got(record, "observer"), "an observer's name")
            pick = Pick(trial=name, observer=observer.strip(), place=place)
            if (pick.observer, name) in picks:
                got = f"trial {known.number} picked twice by {pick.observer!r}"
                raise FileFormatError(path, line, got, "one pick a trial and observer")
            picks[pick.observer, name] = pick
    if not picks:
        raise ConfigError(got="no picks", expected="files of picks: picks.jsonl of the page")
    _same_settings(list(trials.values()))
    return Study(trials=trials, picks=list(picks.values()))


def _objects(path: str | Path) -> tuple[bool, list[tuple[int, dict[str, Any]]]]:
    """Whether a file is a key, and its objects with their lines."""
    objects: list[tuple[int, dict[str, Any]]] = []
    for number, line in enumerate(read_text(path, "study").splitlines(), 1):
        if not line.strip():
            continue
        try:
            record = parse_json(path, line, expected="a key, or a pick in each line")
        except FileFormatError as error:
            raise FileFormatError(path, number, error.got, error.expected) from None
        if not isinstance(record, dict):
            raise FileFormatError(path, number, shown(record), "a JSON object")
        if record.get("format") != FORMAT:
            raise FileFormatError(path, number, _got(record, "format"), f"format {FORMAT!r}")
        objects.append((number, record))
    is_key = "trials" in objects[0][1]
    if is_key and len(objects) > 1:
        raise FileFormatError(path, objects[1][0], "more after a key", "a key alone")
    return is_key, objects


def _got(record: dict[str, Any], name: str) -> str:
    return f"{name} {shown(record[name])}" if name in record else f"no {name}"


def _key(path: str | Path, record: dict[str, Any]) -> tuple[str, dict[str, Known]]:
    study, rows = record.get("study"), record["trials"]
    if not isinstance(study, str) or not isinstance(rows, list) or not rows:
        raise FileFormatError(path, 1, "a key without study or trials", "what export wrote")
    trials = [_known(path, 1, row) for row in rows]
    if [trial.number for trial in trials] != list(range(1, len(trials) + 1)):
        raise FileFormatError(path, 1, "trials out of order", "trials 1, 2, …")
    return study, {str(trial.number): trial for trial in trials}


def _trial_of(
    path: str | Path,
    line: int,
    record: dict[str, Any],
    study: str | None,
    trials: dict[str, Known],
) -> tuple[str, Known]:
    """Name and content of the trial of a pick."""
    if "candidates" in record:
        own = ("format", "observer", "when", "pick", "trial")
        content = {key: value for key, value in record.items() if key not in own}
        return digest(content), _known(path, line, record)
    if study is None:
        raise FileFormatError(path, line, "a pick without its trial", "the study's key.json, too")
    if record.get("study") != study:
        raise FileFormatError(path, line, _got(record, "study"), f"study {study!r} of the key")
    number = _count(path, line, record)
    if str(number) not in trials:
        raise FileFormatError(
            path, line, f"trial {number}", f"a trial of the key, 1 … {len(trials)}"
        )
    return str(number), trials[str(number)]


def _count(path: str | Path, line: int, record: dict[str, Any]) -> int:
    number = record.get("trial")
    if not isinstance(number, float) or not number.is_integer():
        raise FileFormatError(path, line, _got(record, "trial"), "the number of a trial")
    return int(number)


def _letter(path: str | Path, line: int, record: dict[str, Any], name: str, count: int) -> int:
    letter = record.get(name)
    letters = LETTERS[:count]
    if not isinstance(letter, str) or len(letter) != 1 or letter not in letters:
        raise FileFormatError(path, line, _got(record, name), f"one of {', '.join(letters)}")
    return letters.index(letter)


def _known(path: str | Path, line: int, record: Any) -> Known:
    """A trial; its candidates' measures are made those of an adult."""
    if not isinstance(record, dict):
        raise FileFormatError(path, line, shown(record), "a trial, which is an object")
    number, rows = _count(path, line, record), record.get("candidates")
    if not isinstance(rows, list) or not 2 <= len(rows) <= len(LETTERS):
        got = f"candidates {shown(rows)} of trial {number}"
        raise FileFormatError(path, line, got, f"a list of 2 … {len(LETTERS)}")
    scale = _number(path, line, record, "body_scale", number)
    if scale <= 0:
        raise FileFormatError(path, line, f"body_scale {scale:g}", "more than 0")
    settings = record.get("settings")
    place = f"{printable(path)}:{line}"
    if not isinstance(settings, dict):
        raise FileFormatError(path, line, _got(record, "settings"), "the search's settings")
    energy = EnergyConfig()
    for key, value in settings.items():
        if key != "T_window":
            energy = changed(energy, key, value, place)
    try:
        validate_config(AvoidanceConfig(energy=energy))
    except ConfigError as error:
        raise ConfigError(got=error.got, expected=error.expected, place=place) from None
    return Known(
        number=number,
        measures=tuple(_measures(path, line, row, number, scale) for row in rows),
        taken=_letter(path, line, record, "library", len(rows)),
        settings=energy,
    )


def _measures(path: str | Path, line: int, row: Any, trial: int, scale: float) -> tuple[float, ...]:
    energy = row.get("energy") if isinstance(row, dict) else None
    if not isinstance(energy, dict):
        got = f"a candidate of trial {trial} without energy"
        raise FileFormatError(path, line, got, "what was measured of it")
    lengths = [_number(path, line, energy, name, trial) / scale for name in MEASURES[:-1]]
    seconds = _number(path, line, row, "time_scale", trial)
    if seconds <= 0:
        raise FileFormatError(path, line, f"time_scale {seconds:g}", "more than 0")
    return (*lengths, seconds)


def _number(path: str | Path, line: int, record: dict[str, Any], name: str, trial: int) -> float:
    value = record.get(name)
    if not isinstance(value, float) or not math.isfinite(value):
        got = f"{_got(record, name)} in trial {trial}"
        raise FileFormatError(path, line, got, "a finite number")
    return value


def _same_settings(trials: list[Known]) -> None:
    first = trials[0]
    for trial in trials[1:]:
        for name in (f.name for f in fields(EnergyConfig) if f.name in _HELD):
            one, other = getattr(first.settings, name), getattr(trial.settings, name)
            if one != other:
                raise ConfigError(
                    got=f"trials with {name} = {one!r} and {other!r}", expected="one of both"
                )
