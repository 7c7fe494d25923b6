"""Clips made ready for one graph: one skeleton, one rate, no T-pose, no jumps, mirrored copies."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from mgjax.clips.oddities import first_clean_frame, jump_frames
from mgjax.clips.retarget.clip import Retargeted
from mgjax.clips.retarget.many import Retargeter, notes_on
from mgjax.clips.retarget.same import difference
from mgjax.clips.rigid import standing_clip
from mgjax.clips.types import Clip, Label, Labels, mirrored_direction
from mgjax.core.body.rest import standing_rest
from mgjax.core.body.roles import find_role
from mgjax.core.contacts import foot_joints
from mgjax.core.errors import SkeletonError
from mgjax.core.motion import Motion, cut, mirror, resample
from mgjax.core.skeleton import Skeleton, rest_positions

Put = Callable[[Clip, Motion, str], tuple[Motion, Retargeted | None]]
"""Puts a motion of a clip, under a name, on the graph's skeleton; says how if it was retargeted."""


@dataclass(frozen=True, kw_only=True)
class PreparedClip:
    """A clip on the graph's skeleton and rate, its labels in frames of that rate.

    Attributes:
        name: as given; pieces of a split clip and mirrored copies have a suffix.
        motion: at the graph's rate.
        label_frames: [P,2] start and stop of each label, in frames.
        labels: what they are.
        retargeted: how the motion was put on the skeleton, if it was another one's.
    """

    name: str
    motion: Motion
    label_frames: np.ndarray
    labels: tuple[Label, ...]
    retargeted: Retargeted | None = None


def prepare_clips(
    clips: list[Clip],
    labels: Labels,
    *,
    skeleton: Skeleton,
    frame_rate: float,
    mirrored: bool,
    retarget: bool = False,
    example: Motion | None = None,
) -> tuple[list[PreparedClip], list[str]]:
    """Puts clips on one skeleton and rate; returns them with notes on every change made.

    A rest pose that does not stand is replaced by a T-pose, with the same joint places. Local
    rotations are copied; the root's place is scaled by the ratio of the heights at which
    it stands, so that feet stay on the floor. A T-pose in the first frame is cut off, with the
    frames that a converter blended it into; a clip is split where it jumps, and loses a label that
    holds the jump. With ``retarget``, clips of another skeleton (names, proportions, rest pose,
    bone axes) are put on this one (:func:`mgjax.clips.retarget.clip.carry`); ``example`` is a
    motion of the skeleton that shows how its joints turn, beside the clips that have it.

    Raises:
        SkeletonError: a clip has another hierarchy or rest pose; the first difference is named.
            With ``retarget``: one that has no legs.
        MotionError: a clip has bones that are not rigid.
    """
    skeleton = graph_skeleton(skeleton)
    prepared: list[PreparedClip] = []
    notes: list[str] = []
    standing = [standing_clip(clip, notes) for clip in clips]
    put: Put = (
        Retargeter(skeleton, standing, frame_rate, example=example)
        if retarget
        else _copier(skeleton, standing)
    )
    for clip in standing:
        lost = set(labels.get(clip.name, ()))
        for name, start, stop in _pieces(clip, notes):
            motion = resample(cut(clip.motion, start, stop), frame_rate)
            motion, how = put(clip, motion, name)
            kept, frames = _labels_of_piece(clip, labels, start, stop, motion)
            lost -= set(kept)
            prepared.append(
                PreparedClip(
                    name=name, motion=motion, label_frames=frames, labels=kept, retargeted=how
                )
            )
        for label in sorted(lost, key=lambda x: x.start_s):
            notes.append(
                f"{clip.name}: label {label.start_s:g} … {label.end_s:g} s left out,"
                f" there is a jump in it or no frame at {frame_rate:g} Hz"
            )
    notes += notes_on([clip.retargeted for clip in prepared if clip.retargeted])
    if mirrored:
        prepared += [_mirror(skeleton, clip) for clip in prepared]
        notes.append(f"{len(clips)} clips mirrored left-right")
    return prepared, notes


