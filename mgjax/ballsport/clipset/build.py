"""The clip set: every hit and every link motion of all clips, on one axis of frames."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float, Int

from mgjax.ballsport.config import KINDS, ClipSetConfig, KindConfig, validate_clip_set
from mgjax.ballsport.hits.bones import BoneHit, analyse
from mgjax.ballsport.hits.detect import hit_joint, links
from mgjax.ballsport.hits.motion_vectors import MotionVectors, leg_length, stack
from mgjax.clips.oddities import first_clean_frame
from mgjax.clips.retarget.clip import retarget
from mgjax.clips.synthetic_kicks import synthetic_kicks
from mgjax.clips.types import Clip, Labels
from mgjax.core.errors import MotionError
from mgjax.core.kinematics import global_positions, joint_velocities, planar_frames
from mgjax.core.motion import Motion, cut, mirror, resample
from mgjax.core.skeleton import Skeleton

NO_LINK = -1


@dataclass(frozen=True, kw_only=True, eq=False)
class ClipSet:
    """All motion of the players; frames and ranges on one axis, stops exclusive.

    A clip is a run of frames; hit h plays ``hit_starts[h] … hit_stops[h] − 1``, link l plays
    ``link_starts[l] … link_stops[l] − 1``. Links and hits of a clip fill it without gaps.

    Attributes:
        skeleton: of all motion.
        motion: all frames.
        positions: of all joints in world coordinates of their clips, m.
        planes: planar frame (θ, x, z) of the body in each frame.
        clip_names, clip_starts, clip_stops: the clips. [K]
        hit_clip: clip of each hit. [H]
        hit_bone: what hits, such as ``"left_foot"``.
        hit_joint: its joint. [H]
        hit_kind: toss, pass or attack.
        labelled: whether the kind was given, and not decided by speed. [H]
        highest, fastest: the main F_H and F_S. [H]
        ball_starts, ball_stops: S_B, in which the ball can be hit. [H]
        hit_starts, hit_stops: S_H. [H]
        hit_keys: the five key poses. [H, 5]
        vectors: motion vectors. [H]
        link_before, link_after: the links around each hit, or ``NO_LINK``. [H]
        link_clip, link_starts, link_stops: the link motions S_L. [N]
        notes: what was done to the clips, for people.
    """

    skeleton: Skeleton
    motion: Motion
    positions: Float[np.ndarray, "F J 3"]
    planes: Float[np.ndarray, "F 3"]
    clip_names: tuple[str, ...]
    clip_starts: Int[np.ndarray, " K"]
    clip_stops: Int[np.ndarray, " K"]
    hit_clip: Int[np.ndarray, " H"]
    hit_bone: tuple[str, ...]
    hit_joint: Int[np.ndarray, " H"]
    hit_kind: tuple[str, ...]
    labelled: np.ndarray
    highest: Int[np.ndarray, " H"]
    fastest: Int[np.ndarray, " H"]
    ball_starts: Int[np.ndarray, " H"]
    ball_stops: Int[np.ndarray, " H"]
    hit_starts: Int[np.ndarray, " H"]
    hit_stops: Int[np.ndarray, " H"]
    hit_keys: Int[np.ndarray, "H 5"]
    vectors: MotionVectors
    link_before: Int[np.ndarray, " H"]
    link_after: Int[np.ndarray, " H"]
    link_clip: Int[np.ndarray, " N"]
    link_starts: Int[np.ndarray, " N"]
    link_stops: Int[np.ndarray, " N"]
    notes: tuple[str, ...]

    @property
    def num_hits(self) -> int:
        return len(self.hit_clip)

    @property
    def num_links(self) -> int:
        return len(self.link_clip)

    @property
    def leg_length(self) -> float:
        """Length of the skeleton's legs, to which a live motion is scaled, m."""
        return leg_length(self.skeleton)

    def bone_path(self, hit: int) -> tuple[np.ndarray, np.ndarray]:
        """Place (m) and velocity (m/s) of the hit bone in the frames of S_B, clip coordinates."""
        clip = int(self.hit_clip[hit])
        first, last = int(self.clip_starts[clip]), int(self.clip_stops[clip])
        path = self.positions[first:last, self.hit_joint[hit]]
        velocity = joint_velocities(path[:, None], self.motion.frame_rate)[:, 0]
        part = slice(int(self.ball_starts[hit]) - first, int(self.ball_stops[hit]) - first)
        return path[part], np.asarray(velocity)[part]


def build_clip_set(
    clips: Sequence[Clip] = (),
    *,
    labels: Labels | None = None,
    config: ClipSetConfig | None = None,
    seed: int = 0,
    takes: int = 2,
) -> ClipSet:
    """The embedded kicks, idle and link motions, with captured clips and their mirror images.

    All motion is put on the embedded skeleton. A captured hit has the kind of the label that holds
    its F_S, if that is one of toss, pass and attack; any other is judged by the largest speed of
    its bone (:class:`KindConfig`), since capture of kicks without a ball does not say what for.

    Args:
        clips: captured clips, each in a world with the floor at y = 0.
        labels: kinds of hits by clip name; the embedded clips bring their own.
        config: frame rate, hit bones, thresholds.
        seed: of the embedded clips.
        takes: kicks in each embedded clip.

    Raises:
        MotionError: no hit is found in the embedded clips, or in any of the captured ones.
        ConfigError: a threshold that cannot be.
    """
    config = config or ClipSetConfig()
    validate_clip_set(config)
    made, known = synthetic_kicks(seed=seed, frame_rate=config.frame_rate, takes=takes)
    skeleton = made[0].skeleton
    known = {**known, **(labels or {})}
    notes: list[str] = []
    parts = [(clip.name, clip.motion, clip.name, False) for clip in made]
    for clip in clips:
        motion = _prepared(clip, skeleton, config.frame_rate, notes)
        parts.append((clip.name, motion, clip.name, True))
        flipped = mirror(skeleton, motion)
        parts.append((f"{clip.name}~mirrored", flipped, clip.name, True))
    rows: list[_Row] = []
    spans: list[list[tuple[int, int]]] = []
    for number, (name, motion, label_name, captured) in enumerate(parts):
        hits = _hits_of(skeleton, motion, number, known.get(label_name, ()), config)
        if captured and not hits:
            notes.append(f"{name}: no hit in it, all of it is link motion")
        rows += hits
        spans.append(links([row.bone_hit.hit for row in hits], motion.num_frames))
    made_rows = sum(row.clip < len(made) for row in rows)
    if made_rows == 0 or (clips and made_rows == len(rows)):
        where = "captured" if made_rows else "embedded"
        raise MotionError(
            f"no hit found in the {where} clips: got a threshold height of"
            f" {config.analysis.height_m:g} m, expected one that a hit bone"
            f" ({', '.join(config.bones)}) rises above"
        )
    return _assemble(skeleton, parts, rows, spans, notes)


