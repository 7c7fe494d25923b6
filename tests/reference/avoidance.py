"""Avoidance in plain float64 Python, one thing at a time, written from the definitions."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from tests.reference import kinematics


def candidates(out_edges, target, seconds, parts, node, t_attack, window) -> set:
    """All (walk, part) of eq. 1, by a depth-first search that tries every walk.

    ``out_edges[node]`` lists edges, ``parts[edge]`` lists (part, middle of the part within the
    edge).
    """
    low, high = t_attack - window / 2, t_attack + window / 2
    found = set()

    def visit(at: int, walk: tuple[int, ...], begin: float) -> None:
        for edge in out_edges[at]:
            longer = (*walk, edge)
            for part, middle in parts.get(edge, ()):
                if low < begin + middle < high:
                    found.add((longer, part))
            end = begin + seconds[edge]
            if end < high:  # a part's middle comes after the beginning of its edge
                visit(target[edge], longer, end)

    visit(node, (), 0.0)
    return found


def time_scale(seconds, slow_down, speed_up, part_centre, t_attack, half_frame, limit):
    """Eqs 2–3: (s_time, scales, status) with status "ok", "not_adjustable" or "out_of_range"."""
    counted = [*seconds[:-1], part_centre]
    t_avoid = math.fsum(counted)
    ones = [1.0] * len(counted)
    if abs(t_avoid - t_attack) <= half_frame:
        return 1.0, ones, "ok"
    adjustable = speed_up if t_attack < t_avoid else slow_down
    t_adjustable = math.fsum(t for t, free in zip(counted, adjustable, strict=True) if free)
    if t_adjustable == 0:
        return 1.0, ones, "not_adjustable"
    s = (t_attack - (t_avoid - t_adjustable)) / t_adjustable
    if s <= 0 or s > limit or s < 1 / limit:
        return 1.0, ones, "out_of_range"
    return s, [s if free else 1.0 for free in adjustable], "ok"


def sphere_places(first, second, share, positions) -> np.ndarray:
    """[S,3] centres between pairs of joints of one pose."""
    places = np.zeros((len(first), 3))
    for i, (a, b, t) in enumerate(zip(first, second, share, strict=True)):
        for axis in range(3):
            start, end = float(positions[a][axis]), float(positions[b][axis])
            places[i, axis] = start + float(t) * (end - start)
    return places


def compose(outer, inner) -> np.ndarray:
    """Planar transforms (θ, x, z): ``inner`` first, then ``outer``."""
    x, _, z = kinematics.planar_apply(outer, (inner[1], 0.0, inner[2]))
    return np.array([outer[0] + inner[0], x, z], np.float64)


def inverse(transform) -> np.ndarray:
    """The planar transform that undoes another."""
    theta = -float(transform[0])
    x, _, z = kinematics.planar_apply((theta, 0, 0), (transform[1], 0.0, transform[2]))
    return np.array([theta, -x, -z])


def edge_places(graph, edges) -> list[np.ndarray]:
    """From each edge's coordinates to the planar frame of the body at the first node."""
    place = inverse(graph.node_plane[graph.edge_source[edges[0]]])
    places = []
    for edge in edges:
        places.append(place)
        place = compose(place, graph.edge_exit[edge])
    return places


def body_at(graph, spheres, edges, scales, time) -> np.ndarray:
    """[S,3] spheres at a time on a walk: those of the two nearest frames, linear in between.

    After the last frame of an edge comes the first of the next edge. Poses are solved joint by
    joint; the walk begins at the origin, heading +Z; its last pose is held.
    """

    def spheres_of(place: np.ndarray, row: int) -> np.ndarray:
        pose, _ = kinematics.forward(
            graph.skeleton.parents,
            graph.skeleton.offsets,
            graph.root_translation[row],
            graph.local_rotations[row],
        )
        pose = [kinematics.planar_apply(place, point) for point in pose]
        return sphere_places(spheres.first, spheres.second, spheres.share, pose)

    places = edge_places(graph, edges)
    begin, final = 0.0, len(edges) - 1
    for k, (edge, scale) in enumerate(zip(edges, scales, strict=True)):
        frames = int(graph.edge_stops[edge] - graph.edge_starts[edge])
        last = frames / graph.frame_rate * scale
        if time < begin + last or k == final:
            where = min((time - begin) / scale * graph.frame_rate, frames)
            low = min(int(where), frames - 1)
            share = where - low
            row = int(graph.edge_starts[edge]) + low
            after = (places[k], row + 1)
            if low == frames - 1 and k < final:
                after = (places[k + 1], int(graph.edge_starts[edges[k + 1]]))
            return (1 - share) * spheres_of(places[k], row) + share * spheres_of(*after)
        begin += last
    raise AssertionError("a walk without edges")


