/** One picture: shadow map, floor, what stands on it, ghosts; into any size, with smooth edges. */

import { createBodies } from './bodies.js';
import { createFloor } from './floor.js';
import { createKit, FRAME_FLOATS } from './gl.js';
import { createLines } from './lines.js';
import { ballAround, createShadow, shadowFrame, SUN } from './shadow.js';
import { createSolids } from './solids.js';

/** Everything that is drawn by one WebGL2 context. */
export function createRenderer(gl) {
  const kit = createKit(gl);
  const frame = kit.buffer();
  const numbers = new Float32Array(FRAME_FLOATS);
  gl.bindBuffer(gl.UNIFORM_BUFFER, frame);
  gl.bufferData(gl.UNIFORM_BUFFER, numbers.byteLength, gl.DYNAMIC_DRAW);
  gl.bindBufferBase(gl.UNIFORM_BUFFER, 0, frame);
  gl.enable(gl.DEPTH_TEST);
  gl.depthFunc(gl.LEQUAL);
  gl.enable(gl.CULL_FACE);
  gl.blendFuncSeparate(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA, gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
  const bodies = createBodies(kit);
  const floor = createFloor(kit);
  const lines = createLines(kit);
  const solids = createSolids(kit);
  const shadow = createShadow(kit);
  const smooth = createSmooth(kit);

  function setFrame({ camera, theme, width, height, ratio, quality }, { matrix, texel }) {
    numbers.set(camera.toClip, 0);
    numbers.set(matrix, 16);
    const begin = camera.distance * 1.5 + 6;
    numbers.set([...camera.eye, begin], 32);
    numbers.set([...SUN, theme.shadow], 36);
    numbers.set([theme.sky, theme.ground, theme.sun, begin * 3.2], 40);
    numbers.set([...theme.haze, texel], 44);
    numbers.set([width, height, ratio, quality.shadow ? quality.taps : 0], 48);
    gl.bindBuffer(gl.UNIFORM_BUFFER, frame);
    gl.bufferSubData(gl.UNIFORM_BUFFER, 0, numbers);
  }

  function drawWorld({ actors, ghosts, spots, floorLines, airLines, nets }, { theme, camera }) {
    gl.disable(gl.CULL_FACE);
    floor.floor(theme);
    gl.depthMask(false);
    gl.disable(gl.DEPTH_TEST);
    floor.spots(spots);
    lines.draw(floorLines);
    gl.enable(gl.DEPTH_TEST);
    floor.background(theme, camera.edges());
    gl.depthMask(true);
    gl.enable(gl.CULL_FACE);
    bodies.solid(actors);
    solids.draw();
    gl.disable(gl.CULL_FACE);
    gl.depthMask(false);
    lines.draw(airLines);
    lines.nets(nets);
    gl.depthMask(true);
    gl.enable(gl.CULL_FACE);
    bodies.ghosts(ghosts);
  }

  return {
    /**
     * Draws into the canvas, which is width by height pixels.
     * @param {object} view camera, theme, width, height, ratio (its pixels in one of the page),
     *   quality {shadow: side of the map, taps, samples}
     * @param {object} scene lists as of scene.js `drawn`
     */
    draw(view, scene) {
      const { quality, width, height } = view;
      const everyone = [...scene.actors, ...scene.ghosts];
      bodies.prepare(everyone, scene.bodies);
      solids.prepare(scene.solids);
      setFrame(view, shadowFrame(ballAround(scene.casters), quality.shadow));
      shadow.draw(quality.shadow, () => {
        bodies.shadows(scene.actors);
        solids.shadows();
      });
      smooth.begin(width, height, quality.samples);
      gl.viewport(0, 0, width, height);
      gl.clear(gl.DEPTH_BUFFER_BIT);
      drawWorld(scene, view);
      smooth.end(width, height);
      gl.bindVertexArray(null);
    },
    free: () => kit.free(),
  };
}

/** Several samples a pixel, in a buffer of its own so that it can be turned off when slow. */
function createSmooth(kit) {
  const { gl } = kit;
  const most = gl.getParameter(gl.MAX_SAMPLES);
  let now = '';
  let framebuffer = null;
  let parts = [];

  function make(width, height, samples) {
    kit.drop(...parts);
    const [colour, depth] = [kit.renderbuffer(), kit.renderbuffer()];
    framebuffer = kit.framebuffer();
    parts = [framebuffer, colour, depth];
    gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
    for (const [buffer, format, place] of [
      [colour, gl.RGBA8, gl.COLOR_ATTACHMENT0], [depth, gl.DEPTH_COMPONENT24, gl.DEPTH_ATTACHMENT],
    ]) {
      gl.bindRenderbuffer(gl.RENDERBUFFER, buffer);
      gl.renderbufferStorageMultisample(gl.RENDERBUFFER, samples, format, width, height);
      gl.framebufferRenderbuffer(gl.FRAMEBUFFER, place, gl.RENDERBUFFER, buffer);
    }
  }

  return {
    begin(width, height, wanted) {
      const samples = Math.min(most, wanted);
      if (samples < 2) {
        kit.drop(...parts);
        [parts, framebuffer, now] = [[], null, ''];
      } else if (now !== `${width} ${height} ${samples}`) {
        make(width, height, samples);
        now = `${width} ${height} ${samples}`;
      }
      gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
    },
    end(width, height) {
      if (!framebuffer) return;
      gl.bindFramebuffer(gl.READ_FRAMEBUFFER, framebuffer);
      gl.bindFramebuffer(gl.DRAW_FRAMEBUFFER, null);
      gl.blitFramebuffer(0, 0, width, height, 0, 0, width, height, gl.COLOR_BUFFER_BIT, gl.NEAREST);
      gl.invalidateFramebuffer(gl.READ_FRAMEBUFFER, [gl.COLOR_ATTACHMENT0, gl.DEPTH_ATTACHMENT]);
      gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    },
  };
}
