"""The procedural motion set: feet stay, bodies balance, and labels mean what they say."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import pytest

from mgjax.clips.synthetic import synthetic_clips, synthetic_skeleton
from mgjax.clips.types import Clip, Label
from mgjax.core import contacts, kinematics, planar
from mgjax.core.body.mirrored import mirror_joints
from mgjax.core.body.roles import require_roles
from mgjax.core.errors import MotionError
from mgjax.core.motion import validate_motion
from mgjax.core.skeleton import rest_positions, validate_skeleton
from tests.work import counted

RATE = 30.0
SEEDS = (0, 1)
BODY = synthetic_skeleton()
TURNING = ("femur", "humerus")
SOLE = ("ltoes", "rtoes", "ltoes_end", "rtoes_end")


@dataclass(frozen=True, kw_only=True)
class MadeSet:
    """Clips, labels and the global positions of each clip."""

    clips: list[Clip]
    labels: dict[str, tuple[Label, ...]]
    positions: dict[str, np.ndarray]


@lru_cache
def made(seed: int) -> MadeSet:
    clips, labels = synthetic_clips(seed=seed)
    positions = {
        c.name: np.asarray(kinematics.global_positions(c.skeleton, c.motion), dtype=np.float64)
        for c in clips
    }
    return MadeSet(clips=clips, labels=labels, positions=positions)


@pytest.fixture(params=SEEDS)
def motions(request: pytest.FixtureRequest) -> MadeSet:
    return made(request.param)


def joints(*names: str) -> list[int]:
    return [BODY.index(name) for name in names]


def parts(motions: MadeSet, kind: str, *, walking: bool = False) -> list[tuple[Label, np.ndarray]]:
    """Each part of a kind with its positions in the body's planar frame at its beginning.

    Those that begin at a walk are apart.
    """
    found: list[tuple[Label, np.ndarray]] = []
    for name, labels in motions.labels.items():
        if (name == "walk_on") != walking:
            continue
        for label in labels:
            if label.kind == kind:
                inside = motions.positions[name][
                    round(label.start_s * RATE) : round(label.end_s * RATE) + 1
                ]
                frame = np.asarray(kinematics.planar_frames(BODY, inside[0]))
                found.append((label, np.asarray(planar.apply(planar.inverse(frame), inside))))
    assert found
    return found


def side(label: Label) -> int:
    return {"left": 1, "right": -1, "": 0}[label.direction]


def angles(at: str, one: str, other: str, positions: np.ndarray) -> np.ndarray:
    """Angle in degrees at a joint between the directions to two others."""
    a, b = (positions[:, BODY.index(n)] - positions[:, BODY.index(at)] for n in (one, other))
    cosine = (a * b).sum(-1) / np.linalg.norm(a, axis=-1) / np.linalg.norm(b, axis=-1)
    return np.degrees(np.arccos(np.clip(cosine, -1, 1)))


def test_skeleton_is_a_symmetric_body_of_known_joints():
    validate_skeleton(BODY)
    assert 1.6 < np.ptp(rest_positions(BODY)[:, 1]) < 1.75
    offsets = np.asarray(BODY.offsets)
    np.testing.assert_array_equal(offsets[list(mirror_joints(BODY))] * [-1, 1, 1], offsets)
    for name in ("lhipjoint", "rhipjoint", "lowerback"):
        np.testing.assert_array_equal(offsets[BODY.index(name)], 0)
    places = ("hip", "knee", "ankle", "toe", "shoulder", "elbow", "wrist", "hand")
    require_roles(BODY, ["root", "spine", "chest", "neck", "head", *(f"left_{p}" for p in places)])
    ends = [name for name in BODY.names if name.endswith("_end")]
    assert [BODY.names[j] for j in BODY.end_joints] == ends
    assert len(ends) == 7


def test_clips_are_valid_unit_and_float32(motions: MadeSet):
    for clip in motions.clips:
        validate_motion(clip.skeleton, clip.motion)
        rotations = np.asarray(clip.motion.local_rotations)
        assert isinstance(clip.motion.local_rotations, np.ndarray)
        assert rotations.dtype == clip.motion.root_translation.dtype == np.float32
        np.testing.assert_allclose(np.linalg.norm(rotations, axis=-1), 1, atol=1e-6)
        assert (rotations[:, list(BODY.end_joints)] == [1, 0, 0, 0]).all()
        # The same rotation keeps its sign, so that components may be interpolated.
        assert (np.sum(rotations[1:] * rotations[:-1], axis=-1) > 0.8).all()


def test_bones_keep_their_lengths(motions: MadeSet):
    lengths = np.linalg.norm(np.asarray(BODY.offsets), axis=-1)[1:]
    for positions in motions.positions.values():
        bones = positions[:, 1:] - positions[:, list(BODY.parents[1:])]
        assert np.abs(np.linalg.norm(bones, axis=-1) - lengths).max() < 1e-5


def test_same_seed_same_motion_other_seed_other_motion():
    again, other = synthetic_clips(seed=0), synthetic_clips(seed=7)
    assert again[1] == made(0).labels
    assert again[1] != other[1]
    for a, b, c in zip(made(0).clips, again[0], other[0], strict=True):
        np.testing.assert_array_equal(a.motion.root_translation, b.motion.root_translation)
        np.testing.assert_array_equal(a.motion.local_rotations, b.motion.local_rotations)
        assert a.name == c.name
        frames = min(a.motion.num_frames, c.motion.num_frames)
        assert not np.allclose(a.motion.local_rotations[:frames], c.motion.local_rotations[:frames])


def test_frame_rate_changes_sampling_only():
    fast, labels = synthetic_clips(seed=0, frame_rate=60.0)
    assert labels == made(0).labels
    for a, b in zip(made(0).clips, fast, strict=True):
        frames = min(a.motion.num_frames, (b.motion.num_frames + 1) // 2)
        apart = a.motion.root_translation[:frames] - b.motion.root_translation[::2][:frames]
        # The last frames differ: the fade to rest ends on the last frame of either rate.
        assert np.abs(apart[:-20]).max() < 2e-4


@pytest.mark.parametrize("rate", [0.0, -30.0, np.nan])
def test_frame_rate_must_be_a_rate(rate: float):
    with pytest.raises(MotionError, match="frame rate"):
        synthetic_clips(frame_rate=rate)


def test_generation_has_no_loop_over_frames():
    with counted() as few:
        synthetic_clips(seed=3, frame_rate=30.0)
    with counted() as many:
        synthetic_clips(seed=3, frame_rate=60.0)
    assert many.lines == pytest.approx(few.lines, rel=0.02)
    assert many.lines < 130_000


def test_length_and_number_of_parts(motions: MadeSet):
    assert 14 <= len(motions.clips) <= 20
    assert 200 <= sum(clip.motion.seconds for clip in motions.clips) <= 210
    labels = [label for of_clip in motions.labels.values() for label in of_clip]
    assert 48 <= len(labels) <= 60
    assert {label.kind for label in labels} == {
        *("duck", "sway", "lean_back", "twist", "sidestep", "jump", "crouch"),
        *("backstep", "dash", "turn"),
    }
    assert all(label.genuine for label in labels)
    for kind in ("sway", "twist", "sidestep", "turn"):
        assert {label.direction for label in labels if label.kind == kind} == {"left", "right"}
    for kind in ("duck", "jump"):
        assert {label.direction for label in labels if label.kind == kind} == {"left", "right", ""}


def test_labels_leave_room_for_a_blend_on_both_sides(motions: MadeSet):
    seconds = {clip.name: clip.motion.seconds for clip in motions.clips}
    for name, labels in motions.labels.items():
        free = [0.0, *(label.end_s for label in labels)]
        starts = [*(label.start_s for label in labels), seconds[name]]
        gaps = np.subtract(starts, free)
        assert gaps.min() >= 0.9, name  # two blends of 1/3 s, one out and one in
        assert all(0.5 <= label.end_s - label.start_s <= 1.4 for label in labels)


def test_planted_feet_do_not_slide(motions: MadeSet):
    for name, positions in motions.positions.items():
        feet = positions[:, list(contacts.foot_joints(BODY))]
        planted = np.asarray(contacts.planted(feet, RATE))
        travel = np.linalg.norm(np.diff(feet[..., [0, 2]], axis=0), axis=-1)
        assert travel[planted[1:] & planted[:-1]].max() < 1e-3, name
        sole = positions[:, joints(*SOLE), 1]
        heights = sole[np.tile(planted, 2)]
        assert heights.min() >= 0, name
        assert heights.max() < 0.045, name
        assert planted.any(axis=0).all(), name


def test_nothing_goes_through_the_floor(motions: MadeSet):
    assert min(p[..., 1].min() for p in motions.positions.values()) > -0.005


def test_motion_is_smooth(motions: MadeSet):
    for name, positions in motions.positions.items():
        velocity = np.diff(positions, axis=0) * RATE
        acceleration = np.diff(velocity, axis=0) * RATE
        assert np.linalg.norm(velocity, axis=-1).max() < 9, name
        # 120 m/s² at 30 Hz is a speed change of 4 m/s from one frame to the next.
        assert np.linalg.norm(acceleration, axis=-1).max() < 120, name
        # The trunk is calmer; a jump's landing is its worst.
        trunk = joints("root", "thorax", "head")
        assert np.linalg.norm(acceleration[:, trunk], axis=-1).max() < 45, name


def test_clips_join_at_rest_in_one_stance(motions: MadeSet):
    inside = max(
        np.linalg.norm(np.diff(p, n=2, axis=0), axis=-1).max() * RATE
        for p in motions.positions.values()
    )
    seams: list[float] = []
    for before in motions.positions.values():
        frame = kinematics.planar_frames(BODY, before[-1])
        for after in motions.positions.values():
            start = planar.inverse(kinematics.planar_frames(BODY, after[0]))
            placed = planar.apply(planar.compose(frame, start), after[:2])
            joined = np.concatenate([before[-2:], np.asarray(placed)])
            seams.append(np.linalg.norm(np.diff(joined, n=2, axis=0), axis=-1).max() * RATE)
    assert max(seams) < 0.05 < inside


def test_knees_bend_forward_within_limits(motions: MadeSet):
    for name, positions in motions.positions.items():
        for s in "lr":
            hip, knee, ankle, toe = (
                positions[:, BODY.index(s + n)] for n in ("femur", "tibia", "foot", "toes")
            )
            forward = (toe - ankle) * [1, 0, 1]
            forward /= np.linalg.norm(forward, axis=-1, keepdims=True)
            along = ankle - hip
            share = ((knee - hip) * along).sum(-1) / (along * along).sum(-1)
            bow = knee - hip - share[:, None] * along
            assert ((bow * forward).sum(-1) > 0.008).all(), name
            assert (angles(f"{s}tibia", f"{s}femur", f"{s}foot", positions) > 38).all(), name
            assert (angles(f"{s}radius", f"{s}humerus", f"{s}wrist", positions) > 55).all(), name


def test_head_looks_ahead(motions: MadeSet):
    """The face turns less than the shoulders do and stays within 45° of the body's heading."""
    for clip in motions.clips:
        rotations = kinematics.forward(
            BODY, clip.motion.root_translation, clip.motion.local_rotations
        )[1]
        heading = kinematics.planar_frames(BODY, motions.positions[clip.name])[:, 0]
        w, x, y, z = np.moveaxis(np.asarray(rotations)[:, BODY.index("head")], -1, 0)
        face = np.stack([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)], -1)
        ahead = face[:, 0] * np.sin(heading) + face[:, 2] * np.cos(heading)
        assert np.degrees(np.arccos(np.clip(ahead, -1, 1))).max() < 50, clip.name


