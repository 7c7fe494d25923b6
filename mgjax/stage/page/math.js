/**
 * Vectors as [x, y, z], matrices as sixteen numbers by columns, as WebGL takes them.
 * Metres, radians, Y up; a camera looks along its −Z.
 */

export const add = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
export const subtract = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
export const scale = (a, s) => [a[0] * s, a[1] * s, a[2] * s];
export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const length = (a) => Math.hypot(a[0], a[1], a[2]);
export const mix = (a, b, share) => a.map((value, i) => value + (b[i] - value) * share);
export const clamp = (value, low, high) => Math.min(high, Math.max(low, value));

export function cross(a, b) {
  return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
}

/** The vector with length one; zero stays zero. */
export function normalize(a) {
  const size = length(a);
  return size > 0 ? scale(a, 1 / size) : [0, 0, 0];
}

/** Projection of a camera: `fov` is the vertical angle in radians, `aspect` width by height. */
export function perspective(fov, aspect, near, far) {
  const f = 1 / Math.tan(fov / 2);
  const depth = near - far;
  return [
    f / aspect, 0, 0, 0,
    0, f, 0, 0,
    0, 0, (far + near) / depth, -1,
    0, 0, 2 * far * near / depth, 0,
  ];
}

/** Projection without perspective of the box ±half by ±half by near … far, m. */
export function orthographic(half, near, far) {
  const depth = near - far;
  return [
    1 / half, 0, 0, 0,
    0, 1 / half, 0, 0,
    0, 0, 2 / depth, 0,
    0, 0, (far + near) / depth, 1,
  ];
}

/** World to camera, for one at `eye` that looks at `target`. */
export function lookAt(eye, target, up = [0, 1, 0]) {
  const z = normalize(subtract(eye, target));
  const x = normalize(cross(up, z));
  const y = cross(z, x);
  return [
    x[0], y[0], z[0], 0,
    x[1], y[1], z[1], 0,
    x[2], y[2], z[2], 0,
    -dot(x, eye), -dot(y, eye), -dot(z, eye), 1,
  ];
}

/** The matrix that does `b` first, then `a`. */
export function multiply(a, b) {
  const out = new Array(16).fill(0);
  for (let column = 0; column < 4; column += 1) {
    for (let row = 0; row < 4; row += 1) {
      for (let k = 0; k < 4; k += 1) out[4 * column + row] += a[4 * k + row] * b[4 * column + k];
    }
  }
  return out;
}

/** A point through a 4×4 matrix, as [x, y, z, w], not divided. */
export function transform(m, [x, y, z]) {
  return [0, 1, 2, 3].map((row) => m[row] * x + m[4 + row] * y + m[8 + row] * z + m[12 + row]);
}

/** Where a ray meets the plane through `point` with `normal`; null if behind it or along it. */
export function rayPlane({ from, to }, point, normal) {
  const slope = dot(to, normal);
  if (Math.abs(slope) < 1e-9) return null;
  const far = dot(subtract(point, from), normal) / slope;
  return far > 0 ? add(from, scale(to, far)) : null;
}

/** How far along a ray (unit direction) a capsule from `a` to `b` is met, m; Infinity if not. */
export function rayCapsule({ from, to }, a, b, radius) {
  const along = subtract(b, a);
  const size = length(along);
  const axis = size > 1e-9 ? scale(along, 1 / size) : [0, 1, 0];
  const start = subtract(from, a);
  const sideways = subtract(to, scale(axis, dot(to, axis)));
  const offset = subtract(start, scale(axis, dot(start, axis)));
  const square = dot(sideways, sideways);
  if (square > 1e-12) {
    const half = dot(sideways, offset);
    const rest = half * half - square * (dot(offset, offset) - radius * radius);
    if (rest >= 0) {
      const far = (-half - Math.sqrt(rest)) / square;
      const height = dot(start, axis) + far * dot(to, axis);
      if (far > 0 && height >= 0 && height <= size) return far;
    }
  }
  return Math.min(raySphere({ from, to }, a, radius), raySphere({ from, to }, b, radius));
}

/** How far along a ray (unit direction) a sphere is met, m; Infinity if not. */
export function raySphere({ from, to }, centre, radius) {
  const start = subtract(from, centre);
  const half = dot(start, to);
  const rest = half * half - dot(start, start) + radius * radius;
  if (rest < 0) return Infinity;
  const far = -half - Math.sqrt(rest);
  return far > 0 ? far : Infinity;
}

/** Where on the line through `point` along the unit vector `axis` a ray passes nearest, m. */
export function nearestOnAxis({ from, to }, point, axis) {
  const between = subtract(from, point);
  const slope = dot(to, axis);
  const square = 1 - slope * slope;
  if (square < 1e-6) return 0;
  return (dot(between, axis) - slope * dot(between, to)) / square;
}
