/** What there is: bodies, actors, balls, lines, things; and what of it is drawn at a second. */

import { makeBody, makePose, poseBody } from './body.js';
import { rgb } from './look.js';
import { ballPlace, Track } from './motion.js';
import { polyline } from './draw/lines.js';
import { clamp } from './math.js';

const TRAIL = 1.2;
const KINDS = ['actors', 'balls', 'lines', 'things'];

/** An empty scene. */
export function createScene() {
  const scene = {
    bodies: [],
    actors: new Map(),
    balls: new Map(),
    lines: new Map(),
    things: new Map(),

    /** Everything replaced by a show. */
    setShow(show) {
      scene.clear();
      (show.bodies ?? []).forEach((body, index) => scene.put('bodies', { ...body, index }));
      for (const kind of KINDS) (show[kind] ?? []).forEach((item) => scene.put(kind, item));
    },

    /** Adds an item, or replaces the one of the same id (a body: of the same `index`). */
    put(kind, item) {
      if (kind === 'bodies') scene.bodies[item.index ?? scene.bodies.length] = makeBody(item);
      else if (kind === 'actors') scene.actors.set(item.id, makeActor(scene, item));
      else if (kind === 'lines') scene.lines.set(item.id, makeLine(item));
      else if (kind === 'balls') scene.balls.set(item.id, item);
      else if (kind === 'things') scene.things.set(item.id, { ...item });
      else throw new Error(`got kind ${kind}, expected bodies, ${KINDS.join(', ')}`);
    },

    remove(kind, id) {
      if (kind === 'bodies') delete scene.bodies[id];
      else scene[kind].delete(id);
    },

    clear(kind) {
      if (!kind || kind === 'bodies') scene.bodies = [];
      for (const each of KINDS) if (!kind || kind === each) scene[each].clear();
    },

    /** Frames that replace what an actor had from `frames.start` (s) on. */
    pushFrames(id, frames) {
      const actor = scene.actors.get(id);
      if (!actor) return;
      actor.track.add(frames);
      actor.track.forget();
    },

    /** Poses everybody for a second. */
    poseAt(time) {
      for (const actor of scene.actors.values()) poseActor(actor, time);
    },

    drawn: (time, eye) => drawn(scene, time, eye),
  };
  return scene;
}

function makeActor(scene, item) {
  const body = scene.bodies[item.body];
  if (!body) throw new Error(`actor ${item.id} has body ${item.body}, which there is not`);
  const { id, colour = 'blue', look = 'solid', note = '' } = item;
  return { id, colour, look, note, body, pose: makePose(body), track: new Track(item.frames), row: 0 };
}

/** An actor's pose; ghosts are seen only from their first frame to their last. */
function poseActor(actor, time) {
  const { body, pose, track } = actor;
  actor.seen = track.pieces.length > 0
    && (actor.look !== 'ghost' || (time >= track.start - 1e-3 && time <= track.end + 1e-3));
  if (!actor.seen) return;
  track.sample(time, pose.local, pose.root);
  poseBody(body, pose);
}

function makeLine({ id, points, colour = 'grey', width = 3, dashed = false }) {
  let top = 0;
  for (let i = 1; i < points.length; i += 3) top = Math.max(top, points[i]);
  const numbers = polyline(points);
  return { id, points, width, dashed, colour: rgb(colour), numbers, flat: top < 0.02 };
}

/** Lists for the renderer, of one second; `eye` (m) says which ghost is farther. */
function drawn(scene, time, eye) {
  const seen = [...scene.actors.values()].filter((actor) => actor.seen);
  const actors = seen.filter((actor) => actor.look !== 'ghost');
  const far = ({ pose }) => Math.hypot(...pose.root.map((value, k) => value - eye[k]));
  const ghosts = seen.filter((actor) => actor.look === 'ghost').sort((a, b) => far(b) - far(a));
  const lines = [...scene.lines.values()];
  const out = {
    bodies: scene.bodies, actors, ghosts, solids: [], nets: [], spots: [], casters: [],
    floorLines: lines.filter((line) => line.flat), airLines: lines.filter((line) => !line.flat),
  };
  for (const actor of actors) addBody(out, actor);
  for (const ball of scene.balls.values()) addBall(out, ball, time);
  for (const thing of scene.things.values()) addThing(out, thing);
  return out;
}

function addBody({ casters, spots }, { body, pose }) {
  const middle = pose.low.map((low, k) => (low + pose.high[k]) / 2);
  const radius = Math.hypot(...pose.low.map((low, k) => (pose.high[k] - low) / 2)) + 0.15;
  casters.push([...middle, radius]);
  for (let j = 0; j < body.count; j += 1) {
    const height = pose.places[3 * j + 1];
    const near = clamp(1 - height / 0.4, 0, 1);
    if (near > 0) spots.push(pose.places[3 * j], pose.places[3 * j + 2], 0.17, 0.2 * near * near);
  }
}

function addBall({ solids, spots, casters, airLines }, ball, time) {
  const place = ballPlace(ball, time);
  if (ball.trail !== false) addTrail(airLines, ball, time);
  if (!place) return;
  solids.push({ from: place, to: place, radius: ball.radius, colour: rgb(ball.colour ?? 'orange') });
  casters.push([...place, ball.radius]);
  const near = clamp(1 - (place[1] - ball.radius) / 1.5, 0, 1);
  spots.push(place[0], place[2], ball.radius * (2 - near) * 1.2, 0.5 * near);
}

/** The way of a ball in the last second, which tapers off. */
function addTrail(lines, ball, time) {
  const { times, places } = ball;
  const last = Math.min(time, times[times.length - 1]);
  const begin = Math.max(times[0], time - TRAIL);
  if (last <= begin) return;
  const moments = [begin, ...Array.from(times).filter((t) => t > begin && t < last), last];
  const points = moments.flatMap((t) => ballPlace(ball, t));
  const shares = moments.map((t) => clamp(1 - (time - t) / TRAIL, 0, 1));
  const width = clamp(ball.radius * 50, 3, 7);
  lines.push({ numbers: polyline(points, shares), colour: rgb(ball.colour ?? 'orange'), width });
}

function addThing({ solids, nets, casters, floorLines, airLines, spots }, thing) {
  const { place, radius = 0.05 } = thing;
  const end = thing.end ?? place;
  const colour = rgb(thing.colour ?? 'purple');
  if (thing.shape === 'ring') {
    floorLines.push({ numbers: circle(place, radius), colour, width: 4 });
    return;
  }
  if (thing.shape === 'net') {
    nets.push({ from: place, to: end, colour });
    airLines.push({ numbers: polyline([...place, ...end]), colour: [1, 1, 1], width: 3 });
    for (const [x, y, z] of [place, end]) {
      solids.push({ from: [x, 0, z], to: [x, y, z], radius: 0.03, colour, flat: true });
      spots.push(x, z, 0.15, 0.4);
    }
  } else {
    solids.push({ from: place, to: end, radius, colour, flat: thing.shape === 'cylinder' });
    for (const [x, y, z] of thing.end ? [place, end] : [place]) {
      const near = clamp(1 - (y - radius) / 1.2, 0, 1);
      spots.push(x, z, radius * (2 - near) + 0.05, 0.4 * near);
    }
  }
  casters.push([...place, radius], [...end, radius]);
}

function circle([x, , z], radius) {
  const points = [];
  for (let i = 0; i <= 64; i += 1) {
    const turn = (2 * Math.PI * i) / 64;
    points.push(x + radius * Math.cos(turn), 0, z + radius * Math.sin(turn));
  }
  return polyline(points);
}
