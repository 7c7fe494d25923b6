/** What of a scene is to be in the picture, and what is written at it. */

const MOMENTS = 24;
const WIDEST = 9;

/**
 * The box (m) around a scene over all its time, or around one actor now. Where a show
 * reaches over more than nine metres it is the box of what stands there now: the camera follows.
 */
export function content(scene, id = null) {
  if (id !== null) return boxOf([...bodyPlaces(scene.actors.get(id))]);
  const still = [...bodies(scene), ...things(scene)];
  const whole = boxOf([...still, ...ways(scene)]);
  const wide = Math.max(...whole.high.map((value, k) => value - whole.low[k]));
  return wide > WIDEST ? boxOf(still) : whole;
}

function boxOf(places) {
  if (!places.length) return { low: [-1, 0, -1], high: [1, 1.8, 1] };
  const low = [0, 1, 2].map((k) => Math.min(...places.map((place) => place[k])));
  const high = [0, 1, 2].map((k) => Math.max(...places.map((place) => place[k])));
  low[1] = Math.min(low[1], 0);
  return { low, high };
}

function* bodyPlaces(actor) {
  if (!actor?.seen) return;
  const { low, high } = actor.pose;
  yield low.map((value) => value - 0.12);
  yield [high[0] + 0.12, actor.pose.top, high[2] + 0.12];
}

function* bodies(scene) {
  for (const actor of scene.actors.values()) yield* bodyPlaces(actor);
}

function* things(scene) {
  for (const { place, end, radius = 0.05, shape } of scene.things.values()) {
    const more = shape === 'net' ? 0 : radius;
    for (const [x, y, z] of end ? [place, end] : [place]) {
      yield [x - more, Math.max(0, y - more), z - more];
      yield [x + more, y + more, z + more];
    }
  }
}

/** Where roots and balls come, and where lines lead. */
function* ways(scene) {
  for (const { track } of scene.actors.values()) {
    for (let step = 0; step <= MOMENTS && track.pieces.length; step += 1) {
      const [x, y, z] = track.smoothRoot(track.start + ((track.end - track.start) * step) / MOMENTS, 0);
      yield [x - 0.4, y, z - 0.4];
      yield [x + 0.4, y + 0.7, z + 0.4];
    }
  }
  for (const { points } of scene.lines.values()) yield* triples(points);
}

function* triples(numbers) {
  const step = 3 * Math.max(1, Math.floor(numbers.length / 3 / MOMENTS));
  for (let i = 0; i + 2 < numbers.length; i += step) {
    yield [numbers[i], numbers[i + 1], numbers[i + 2]];
  }
}

/** Notes of actors over their heads, and of things beside them: [{text, place, colour}]. */
export function labelsOf(scene) {
  const labels = [];
  for (const { note, seen, pose, colour } of scene.actors.values()) {
    if (!note || !seen) continue;
    const place = [(pose.low[0] + pose.high[0]) / 2, pose.top + 0.02, (pose.low[2] + pose.high[2]) / 2];
    labels.push({ text: note, place, colour });
  }
  for (const { note, place, end, radius = 0.05, colour = 'purple', shape } of scene.things.values()) {
    if (!note) continue;
    const over = end ?? place;
    const middle = place.map((value, k) => (value + over[k]) / 2);
    middle[1] = Math.max(place[1], over[1]) + (shape === 'ring' ? 0.05 : radius + 0.05);
    labels.push({ text: note, place: middle, colour });
  }
  return labels;
}
