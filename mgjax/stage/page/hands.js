/** What the mouse takes hold of: a thing, one of its handles, or the floor that is drawn on. */

import { armOf } from './camera.js';
import { beginMove, handleAt } from './gizmo.js';
import { floorAt, thingAt } from './pick.js';

const EASY_TAKE = 0.012;

/** The thing under a ray, with some room around small ones; its id or null. */
export const thingUnder = (ray, things) => thingAt(ray, things, EASY_TAKE)?.id ?? null;

/**
 * @param {object} scene
 * @param {object} camera
 * @param {(name: 'thing' | 'floor', event: object) => void} tell
 */
export function createHands(scene, camera, tell) {
  const draggable = () => [...scene.things.values()].filter((thing) => thing.drag);
  const ray = (x, y) => camera.ray(x, y);
  const hands = {
    /** Ids of the thing under the pointer and of the one that moves, and the handle there. */
    over: null, moving: null, axis: null,

    /** The thing whose handles are shown. */
    get shown() {
      const thing = scene.things.get(hands.moving ?? hands.over);
      return thing?.drag === 'space' ? thing : null;
    },

    /** The pointer is at a pixel; true where what is under it has changed. */
    hover(x, y) {
      const { shown } = hands;
      const axis = shown ? handleAt(x, y, shown, camera) : null;
      const over = axis ? shown.id : thingUnder(ray(x, y), draggable());
      if (over === hands.over && axis === hands.axis) return false;
      Object.assign(hands, { over, axis });
      return true;
    },

    /** What a press of the left button takes; null: nothing. */
    grab(x, y, mayDraw) {
      hands.hover(x, y);
      if (hands.over !== null) return grabThing(scene.things.get(hands.over), x, y);
      return mayDraw ? grabFloor(x, y) : null;
    },
  };

  function grabThing(thing, x, y) {
    const { id, drag } = thing;
    const move = beginMove(thing, drag, hands.axis, ray(x, y), armOf(camera));
    hands.moving = id;
    const say = (phase) => tell('thing', {
      id, phase, place: [...thing.place], end: thing.end ? [...thing.end] : null,
    });
    say('start');
    return {
      move(px, py) {
        if (move(ray(px, py))) say('move');
      },
      end() {
        hands.moving = null;
        say('end');
      },
    };
  }

  function grabFloor(x, y) {
    let point = floorAt(ray(x, y));
    if (!point) return null;
    tell('floor', { phase: 'start', point });
    return {
      move(px, py) {
        const next = floorAt(ray(px, py));
        if (!next) return;
        point = next;
        tell('floor', { phase: 'move', point });
      },
      end: () => tell('floor', { phase: 'end', point }),
    };
  }

  return hands;
}
