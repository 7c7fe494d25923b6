"""A new energy term is tried in a copy of the library: it touches the settings and one module."""

from __future__ import annotations

import filecmp
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import mgjax

SOURCE = Path(mgjax.__file__).parent

EDITS = {
    "avoidance/config.py": [
        (
            "        w_t: weight of the time scale energy.\n",
            "        w_t: weight of the time scale energy.\n        w_haste: weight of haste.\n",
        ),
        ("    w_t: Number = 1.0\n", "    w_t: Number = 1.0\n    w_haste: Number = 0.0\n"),
        (
            '    "w_t": (0.0, 1e9),\n',
            '    "w_t": (0.0, 1e9),\n    "w_haste": (0.0, 1e9),\n',
        ),
    ],
    "avoidance/energy/score.py": [
        (
            '    timescale: Float[Array, "*c"]\n',
            '    timescale: Float[Array, "*c"]\n    haste: Float[Array, "*c"]\n',
        ),
        ("    timescale: float\n", "    timescale: float\n    haste: float\n"),
        (
            "    return Scores(\n"
            "        total=total_energy(avoidance, body, timescale, config, movement),\n",
            "    haste = jnp.maximum(1 - measures.s_time, 0.0)\n"
            "    total = total_energy(avoidance, body, timescale, config, movement)\n"
            "    return Scores(\n        total=total + _float32(config.w_haste) * haste,\n"
            "        haste=haste,\n",
        ),
    ],
}

USE = """
import json
import numpy as np
from mgjax.avoidance import AvoidanceConfig, EnergyConfig, choose, select_batch, sweep_energies
from mgjax.avoidance.choice.results import Status
from mgjax.clips import synthetic_clips
from mgjax.graph import GraphConfig, build_graph
from tests.avoidance.made import throw

clips, labels = synthetic_clips()
graph = build_graph(clips, labels=labels, config=GraphConfig(threshold_m=0.05))
rows = []
for seed in range(12):
    rng = np.random.default_rng(seed)
    node, attack = int(rng.integers(graph.num_nodes)), throw(rng)
    for weight in (0.0, 50.0):
        config = AvoidanceConfig(energy=EnergyConfig(w_haste=weight), T_wide=0.0, refine="off")
        choice = choose(graph, node, attack, config=config)
        if choice.energy is None:
            continue
        e, batch = choice.energy, select_batch(graph, [node], [attack], config=config)
        swept = sweep_energies(graph, node, attack, [config.energy])
        assert tuple(Status)[batch.status[0]] == tuple(Status)[swept.status[0]] == choice.status
        rest = e.total - e.avoidance - e.body - e.timescale - config.energy.w_m * e.movement
        rows.append((weight, choice.time_scale, e.haste, rest))
print(json.dumps(rows))
"""


@pytest.mark.long
def test_a_made_up_weight_touches_three_files_at_most(tmp_path: Path) -> None:
    copy = tmp_path / "mgjax"
    shutil.copytree(SOURCE, copy, ignore=shutil.ignore_patterns("__pycache__"))
    for name, edits in EDITS.items():
        text = (copy / name).read_text()
        for old, new in edits:
            assert text.count(old) == 1, (name, old)
            text = text.replace(old, new)
        (copy / name).write_text(text)
    names = [str(path.relative_to(copy)) for path in copy.rglob("*.py")]
    _, changed, errors = filecmp.cmpfiles(SOURCE, copy, names, shallow=False)
    assert not errors
    assert sorted(changed) == sorted(EDITS)
    assert len(changed) <= 3
    paths = os.pathsep.join([str(tmp_path), str(SOURCE.parent)])
    done = subprocess.run(
        [sys.executable, "-c", USE],
        env=os.environ | {"PYTHONPATH": paths, "TF_CPP_MIN_LOG_LEVEL": "3"},
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr[-2000:]
    rows = json.loads(done.stdout)
    assert len(rows) >= 10
    for weight, s_time, haste, rest in rows:
        assert abs(haste - max(1 - s_time, 0.0)) < 1e-6
        assert abs(rest - weight * haste) < 1e-4
    assert any(haste > 0 for weight, _, haste, _ in rows if weight == 0)
    least, most = (sum(h for w, _, h, _ in rows if w == weight) for weight in (50.0, 0.0))
    assert least < most  # the term decides on what is played
