/** Things that are moved with the mouse: over the floor, in the camera's plane, along an axis. */

import { add, dot, nearestOnAxis, rayPlane, scale, subtract } from './math.js';

const AXES = { x: [1, 0, 0], y: [0, 1, 0], z: [0, 0, 1] };
const ARM_PIXELS = 62;
const NEAR_PIXELS = 9;

/** Ends of the three axis handles of a thing: [{axis, from, to}], m; they keep their size in pixels. */
export function handlesOf(thing, camera) {
  const size = ARM_PIXELS / camera.pixelsAt(thing.place) + (thing.end ? 0 : thing.radius ?? 0.05);
  return Object.entries(AXES).map(([axis, way]) => (
    { axis, from: thing.place, to: add(thing.place, scale(way, size)) }));
}

/** The axis whose handle is at a pixel: 'x', 'y', 'z' or null. */
export function handleAt(x, y, thing, camera) {
  for (const { axis, from, to } of handlesOf(thing, camera)) {
    const [a, b] = [camera.project(from), camera.project(to)];
    if (a && b && pixelsToSegment([x, y], a, b) < NEAR_PIXELS) return axis;
  }
  return null;
}

/** Distance of a pixel from the outer three quarters of a segment. */
function pixelsToSegment([x, y], from, to) {
  const [dx, dy] = [to[0] - from[0], to[1] - from[1]];
  const square = dx * dx + dy * dy;
  const share = square ? ((x - from[0]) * dx + (y - from[1]) * dy) / square : 0;
  const at = Math.min(1.05, Math.max(0.25, share));
  return Math.hypot(x - from[0] - at * dx, y - from[1] - at * dy);
}

/**
 * Begins to move a thing.
 * @param {object} thing is moved itself: its place, and its end with it
 * @param {'floor' | 'space'} way over the floor or in the plane across the camera
 * @param {string | null} axis of the handle that was taken
 * @param {object} ray the pointer's, at the beginning
 * @returns {(ray: object) => boolean} moves it to where another ray points; false where that is
 *   nowhere
 */
export function beginMove(thing, way, axis, ray, arm) {
  const place = [...thing.place];
  const end = thing.end ? [...thing.end] : null;
  const shiftOf = axis ? alongAxis(place, AXES[axis], ray) : inPlane(place, way, ray, arm);
  return (next) => {
    const shift = shiftOf(next);
    if (!shift) return false;
    if (place[1] + shift[1] < 0) shift[1] = -place[1];
    thing.place = add(place, shift);
    if (end) thing.end = add(end, shift);
    return true;
  };
}

function alongAxis(place, axis, ray) {
  const start = nearestOnAxis(ray, place, axis);
  return (next) => scale(axis, nearestOnAxis(next, place, axis) - start);
}

function inPlane(place, way, ray, arm) {
  const normal = way === 'floor' ? [0, 1, 0] : arm;
  const grip = rayPlane(ray, place, normal) ?? place;
  return (next) => {
    const point = rayPlane(next, place, normal);
    if (!point || dot(subtract(point, grip), subtract(point, grip)) > 60 * 60) return null;
    return subtract(point, grip);
  };
}
