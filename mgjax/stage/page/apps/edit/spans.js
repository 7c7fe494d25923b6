/** Labels on a clip's frames: where one may be dragged to without lying over another. */

/** The frames of a label, as the server counts them. */
export function framesOf({ start_s: start, end_s: end }, rate) {
  return { start: roundEven(start * rate), stop: roundEven(end * rate) };
}

/** Halves go to the even neighbour, as they do in Python. */
function roundEven(value) {
  const low = Math.floor(value);
  const rest = value - low;
  if (rest !== 0.5) return Math.round(value);
  return low % 2 === 0 ? low : low + 1;
}

/**
 * Between which frames a label may lie: up to its neighbours and the ends of the clip.
 * @param {{id, start, stop}[]} others
 * @param {{start, stop}} span from where it is dragged
 * @returns {{low: number, high: number, before: object | null, after: object | null}}
 */
export function room(others, { start, stop }, frames) {
  let [before, after] = [null, null];
  for (const other of others) {
    if (other.stop <= start && other.stop > (before?.stop ?? -1)) before = other;
    if (other.start >= stop && other.start < (after?.start ?? Infinity)) after = other;
  }
  return { low: before?.stop ?? 0, high: after?.start ?? frames, before, after };
}

/**
 * Where a drag by some frames takes a label.
 * @param {'start' | 'stop' | 'whole'} part
 * @returns {{start, stop, blocked: object | null}} blocked: the label, or 'end', that is in the way
 */
export function dragged(span, part, by, { low, high, before, after }) {
  let { start, stop } = span;
  let blocked = null;
  const stopAt = (value, least, most) => {
    if (value < least) blocked = before ?? 'end';
    if (value > most) blocked = after ?? 'end';
    return Math.min(most, Math.max(least, value));
  };
  if (part === 'start') {
    start = Math.min(stopAt(start + by, low, high), stop - 1);
  } else if (part === 'stop') {
    stop = Math.max(stopAt(stop + by, low, high), start + 1);
  } else {
    const length = stop - start;
    start = stopAt(start + by, low, Math.max(low, high - length));
    stop = start + length;
  }
  return { start, stop, blocked };
}

/** Seconds between two marks of a ruler, so that they stand at least so many pixels apart. */
export function markStep(perSecond, apart) {
  const steps = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 30, 60, 120, 300, 600, 1800, 3600];
  return steps.find((step) => step * perSecond >= apart) ?? 3600;
}
