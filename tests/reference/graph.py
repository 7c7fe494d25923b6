"""The motion graph's definitions in float64 loops, one window or one transition at a time.

Written from the definitions alone; it shares no code with the package.
"""

from __future__ import annotations

import numpy as np

from tests.reference import kinematics


def cloud(positions, start: int, window: int) -> np.ndarray:
    """[W·J,3] all joints of the frames start … start+W−1."""
    return np.asarray(positions, np.float64)[start : start + window].reshape(-1, 3)


def cloud_weights(weights, joints: int, window: int) -> np.ndarray:
    """[W·J] joint weights, equal over the frames, with the sum 1."""
    w = np.ones(joints) if weights is None else np.asarray(weights, np.float64)
    return np.tile(w / w.sum() / window, window)


def centred(points, w) -> np.ndarray:
    """The weighted mean of x and z subtracted, not of y."""
    return points - (w @ points) * np.array([1.0, 0.0, 1.0])


def best_turn(a, b, w) -> float:
    """θ that turns the centred cloud b nearest to the centred cloud a."""
    cosine = np.sum(w * (a[:, 0] * b[:, 0] + a[:, 2] * b[:, 2]))
    sine = np.sum(w * (a[:, 0] * b[:, 2] - a[:, 2] * b[:, 0]))
    return float(np.arctan2(sine, cosine))


def squared_distance(points_a, points_b, w) -> float:
    """Eq. 1 in its closed form."""
    a, b = centred(points_a, w), centred(points_b, w)
    flat = a[:, 0] ** 2 + a[:, 2] ** 2 + b[:, 0] ** 2 + b[:, 2] ** 2
    total = np.sum(w * (flat + (a[:, 1] - b[:, 1]) ** 2))
    cosine = np.sum(w * (a[:, 0] * b[:, 0] + a[:, 2] * b[:, 2]))
    sine = np.sum(w * (a[:, 0] * b[:, 2] - a[:, 2] * b[:, 0]))
    return float(total - 2 * np.sqrt(cosine**2 + sine**2))


def misfit(transform, points_a, points_b, w) -> float:
    """Weighted squared distance of the clouds after mapping b by (θ, x, z): what is minimised."""
    mapped = np.array([kinematics.planar_apply(transform, q) for q in points_b])
    return float(np.sum(w[:, None] * (points_a - mapped) ** 2))


def align(points_a, points_b, w) -> np.ndarray:
    """(θ, x, z) that maps the second cloud on the first."""
    theta = best_turn(centred(points_a, w), centred(points_b, w), w)
    turned = kinematics.planar_apply((theta, 0.0, 0.0), w @ points_b)
    shift = w @ points_a - turned
    return np.array([theta, shift[0], shift[2]])


def distance_matrix(positions_a, positions_b, window: int, weights=None) -> np.ndarray:
    """Squared distances of all window starts, m²."""
    joints = np.shape(positions_a)[1]
    w = cloud_weights(weights, joints, window)
    rows, columns = len(positions_a) - window + 1, len(positions_b) - window + 1
    result = np.zeros((rows, columns))
    for r in range(rows):
        for c in range(columns):
            result[r, c] = squared_distance(
                cloud(positions_a, r, window), cloud(positions_b, c, window), w
            )
    return result


def is_minimum(matrix, r: int, c: int, reach: int, slack: float = 0.0) -> bool:
    """No neighbour within ``reach`` is lower by more than ``slack``; ties: lowest (row, column)."""
    rows, columns = matrix.shape
    for i in range(max(r - reach, 0), min(r + reach + 1, rows)):
        for j in range(max(c - reach, 0), min(c + reach + 1, columns)):
            if matrix[i, j] < matrix[r, c] - slack:
                return False
            if slack == 0 and matrix[i, j] == matrix[r, c] and (i, j) < (r, c):
                return False
    return True


