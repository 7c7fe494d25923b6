"""Virtual environments of peers: made once, with nothing but what the peer needs."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

from experiments.benchmarks.beside.types import Peer
from mgjax.core.errors import ConfigError
from mgjax.core.xla.compilation import cache_folder

FOLDER = "MGJAX_PEERS"
"""Environment variable: the folder of the environments."""
READY = "mgjax-ready.txt"
"""In an environment: what was installed there."""
NO_INDEX = "from versions: none"
"""What pip says of a name that no index has, and of all names where no index answers."""


class Unavailable(Exception):
    """A peer that cannot be measured here; its text is one line that says why."""


def folder() -> Path:
    """``MGJAX_PEERS``, else ``peers`` in mgjax's cache folder."""
    named = os.environ.get(FOLDER)
    return Path(named).expanduser().resolve() if named else cache_folder() / "peers"


def interpreter(peer: Peer, base: Path) -> Path:
    """The Python that has the peer; its environment is made below ``base`` where there is none.

    Raises:
        Unavailable: it cannot be installed.
        ConfigError: there is no package index.
    """
    if not peer.packages:
        return Path(sys.executable)
    place = base / re.sub(r"[^\w.]+", "-", peer.name)
    python = place / ("Scripts" if os.name == "nt" else "bin") / "python"
    wanted = "\n".join([sys.version, *peer.packages, *peer.alone])
    if (place / READY).is_file() and (place / READY).read_text(encoding="utf-8") == wanted:
        return python
    print(f"{peer.name}: an environment with {', '.join(peer.installed)} …", file=sys.stderr)
    base.mkdir(parents=True, exist_ok=True)
    made = call([sys.executable, "-m", "venv", "--clear", str(place)])
    if made.returncode:
        raise Unavailable(reason(made))
    _install(python, list(peer.packages))
    if peer.alone:
        _install(python, ["--no-deps", *peer.alone])
    (place / READY).write_text(wanted, encoding="utf-8")
    return python


def _install(python: Path, words: list[str]) -> None:
    done = pip(python, words)
    if done.returncode == 0:
        return
    if NO_INDEX in done.stdout + done.stderr and pip(python, ["--dry-run", "numpy"]).returncode:
        raise ConfigError(
            got="no package index that answers",
            expected="one from which peers can be installed, or their environments made before",
        )
    raise Unavailable(reason(done))


def pip(python: Path, words: list[str]) -> subprocess.CompletedProcess[str]:
    """``pip install`` in an environment."""
    quiet = ("--quiet", "--disable-pip-version-check", "--no-input")
    return call([str(python), "-m", "pip", "install", *quiet, *words])


def call(words: list[str]) -> subprocess.CompletedProcess[str]:
    """Runs a command, what it prints kept; without what this process imports from."""
    kept = {k: v for k, v in os.environ.items() if k not in ("PYTHONPATH", "PYTHONHOME")}
    return subprocess.run(words, env=kept, capture_output=True, text=True, check=False)


def reason(done: subprocess.CompletedProcess[str]) -> str:
    """One line on why a command failed: its first error."""
    lines = [line.strip() for line in (done.stderr + done.stdout).splitlines() if line.strip()]
    errors = [line.removeprefix("ERROR: ") for line in lines if line.startswith("ERROR: ")]
    return one_line((errors or lines[-1:] or [f"exit status {done.returncode}"])[0])


def one_line(text: str) -> str:
    """A text on one line of at most 200 characters, without the place of any file."""
    return re.sub(r"(?<![\w:/])/(?:[^\s'\"/]+/)+", "…/", " ".join(text.split()))[:200]
