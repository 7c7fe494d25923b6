/** What of a scene is to be in the picture, and what is written at it. */

const MOMENTS = 24;
const WIDEST = 9;

/**
 * Places (m) that are to be in the picture: those of a scene over all its time, or of one actor now.
 * Where a show reaches over more than nine metres it is what stands there now: the camera follows.
 */
export function content(scene, id = null) {
  if (id !== null) return orSomething([...bodyPlaces(scene.actors.get(id))]);
  const still = [...bodies(scene), ...things(scene)];
  const whole = [...still, ...ways(scene)];
  return orSomething(broad(whole) > WIDEST && still.length ? still : whole);
}

const orSomething = (places) => (places.length ? places : [[-1, 0, -1], [1, 1.8, 1]]);

function broad(places) {
  return Math.max(0, ...[0, 2].map((k) => {
    const values = places.map((place) => place[k]);
    return Math.max(...values) - Math.min(...values);
  }));
}

function* bodyPlaces(actor) {
  if (!actor?.seen) return;
  const { low, high, top } = actor.pose;
  for (const x of [low[0] - 0.12, high[0] + 0.12]) {
    for (const y of [Math.max(0, low[1] - 0.12), top]) {
      for (const z of [low[2] - 0.12, high[2] + 0.12]) yield [x, y, z];
    }
  }
}

function* bodies(scene) {
  for (const actor of scene.actors.values()) yield* bodyPlaces(actor);
}

function* things(scene) {
  for (const { place, end, radius = 0.05, shape } of scene.things.values()) {
    const more = shape === 'net' ? 0 : radius;
    const over = shape === 'ring' ? 0 : more;
    for (const [x, y, z] of end ? [place, end] : [place]) {
      for (const side of [-more, more]) {
        yield [x + side, y + over, z - side];
        yield [x + side, y + over, z + side];
      }
      yield [x, Math.max(0, y - over), z];
    }
  }
}

/** Where bodies come, and where lines lead. */
function* ways(scene) {
  for (const { track } of scene.actors.values()) {
    for (let step = 0; step <= MOMENTS && track.pieces.length; step += 1) {
      const [x, y, z] = track.smoothRoot(track.start + ((track.end - track.start) * step) / MOMENTS, 0);
      for (const side of [-0.3, 0.3]) {
        yield [x + side, 0, z - side];
        yield [x + side, y + 0.75, z + side];
      }
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

/**
 * Notes of actors over their heads, and of things: [{text, place, colour, aside}], where `aside` (m)
 * is how far to the right of its place one begins; without it the note stands over the place. The
 * thing whose handles are shown has none.
 */
export function labelsOf(scene, handled = null) {
  const labels = [];
  for (const { note, seen, pose, colour } of scene.actors.values()) {
    if (!note || !seen) continue;
    const place = [(pose.low[0] + pose.high[0]) / 2, pose.top + 0.02, (pose.low[2] + pose.high[2]) / 2];
    labels.push({ text: note, place, colour });
  }
  for (const { id, note, place, end, radius = 0.05, colour = 'purple' } of scene.things.values()) {
    if (!note || id === handled) continue;
    const other = end ?? place;
    const middle = place.map((value, k) => (value + other[k]) / 2);
    const long = Math.hypot(other[0] - place[0], other[2] - place[2]) > 2 * radius;
    if (long) middle[1] += radius + 0.02;
    labels.push({ text: note, place: middle, colour, aside: long ? undefined : radius });
  }
  return labels;
}