def kind_of(v_max: float, config: KindConfig) -> str:
    """Toss, pass or attack by the largest speed of the hit bone, m/s."""
    return KINDS[int(v_max >= config.pass_m_s) + int(v_max >= config.attack_m_s)]


@dataclass(frozen=True, kw_only=True)
class _Row:
    clip: int
    bone_hit: BoneHit
    kind: str
    labelled: bool


def _prepared(clip: Clip, skeleton: Skeleton, frame_rate: float, notes: list[str]) -> Motion:
    """A captured clip without a T-pose, on the skeleton and at the rate of the set."""
    motion, first = clip.motion, first_clean_frame(clip.skeleton, clip.motion)
    if first:
        notes.append(f"{clip.name}: T-pose in the first frame cut off")
        motion = cut(motion, first, motion.num_frames)
    return resample(retarget(clip.skeleton, motion, skeleton), frame_rate)


def _hits_of(
    skeleton: Skeleton, motion: Motion, clip: int, labels: tuple, config: ClipSetConfig
) -> list[_Row]:
    """All hits of one clip, in order of time."""
    positions = np.asarray(global_positions(skeleton, motion))
    hits = analyse(
        skeleton, positions, motion.frame_rate, bones=config.bones, config=config.analysis
    )
    rows: list[_Row] = []
    for item in hits:
        at = item.hit.fastest / motion.frame_rate
        kinds = [x.kind for x in labels if x.start_s <= at < x.end_s and x.kind in KINDS]
        kind = kinds[0] if kinds else kind_of(float(item.vector.v_max), config.kinds)
        rows.append(_Row(clip=clip, bone_hit=item, kind=kind, labelled=bool(kinds)))
    return rows


def _assemble(
    skeleton: Skeleton,
    parts: list[tuple[str, Motion, str, bool]],
    rows: list[_Row],
    spans: list[list[tuple[int, int]]],
    notes: list[str],
) -> ClipSet:
    """Everything on one axis of frames."""
    stops = np.cumsum([motion.num_frames for _, motion, _, _ in parts])
    starts = stops - [motion.num_frames for _, motion, _, _ in parts]
    motion = replace(
        parts[0][1],
        root_translation=np.concatenate([np.asarray(m.root_translation) for _, m, _, _ in parts]),
        local_rotations=np.concatenate([np.asarray(m.local_rotations) for _, m, _, _ in parts]),
    )
    positions = np.asarray(global_positions(skeleton, motion))
    first = starts[[row.clip for row in rows]] if rows else np.zeros(0, np.int64)
    link_clip = np.array([k for k, s in enumerate(spans) for _ in s], np.int64)
    link_ranges = np.array([s for part in spans for s in part], np.int64).reshape(-1, 2)
    link_ranges += starts[link_clip][:, None]

    def frames(name: str) -> np.ndarray:
        return first + np.array([getattr(row.bone_hit.hit, name) for row in rows], np.int64)

    hit_starts, hit_stops = frames("start"), frames("stop")
    before = [_place(link_ranges[:, 1] == f) for f in hit_starts]
    after = [_place(link_ranges[:, 0] == f) for f in hit_stops]
    return ClipSet(
        skeleton=skeleton,
        motion=motion,
        positions=positions,
        planes=np.asarray(planar_frames(skeleton, positions)),
        clip_names=tuple(name for name, _, _, _ in parts),
        clip_starts=starts,
        clip_stops=stops,
        hit_clip=np.array([row.clip for row in rows], np.int64),
        hit_bone=tuple(row.bone_hit.bone for row in rows),
        hit_joint=np.array([hit_joint(skeleton, row.bone_hit.bone) for row in rows], np.int64),
        hit_kind=tuple(row.kind for row in rows),
        labelled=np.array([row.labelled for row in rows], bool),
        highest=frames("top"),
        fastest=frames("fastest"),
        ball_starts=frames("hit_start"),
        ball_stops=frames("hit_stop"),
        hit_starts=hit_starts,
        hit_stops=hit_stops,
        hit_keys=first[:, None]
        + np.array([row.bone_hit.hit.key_frames for row in rows], np.int64).reshape(-1, 5),
        vectors=stack([row.bone_hit.vector for row in rows]),
        link_before=np.array(before, np.int64),
        link_after=np.array(after, np.int64),
        link_clip=link_clip,
        link_starts=link_ranges[:, 0],
        link_stops=link_ranges[:, 1],
        notes=tuple(notes),
    )


def _place(mask: np.ndarray) -> int:
    """Where the one true entry is, or ``NO_LINK``."""
    return int(np.argmax(mask)) if mask.any() else NO_LINK
