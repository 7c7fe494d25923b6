"""``mgjax fetch``."""

from __future__ import annotations

import sys

from tqdm import tqdm

from mgjax.cli.arguments import Fetch
from mgjax.cli.report import emit
from mgjax.core.errors import ConfigError
from mgjax.core.xla.compilation import cache_folder
from mgjax.io.fetch.cmu import SERVER, THANKS, Fetched, fetch_subject, subjects_in_words
from mgjax.io.fetch.cmu_subjects import LAST


def run(command: Fetch) -> None:
    """Fetches each subject in turn, and says how to go on."""
    unknown = [number for number in command.subjects if number not in LAST]
    if unknown or not command.subjects:
        got = f"subject {unknown[0]}" if unknown else "no subject"
        raise ConfigError(got=got, expected=f"numbers of {subjects_in_words()}")
    folder = cache_folder() / command.database
    done = []
    with tqdm(unit=" files", disable=not sys.stderr.isatty(), leave=False) as bar:

        def watch(name: str, count: int, total: int) -> None:
            bar.set_description(name, refresh=False)
            bar.total, bar.n = total, count
            bar.refresh()

        for number in dict.fromkeys(command.subjects):
            server = command.server or SERVER
            done.append(fetch_subject(number, folder, server=server, watch=watch))
    result = {"folder": str(folder), "subjects": [_json(fetched) for fetched in done]}
    lines = [line for fetched in done for line in _lines(fetched)]
    emit(result, [*lines, THANKS], as_json=command.json)


def _json(fetched: Fetched) -> dict[str, object]:
    return {
        "subject": fetched.subject.number,
        "folder": str(fetched.folder),
        "files": fetched.new + fetched.there,
        "new": fetched.new,
        "bytes": fetched.size,
        "missing": list(fetched.missing),
        "frame_rates": fetched.subject.rates,
        "frame_rates_stated": fetched.subject.stated,
    }


def _lines(fetched: Fetched) -> list[str]:
    subject = fetched.subject
    rates = ", ".join(f"{rate:g}" for rate in sorted(set(subject.rates.values())))
    source = "as the database states" if subject.stated else "the database's page does not say"
    lines = [
        f"subject {subject.number}: {fetched.new + fetched.there} files, {fetched.new} of them new"
        f" ({fetched.size / 1e6:.1f} MB); {rates} fps, {source}"
    ]
    if fetched.missing:
        lines.append(f"  not on the server: {', '.join(fetched.missing)}")
    return [*lines, f"  mgjax build --clips {fetched.folder} --out out/cmu{subject.name}"]
