/** A skeleton with its surface, and its pose in the world by forward kinematics. */

const HEAD = 0.25;

/**
 * A body ready to be posed and drawn.
 * @param {object} value as in mgjax/stage/show/types.py `Body`
 * @returns {object} parents, offsets and rest places (m), names, and the mesh in plain types
 */
export function makeBody({ parents, offsets, names, mesh }) {
  const count = parents.length;
  const rest = new Float32Array(3 * count);
  for (let j = 1; j < count; j += 1) {
    for (let k = 0; k < 3; k += 1) rest[3 * j + k] = rest[3 * parents[j] + k] + offsets[3 * j + k];
  }
  const surface = {
    places: Float32Array.from(mesh.places, (value) => value * mesh.unit),
    normals: Int8Array.from(mesh.normals),
    joints: Uint16Array.from(mesh.joints),
    weights: Uint8Array.from(mesh.weights),
    triangles: Uint32Array.from(mesh.triangles),
  };
  const reach = reachOf(surface, rest);
  return { count, parents: Array.from(parents), offsets, rest, reach, names, mesh: surface };
}

/** How far the surface of each joint goes from it, m, at most what a head does. */
function reachOf({ places, joints, weights }, rest) {
  const reach = new Float32Array(rest.length / 3);
  for (let v = 0; v < places.length / 3; v += 1) {
    const j = joints[heaviest(weights, v)];
    const way = Math.hypot(...[0, 1, 2].map((k) => places[3 * v + k] - rest[3 * j + k]));
    reach[j] = Math.min(HEAD, Math.max(reach[j], way));
  }
  return reach;
}

/** Index, in `joints` and `weights`, of the joint with which a vertex moves most. */
export function heaviest(weights, vertex) {
  let best = 4 * vertex;
  for (let i = best + 1; i < 4 * vertex + 4; i += 1) if (weights[i] > weights[best]) best = i;
  return best;
}

/** Room for one pose of a body. */
export function makePose(body) {
  return {
    local: new Float32Array(4 * body.count),
    root: new Float32Array(3),
    turns: new Float32Array(4 * body.count),
    places: new Float32Array(3 * body.count),
    rows: new Float32Array(12 * body.count),
    low: [0, 0, 0],
    high: [0, 0, 0],
    top: 0,
  };
}

/**
 * Fills places (m), turns (wxyz, world) and the 3×4 matrices, by rows, that move the surface from
 * the rest pose, from `pose.local` and `pose.root`. The root's offset is not added.
 */
export function poseBody(body, pose) {
  const { parents, offsets } = body;
  const { local, root, turns, places } = pose;
  for (let j = 0; j < body.count; j += 1) {
    const parent = parents[j];
    if (parent < 0) {
      for (let k = 0; k < 4; k += 1) turns[4 * j + k] = local[4 * j + k];
      for (let k = 0; k < 3; k += 1) places[3 * j + k] = root[k];
    } else {
      placeChild(turns, places, offsets, parent, j);
      turnChild(turns, local, parent, j);
    }
  }
  fillRows(body, pose);
  fillBounds(body, pose);
}

/** places[j] = places[parent] + turns[parent] · offsets[j]. */
function placeChild(turns, places, offsets, parent, j) {
  const w = turns[4 * parent];
  const x = turns[4 * parent + 1];
  const y = turns[4 * parent + 2];
  const z = turns[4 * parent + 3];
  const a = offsets[3 * j];
  const b = offsets[3 * j + 1];
  const c = offsets[3 * j + 2];
  const u = 2 * (y * c - z * b);
  const v = 2 * (z * a - x * c);
  const t = 2 * (x * b - y * a);
  places[3 * j] = places[3 * parent] + a + w * u + y * t - z * v;
  places[3 * j + 1] = places[3 * parent + 1] + b + w * v + z * u - x * t;
  places[3 * j + 2] = places[3 * parent + 2] + c + w * t + x * v - y * u;
}

/** turns[j] = turns[parent] · local[j]. */
function turnChild(turns, local, parent, j) {
  const p = 4 * parent;
  const q = 4 * j;
  const [pw, px, py, pz] = [turns[p], turns[p + 1], turns[p + 2], turns[p + 3]];
  const [qw, qx, qy, qz] = [local[q], local[q + 1], local[q + 2], local[q + 3]];
  turns[q] = pw * qw - px * qx - py * qy - pz * qz;
  turns[q + 1] = pw * qx + px * qw + py * qz - pz * qy;
  turns[q + 2] = pw * qy - px * qz + py * qw + pz * qx;
  turns[q + 3] = pw * qz + px * qy - py * qx + pz * qw;
}

/** The surface of joint j goes from v to R (v − rest) + place: rows of [R | place − R rest]. */
function fillRows({ count, rest }, { turns, places, rows }) {
  for (let j = 0; j < count; j += 1) {
    const w = turns[4 * j];
    const x = turns[4 * j + 1];
    const y = turns[4 * j + 2];
    const z = turns[4 * j + 3];
    const at = 12 * j;
    rows[at] = 1 - 2 * (y * y + z * z);
    rows[at + 1] = 2 * (x * y - w * z);
    rows[at + 2] = 2 * (x * z + w * y);
    rows[at + 4] = 2 * (x * y + w * z);
    rows[at + 5] = 1 - 2 * (x * x + z * z);
    rows[at + 6] = 2 * (y * z - w * x);
    rows[at + 8] = 2 * (x * z - w * y);
    rows[at + 9] = 2 * (y * z + w * x);
    rows[at + 10] = 1 - 2 * (x * x + y * y);
    for (let k = 0; k < 3; k += 1) {
      const row = at + 4 * k;
      rows[row + 3] = places[3 * j + k] - rows[row] * rest[3 * j]
        - rows[row + 1] * rest[3 * j + 1] - rows[row + 2] * rest[3 * j + 2];
    }
  }
}

/** The box around the joints, and how high the surface comes at most. */
function fillBounds({ count, reach }, pose) {
  const { places, low, high } = pose;
  pose.top = -Infinity;
  for (let j = 0; j < count; j += 1) pose.top = Math.max(pose.top, places[3 * j + 1] + reach[j]);
  for (let k = 0; k < 3; k += 1) {
    low[k] = Infinity;
    high[k] = -Infinity;
    for (let j = 0; j < count; j += 1) {
      low[k] = Math.min(low[k], places[3 * j + k]);
      high[k] = Math.max(high[k], places[3 * j + k]);
    }
  }
}

/**
 * The vertices of the surface in a pose, m.
 * @returns {Float32Array} [V·3]
 */
export function surfacePlaces({ mesh }, { rows }) {
  const { places, joints, weights } = mesh;
  const out = new Float32Array(places.length);
  for (let v = 0; v < places.length / 3; v += 1) {
    const x = places[3 * v];
    const y = places[3 * v + 1];
    const z = places[3 * v + 2];
    for (let i = 4 * v; i < 4 * v + 4; i += 1) {
      const share = weights[i] / 255;
      if (share === 0) continue;
      const at = 12 * joints[i];
      for (let k = 0; k < 3; k += 1) {
        const row = at + 4 * k;
        out[3 * v + k] += share
          * (rows[row] * x + rows[row + 1] * y + rows[row + 2] * z + rows[row + 3]);
      }
    }
  }
  return out;
}
