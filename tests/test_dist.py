"""The wheel and the source archive: complete, and of use without the checkout."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tarfile
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
pytestmark = pytest.mark.long


def call(*words: str | Path, cwd: Path, **more: str) -> str:
    """Runs a command outside of the checkout and returns what it printed."""
    environment = {k: v for k, v in os.environ.items() if k != "PYTHONPATH"} | more
    done = subprocess.run(
        [str(word) for word in words],
        cwd=cwd, env=environment, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the source archive, and the wheel built from it."""
    out = tmp_path_factory.mktemp("dist")
    call(sys.executable, "-m", "build", "--outdir", out, ROOT, cwd=out)
    return out


def test_the_source_archive_has_the_sources_only(built: Path) -> None:
    (archive,) = built.glob("*.tar.gz")
    with tarfile.open(archive) as files:
        names = {name.partition("/")[2] for name in files.getnames()}
    tops = {name.partition("/")[0] for name in names}
    assert tops <= {
        *("mgjax", "configs", "docs", "experiments", "notebooks", "tests"),
        *("CHANGELOG.md", "CONTRIBUTING.md", "LICENSE", "README.md", "RESULTS.md", "Makefile"),
        *("mkdocs.yml",),
        *("pyproject.toml", "PKG-INFO", ".gitignore"),
    }
    assert {"mgjax/py.typed", "tests/test_dist.py", "pyproject.toml"} <= names
    assert not [name for name in names if name.endswith((".amc", ".asf", ".bvh", ".pyc"))]


def test_the_wheel_has_the_package_only(built: Path) -> None:
    (wheel,) = built.glob("*.whl")
    with zipfile.ZipFile(wheel) as files:
        names = set(files.namelist())
    package = ROOT / "mgjax"
    pages = [path for path in (package / "stage" / "page").rglob("*") if path.is_file()]
    sources = {str(path.relative_to(ROOT)) for path in (*package.rglob("*.py"), *pages)}
    assert sources | {"mgjax/py.typed"} == {n for n in names if ".dist-info/" not in n}


def test_the_demo_runs_from_the_wheel(built: Path, tmp_path: Path) -> None:
    (wheel,) = built.glob("*.whl")
    call(sys.executable, "-m", "venv", "empty", cwd=tmp_path)
    folder = tmp_path / "empty" / "bin"
    pip = ("-m", "pip", "install", "--quiet", "--disable-pip-version-check")
    call(folder / "python", *pip, wheel, cwd=tmp_path)
    cache = str(tmp_path / "cache")
    out = call(folder / "mgjax", "demo", "--json", "--out", "demo", cwd=tmp_path, MGJAX_CACHE=cache)
    assert json.loads(out)["avoided"] >= 1
    files = {path.name for path in (tmp_path / "demo").iterdir()}
    assert files == {"index.html", "motion.bvh", "result.json", "scene.png"}
