"""Whole builds by other executors and in processes that are killed: each has its own jax."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from mgjax.core.errors import WorkerError
from mgjax.core.parallel.executors import executor
from mgjax.graph.build import build_graph
from mgjax.graph.files import load_graph
from mgjax.graph.stages.stages import Stages, stage_store
from mgjax.io.bvh.write import save_bvh
from tests.graph.made import BODY, march
from tests.graph.stages.test_build_in_stages import ENTRIES, assert_same_graph, counts

PARENT = """
import os, signal, sys
import tests.conftest
from tests.graph.made import made_clips
from mgjax.graph.build import build_graph
from mgjax.graph.stages.stages import Stages, stage_store
from mgjax.io.stages import StageStore

if __name__ == "__main__":
    folder, blocks = sys.argv[1], int(sys.argv[2])
    store = stage_store(folder)
    save = StageStore.save

    def killed(self, stage, *rest):
        save(self, stage, *rest)
        if self.made["minima"] == blocks:
            os.kill(os.getpid(), signal.SIGKILL)

    StageStore.save = killed
    clips, labels = made_clips()
    build_graph(clips, labels=labels, stages=Stages(store=store, entries=200))
"""


def test_a_killed_build_goes_on_where_it_was(made, tmp_path):
    child = subprocess.run(
        [sys.executable, "-c", PARENT, tmp_path, "4"], capture_output=True, text=True, check=False
    )
    assert child.returncode == -signal.SIGKILL, child.stderr
    used = Stages(store=stage_store(tmp_path), entries=ENTRIES)
    graph = build_graph(made[0], labels=made[1], stages=used)
    found, computed = counts(used)
    assert (found["minima"], computed["minima"]) == (4, 2)
    assert_same_graph(build_graph(made[0], labels=made[1], stages=Stages()), graph)


DEVICES = """
import sys
import tests.conftest
import jax
from tests.graph.made import made_clips
from mgjax.core.parallel.executors import executor
from mgjax.graph.build import build_graph
from mgjax.graph.distances import pruned
from mgjax.graph.files import save_graph
from mgjax.graph.stages.stages import Stages

opened, used = pruned.open_pairs, set()


def watched(rows, *rest, **more):
    found = opened(rows, *rest, **more)
    used.add(found.device)
    return found


pruned.open_pairs = watched
clips, labels = made_clips()
with executor("devices", device="cpu") as pool:
    graph = build_graph(clips, labels=labels, stages=Stages(executor=pool, entries=200))
assert len(jax.devices()) == 3
assert used == set(jax.devices()), used
save_graph(sys.argv[1], graph)
"""


@pytest.mark.long
def test_several_devices_make_the_same_graph(made, tmp_path):
    flags = f"{os.environ.get('XLA_FLAGS', '')} --xla_force_host_platform_device_count=3"
    child = subprocess.run(
        [sys.executable, "-c", DEVICES, tmp_path / "graph"],
        env={**os.environ, "XLA_FLAGS": flags},
        capture_output=True,
        text=True,
        check=False,
    )
    assert child.returncode == 0, child.stderr
    want = build_graph(made[0], labels=made[1], stages=Stages())
    assert_same_graph(want, load_graph(tmp_path / "graph"))


def ends(_: object) -> None:
    os.kill(os.getpid(), signal.SIGKILL)


@pytest.mark.long
def test_workers_make_the_same_graph_and_a_killed_one_loses_nothing(made, tmp_path):
    want = build_graph(made[0], labels=made[1], stages=Stages())
    with executor("processes", 2) as pool:
        store = stage_store(tmp_path)
        pool.submit(ends, None).exception()
        with pytest.raises(WorkerError, match="got the end of a worker process"):
            build_graph(
                made[0],
                labels=made[1],
                stages=Stages(executor=pool, store=store, entries=ENTRIES),
            )
    for name, workers in (("processes", 2), ("processes", 4), ("ray", 2)):
        with executor(name, workers) as pool:
            stages = Stages(executor=pool, entries=ENTRIES)
            assert_same_graph(want, build_graph(made[0], labels=made[1], stages=stages))


@pytest.mark.long
def test_the_command_line_goes_on_after_a_worker_was_killed(tmp_path):
    clips = tmp_path / "clips"
    clips.mkdir()
    for k in range(4):
        save_bvh(clips / f"{k}.bvh", BODY, march(1500, seed=k, noise=0.05))
    command = [sys.executable, "-m", "mgjax", "build", "--clips", clips, "--json"]
    command += ["--work", tmp_path / "work", "--workers", "1"]

    first = subprocess.Popen(
        [*command, "--out", tmp_path / "one"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    minima = tmp_path / "work" / "minima"
    while not (minima.is_dir() and len(list(minima.glob("*.safetensors"))) >= 2):
        assert first.poll() is None, first.communicate()
        time.sleep(0.01)
    for worker in workers_of(first.pid):
        os.kill(worker, signal.SIGKILL)
    _, said = first.communicate()
    assert first.returncode == 2
    assert said.strip().splitlines()[-1].startswith("mgjax: got the end of a worker process")
    assert not (tmp_path / "one").exists()
    kept = len(list(minima.glob("*.safetensors")))
    assert 2 <= kept < 10
    second = subprocess.run(
        [*command, "--out", tmp_path / "two"], capture_output=True, text=True, check=True
    )
    assert json.loads(second.stdout)["clips"] == 4
    assert len(list(minima.glob("*.safetensors"))) == 10
    whole = [*command[:-4], "--executor", "serial", "--work", tmp_path / "other"]
    subprocess.run([*whole, "--out", tmp_path / "three"], capture_output=True, check=True)
    assert_same_graph(load_graph(tmp_path / "three"), load_graph(tmp_path / "two"))


def workers_of(parent: int) -> list[int]:
    """Processes that a pool of ``parent`` has spawned."""
    found = []
    for entry in Path("/proc").iterdir():
        if not entry.name.isdecimal():
            continue
        try:
            above = (entry / "stat").read_text().rpartition(")")[2].split()[1]
            line = (entry / "cmdline").read_text()
        except OSError:
            continue
        if int(above) == parent and "spawn_main" in line:
            found.append(int(entry.name))
    return found
