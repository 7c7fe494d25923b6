/** Where the parts of the picture of a graph lie, in pixels of the whole picture. */

export const ROW = 27;
export const BAR = 11;
/** Width of the names at the left. */
export const NAMES = 132;
const TOP = 26;
const STEPS = 20;

/** The height of the whole picture. */
export const heightOf = (clips) => TOP + clips.length * ROW + 8;

/** The middle of a clip's bar. */
export const rowY = (clip) => TOP + clip * ROW + ROW - BAR / 2 - 4;

/** The clip whose row is at a height, or -1. */
export function clipAt(y, clips) {
  const clip = Math.floor((y - TOP) / ROW);
  return clip >= 0 && clip < clips.length ? clip : -1;
}

/**
 * The curve of a transition as points x, y: within a clip an arch over its bar, else from bar to bar.
 * @returns {Float32Array} of 2 * (STEPS + 1) numbers
 */
export function curve({ fromClip, fromX, toClip, toX }) {
  const [y1, y2] = [rowY(fromClip), rowY(toClip)];
  const half = BAR / 2;
  let points;
  if (fromClip === toClip) {
    const lift = Math.min(ROW - BAR - 3, 7 + Math.abs(toX - fromX) * 0.12);
    points = [[fromX, y1 - half], [fromX, y1 - half - lift * 1.33], [toX, y1 - half - lift * 1.33], [toX, y1 - half]];
  } else {
    const down = toClip > fromClip ? 1 : -1;
    const [a, b] = [y1 + down * half, y2 - down * half];
    const bend = Math.max(12, Math.abs(b - a) * 0.45);
    points = [[fromX, a], [fromX, a + down * bend], [toX, b - down * bend], [toX, b]];
  }
  const made = new Float32Array(2 * (STEPS + 1));
  for (let n = 0; n <= STEPS; n += 1) {
    const t = n / STEPS;
    const s = 1 - t;
    const w = [s * s * s, 3 * s * s * t, 3 * s * t * t, t * t * t];
    for (let k = 0; k < 2; k += 1) made[2 * n + k] = w.reduce((sum, share, i) => sum + share * points[i][k], 0);
  }
  return made;
}

/** How far a point is from a curve. */
export function distanceTo(points, x, y) {
  let least = Infinity;
  for (let n = 0; n + 3 < points.length; n += 2) {
    const [ax, ay, bx, by] = [points[n], points[n + 1], points[n + 2], points[n + 3]];
    const [dx, dy] = [bx - ax, by - ay];
    const length = dx * dx + dy * dy;
    const t = length ? Math.min(1, Math.max(0, ((x - ax) * dx + (y - ay) * dy) / length)) : 0;
    least = Math.min(least, Math.hypot(ax + t * dx - x, ay + t * dy - y));
  }
  return least;
}

/**
 * The transitions that are drawn: the nearest that touch a clip (or all), up to so many.
 * @param {{distance: Float32Array, from_clip: Int32Array, to_clip: Int32Array}} transitions
 * @param {number | null} clip
 * @returns {number[]} the nearest first
 */
export function drawn({ distance, from_clip: from, to_clip: to }, clip, most) {
  const found = [];
  for (let n = 0; n < distance.length; n += 1) {
    if (clip === null || from[n] === clip || to[n] === clip) found.push(n);
  }
  return found.sort((a, b) => distance[a] - distance[b]).slice(0, most);
}