def ball_place(start, at, speed, arrives, gravity, time) -> np.ndarray:
    """Where a ball is that was thrown from ``start`` to be at ``at`` in ``arrives`` seconds.

    Under gravity the time of flight is found by bisection: the shortest one whose launch has the
    given speed.
    """
    start, at = np.asarray(start, np.float64), np.asarray(at, np.float64)
    pull = np.array([0.0, -9.8 if gravity else 0.0, 0.0])

    def launch(flight: float) -> np.ndarray:
        return (at - start) / flight - 0.5 * pull * flight

    flight = float(np.linalg.norm(at - start)) / speed
    if gravity:
        # Short flights need a faster launch than this one: go on until it is slow enough.
        short = long = flight / 3
        assert np.linalg.norm(launch(short)) > speed
        while np.linalg.norm(launch(long)) > speed:
            short, long = long, long * 1.001
            assert long < 100, "out of reach"
        for _ in range(100):
            middle = 0.5 * (short + long)
            if np.linalg.norm(launch(middle)) > speed:
                short = middle
            else:
                long = middle
        flight = long
    since = time - (arrives - flight)
    return start + launch(flight) * since + 0.5 * pull * since**2


def swept_clearance(attack, attack_radii, body, body_radii, pieces: int = 1) -> float:
    """Least D of spheres that move linearly between common moments: [T,I,3] and [T,S,3].

    With ``pieces`` > 1 the segments are only sampled, which gives a little too much.
    """
    best = math.inf
    for t in range(len(attack) - 1):
        for i in range(attack.shape[1]):
            for j in range(body.shape[1]):
                start = attack[t, i] - body[t, j]
                end = attack[t + 1, i] - body[t + 1, j]
                move = end - start
                if pieces > 1:
                    shares = [k / pieces for k in range(pieces + 1)]
                else:
                    square = float(move @ move)
                    share = -float(start @ move) / square if square > 0 else 0.0
                    shares = [min(1.0, max(0.0, share))]
                for share in shares:
                    gap = float(np.linalg.norm(start + share * move))
                    best = min(best, gap - attack_radii[i] - body_radii[j])
    return best


def quick_clearance(attack, attack_radii, body, body_radii) -> float:
    """:func:`swept_clearance`, for many moments: the same formula on whole arrays."""
    start = attack[:-1, :, None] - body[:-1, None]
    move = attack[1:, :, None] - body[1:, None] - start
    square = np.sum(move * move, axis=-1)
    share = np.divide(
        -np.sum(start * move, axis=-1), square, out=np.zeros_like(square), where=square > 0
    )
    near = start + np.clip(share, 0, 1)[..., None] * move
    radii = np.asarray(attack_radii)[:, None] + np.asarray(body_radii)[None]
    return float((np.linalg.norm(near, axis=-1) - radii).min())


