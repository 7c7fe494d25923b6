"""The page poses bodies as :func:`mgjax.global_positions` does."""

import numpy as np
import pytest

from mgjax import global_positions
from mgjax.core import quaternion
from mgjax.core.motion import Motion
from mgjax.stage.show.frames import frames_of
from mgjax.stage.show.types import Actor, show_value

from .shows import actor, clips, show_of

PLACES = """([id, time]) => {
  mgjax.stage.scene.poseAt(time);
  return Array.from(mgjax.stage.scene.actors.get(id).pose.places);
}"""


def places(page, time, id="a"):
    return np.array(page.evaluate(PLACES, [id, time])).reshape(-1, 3)


def as_sent(motion: Motion, frames) -> Motion:
    """The motion with the rounding of what is sent."""
    turns = np.asarray(frames.rotations, np.int16)
    if frames.delta:
        turns = np.cumsum(turns.astype(np.int64), axis=0).astype(np.int16)
    turns = turns.astype(np.float64)
    turns /= np.linalg.norm(turns, axis=-1, keepdims=True)
    return Motion(
        root_translation=np.asarray(frames.root, np.float64),
        local_rotations=turns,
        frame_rate=frames.rate,
    )


@pytest.mark.parametrize("delta", [False, True])
def test_joints_stand_where_python_has_them(bench, delta):
    clip = clips()["mixed1"]
    frames = frames_of(clip.motion, start=0.5, delta=delta)
    page = bench(show_of(Actor(id="a", body=0, frames=frames)))
    expected = global_positions(clip.skeleton, as_sent(clip.motion, frames))
    for frame in (0, 1, 57, len(expected) - 1):
        got = places(page, 0.5 + frame / frames.rate)
        np.testing.assert_allclose(got, expected[frame], atol=2e-5)
    exact = global_positions(clip.skeleton, clip.motion)
    np.testing.assert_allclose(places(page, 0.5 + 57 / frames.rate), exact[57], atol=1e-3)


def test_between_frames_it_is_halfway(bench):
    clip = clips()["duck"]
    frames = frames_of(clip.motion, delta=False)
    page = bench(show_of(Actor(id="a", body=0, frames=frames)))
    sent = as_sent(clip.motion, frames)
    turns = np.asarray(sent.local_rotations)
    middle = quaternion.slerp(turns[40], turns[41], np.full(turns.shape[1], 0.5))
    motion = Motion(
        root_translation=np.asarray(sent.root_translation)[40:42].mean(axis=0, keepdims=True),
        local_rotations=middle[None],
        frame_rate=frames.rate,
    )
    expected = global_positions(clip.skeleton, motion)[0]
    np.testing.assert_allclose(places(page, 40.5 / frames.rate), expected, atol=2e-5)


def test_poses_are_held_at_both_ends(bench):
    clip = clips()["duck"]
    frames = frames_of(clip.motion, start=1.0)
    page = bench(show_of(Actor(id="a", body=0, frames=frames)))
    last = 1.0 + (len(frames.root) - 1) / frames.rate
    np.testing.assert_array_equal(places(page, 0.0), places(page, 1.0))
    np.testing.assert_array_equal(places(page, last + 9), places(page, last))


def test_the_surface_moves_with_the_joints(bench):
    show = show_of(actor("duck"))
    page = bench(show)
    got = page.evaluate(
        """() => {
          const { scene } = mgjax.stage;
          scene.poseAt(1.3);
          const actor = scene.actors.get('a');
          return {
            surface: Array.from(bench.body.surfacePlaces(actor.body, actor.pose)),
            turns: Array.from(actor.pose.turns), places: Array.from(actor.pose.places),
          };
        }"""
    )
    turns, places_ = np.array(got["turns"]).reshape(-1, 4), np.array(got["places"]).reshape(-1, 3)
    body = show.bodies[0]
    rest = np.zeros((len(body.parents), 3))
    for joint, parent in enumerate(body.parents[1:], start=1):
        rest[joint] = rest[parent] + body.offsets[joint]
    vertices = np.asarray(body.mesh.places, np.float64) * body.mesh.unit
    expected = np.zeros_like(vertices)
    for k in range(4):
        joint = np.asarray(body.mesh.joints)[:, k]
        moved = places_[joint] + quaternion.rotate(turns[joint], vertices - rest[joint])
        expected += np.asarray(body.mesh.weights)[:, k, None] / 255 * moved
    np.testing.assert_allclose(np.array(got["surface"]).reshape(-1, 3), expected, atol=1e-4)


def test_live_frames_replace_what_follows_and_a_minute_is_kept(bench):
    page = bench(show_of(actor("stance")))
    page.evaluate(
        """async () => {
          window.push = (start, x, count) => {
            const joints = mgjax.stage.scene.actors.get('a').body.count;
            const rotations = new Int16Array(count * joints * 4);
            for (let i = 0; i < rotations.length; i += 4) rotations[i] = 32767;
            rotations.shape = [count, joints, 4];
            const root = new Float32Array(3 * count).fill(0);
            for (let i = 0; i < count; i += 1) root[3 * i] = x;
            mgjax.stage.pushFrames('a', { rate: 10, start, rotations, root, delta: false });
          };
        }"""
    )

    def x(time):
        return places(page, time)[0, 0]

    page.evaluate("push(0, 1, 30); push(2, 2, 30)")
    assert x(1.85) == pytest.approx(1)
    assert x(2.05) == pytest.approx(2)
    assert x(1.95) == pytest.approx(1.5)
    page.evaluate("push(80, 3, 10)")
    assert page.evaluate("mgjax.stage.scene.actors.get('a').track.start") >= 2
    assert x(90) == pytest.approx(3)


def test_a_body_of_three_hundred_joints_is_drawn(bench):
    show = show_value(show_of(actor("stance")))
    body = show["bodies"][0]
    more = 300 - len(body["parents"])
    chain = np.arange(len(body["parents"]) - 1, 299, dtype=np.int16)
    body["parents"] = np.concatenate([body["parents"], chain])
    body["offsets"] = np.concatenate([body["offsets"], np.zeros((more, 3), np.float32)])
    body["names"] = [*body["names"], *(f"extra{i}" for i in range(more))]
    joints = body["mesh"]["joints"].astype(np.uint16)
    body["mesh"]["joints"] = np.where(joints == 3, 299, joints).astype(np.uint16)
    rotations = show["actors"][0]["frames"]["rotations"]
    still = np.zeros((len(rotations), more, 4), np.int16)
    still[0, :, 0] = 32767
    if not show["actors"][0]["frames"]["delta"]:
        still[:, :, 0] = 32767
    show["actors"][0]["frames"]["rotations"] = np.concatenate([rotations, still], axis=1)
    page = bench(show)
    assert page.evaluate("mgjax.stage.scene.actors.get('a').pose.places.length") == 900
    assert page.evaluate("mgjax.stage.snapshot().length") > 1000
