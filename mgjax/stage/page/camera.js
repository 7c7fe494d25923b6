/** A camera on an arm around a target: turned, shifted, brought nearer; follows smoothly. */

import {
  add, clamp, cross, dot, length, lookAt, mix, multiply, normalize, perspective, scale, subtract,
  transform,
} from './math.js';

const FOV = (42 * Math.PI) / 180;
const LOWEST = 0.03;
const HIGHEST = 1.5;
const SETTLE = 0.12;
const FILLED = 0.82;
const NEAREST = 1.6;

/** Angles in radians, lengths in metres, pixels of the page. */
export function createCamera() {
  const camera = {
    yaw: 0.6, pitch: 0.26, distance: 4.5, target: [0, 0.9, 0],
    eye: [0, 0, 0], toClip: [], width: 1, height: 1,
    goal: null,

    /** Computes eye and matrix for a picture of width by height. */
    update(width, height) {
      Object.assign(camera, { width: Math.max(1, width), height: Math.max(1, height) });
      camera.eye = add(camera.target, scale(armOf(camera), camera.distance));
      const near = clamp(camera.distance * 0.05, 0.05, 1);
      const lens = perspective(FOV, camera.width / camera.height, near, 600);
      camera.toClip = multiply(lens, lookAt(camera.eye, camera.target));
    },

    /** Turns around the target by a drag in pixels. */
    orbit(dx, dy) {
      camera.yaw -= dx * 0.006;
      camera.pitch = clamp(camera.pitch + dy * 0.006, LOWEST, HIGHEST);
    },

    /** Shifts target and eye by a drag in pixels. */
    pan(dx, dy) {
      const metres = (2 * camera.distance * Math.tan(FOV / 2)) / camera.height;
      const { right, up } = axes();
      const shift = add(scale(right, -dx * metres), scale(up, dy * metres));
      camera.target = add(camera.target, shift);
      camera.target[1] = clamp(camera.target[1], 0, 20);
      return shift;
    },

    /** Brings the eye nearer by a factor under 1, or farther. */
    zoom(factor) {
      camera.distance = clamp(camera.distance * factor, 0.4, 120);
    },

    /** Where the target is to be brought smoothly, m; null: it stays. */
    lead(goal) {
      camera.goal = goal;
    },

    /** Moves to the goal: by `seconds` passed, or at once. True while there is way to go. */
    step(seconds, atOnce) {
      if (!camera.goal) return false;
      const way = length(subtract(camera.goal, camera.target));
      if (way < 1e-4) return false;
      const far = atOnce || way > 4 * camera.distance;
      camera.target = mix(camera.target, camera.goal, far ? 1 : 1 - Math.exp(-seconds / SETTLE));
      return true;
    },

    /** Stands, looking the same way, so that places (m) fill most of the picture. */
    frame(places) {
      const { arm, right, up, tall, wide } = axes();
      const [low, high] = [Math.min, Math.max].map((most) => (
        [0, 1, 2].map((k) => most(...places.map((place) => place[k])))));
      let target = scale(add(low, high), 0.5);
      let distance = 2 * length(subtract(high, low)) + 2;
      for (let step = 0; step < 6; step += 1) {
        const seen = places.map((place) => {
          const at = subtract(place, target);
          const away = Math.max(0.3, distance - dot(at, arm));
          return [dot(at, right) / (away * wide), dot(at, up) / (away * tall)];
        });
        const [x, y] = [0, 1].map((k) => spread(seen.map((point) => point[k])));
        target = add(target, scale(right, x.middle * distance * wide));
        target = add(target, scale(up, y.middle * distance * tall));
        distance = clamp((distance * Math.max(x.half, y.half)) / FILLED, NEAREST, 100);
      }
      Object.assign(camera, { target, distance });
    },

    /** The ray through a pixel: from the eye, unit direction. */
    ray(x, y) {
      const { left, right, up } = camera.edges();
      const to = add(mix(left, right, x / camera.width), scale(up, 1 - (2 * y) / camera.height));
      return { from: camera.eye, to: normalize(to) };
    },

    /** Pixels of one metre at a place. */
    pixelsAt(place) {
      const away = Math.max(0.1, dot(subtract(camera.eye, place), axes().arm));
      return camera.height / (2 * Math.tan(FOV / 2) * away);
    },

    /** Directions to the middles of the left and right edge, and from the middle to the upper. */
    edges() {
      const { arm, right, up, tall, wide } = axes();
      return {
        left: subtract(scale(right, -wide), arm),
        right: subtract(scale(right, wide), arm),
        up: scale(up, tall),
      };
    },

    /** The pixel of a place; null behind the eye. */
    project(place) {
      const [x, y, , w] = transform(camera.toClip, place);
      if (w < 1e-3) return null;
      return [(0.5 + (0.5 * x) / w) * camera.width, (0.5 - (0.5 * y) / w) * camera.height];
    },
  };

  /** The camera's own directions, and half of what it sees at one metre. */
  function axes() {
    const arm = armOf(camera);
    const right = normalize(cross([0, 1, 0], arm));
    const tall = Math.tan(FOV / 2);
    return { arm, right, up: cross(arm, right), tall, wide: tall * (camera.width / camera.height) };
  }

  camera.update(1, 1);
  return camera;
}

function spread(values) {
  const [low, high] = [Math.min(...values), Math.max(...values)];
  return { middle: (low + high) / 2, half: (high - low) / 2 };
}

/** From the target to the eye, unit. */
export function armOf({ yaw, pitch }) {
  return [Math.sin(yaw) * Math.cos(pitch), Math.sin(pitch), Math.cos(yaw) * Math.cos(pitch)];
}