def _copier(skeleton: Skeleton, clips: list[Clip]) -> Put:
    """Copies rotations of clips that have the skeleton's hierarchy and rest pose, or refuses."""
    for clip in clips:
        found = difference(skeleton, clip.skeleton)
        if found is not None:
            raise SkeletonError(
                f"{clip.name}: got {found}, expected one hierarchy and rest pose in all clips;"
                " --retarget puts clips of another skeleton on this one"
            )

    def put(clip: Clip, motion: Motion, name: str) -> tuple[Motion, None]:
        scale = standing_height(skeleton) / standing_height(clip.skeleton)
        root = motion.root_translation * np.float32(scale)
        return replace(motion, root_translation=root), None

    return put


def graph_skeleton(skeleton: Skeleton) -> Skeleton:
    """The skeleton with a rest pose that stands."""
    rest = standing_rest(skeleton)
    return skeleton if rest is None else rest.skeleton


def _labels_of_piece(
    clip: Clip, labels: Labels, start: int, stop: int, motion: Motion
) -> tuple[tuple[Label, ...], np.ndarray]:
    """Labels that lie in captured frames ``start … stop − 1``, with their frames in ``motion``.

    A label that begins in what was cut off at the beginning of the clip begins with the rest of it.
    """
    rate, offset = clip.motion.frame_rate, start / clip.motion.frame_rate
    beginning = start <= first_clean_frame(clip.skeleton, clip.motion)
    kept: list[Label] = []
    frames: list[tuple[int, int]] = []
    for label in sorted(labels.get(clip.name, ()), key=lambda x: x.start_s):
        a, b = round(label.start_s * rate), round(label.end_s * rate)
        if b > stop or (a < start and not beginning):
            continue
        first = max(round((label.start_s - offset) * motion.frame_rate), 0)
        # Rounded up, a label that ends with the clip may end after the last frame.
        last = min(round((label.end_s - offset) * motion.frame_rate), motion.num_frames)
        if last > first:
            kept.append(label)
            frames.append((first, last))
    return tuple(kept), np.array(frames, dtype=np.int64).reshape(-1, 2)


def _pieces(clip: Clip, notes: list[str]) -> list[tuple[str, int, int]]:
    """Name, start and stop of the pieces between the jumps of a clip."""
    first = first_clean_frame(clip.skeleton, clip.motion)
    if first:
        trace = f", with {first - 1} frames that have a trace of it" if first > 1 else ""
        notes.append(f"{clip.name}: T-pose in the first frame cut off{trace}")
    jumps = [int(f) for f in jump_frames(clip.skeleton, clip.motion) if f > first]
    if not jumps:
        return [(clip.name, first, clip.motion.num_frames)]
    seconds = ", ".join(f"{f / clip.motion.frame_rate:.2f}" for f in jumps)
    notes.append(f"{clip.name}: split where it jumps, at {seconds} s")
    bounds = [first, *jumps, clip.motion.num_frames]
    return [
        (f"{clip.name}#{i}", a, b) for i, (a, b) in enumerate(zip(bounds, bounds[1:], strict=False))
    ]


def standing_height(skeleton: Skeleton) -> float:
    """Height of the root over the left ball of the foot with straight legs, m; 1 without legs.

    Between CMU's subjects this keeps planted feet within 1 cm of the floor on the average of a
    clip, where the length of the legs alone leaves up to 2.3 cm.
    """
    skeleton = graph_skeleton(skeleton)
    hip, ankle = find_role(skeleton, "left_hip"), find_role(skeleton, "left_ankle")
    if hip is None or ankle is None:
        return 1.0
    places = rest_positions(skeleton)
    ball, _ = foot_joints(skeleton)
    height, joint = float(places[ankle, 1] - places[ball, 1] - places[hip, 1]), ankle
    while joint != hip and joint > 0:
        parent = skeleton.parents[joint]
        height += float(np.linalg.norm(places[joint] - places[parent]))
        joint = parent
    return height if height > 1e-3 else 1.0


def _mirror(skeleton: Skeleton, clip: PreparedClip) -> PreparedClip:
    flipped = tuple(replace(x, direction=mirrored_direction(x.direction)) for x in clip.labels)
    return replace(
        clip,
        name=f"{clip.name}~mirrored",
        motion=mirror(skeleton, clip.motion),
        labels=flipped,
        retargeted=None,
    )