def test_standing_body_is_balanced(motions: MadeSet):
    """While an avoidance in place lasts, the centre of mass stays over the feet."""
    for kind in ("duck", "sway", "lean_back", "twist", "crouch"):
        for label, p in parts(motions, kind):
            centre = centre_of_mass(p)
            feet = p[:, joints("lfoot", "rfoot", *SOLE)]
            assert (np.abs(centre[:, 0]) < np.abs(feet[..., 0]).max() + 0.03).all(), label
            heel = feet[..., 2].min(axis=1) - 0.05
            assert (centre[:, 2] > heel).all(), label
            assert (centre[:, 2] < feet[..., 2].max(axis=1)).all(), label


def centre_of_mass(p: np.ndarray) -> np.ndarray:
    """From rounded shares of the segments' weights, their middles taken as their centres."""
    shares = {("head", "head_end"): 0.08, ("root", "upperback"): 0.2, ("thorax", "lowerneck"): 0.3}
    for s in "lr":
        shares |= {(f"{s}femur", f"{s}tibia"): 0.1, (f"{s}tibia", f"{s}foot"): 0.047}
        shares |= {(f"{s}foot", f"{s}toes"): 0.014, (f"{s}humerus", f"{s}radius"): 0.028}
        shares |= {(f"{s}radius", f"{s}hand"): 0.022}
    middles = [share * p[:, joints(*ends)].mean(axis=1) for ends, share in shares.items()]
    return np.sum(middles, axis=0) / sum(shares.values())


