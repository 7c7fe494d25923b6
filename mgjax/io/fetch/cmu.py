"""Subjects of the CMU Graphics Lab Motion Capture Database, into a folder each.

The database says: it is free for all uses, is not to be crawled, and its data may not be resold.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import urlencode

from mgjax.core.errors import ConfigError, FetchError, OutputError
from mgjax.io.fetch.cmu_subjects import LAST, RATES, USUAL_RATE, known_motions
from mgjax.io.fetch.download import download
from mgjax.io.output import replace_file
from mgjax.io.text import reason

SERVER = "http://mocap.cs.cmu.edu"
THANKS = (
    "The data used in this project was obtained from mocap.cs.cmu.edu. The database was created"
    " with funding from NSF EIA-0196217."
)
"""What the database asks those to write who publish."""

_MOTION = re.compile(r'/(\d+_\d+)\.amc"[^>]*>\s*amc\s*<(.*?)(?=<tr\b|badtrial|$)', re.I | re.S)
"""A motion in the page of a subject, and its row from there to the link for complaints."""
_RATE = re.compile(r"<td[^>]*>\s*([1-9]\d{0,2})\s*</td>", re.I)
"""The cell with the frame rate: after the files the only one with a number alone."""


@dataclass(frozen=True, kw_only=True)
class Subject:
    """One subject of the database.

    Attributes:
        number: the database's.
        rates: frames per second of each motion, by its name, such as ``14_02``.
        stated: whether the database stated all of them now; otherwise some are those known offline.
    """

    number: int
    rates: dict[str, float]
    stated: bool

    @property
    def name(self) -> str:
        """As the database writes it, such as ``07``."""
        return f"{self.number:02d}"


@dataclass(frozen=True, kw_only=True)
class Fetched:
    """What was fetched of a subject.

    Attributes:
        subject: which.
        folder: where its files are.
        new: files that came now.
        there: files that were there before.
        missing: motions that the server does not have.
        size: bytes that came now.
    """

    subject: Subject
    folder: Path
    new: int
    there: int
    missing: tuple[str, ...]
    size: int


def fetch_subject(
    number: int,
    folder: Path,
    *,
    server: str = SERVER,
    watch: Callable[[str, int, int], None] | None = None,
) -> Fetched:
    """Fetches skeleton and motions of a subject; files that are there already stay as they are.

    Each file is whole or not there, so that the same call goes on where one was stopped. Where a
    rate is not 120 a ``clips.toml`` says so, before the first motion is there.

    Args:
        number: of the subject.
        folder: for the folders of subjects.
        server: where the database is, or a copy of it.
        watch: is told each file's name, its number and how many there are.

    Raises:
        ConfigError: there is no such subject.
        FetchError: the network or the server fails; what had come by then stays.
        OutputError: the folder cannot be written.
    """
    if number not in LAST:
        raise ConfigError(got=f"subject {number}", expected=f"one of {subjects_in_words()}")
    server = server.rstrip("/")
    subject = ask(number, server)
    place = folder / subject.name
    try:
        place.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputError(
            got=f"no folder {place} ({reason(error)})", expected="a writable place"
        ) from None
    if any(rate != USUAL_RATE for rate in subject.rates.values()):
        replace_file(place / "clips.toml", rates_toml(subject.rates))
    names = [f"{subject.name}.asf", *(f"{motion}.amc" for motion in subject.rates)]
    new = there = size = 0
    missing = []
    for count, name in enumerate(names):
        if watch is not None:
            watch(name, count, len(names))
        if (place / name).is_file():
            there += 1
            continue
        url = f"{server}/subjects/{subject.name}/{name}"
        try:
            data = _acclaim(url)
        except FetchError as error:
            if name.endswith(".amc") and error.got.startswith("404"):
                missing.append(name.removesuffix(".amc"))
                continue
            raise FetchError(
                f"{error}; {new + there} of {len(names)} files are there, the same command goes on"
            ) from None
        replace_file(place / name, data)
        new, size = new + 1, size + len(data)
    return Fetched(
        subject=subject, folder=place, new=new, there=there, missing=tuple(missing), size=size
    )


def ask(number: int, server: str = SERVER) -> Subject:
    """What the database says of a subject; where its page lists no motion, what is known offline.

    Raises:
        FetchError: the page does not come.
    """
    query = urlencode({"subjectnumber": number, "motion": "%"})
    url = f"{server}/search.php?{query}"
    page = download(url, "the database's page of a subject").decode("latin-1")
    name = f"{number:02d}_"
    rows = {motion: row for motion, row in _MOTION.findall(page) if motion.startswith(name)}
    cells = {motion: _RATE.search(row) for motion, row in rows.items()}
    known = RATES.get(number, USUAL_RATE)
    return Subject(
        number=number,
        rates={
            motion: float(cell[1]) if (cell := cells.get(motion)) else known
            for motion in rows or known_motions(number)
        },
        stated=bool(cells) and all(cells.values()),
    )


def rates_toml(rates: dict[str, float]) -> str:
    """A ``clips.toml`` that states the rates that are not the usual one."""
    if len(set(rates.values())) == 1:
        return f"frame_rate = {next(iter(rates.values())):g}\n"
    return "".join(
        f'["{motion}.amc"]\nframe_rate = {rate:g}\n'
        for motion, rate in rates.items()
        if rate != USUAL_RATE
    )


def subjects_in_words() -> str:
    """The numbers of all subjects, runs of them as ``5–43``."""
    runs: list[list[int]] = []
    for number in sorted(LAST):
        if runs and number == runs[-1][-1] + 1:
            runs[-1].append(number)
        else:
            runs.append([number])
    return ", ".join(f"{r[0]}–{r[-1]}" if len(r) > 1 else str(r[0]) for r in runs)


def _acclaim(url: str) -> bytes:
    """An ASF or AMC file, which begins with ``#`` or ``:`` and not as a page does."""
    data = download(url, "an ASF or AMC file")
    if not data.lstrip().startswith((b"#", b":")):
        raise FetchError(
            got=f"something else, which begins {data[:20]!r}",
            expected="an ASF or AMC file",
            place=url,
        )
    return data
