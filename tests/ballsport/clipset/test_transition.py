from __future__ import annotations

from dataclasses import replace

import jax.numpy as jnp
import numpy as np
import pytest

from mgjax.ballsport.clipset.build import ClipSet
from mgjax.ballsport.clipset.joining import join
from mgjax.ballsport.clipset.transition import (
    NO_SECTION,
    compared_joints,
    find_transitions,
    pose_distances,
    pose_features,
)
from mgjax.ballsport.config import TransitionConfig
from mgjax.core import planar
from mgjax.core.body.roles import require_roles
from mgjax.core.errors import ConfigError, MotionError
from mgjax.core.kinematics import global_positions
from tests.reference import match as reference


def shortened(clips: ClipSet, links: list[int], most: int = 24) -> ClipSet:
    """A clip set with but a few short link motions."""
    starts = clips.link_starts[links]
    stops = np.minimum(clips.link_stops[links], starts + most - np.arange(len(links)))
    return replace(clips, link_clip=clips.link_clip[links], link_starts=starts, link_stops=stops)


@pytest.fixture(scope="module")
def table_of_real(real_set: ClipSet):
    return find_transitions(real_set)


def test_features_agree_with_the_definition(real_set: ClipSet) -> None:
    features = pose_features(real_set)
    joints = compared_joints(real_set.skeleton)
    hips = require_roles(real_set.skeleton, ("left_hip", "right_hip"))
    for clip in (0, len(real_set.clip_names) - 1):
        first, stop = int(real_set.clip_starts[clip]), int(real_set.clip_stops[clip])
        for f in (first, first + 7, stop - 1):
            expected = reference.pose_feature(
                real_set.positions, f, first, stop, joints, hips, real_set.motion.frame_rate
            )
            np.testing.assert_allclose(features[f], expected, atol=2e-4)


def test_sections_agree_with_the_definition(real_set: ClipSet) -> None:
    clips = shortened(real_set, [0, 5, 20, 30, 9])
    clips = replace(clips, link_stops=np.append(clips.link_stops[:-1], clips.link_starts[-1] + 4))
    config = TransitionConfig(seconds=0.2, loop_s=0.3)
    table = find_transitions(clips, config)
    assert table.window == 6
    features = pose_features(clips)
    weights = [*config.w_p, *config.w_v]
    for i in range(5):
        for j in range(5):
            a, b = (features[clips.link_starts[x] : clips.link_stops[x]] for x in (i, j))
            best = reference.section(a, b, weights, 6, 9 if i == j else None)
            if best is None:
                assert table.leave[i, j] == table.arrive[i, j] == NO_SECTION
                assert np.isinf(table.distance[i, j])
                continue
            np.testing.assert_allclose(table.distance[i, j], best[0], rtol=1e-4)
            row = int(table.leave[i, j] - clips.link_starts[i])
            column = int(table.arrive[i, j] - clips.link_starts[j])
            again = reference.section(a[row : row + 6], b[column : column + 6], weights, 6, None)
            np.testing.assert_allclose(again[0], best[0], rtol=1e-4)


def test_by_hand() -> None:
    rows, columns = np.zeros((10, 3, 1), np.float32), np.zeros((10, 3, 2), np.float32)
    columns[0, :, 1] = [3, 4, 0]
    columns[9, :, 1] = [0, 0, 2]
    weights = np.array([2, 1, 1, 1, 1, 1, 1, 1, 1, 0.5], np.float32)
    got = pose_distances(*(jnp.asarray(x) for x in (rows, columns, weights)))
    np.testing.assert_allclose(got, [[0.0, 2 * 5 + 0.5 * 2]])


def test_sections_lie_inside_their_links(real_set: ClipSet, table_of_real) -> None:
    table, window = table_of_real, table_of_real.window
    for i in range(real_set.num_links):
        for j in range(real_set.num_links):
            if table.leave[i, j] == NO_SECTION:
                short = min(
                    real_set.link_stops[i] - real_set.link_starts[i],
                    real_set.link_stops[j] - real_set.link_starts[j],
                )
                assert short < window + (15 if i == j else 0)
                continue
            assert real_set.link_starts[i] <= table.leave[i, j]
            assert table.leave[i, j] + window <= real_set.link_stops[i]
            assert real_set.link_starts[j] <= table.arrive[i, j]
            assert table.arrive[i, j] + window <= real_set.link_stops[j]
            if i == j:
                assert table.arrive[i, j] <= table.leave[i, j] - 15