def clear_minimum(matrix, r: int, c: int, reach: int, margin: float) -> bool:
    """All neighbours are higher by more than ``margin``."""
    rows, columns = matrix.shape
    return all(
        matrix[i, j] > matrix[r, c] + margin
        for i in range(max(r - reach, 0), min(r + reach + 1, rows))
        for j in range(max(c - reach, 0), min(c + reach + 1, columns))
        if (i, j) != (r, c)
    )


def minima(matrix, reach: int, threshold: float) -> list[tuple[int, int]]:
    """All minima of one pair of clips below the threshold, by exhaustive scan."""
    rows, columns = matrix.shape
    return [
        (r, c)
        for r in range(rows)
        for c in range(columns)
        if matrix[r, c] < threshold and is_minimum(matrix, r, c, reach)
    ]


def alpha(p: int, window: int) -> float:
    """Share of the first clip; 1 before the window and 0 after it."""
    u = (p + 1) / window
    if u <= 0:
        return 1.0
    if u >= 1:
        return 0.0
    return 2 * u**3 - 3 * u**2 + 1


def blend(root_a, rotations_a, root_b, rotations_b, transform):
    """Roots [W,3] and local rotation matrices [W,J,3,3], b mapped by the transform first."""
    window, joints = np.shape(rotations_a)[:2]
    roots, turns = np.zeros((window, 3)), np.zeros((window, joints, 3, 3))
    turn = (np.cos(transform[0] / 2), 0.0, np.sin(transform[0] / 2), 0.0)
    for p in range(window):
        share = alpha(p, window)
        mapped = kinematics.planar_apply(transform, root_b[p])
        roots[p] = share * np.asarray(root_a[p], np.float64) + (1 - share) * mapped
        for joint in range(joints):
            b = rotations_b[p][joint]
            if joint == 0:
                b = multiply(turn, b)
            turns[p, joint] = kinematics.slerp(rotations_a[p][joint], b, 1 - share)
    return roots, turns


def multiply(a, b) -> np.ndarray:
    """Hamilton product of (scalar, vector) pairs."""
    a, b = np.asarray(a, np.float64), np.asarray(b, np.float64)
    scalar = a[0] * b[0] - a[1:] @ b[1:]
    return np.concatenate([[scalar], a[0] * b[1:] + b[0] * a[1:] + np.cross(a[1:], b[1:])])


def component(starts, stops, leave, arrive, labels):
    """The strongly connected component with most frames, by plain reachability over frames.

    Every frame boundary of every clip is a point ``(clip, frame)``, frame = start … stop; time
    leads from each to the next, transition m from leave[m] to arrive[m] in the clip that holds
    the frame before.

    Returns:
        frames of clips in each component, largest first; which transitions and which labels
        (start, stop) lie in the largest (in any, where two are as large).
    """
    clip_of = {
        frame: k
        for k, (a, b) in enumerate(zip(starts, stops, strict=True))
        for frame in range(a, b)
    }
    points = [
        (k, frame)
        for k, (a, b) in enumerate(zip(starts, stops, strict=True))
        for frame in range(a, b + 1)
    ]
    jumps = [((clip_of[x], x), (clip_of[y - 1], y)) for x, y in zip(leave, arrive, strict=True)]
    follow = {p: [] for p in points}
    lead = {p: [] for p in points}
    steps = [((k, f), (k, f + 1)) for k, f in points if (k, f + 1) in follow]
    for p, q in steps + jumps:
        follow[p].append(q)
        lead[q].append(p)

    def reach(start, ways):
        seen, todo = {start}, [start]
        while todo:
            for q in ways[todo.pop()]:
                if q not in seen:
                    seen.add(q)
                    todo.append(q)
        return seen

    parts, done = [], set()
    for p in points:
        if p not in done:
            part = reach(p, follow) & reach(p, lead)
            done |= part
            parts.append(part)

    def frames_in(part):
        return sum(1 for p, q in steps if p in part and q in part)

    sizes = sorted((frames_in(part) for part in parts), reverse=True)
    best = max(parts, key=frames_in)
    kept = [p in best and q in best for p, q in jumps]
    held = [all((clip_of[a], f) in best for f in range(a, b + 1)) for a, b in labels]
    return sizes, kept, held