def test_ducks_and_crouches_lower_the_head(motions: MadeSet):
    for label, p in parts(motions, "duck"):
        head = p[:, BODY.index("head")]
        lowered, aside = head[0, 1] - head[:, 1].min(), (head[:, 0] - head[0, 0]) * side(label)
        assert (0.23 if label.direction else 0.3) <= lowered <= 0.62, label
        assert not label.direction or aside.max() >= 0.15, label
    for label, p in parts(motions, "crouch"):
        assert p[:, BODY.index("head_end"), 1].min() < 0.92, label
        assert p[:, BODY.index("head"), 1].min() < 0.85, label


def test_sways_and_leans_take_the_head_away(motions: MadeSet):
    for label, p in parts(motions, "sway"):
        head = p[:, BODY.index("head"), 0] * side(label)
        assert 0.27 <= (head - head[0]).max() <= 0.5, label
    for label, p in parts(motions, "lean_back"):
        head = p[:, BODY.index("head"), 2]
        assert (head - head[0]).min() <= -0.3, label


def test_twists_pull_one_shoulder_back(motions: MadeSet):
    for label, p in parts(motions, "twist"):
        across = {
            n: p[:, BODY.index(f"l{n}")] - p[:, BODY.index(f"r{n}")] for n in ("humerus", "femur")
        }
        yaw = {n: np.degrees(np.arctan2(-v[:, 2], v[:, 0])) for n, v in across.items()}
        assert ((yaw["humerus"] - yaw["femur"]) * side(label)).max() >= 45, label
        near = "lhumerus" if label.direction == "left" else "rhumerus"
        assert p[0, BODY.index(near), 2] - p[:, BODY.index(near), 2].min() >= 0.1, label