def test_other_links_change_nothing(real_set: ClipSet, table_of_real) -> None:
    few = [3, 17, 40]
    clips = replace(
        real_set,
        link_clip=real_set.link_clip[few],
        link_starts=real_set.link_starts[few],
        link_stops=real_set.link_stops[few],
    )
    table = find_transitions(clips)
    part = np.ix_(few, few)
    np.testing.assert_allclose(table.distance, table_of_real.distance[part], rtol=1e-5)
    np.testing.assert_array_equal(table.leave, table_of_real.leave[part])
    np.testing.assert_array_equal(table.arrive, table_of_real.arrive[part])


def test_joined_motion_does_not_jump(real_set: ClipSet, table_of_real) -> None:
    window = table_of_real.window
    # From a captured kick to a made one: hit, link, link, hit.
    for first, second in ((real_set.num_hits - 1, 0), (0, 14), (14, 20)):
        i, j = real_set.link_after[first], real_set.link_before[second]
        leave, arrive = int(table_of_real.leave[i, j]), int(table_of_real.arrive[i, j])
        pieces = [
            (int(real_set.hit_starts[first]), leave + window),
            (arrive, int(real_set.hit_stops[second])),
        ]
        start = np.array([0.3, 1.0, -2.0])
        joined = join(real_set, pieces, window=window, placement=start)
        assert joined.motion.num_frames == sum(b - a for a, b in pieces) - window
        places = np.asarray(global_positions(real_set.skeleton, joined.motion))
        steps = np.linalg.norm(np.diff(places, axis=0), axis=-1).max(axis=1)
        own = max(
            np.linalg.norm(np.diff(real_set.positions[a:b], axis=0), axis=-1).max()
            for a, b in pieces
        )
        ((begin, stop),) = joined.seams
        assert steps[begin - 1 : stop + 1].max() < own + 0.03
        # The frames of the hits are those of the set, moved as the placements say.
        for piece, frame in enumerate((real_set.fastest[first], real_set.fastest[second])):
            expected = planar.apply(joined.placements[piece], real_set.positions[frame])
            got = places[frame + joined.offsets[piece]]
            np.testing.assert_allclose(got, expected, atol=1e-4)


def test_one_piece_is_the_clip(made_set: ClipSet) -> None:
    joined = join(made_set, [(10, 40)], window=5)
    np.testing.assert_array_equal(
        joined.motion.root_translation, made_set.motion.root_translation[10:40]
    )
    assert joined.seams.shape == (0, 2)
    # A seam between a motion and itself at the same frames changes nothing.
    same = join(made_set, [(10, 30), (20, 40)], window=10)
    whole = np.asarray(global_positions(made_set.skeleton, same.motion))
    np.testing.assert_allclose(whole, made_set.positions[10:40], atol=2e-5)


@pytest.mark.parametrize(
    ("pieces", "text"),
    [
        ([], "0 pieces"),
        ([(5, 5)], "inside one clip"),
        ([(0, 10**6)], "inside one clip"),
        ([(0, 30), (30, 39), (60, 90)], "at least 10 frames"),
    ],
)
def test_pieces_that_cannot_be(made_set: ClipSet, pieces, text: str) -> None:
    with pytest.raises(MotionError, match=text):
        join(made_set, pieces, window=5)


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"seconds": 0.0}, "seconds = 0.0, expected 0.001 … 60"),
        ({"seconds": float("nan")}, "seconds = nan"),
        ({"loop_s": -1.0}, "loop_s"),
        ({"w_p": (0.0,) * 5, "w_v": (0.0,) * 5}, "one above 0"),
        ({"w_p": (-1.0,) * 5}, "w_p = -1"),
    ],
)
def test_settings_that_cannot_be(made_set: ClipSet, change: dict, text: str) -> None:
    with pytest.raises(ConfigError, match=text):
        find_transitions(made_set, replace(TransitionConfig(), **change))
