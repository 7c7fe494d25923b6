/** Poses over time: frames as they arrive, and the pose at any second in between. */

const KEPT = 60;
const FULL = 32767;

/** Frames whose rotations are no differences any more. */
function decoded({ rate, start, rotations, root, delta }) {
  const count = rotations.shape[0];
  const joints = rotations.shape[1];
  const size = joints * 4;
  let whole = rotations;
  if (delta) {
    whole = new Int16Array(rotations);
    for (let i = size; i < whole.length; i += 1) whole[i] += whole[i - size];
  }
  return { rate, start, count, joints, rotations: whole, root, end: start + (count - 1) / rate };
}

/** The first `count` frames of a piece. */
function shortened(piece, count) {
  return { ...piece, count, end: piece.start + (count - 1) / piece.rate };
}

/** The frames of one actor: pieces at fixed rates, one after the other. */
export class Track {
  /** @param {object} frames as in mgjax/stage/show/types.py `Frames` */
  constructor(frames) {
    this.pieces = [];
    this.add(frames);
  }

  /** Frames that replace everything from `frames.start` (s) on. */
  add(frames) {
    const piece = decoded(frames);
    if (piece.count < 1) return;
    this.pieces = this.pieces.flatMap((old) => {
      const kept = Math.min(old.count, Math.ceil((piece.start - old.start) * old.rate - 1e-6));
      return kept > 0 ? [shortened(old, kept)] : [];
    });
    this.pieces.push(piece);
  }

  /** Drops the pieces that end more than a minute before the last frame. */
  forget() {
    const oldest = this.end - KEPT;
    this.pieces = this.pieces.filter((piece) => piece.end >= oldest);
  }

  /** Second of the first frame. */
  get start() { return this.pieces.length ? this.pieces[0].start : 0; }

  /** Second of the last frame. */
  get end() { return this.pieces.length ? this.pieces[this.pieces.length - 1].end : 0; }

  get joints() { return this.pieces.length ? this.pieces[0].joints : 0; }

  /** The two frames around a second, and the share of the second one. */
  around(time) {
    const { pieces } = this;
    let index = pieces.length - 1;
    while (index > 0 && pieces[index].start > time) index -= 1;
    const piece = pieces[index];
    const at = Math.max(0, (time - piece.start) * piece.rate);
    const frame = Math.floor(at);
    if (frame < piece.count - 1) return [piece, frame, piece, frame + 1, at - frame];
    const next = pieces[index + 1];
    if (!next) return [piece, piece.count - 1, piece, piece.count - 1, 0];
    const share = Math.min(1, (time - piece.end) / Math.max(1e-9, next.start - piece.end));
    return [piece, piece.count - 1, next, 0, share];
  }

  /**
   * The pose at a second, between frames by normalised mixing; held before the first frame and
   * after the last.
   * @param {number} time s
   * @param {Float32Array} rotations filled with local rotations, wxyz [J·4]
   * @param {Float32Array} root filled with the place of the root, m [3]
   */
  sample(time, rotations, root) {
    const [a, first, b, second, share] = this.around(time);
    for (let k = 0; k < 3; k += 1) {
      const here = a.root[3 * first + k];
      root[k] = here + (b.root[3 * second + k] - here) * share;
    }
    const from = first * a.joints * 4;
    const to = second * b.joints * 4;
    for (let i = 0; i < a.joints * 4; i += 4) {
      mixTurns(a.rotations, from + i, b.rotations, to + i, share, rotations, i);
    }
  }

  /** Place of the root at a second, m, averaged over `width` seconds around it. */
  smoothRoot(time, width) {
    const sum = [0, 0, 0];
    const steps = 9;
    for (let step = 0; step < steps; step += 1) {
      const [a, first, b, second, share] = this.around(time + width * (step / (steps - 1) - 0.5));
      for (let k = 0; k < 3; k += 1) {
        const here = a.root[3 * first + k];
        sum[k] += (here + (b.root[3 * second + k] - here) * share) / steps;
      }
    }
    return sum;
  }
}

/** out[o…] = the unit quaternion between a[i…] and b[j…], the short way round. */
function mixTurns(a, i, b, j, share, out, o) {
  const same = a[i] * b[j] + a[i + 1] * b[j + 1] + a[i + 2] * b[j + 2] + a[i + 3] * b[j + 3];
  const other = same < 0 ? -share : share;
  const w = a[i] * (1 - share) + b[j] * other;
  const x = a[i + 1] * (1 - share) + b[j + 1] * other;
  const y = a[i + 2] * (1 - share) + b[j + 2] * other;
  const z = a[i + 3] * (1 - share) + b[j + 3] * other;
  const size = Math.sqrt(w * w + x * x + y * y + z * z);
  if (size < FULL * 1e-6) {
    out[o] = 1;
    out[o + 1] = out[o + 2] = out[o + 3] = 0;
    return;
  }
  out[o] = w / size;
  out[o + 1] = x / size;
  out[o + 2] = y / size;
  out[o + 3] = z / size;
}

/**
 * Where a ball is at a second, m, straight between its moments; null where it is not there.
 * @param {{times: Float32Array, places: Float32Array}} ball
 */
export function ballPlace({ times, places }, time) {
  const last = times.length - 1;
  if (last < 0 || time < times[0] || time > times[last]) return null;
  let low = 0;
  let high = last;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (times[middle] <= time) low = middle; else high = middle;
  }
  const gap = times[high] - times[low];
  const share = gap > 0 ? (time - times[low]) / gap : 0;
  return [0, 1, 2].map((k) => places[3 * low + k]
    + (places[3 * high + k] - places[3 * low + k]) * share);
}