def test_sidesteps_are_quick_and_wide(motions: MadeSet):
    for label, p in parts(motions, "sidestep"):
        moved = (p[:, 0, 0] - p[0, 0, 0]) * side(label)
        assert moved[-1] >= 0.5, label
        most = (moved > 0.1 * moved[-1]) & (moved < 0.9 * moved[-1])
        assert most.sum() / RATE <= 0.7, label


def test_steps_back_and_ahead_are_long(motions: MadeSet):
    for kind, sign, least in (("backstep", -1, 0.45), ("dash", 1, 0.75)):
        for label, p in parts(motions, kind):
            assert sign * (p[-1, 0, 2] - p[0, 0, 2]) >= least, label
            assert abs(p[-1, 0, 0] - p[0, 0, 0]) <= 0.12, label


def test_turns_step_aside_and_show_the_narrow_side(motions: MadeSet):
    for label, p in parts(motions, "turn"):
        moved, facing = p[-1, 0] - p[0, 0], np.asarray(kinematics.planar_frames(BODY, p[-1]))[0]
        assert moved[0] * side(label) >= 0.3, label
        assert np.degrees(-facing * side(label)) >= 45, label


def test_jumps_with_a_direction_go_there(motions: MadeSet):
    gone = [p[-1, 0] - p[0, 0] for label, p in parts(motions, "jump") if not label.direction]
    assert min(np.hypot(x, z) for x, _, z in gone) < 0.03  # on the spot
    assert max(z for _, _, z in gone) > 0.4
    assert min(z for _, _, z in gone) < -0.4
    for label, p in parts(motions, "jump"):
        if label.direction:
            assert (p[-1, 0, 0] - p[0, 0, 0]) * side(label) >= 0.4, label


def test_who_walks_avoids_without_standing_still(motions: MadeSet):
    found = {}
    for kind in ("duck", "sway"):
        for label, p in parts(motions, kind, walking=True):
            found[kind, label.direction] = p
            speed = np.linalg.norm(np.diff(p[:, 0, [0, 2]], axis=0), axis=-1) * RATE
            assert speed.min() > 0.6, label
            head = p[:, BODY.index("head")] - p[:, 0]
            aside = (head[:, 0] - head[0, 0]) * side(label)
            assert aside.max() >= (0.1 if label.direction else 0.0), label
            head = p[:, BODY.index("head"), 1]
            assert kind != "duck" or head[0] - head.min() >= 0.2, label
    assert len(found) == 3


