import numpy as np
import pytest

from mgjax.clips.synthetic import synthetic_clips
from mgjax.core.body.roles import find_role
from mgjax.core.skeleton import Skeleton, rest_positions
from mgjax.io.skin.bones import Capsule
from mgjax.io.skin.field import Shape, body_distance, capsule_distance
from mgjax.io.skin.shapes import body_shapes
from mgjax.io.skin.spread import spread_pose
from mgjax.io.skin.surface_nets import surface_nets
from mgjax.io.skin.welded import MOST_VERTICES, WeldedMesh, welded_mesh
from tests.io.skeletons import CASES


def edges(triangles: np.ndarray) -> np.ndarray:
    """Both ends of every side of every triangle, in its direction."""
    return np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])


def assert_closed(triangles: np.ndarray) -> None:
    """Each side of a triangle is the side of exactly one other one, in the other direction."""
    sides = edges(triangles)
    there = np.unique(sides, axis=0)
    assert len(there) == len(sides)
    np.testing.assert_array_equal(there, np.unique(sides[:, ::-1], axis=0))


def volume(vertices: np.ndarray, triangles: np.ndarray) -> float:
    a, b, c = (vertices[triangles[:, i]].astype(np.float64) for i in range(3))
    return float(np.einsum("tx,tx->", a, np.cross(b, c)) / 6)


def person() -> Skeleton:
    return synthetic_clips()[0][0].skeleton


@pytest.fixture(scope="module")
def skin() -> WeldedMesh:
    return welded_mesh(person())


def quadruped() -> Skeleton:
    names, parents, offsets = ["root"], [-1], [(0.0, 0.0, 0.0)]

    def bone(name: str, parent: str, x: float, y: float, z: float) -> None:
        names.append(name)
        parents.append(names.index(parent))
        offsets.append((x, y, z))

    bone("back", "root", 0, 0.05, 0.5)
    bone("neck", "back", 0, 0.3, 0.2)
    bone("head", "neck", 0, 0.0, 0.25)
    bone("tail", "root", 0, -0.1, -0.4)
    for end, top in (("hind", "root"), ("fore", "back")):
        for side, x in (("left", 0.12), ("right", -0.12)):
            bone(f"{side}_{end}_leg", top, x, -0.05, 0)
            bone(f"{side}_{end}_shin", f"{side}_{end}_leg", 0, -0.3, 0.02)
            bone(f"{side}_{end}_paw", f"{side}_{end}_shin", 0, -0.3, -0.02)
    return Skeleton(
        names=tuple(names), parents=tuple(parents), offsets=np.array(offsets, np.float32)
    )


KINDS = {name: lambda name=name: CASES[name]()[0] for name in CASES} | {"quadruped": quadruped}


@pytest.mark.parametrize("kind", KINDS)
def test_every_skeleton_gets_a_closed_surface(kind):
    skeleton = KINDS[kind]()
    mesh = welded_mesh(skeleton)
    assert_closed(mesh.triangles)
    assert len(mesh.vertices) <= MOST_VERTICES
    assert np.isfinite(mesh.vertices).all()
    assert np.isfinite(mesh.normals).all()
    assert (mesh.weights.astype(int).sum(axis=1) == 255).all()
    assert mesh.joints.min() >= 0
    assert mesh.joints.max() < skeleton.num_joints


def test_a_person_has_the_volume_of_one(skin):
    height = np.ptp(skin.vertices[:, 1])
    litres = 1000 * volume(skin.vertices, skin.triangles)
    assert 1.6 < height < 1.9
    assert 55 < litres * (1.75 / height) ** 3 < 75


def test_a_person_is_one_ball(skin):
    """Euler's number of a surface without handles is 2: no limb grows together with another."""
    assert len(skin.vertices) - len(skin.triangles) // 2 == 2


def test_normals_point_outwards(skin):
    a, b, c = (skin.vertices[skin.triangles[:, i]] for i in range(3))
    of_triangles = np.cross(b - a, c - a)
    of_vertices = skin.normals[skin.triangles].mean(axis=1)
    agree = np.einsum("tx,tx->t", of_triangles, of_vertices) > 0
    assert agree.mean() > 0.98


def test_the_surface_lies_around_the_bones(skin):
    skeleton = person()
    shapes = body_shapes(skeleton, person=True)
    ends = np.array([p for s in shapes for p in (s.capsule.start, s.capsule.end)])
    thick = max(max(s.capsule.radii) * max(s.capsule.width, 1) for s in shapes)
    assert (skin.vertices.min(axis=0) > ends.min(axis=0) - thick).all()
    assert (skin.vertices.max(axis=0) < ends.max(axis=0) + thick).all()
    places = rest_positions(skeleton)
    assert (skin.vertices.min(axis=0) < places.min(axis=0)).all()


