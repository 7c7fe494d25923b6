"""Public names: typed for checkers as they are at run time, complete, and readable."""

from __future__ import annotations

import ast
import importlib
import inspect
import json
import pydoc
import re
import shutil
import subprocess
import sys
import types
import typing
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

PACKAGES = [
    *("mgjax", "mgjax.clips", "mgjax.graph"),
    *("mgjax.avoidance", "mgjax.ballsport", "mgjax.hybrid", "mgjax.quality", "mgjax.pictures"),
]
ROOT = Path(__file__).resolve().parent.parent

SCRIPT = """
import numpy as np
import mgjax
from mgjax.clips import load_clips, load_labels
from mgjax.graph import GraphConfig, build_graph, save_graph
from mgjax.avoidance import ball_attack, select

clips, notes = load_clips("capture")
labels = load_labels("capture/labels.json", clips, "capture")
graph = build_graph(clips, labels=labels, config=GraphConfig(keep=0.9))
save_graph("out/graph", graph)

attack = ball_attack(np.array([0, 1.4, 5.0]), np.array([0, 1.4, 0]), speed=10.0, arrives=1.2)
selection = select(graph, 0, attack)
print(selection.status, selection.clearance_m, selection.energy)
mgjax.save_bvh("avoided.bvh", graph.skeleton, selection.motion)

skeleton, motion = mgjax.load_motion("a.bvh")
reveal_type(clips)
reveal_type(notes)
reveal_type(labels)
reveal_type(graph)
reveal_type(attack)
reveal_type(selection)
reveal_type(selection.status)
reveal_type(selection.clearance_m)
reveal_type(selection.energy)
reveal_type(selection.motion)
reveal_type(skeleton)
reveal_type(motion)
reveal_type(mgjax.global_positions(skeleton, motion))
reveal_type(mgjax.graph.load_graph("out/graph"))
reveal_type(mgjax.graph.unroll(graph, [0]))
reveal_type(mgjax.clips.synthetic_clips())

positions = np.zeros((9, 31, 3), np.float32)
reveal_type(mgjax.graph.distance_matrix(positions, positions, window=3))

room = mgjax.avoidance
reveal_type(room.choose)
reveal_type(room.limb_attack)
reveal_type(room.merge_attacks([attack, attack]))
reveal_type(room.load_attack("attack.json"))
reveal_type(room.load_index("out/graph", graph))
reveal_type(room.build_index)
reveal_type(room.save_index)
reveal_type(room.Planner(graph))
reveal_type(room.select_batch)
reveal_type(room.sweep_energies)
reveal_type(room.energies)
reveal_type(room.energies_batch)
reveal_type(room.EnergyConfig(w_t=2.0).E_avoidance)

hybrid = mgjax.hybrid
sketch = hybrid.make_sketch([[0.0, 0.0], [0.0, 3.0]])
reveal_type(sketch)
reveal_type(hybrid.follow(graph, sketch))
target = hybrid.make_target("head", place=[0.0, 1.5, 2.0], when="passing")
reveal_type(hybrid.reach(graph, sketch, (target,)))
reveal_type(hybrid.fabrik)
reveal_type(hybrid.fabrik_tree)
reveal_type(hybrid.reach_pose)

sport = mgjax.ballsport
reveal_type(sport.fly)
reveal_type(sport.aim)
reveal_type(sport.aim_batch)
reveal_type(sport.find_hits)
hits = sport.build_clip_set()
reveal_type(hits)
reveal_type(sport.Matcher(hits))
"""


@pytest.mark.parametrize("package", PACKAGES)
def test_checkers_see_the_names_of_the_table(package: str) -> None:
    module = importlib.import_module(package)
    tree = ast.parse(inspect.getsource(module))
    block = next(node for node in tree.body if isinstance(node, ast.If))
    seen: dict[str, str] = {}
    for item in block.body:
        assert isinstance(item, ast.ImportFrom)
        for alias in item.names:
            assert alias.asname == alias.name, "a re-export has to be explicit"
            seen[alias.name] = str(item.module)
    call = next(node for node in ast.walk(block) if isinstance(node, ast.Call))
    table: dict[str, str] = ast.literal_eval(call.args[1])
    rooms = {name for name, home in table.items() if home == f"{package}.{name}"}
    assert {n: package if n in rooms else home for n, home in table.items()} == seen
    assert set(table) == set(module.__all__) - {"__version__"}
    for name in table:
        assert getattr(module, name) is not None
    with pytest.raises(AttributeError, match="'nothing'"):
        _ = module.nothing


@pytest.mark.parametrize("package", PACKAGES)
def test_names_are_listed(package: str) -> None:
    module = importlib.import_module(package)
    assert dir(module) == sorted(module.__all__)
    text = pydoc.render_doc(module, renderer=pydoc.plaintext)
    for name in set(module.__all__) - {"__version__"}:
        assert name in text
    folders = {path.name for path in Path(module.__path__[0]).iterdir()}
    homes = {name for name in module.__all__ if isinstance(getattr(module, name), types.ModuleType)}
    assert not (set(module.__all__) - homes) & folders, "a folder would hide the name"


def _classes(hint: Any) -> Iterator[type]:
    """The classes of this package in an annotation."""
    if isinstance(hint, type) and typing.get_origin(hint) is None:
        if hint.__module__.startswith("mgjax."):
            yield hint
        return
    for argument in typing.get_args(hint):
        yield from _classes(argument)


def test_what_functions_return_can_be_imported() -> None:
    public: dict[str, Any] = {}
    for package in PACKAGES:
        module = importlib.import_module(package)
        public |= {f"{package}.{name}": getattr(module, name) for name in module.__all__}
    known = {id(item) for item in public.values()}
    missing = [
        f"{name}: {kind.__module__}.{kind.__name__}"
        for name, item in public.items()
        if callable(item) and not isinstance(item, type)
        for kind in _classes(typing.get_type_hints(item).get("return"))
        if id(kind) not in known
    ]
    assert not missing


def test_a_user_script(tmp_path: Path) -> None:
    checker = shutil.which("pyright", path=str(Path(sys.executable).parent))
    if checker is None:
        reason = "pyright is not installed"
        print(reason)
        pytest.skip(reason)
    (tmp_path / "script.py").write_text(SCRIPT)
    strict = ("Variable", "Member", "Argument", "Parameter", "Lambda")
    settings: dict[str, Any] = {f"reportUnknown{kind}Type": "error" for kind in strict}
    settings |= {
        "include": ["script.py"],
        "extraPaths": [str(ROOT)],
        "reportUnknownMemberType": "error",
        "reportMissingTypeArgument": "error",
        "reportPrivateImportUsage": "error",
    }
    (tmp_path / "pyrightconfig.json").write_text(json.dumps(settings))
    words = [checker, "--outputjson", "--pythonpath", sys.executable, "-p", str(tmp_path)]
    done = subprocess.run(words, capture_output=True, text=True, check=False, cwd=tmp_path)
    found = json.loads(done.stdout)["generalDiagnostics"]
    wrong = [f"{x['range']['start']['line']}: {x['message']}" for x in found
             if x["severity"] != "information"]  # fmt: skip
    assert not wrong
    revealed = [x["message"] for x in found if x["severity"] == "information"]
    assert len(revealed) == SCRIPT.count("reveal_type(")
    for text in revealed:
        # NumPy's own default for the shape and the numbers of an array.
        plain = re.sub(r"ndarray\[(tuple\[Any, \.\.\.\]|_AnyShape), dtype\[Any\]\]", "array", text)
        results = plain.rpartition("->")[2]
        assert not re.search(r"\b(Any|Unknown)\b", results), text