def read_written(path) -> tuple[list[str], list[int], np.ndarray, float, np.ndarray, np.ndarray]:
    """A written BVH file: names, parents, offsets, rate, root [F,3] and rotations [F,J,4].

    For files with a root of six channels, joints of Z Y X rotations and end sites, in centimetres.
    """
    lines = [line.split() for line in Path(path).read_text().splitlines()]
    names: list[str] = []
    parents: list[int] = []
    offsets: list[list[float]] = []
    turning: list[int] = []
    stack: list[int] = []
    head = next(i for i, line in enumerate(lines) if line and line[0] == "MOTION")
    for words in lines[:head]:
        if words[0] in ("ROOT", "JOINT", "End"):
            names.append(f"{names[stack[-1]]}_end" if words[0] == "End" else words[1])
            parents.append(stack[-1] if stack else -1)
            stack.append(len(names) - 1)
        elif words[0] == "OFFSET":
            offsets.append([float(w) / 100 for w in words[1:]])
        elif words[0] == "CHANNELS":
            assert words[-3:] == ["Zrotation", "Yrotation", "Xrotation"]
            assert len(words) == (8 if len(names) == 1 else 5)
            turning.append(len(names) - 1)
        elif words[0] == "}":
            stack.pop()
    rate = 1 / float(lines[head + 2][2])
    rows = np.array(lines[head + 3 :], np.float64)
    assert len(rows) == int(lines[head + 1][1])
    rotations = np.zeros((len(rows), len(names), 4))
    rotations[..., 0] = 1
    half = np.deg2rad(rows[:, 3:].reshape(len(rows), len(turning), 3)) / 2
    (cz, sz), (cy, sy), (cx, sx) = ((np.cos(half[..., i]), np.sin(half[..., i])) for i in range(3))
    zero = np.zeros_like(cz)
    z = np.stack([cz, zero, zero, sz], axis=-1)
    y = np.stack([cy, zero, sy, zero], axis=-1)
    x = np.stack([cx, sx, zero, zero], axis=-1)
    rotations[:, turning] = product(product(z, y), x)
    return names, parents, np.array(offsets), rate, rows[:, :3] / 100, rotations


def product(p: np.ndarray, q: np.ndarray) -> np.ndarray:
    """Hamilton's product of quaternions wxyz, as cross and dot products."""
    w = p[..., :1] * q[..., :1] - np.sum(p[..., 1:] * q[..., 1:], axis=-1, keepdims=True)
    v = p[..., :1] * q[..., 1:] + q[..., :1] * p[..., 1:] + np.cross(p[..., 1:], q[..., 1:])
    return np.concatenate([w, v], axis=-1)


def written_positions(path) -> tuple[list[str], np.ndarray, np.ndarray]:
    """Names, seconds [T] and joint positions [T,J,3] of a written motion, also half-way.

    Half-way between two frames the root is half-way, and each rotation is the normalised sum of
    the two quaternions, which is the slerp at ½.
    """
    names, parents, offsets, rate, root, rotations = read_written(path)
    near = np.sum(rotations[:-1] * rotations[1:], axis=-1, keepdims=True)
    between = rotations[:-1] + np.where(near < 0, -1.0, 1.0) * rotations[1:]
    between /= np.linalg.norm(between, axis=-1, keepdims=True)
    count = 2 * len(root) - 1
    roots, turns = np.zeros((count, 3)), np.zeros((count, *rotations.shape[1:]))
    roots[::2], turns[::2] = root, rotations
    roots[1::2], turns[1::2] = 0.5 * (root[:-1] + root[1:]), between
    places, world = np.zeros((count, len(names), 3)), np.zeros_like(turns)
    for joint, parent in enumerate(parents):
        if parent < 0:
            places[:, joint], world[:, joint] = roots, turns[:, joint]
            continue
        above = world[:, parent]
        v = np.broadcast_to(offsets[joint], (count, 3))
        cross = 2 * np.cross(above[:, 1:], v)
        turned = v + above[:, :1] * cross + np.cross(above[:, 1:], cross)
        places[:, joint] = places[:, parent] + turned
        world[:, joint] = product(above, turns[:, joint])
    return names, np.arange(count) / (2 * rate), places


def edges_onward(graph, node, seconds) -> list[int]:
    """The walk of who does not react: along the clip, else along the first edge that leaves."""
    edges: list[int] = []
    end = 0.0
    while not edges or end < seconds:
        leaving = [int(e) for e in graph.edges_from(node)]
        of_clip = [e for e in leaving if graph.edge_clip[e] >= 0]
        edges.append((of_clip or leaving)[0])
        end += graph.edge_frames[edges[-1]] / graph.frame_rate
        node = int(graph.edge_target[edges[-1]])
    return edges
