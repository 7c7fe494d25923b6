import json
import shutil

import numpy as np
import pytest

from mgjax.cli.avoid import selection_json, write_volumes
from mgjax.cli.report import to_json
from mgjax.core.errors import FileFormatError
from mgjax.io.bvh.write import save_bvh
from mgjax.stage.show.folder import show_of_folder
from mgjax.stage.show.selection import selection_show


@pytest.fixture(scope="module")
def avoided(tmp_path_factory, graph, thrown):
    """What ``mgjax avoid`` writes."""
    folder = tmp_path_factory.mktemp("avoid")
    attack, selection = thrown
    (folder / "result.json").write_text(to_json(selection_json(graph, selection)))
    save_bvh(folder / "motion.bvh", graph.skeleton, selection.motion)
    write_volumes(folder / "volumes.npz", graph, attack, selection)
    return folder


def test_a_folder_shows_what_the_selection_shows(avoided, graph, thrown):
    attack, selection = thrown
    wanted, show = selection_show(graph, attack, selection), show_of_folder(avoided)
    assert show.words == wanted.words
    assert show.notes == wanted.notes
    assert show.seconds == pytest.approx(wanted.seconds, abs=1e-4)
    assert [bar.value for bar in show.bars] == pytest.approx([bar.value for bar in wanted.bars])
    assert [s.text for s in show.spans] == [s.text for s in wanted.spans]
    for a, b in zip(show.spans, wanted.spans, strict=True):
        assert (a.start, a.end) == pytest.approx((b.start, b.end), abs=1e-6)
    assert dict(show.moments) == pytest.approx(dict(wanted.moments))


def test_its_ball_flies_where_the_attack_did(avoided, thrown):
    (ball,) = show_of_folder(avoided).balls
    np.testing.assert_allclose(ball.places, thrown[0].at(ball.times)[:, 0], atol=1e-4)


def test_a_motion_file_is_a_show_of_its_own(avoided, thrown):
    show = show_of_folder(avoided / "motion.bvh")
    assert show.title == "motion.bvh"
    assert show.seconds == pytest.approx((thrown[1].motion.num_frames - 1) / 60, rel=0.6)
    assert len(show.actors) == 1


@pytest.mark.parametrize(
    ("spoil", "got"),
    [
        (lambda folder: (folder / "result.json").unlink(), "none of these files"),
        (lambda folder: (folder / "result.json").write_text("{"), "expected"),
        (lambda folder: (folder / "result.json").write_text("[]"), "none of these files"),
        (lambda folder: (folder / "volumes.npz").unlink(), "no volumes"),
        (lambda folder: (folder / "volumes.npz").write_bytes(b"PK no"), "no volumes"),
        (lambda folder: (folder / "motion.bvh").unlink(), "motion.bvh"),
        (
            lambda folder: (folder / "result.json").write_text(
                json.dumps({"clearance_m": 1, "walk": 3})
            ),
            "values of another kind",
        ),
        (
            lambda folder: (folder / "result.json").write_text(json.dumps({"clearance_m": 1})),
            "no 'walk'",
        ),
    ],
)
def test_one_clear_error_for_what_is_none(tmp_path, avoided, spoil, got):
    folder = tmp_path / "copy"
    shutil.copytree(avoided, folder)
    spoil(folder)
    with pytest.raises(FileFormatError) as caught:
        show_of_folder(folder)
    assert got in str(caught.value)
    assert "expected" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_nothing_there_and_no_motion(tmp_path):
    with pytest.raises(FileFormatError, match="nothing there"):
        show_of_folder(tmp_path / "missing")
    (tmp_path / "picture.png").write_bytes(b"1")
    with pytest.raises(FileFormatError, match=r"a file \.png"):
        show_of_folder(tmp_path / "picture.png")
