import numpy as np
import pytest

from mgjax.cli.report import to_json
from mgjax.cli.walk import reach_json, sketch_json, walk_json
from mgjax.hybrid.paths.curve import make_curve
from mgjax.hybrid.paths.search import follow
from mgjax.hybrid.paths.sketch import make_sketch
from mgjax.hybrid.reaching.result import Reached, ReachResult
from mgjax.hybrid.reaching.targets import make_target
from mgjax.io.bvh.write import save_bvh
from mgjax.stage.show.folder import show_of_folder
from mgjax.stage.show.of import show_of
from mgjax.stage.show.paths import path_show, reach_show


@pytest.fixture(scope="module")
def walked(graph):
    sketch = make_sketch([[0, 0], [0, 2], [1, 3]], obstacles=[[2.0, 1.0, 0.3]], end=(1, 3, np.nan))
    return sketch, follow(graph, sketch)


def test_path_track_and_obstacles(graph, walked):
    sketch, result = walked
    show = path_show(graph, sketch, result)
    lines = {line.id: line for line in show.lines}
    np.testing.assert_allclose(lines["sketch"].points[[0, -1]][:, [0, 2]], [[0, 0], [1, 3]])
    assert (lines["sketch"].points[:, 1] == 0).all()
    root = np.asarray(result.motion.root_translation)
    np.testing.assert_allclose(lines["track"].points[-1][[0, 2]], root[-1, [0, 2]], atol=1e-5)
    things = {thing.id: thing for thing in show.things}
    assert things["obstacle0"].radius == pytest.approx(0.3)
    assert things["obstacle0"].place == [2.0, 0.0, 1.0]
    assert things["end"].place == [1.0, 0.0, 3.0]
    notes = dict(show.notes)
    assert notes["path"] == f"{make_curve(sketch).length:.2f} m"
    assert notes["mean distance"] == f"{100 * result.mean_distance:.1f} cm"
    assert show.seconds == result.seconds
    assert show_of(result).words == show.words


def reached(walked) -> ReachResult:
    """A reach and a bar as they would be told, on the walk without them."""
    _, result = walked
    hand = make_target("right_hand", place=[0.4, 1.2, 1.0], when="passing")
    bar = make_target("head", bar=([-1, 1.5, 2], [1, 1.5, 2], 0.03))
    rows = (
        Reached(
            target=hand, status="reached", error_m=0.0004, hold_m=0.001, first=30, last=45,
            extended_m=0.0, stopped=False, drop_m=0.0, clear_m=0.05,
        ),
        Reached(
            target=bar, status="hit", error_m=np.nan, hold_m=np.nan, first=None, last=None,
            extended_m=0.0, stopped=False, drop_m=0.0, clear_m=-0.02,
        ),
    )  # fmt: skip
    return ReachResult(
        walked=result, motion=result.motion, plain=result.motion, targets=rows,
        shown=np.arange(float(result.motion.num_frames)),
        fastest_deg_s=1.0, fastest_plain_deg_s=1.0, slide=0.0, solve_s=0.1,
    )  # fmt: skip


def test_targets_stand_in_the_world(graph, walked):
    show = reach_show(graph, walked[0], reached(walked))
    things = {thing.id: thing for thing in show.things}
    assert things["target0"].place == pytest.approx([0.4, 1.2, 1.0])
    assert (things["target0"].colour, things["target1"].colour) == ("green", "red")
    assert things["target1"].end == pytest.approx([1, 1.5, 2])
    assert show.words == "1 of 2 reached; bar hit"
    (span,) = show.spans
    assert (span.start, span.end) == pytest.approx((30 / 30, 45 / 30))


@pytest.mark.parametrize("reaching", [False, True])
def test_the_folder_shows_the_same(tmp_path, graph, walked, reaching):
    sketch, result = walked
    value = walk_json(graph, result, make_curve(sketch).length) | {"sketch": sketch_json(sketch)}
    if reaching:
        value |= reach_json(graph, reached(walked))
        wanted = reach_show(graph, sketch, reached(walked))
    else:
        wanted = path_show(graph, sketch, result)
    (tmp_path / "result.json").write_text(to_json(value))
    save_bvh(tmp_path / "motion.bvh", graph.skeleton, result.motion)
    show = show_of_folder(tmp_path)
    assert show.title == wanted.title
    assert [(t.id, t.shape, t.colour) for t in show.things] == [
        (t.id, t.shape, t.colour) for t in wanted.things
    ]
    for a, b in zip(show.things, wanted.things, strict=True):
        np.testing.assert_allclose(a.place, b.place, atol=1e-6)
    assert [(s.row, s.text) for s in show.spans] == [(s.row, s.text) for s in wanted.spans]
    by_name = {line.id: line.points for line in wanted.lines}
    for line in show.lines:
        np.testing.assert_allclose(line.points[[0, -1]], by_name[line.id][[0, -1]], atol=2e-3)
    assert f"{100 * result.mean_distance:.1f} cm off" in show.words