def test_soles_are_flat(skin):
    skeleton = person()
    toe = rest_positions(skeleton)[find_role(skeleton, "left_toe")]
    under = skin.vertices[np.linalg.norm((skin.vertices - toe)[:, [0, 2]], axis=1) < 0.05]
    low = under[under[:, 1] < toe[1] - 0.02]
    assert len(low) > 8
    assert np.ptp(low[:, 1]) < 0.012


def test_left_vertices_do_not_move_with_right_limbs(skin):
    skeleton = person()
    for side, sign in (("left", 1), ("right", -1)):
        knee = find_role(skeleton, f"{side}_knee")
        with_it = skin.weights[skin.joints == knee]
        assert len(with_it) > 100
        vertices = skin.vertices[((skin.joints == knee) & (skin.weights > 0)).any(axis=1)]
        assert (sign * vertices[:, 0] > 0).all()


def test_spread_pose_parts_the_legs():
    skeleton = person()
    pose = spread_pose(skeleton)
    assert pose.person
    places = rest_positions(pose.skeleton)
    apart = [places[find_role(skeleton, f"{s}_ankle")][0] for s in ("left", "right")]
    stood = rest_positions(skeleton)
    before = [stood[find_role(skeleton, f"{s}_ankle")][0] for s in ("left", "right")]
    assert apart[0] - apart[1] > before[0] - before[1] + 0.1


def capsule(start, end, radii, **more) -> Capsule:
    side = np.array([1.0, 0.0, 0.0])
    return Capsule(
        joint=0, start=np.array(start, float), end=np.array(end, float), radii=radii,
        side=side, **more,
    )  # fmt: skip


def test_distance_to_a_capsule_by_hand():
    one = capsule((0, 0, 0), (0, 1, 0), (0.2, 0.2))
    points = np.array([[0, -1, 0], [0.5, 0.5, 0], [0, 1.5, 0], [0.0, 0.5, 0.1]])
    np.testing.assert_allclose(
        capsule_distance(one, points).distance, [0.8, 0.3, 0.3, -0.1], atol=1e-9
    )


def test_distance_to_a_cone_between_two_balls():
    """The nearest point of two balls and what lies between, over 20,000 places on its axis."""
    one = capsule((0, 0, 0), (0, 1, 0), (0.3, 0.1))
    points = np.random.default_rng(0).uniform(-1.5, 1.5, (50, 3))
    share = np.linspace(0, 1, 20001)[:, None]
    balls = np.concatenate([0 * share, share, 0 * share], axis=1)
    wanted = [
        (np.linalg.norm(point - balls, axis=1) - (0.3 - 0.2 * share[:, 0])).min()
        for point in points
    ]
    np.testing.assert_allclose(capsule_distance(one, points).distance, wanted, atol=1e-6)


def test_nothing_bulges_along_a_straight_limb_and_a_corner_is_filled():
    along = [capsule((0, -1, 0), (0, 0, 0), (0.1, 0.1)), capsule((0, 0, 0), (0, 1, 0), (0.1, 0.1))]
    straight = [Shape(capsule=along[0]), Shape(capsule=along[1], onto=0)]
    beside = np.array([[0.15, 0.0, 0.0]])
    np.testing.assert_allclose(body_distance(straight, beside, 0.05), 0.05, atol=1e-6)
    across = capsule((0, 0, 0), (1, 0, 0), (0.1, 0.1))
    inner = np.array([[0.13, -0.13, 0.0]])
    joined = [Shape(capsule=along[0]), Shape(capsule=across, onto=0)]
    apart = [Shape(capsule=along[0]), Shape(capsule=across)]
    assert body_distance(joined, inner, 0.1)[0] < 0.03 - 1e-3
    assert body_distance(apart, inner, 0.1)[0] == pytest.approx(0.03)


def test_a_ball_on_a_grid():
    axes = np.arange(-1.5, 1.51, 0.1)
    points = np.stack(np.meshgrid(axes, axes, axes, indexing="ij"), axis=-1)
    vertices, triangles = surface_nets(np.linalg.norm(points, axis=-1) - 1)
    assert_closed(triangles)
    places = -1.5 + 0.1 * vertices
    np.testing.assert_allclose(np.linalg.norm(places, axis=1), 1, atol=0.01)
    assert volume(places, triangles) == pytest.approx(4 / 3 * np.pi, rel=0.02)


def test_random_fields_give_closed_surfaces():
    """Noise has every ambiguous face and cell that there is."""
    values = np.random.default_rng(3).normal(size=(12, 12, 12))
    values[[0, -1]] = values[:, [0, -1]] = values[:, :, [0, -1]] = 1.0
    _, triangles = surface_nets(values)
    assert_closed(triangles)