def test_hips_lead(motions: MadeSet):
    """In a twist the pelvis is half way before the shoulders are, in a duck before the head is."""
    for label, p in parts(motions, "twist"):
        turned = [
            np.arctan2(-v[:, 2], v[:, 0])
            for v in (p[:, BODY.index(f"l{n}")] - p[:, BODY.index(f"r{n}")] for n in TURNING)
        ]
        assert half_way(turned[0]) < half_way(turned[1] - turned[0]), label
    for label, p in parts(motions, "duck"):
        bent = p[:, BODY.index("head"), 1] - p[:, 0, 1]
        assert half_way(p[:, 0, 1]) < half_way(bent), label


def half_way(values: np.ndarray) -> float:
    """When values are first half way to their largest deviation, frames."""
    gone = np.abs(values - values[0])
    after = int(np.argmax(gone >= 0.5 * gone.max()))
    return after - (gone[after] - 0.5 * gone.max()) / (gone[after] - gone[after - 1])


def test_weight_goes_over_before_a_foot_leaves(motions: MadeSet):
    """Of steps from standing, the pelvis is on its way to the standing foot as the other lifts."""
    p = motions.positions["steps"]
    toes = p[:, joints("ltoes", "rtoes")]
    lifted = toes[..., 1] > body_rest_height(toes) + 0.015
    begun = 0
    for foot in (0, 1):
        for frame in np.flatnonzero(lifted[1:, foot] & ~lifted[:-1, foot]) + 1:
            calm = max(frame - 15, 0)
            if lifted[calm : frame - 1].any():
                continue  # the second step of two
            towards = toes[frame, 1 - foot] - toes[frame, foot]
            towards[1] = 0
            gone = (p[calm : frame + 1, 0] - p[calm, 0]) @ towards / np.linalg.norm(towards)
            assert gone.max() >= 0.02, frame
            begun += 1
    assert begun == 4


def body_rest_height(toes: np.ndarray) -> np.ndarray:
    """The height of each toe joint while it stands, m."""
    return toes[..., 1].min(axis=0)


def test_nobody_stands_like_a_statue(motions: MadeSet):
    """Head, chest and hands never rest for a second, and no one's arms do quite the same."""
    for name, p in motions.positions.items():
        inner = p[
            round(0.7 * RATE) : -round(0.7 * RATE), joints("head", "thorax", "lhand", "rhand")
        ]
        for begin in range(0, len(inner) - 30, 10):
            moved = np.ptp(inner[begin : begin + 30], axis=0).max(axis=-1)
            assert moved.min() > 1e-3, (name, begin)
    for label, p in parts(motions, "crouch"):
        bent = [angles(f"{s}radius", f"{s}humerus", f"{s}wrist", p).min() for s in "lr"]
        assert 0.3 < abs(bent[0] - bent[1]) < 45, label


def test_jumps_leave_the_floor_with_knees_tucked(motions: MadeSet):
    for label, p in parts(motions, "jump"):
        lowest = p[:, joints("lfoot", "rfoot", *SOLE), 1].min(axis=1)
        top = int(lowest.argmax())
        assert lowest[top] - lowest[0] >= 0.3, label
        assert angles("ltibia", "lfemur", "lfoot", p)[top] < 110, label
        # In flight the root falls freely; the highest frame and its neighbours are within it.
        fall = np.diff(p[top - 3 : top + 4, 0, 1], n=2) * RATE**2
        np.testing.assert_allclose(fall, -9.81, atol=0.6)


def test_walks_are_at_walking_speed(motions: MadeSet):
    for name in ("walk", "walk_curve"):
        root = motions.positions[name][:, 0]
        speed = np.linalg.norm(np.diff(root[:, [0, 2]], axis=0), axis=-1) * RATE
        steady = speed[speed > 0.9]
        assert 1.0 <= np.median(steady) <= 1.4, name
        assert len(steady) > 2.5 * RATE, name
        fast = np.flatnonzero(speed > 1.1)
        assert 0.02 < np.ptp(root[fast, 1]) < 0.08, name
