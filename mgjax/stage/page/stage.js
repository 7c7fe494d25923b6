/** The stage: a canvas on which a scene is drawn, looked around in, picked and moved. */

import { createCamera } from './camera.js';
import { content, labelsOf } from './content.js';
import { createRenderer } from './draw/renderer.js';
import { createHands, thingUnder } from './hands.js';
import { THEMES } from './look.js';
import { asPicture, boxesOver, createPaper } from './paper.js';
import { bodyAt, floorAt } from './pick.js';
import { listen } from './pointer.js';
import { createQuality, firstLevel, LEVELS } from './quality.js';
import { createScene } from './scene.js';

const SMOOTH_SECONDS = 0.8;

/**
 * A stage on a canvas, which fills its parent. Places are [x, y, z] in metres, Y up; x, y alone are
 * pixels of the page in the canvas; times are seconds.
 * @param {HTMLCanvasElement} canvas
 * @param {{dark?: boolean, wheel?: 'always' | 'focused'}} options `focused`: the wheel zooms only
 *   after the picture was clicked, so that a page can be scrolled over it
 * @throws {Error} where the browser has no WebGL2
 */
export function createStage(canvas, { dark = false, wheel = 'always' } = {}) {
  const gl = canvas.getContext('webgl2', { alpha: true, antialias: false, depth: true });
  if (!gl) throw new Error('this browser cannot draw in three dimensions (WebGL2 is missing)');
  let renderer = createRenderer(gl);
  const scene = createScene();
  const camera = createCamera();
  const quality = createQuality(firstLevel(gl));
  const paper = createPaper(canvas);
  const heard = { frame: [], click: [], floor: [], thing: [], tick: [] };
  const tell = (name, what) => [...heard[name]].forEach((callback) => callback(what));
  const hands = createHands(scene, camera, tell);
  const state = {
    time: 0, dark, follow: null, offset: [0, 0, 0], posed: false, dirty: true, request: 0,
    last: 0, drawn: false, gone: false, over: [],
  };

  function hear(name, callback) {
    heard[name].push(callback);
    return () => { heard[name] = heard[name].filter((each) => each !== callback); };
  }

  /** Asks for a frame; `dirty`: there is something new to draw. */
  function wake(dirty = true) {
    state.dirty ||= dirty;
    if (!state.request && !state.gone) state.request = requestAnimationFrame(frame);
  }

  function changed() {
    state.posed = false;
    wake();
  }

  function frame(now) {
    state.request = 0;
    const seconds = Math.min(0.1, (now - state.last) / 1000);
    state.last = now;
    let more = false;
    for (const tick of [...heard.tick]) more = tick(now) || more;
    lead();
    if (camera.step(seconds, false)) [state.dirty, more] = [true, true];
    const drawn = state.dirty && draw(quality.now);
    if (drawn) {
      state.dirty = quality.frame(now, state.drawn);
      tell('frame', now);
    }
    state.drawn = drawn;
    // One more after each that was drawn, so that whoever draws all the time misses none.
    if (more || drawn) wake(false);
  }

  function pose() {
    if (!state.posed) scene.poseAt(state.time);
    state.posed = true;
  }

  /** Where the camera goes with the actor that it follows. */
  function lead() {
    const actor = scene.actors.get(state.follow);
    if (!actor || !actor.track.pieces.length) {
      camera.lead(null);
      return;
    }
    const [x, , z] = actor.track.smoothRoot(state.time, SMOOTH_SECONDS);
    camera.lead([x + state.offset[0], camera.target[1], z + state.offset[2]]);
  }

  /** Draws now; false where there is nothing to draw on. */
  function draw({ scale, shadow, taps, samples }) {
    const [wide, high] = [canvas.clientWidth, canvas.clientHeight];
    if (!wide || !high || !renderer) return false;
    state.dirty = false;
    const ratio = Math.min(2, globalThis.devicePixelRatio || 1) * scale;
    const [width, height] = [wide, high].map((side) => Math.max(1, Math.round(side * ratio)));
    if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
    pose();
    camera.update(wide, high);
    const theme = THEMES[state.dark ? 'dark' : 'light'];
    const view = { camera, theme, width, height, ratio, quality: { shadow, taps, samples } };
    renderer.draw(view, scene.drawn(state.time, camera.eye));
    paper.write({
      camera, theme, labels: labelsOf(scene, hands.shown?.id), taken: boxesOver(canvas, state.over),
      handles: hands.shown, held: hands.axis,
    });
    return true;
  }

  /** The camera stands so that everything, or one actor, is in the picture. */
  function frameContent(id) {
    pose();
    camera.update(canvas.clientWidth, canvas.clientHeight);
    camera.frame(content(scene, id));
    state.offset = [0, 0, 0];
    wake();
  }

  function hover(x, y) {
    if (!hands.hover(x, y)) return;
    canvas.style.cursor = hands.over === null ? '' : 'grab';
    wake();
  }

  const stage = {
    canvas, camera, scene,
    /** `look`: a drag turns the camera; `draw`: it draws on the floor. */
    tool: 'look',

    /** Everything replaced by a show (types.py `Show`); the camera stays. */
    setShow(show) {
      scene.setShow(show);
      if (!scene.actors.has(state.follow)) state.follow = null;
      changed();
    },
    /** Adds or replaces an item of 'bodies' (by index), 'actors', 'balls', 'lines' or 'things'. */
    put(kind, item) {
      if (kind === 'things' && item.id === hands.moving) return;
      scene.put(kind, item);
      changed();
    },
    remove(kind, id) {
      scene.remove(kind, id);
      changed();
    },
    clear(kind) {
      scene.clear(kind);
      changed();
    },
    /** Frames that replace what an actor had from `frames.start` on; a minute is kept. */
    pushFrames(id, frames) {
      scene.pushFrames(id, frames);
      changed();
    },

    get time() { return state.time; },
    set time(seconds) {
      if (seconds === state.time) return;
      state.time = seconds;
      changed();
    },
    /** Id of the actor whom the camera follows, or null. */
    get follow() { return state.follow; },
    set follow(id) {
      state.follow = scene.actors.has(id) ? id : null;
      state.offset = [0, 0, 0];
      wake();
    },
    get dark() { return state.dark; },
    set dark(value) {
      state.dark = Boolean(value);
      wake();
    },

    /** The camera stands so that all of the show is in the picture, or (frameOn) one actor. */
    frameAll: () => frameContent(null),
    frameOn: (id) => frameContent(id),

    ray: (x, y) => camera.ray(x, y),
    /** @returns {number[] | null} */
    pickFloor: (x, y) => floorAt(camera.ray(x, y)),
    /** @returns {{actor, joint, name, place, far} | null} joint by number */
    pickBody(x, y) {
      pose();
      return bodyAt(camera.ray(x, y), scene.actors.values());
    },
    pickThing: (x, y) => thingUnder(camera.ray(x, y), scene.things.values()),
    project: (place) => camera.project(place),

    /** Each of these calls back until the function that it returns is called. */
    onFrame: (callback) => hear('frame', callback),
    onClick: (callback) => hear('click', callback),
    onFloorDrag: (callback) => hear('floor', callback),
    onThingDrag: (callback) => hear('thing', callback),
    /** Called with now (ms) before each frame; frames go on for as long as it returns true. */
    onTick: (callback) => hear('tick', callback),
    wake,
    /** Labels keep clear of these elements of the page, which lie over the picture. */
    keepClear(...elements) {
      state.over = elements;
      wake();
    },

    /** A picture of a second, labels too, in the best quality: a PNG as a data URL, or null. */
    snapshot(seconds = state.time) {
      stage.time = seconds;
      lead();
      camera.step(0, true);
      const drawn = draw(LEVELS[0]);
      wake();
      return drawn ? asPicture(canvas, paper.canvas) : null;
    },

    /** How finely is drawn: 0 (best) … 4, or null: as the time between frames allows. */
    set level(level) {
      quality.fix(level);
      wake();
    },

    /** Frames a second and ms between them while something moves; pixels drawn for one (scale). */
    stats() {
      const { ms, level } = quality;
      return { fps: ms ? 1000 / ms : 0, ms, scale: quality.now.scale, level };
    },

    /** Frees everything; the canvas cannot be used again. */
    dispose() {
      if (state.gone) return;
      state.gone = true;
      cancelAnimationFrame(state.request);
      stops.forEach((stop) => stop());
      renderer?.free();
      renderer = null;
      scene.clear();
      paper.remove();
      gl.getExtension('WEBGL_lose_context')?.loseContext();
    },
  };

  const stops = [listen(canvas, {
    orbit(dx, dy) {
      camera.orbit(dx, dy);
      wake();
    },
    pan(dx, dy) {
      const shift = camera.pan(dx, dy);
      state.offset = state.offset.map((value, k) => value + shift[k]);
      wake();
    },
    zoom(factor) {
      camera.zoom(factor);
      wake();
    },
    hover,
    leave: () => hover(-1e4, -1e4),
    grab(x, y) {
      wake();
      return hands.grab(x, y, stage.tool === 'draw');
    },
    click: (x, y) => tell('click', {
      x, y, floor: stage.pickFloor(x, y), body: stage.pickBody(x, y), thing: stage.pickThing(x, y),
    }),
    mayZoom: (event) => wheel === 'always' || event.ctrlKey || document.activeElement === canvas,
  })];
  hear('thing', () => wake());
  stops.push(watch(canvas, wake, () => { renderer = null; }, () => {
    if (!state.gone) renderer = createRenderer(gl);
    wake();
  }));
  wake();
  return stage;
}

/** Calls `wake` when the canvas gets another size, and tells of a context lost and given back. */
function watch(canvas, wake, lost, back) {
  const sized = new ResizeObserver(() => wake());
  sized.observe(canvas);
  const onLost = (event) => {
    event.preventDefault();
    lost();
  };
  canvas.addEventListener('webglcontextlost', onLost);
  canvas.addEventListener('webglcontextrestored', back);
  return () => {
    sized.disconnect();
    canvas.removeEventListener('webglcontextlost', onLost);
    canvas.removeEventListener('webglcontextrestored', back);
  };
}
