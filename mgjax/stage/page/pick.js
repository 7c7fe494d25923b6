/** What lies under a ray: the floor, a body, a thing. */

import { heaviest, surfacePlaces } from './body.js';
import { cross, dot, rayCapsule, rayPlane, raySphere, subtract } from './math.js';

const FARTHEST = 80;

/** Where a ray meets the floor, [x, 0, z] in m; null above the horizon or very far away. */
export function floorAt(ray) {
  const point = rayPlane(ray, [0, 0, 0], [0, 1, 0]);
  if (!point || Math.hypot(point[0] - ray.from[0], point[2] - ray.from[2]) > FARTHEST) return null;
  return [point[0], 0, point[2]];
}

/**
 * The body that a ray meets first, as drawn.
 * @returns {{actor: string, joint: number, name: string, place: number[], far: number} | null}
 */
export function bodyAt(ray, actors) {
  let best = null;
  for (const actor of actors) {
    if (!actor.seen || !mayMeet(ray, actor.pose)) continue;
    const hit = surfaceAt(ray, actor);
    if (hit && (!best || hit.far < best.far)) best = { actor: actor.id, ...hit };
  }
  return best;
}

function mayMeet(ray, { low, high }) {
  const centre = low.map((value, k) => (value + high[k]) / 2);
  const radius = Math.hypot(...low.map((value, k) => (high[k] - value) / 2)) + 0.25;
  return raySphere(ray, centre, radius) < Infinity;
}

/** Nearest triangle of a posed surface (Möller and Trumbore), and the joint it moves with. */
function surfaceAt({ from, to }, { body, pose }) {
  const places = surfacePlaces(body, pose);
  const { triangles } = body.mesh;
  const corner = (v) => [places[3 * v], places[3 * v + 1], places[3 * v + 2]];
  let far = Infinity;
  let found = -1;
  for (let t = 0; t < triangles.length; t += 3) {
    const a = corner(triangles[t]);
    const u = subtract(corner(triangles[t + 1]), a);
    const v = subtract(corner(triangles[t + 2]), a);
    const p = cross(to, v);
    const size = dot(u, p);
    if (Math.abs(size) < 1e-12) continue;
    const offset = subtract(from, a);
    const first = dot(offset, p) / size;
    if (first < 0 || first > 1) continue;
    const q = cross(offset, u);
    const second = dot(to, q) / size;
    if (second < 0 || first + second > 1) continue;
    const at = dot(v, q) / size;
    if (at > 0 && at < far) [far, found] = [at, t];
  }
  if (found < 0) return null;
  const joint = body.mesh.joints[heaviest(body.mesh.weights, triangles[found])];
  return { joint, name: body.names[joint], place: from.map((value, k) => value + to[k] * far), far };
}

/**
 * The thing that a ray meets first.
 * @param {number} slack m at one metre from the eye that count as met, so that small ones can be
 *   taken
 * @returns {{id: string, far: number} | null}
 */
export function thingAt(ray, things, slack = 0) {
  let best = null;
  for (const thing of things) {
    const far = thingDistance(ray, thing, slack);
    if (far < Infinity && (!best || far < best.far)) best = { id: thing.id, far };
  }
  return best;
}

function thingDistance(ray, { shape, place, end, radius = 0.05 }, slack) {
  const more = radius + slack * Math.hypot(...subtract(place, ray.from));
  if (shape === 'ring') {
    const point = floorAt(ray);
    const off = point ? Math.hypot(point[0] - place[0], point[2] - place[2]) : Infinity;
    return off <= more ? Math.hypot(...subtract(point, ray.from)) : Infinity;
  }
  if (shape === 'net') return netDistance(ray, place, end ?? place);
  return rayCapsule(ray, place, end ?? place, more);
}

function netDistance(ray, from, to) {
  const [x, , z] = subtract(to, from);
  const point = rayPlane(ray, from, [-z, 0, x]);
  if (!point) return Infinity;
  const share = ((point[0] - from[0]) * x + (point[2] - from[2]) * z) / (x * x + z * z);
  const top = from[1] + share * (to[1] - from[1]);
  if (share < 0 || share > 1 || point[1] < 0 || point[1] > top) return Infinity;
  return Math.hypot(...subtract(point, ray.from));
}
