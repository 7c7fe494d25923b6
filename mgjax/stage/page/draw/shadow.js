/** The sun's depth map: what lies in shadow, around all that casts one. */

import { add, lookAt, multiply, normalize, orthographic, scale } from '../math.js';

/** Towards the sun: high, so that shadows stay near the feet. */
export const SUN = normalize([0.38, 1, 0.3]);

const HALF = [0.5, 0, 0, 0, 0, 0.5, 0, 0, 0, 0, 0.5, 0, 0.5, 0.5, 0.5, 1];

/** Keeps the map; `kit` as of gl.js. */
export function createShadow(kit) {
  const { gl } = kit;
  const texture = kit.texture();
  const framebuffer = kit.framebuffer();
  let side = 0;

  function resize(size) {
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, texture);
    if (size === side) return;
    side = size;
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.DEPTH_COMPONENT24, size, size, 0, gl.DEPTH_COMPONENT,
      gl.UNSIGNED_INT, null);
    for (const [name, value] of [
      [gl.TEXTURE_MIN_FILTER, gl.LINEAR], [gl.TEXTURE_MAG_FILTER, gl.LINEAR],
      [gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE], [gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE],
      [gl.TEXTURE_COMPARE_MODE, gl.COMPARE_REF_TO_TEXTURE], [gl.TEXTURE_COMPARE_FUNC, gl.LEQUAL],
    ]) gl.texParameteri(gl.TEXTURE_2D, name, value);
    gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.TEXTURE_2D, texture, 0);
  }

  return {
    /**
     * Draws the map.
     * @param {number} size pixels a side; 0: none, the map then stands empty
     * @param {{centre: number[], radius: number}} around a ball around all casters, m
     * @param {() => void} drawCasters
     */
    draw(size, drawCasters) {
      resize(Math.max(1, size));
      if (!size) return;
      gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
      gl.viewport(0, 0, size, size);
      gl.clear(gl.DEPTH_BUFFER_BIT);
      gl.enable(gl.POLYGON_OFFSET_FILL);
      gl.polygonOffset(2, 4);
      drawCasters();
      gl.disable(gl.POLYGON_OFFSET_FILL);
    },
  };
}

/**
 * World to the shadow map, 0 … 1; it moves by whole texels so that edges do not swim.
 * @returns {{matrix: number[], texel: number}} texel in m
 */
export function shadowFrame({ centre, radius }, size) {
  const half = Math.ceil(radius * 2) / 2 + 0.3;
  const texel = (2 * half) / Math.max(1, size);
  const turn = lookAt(SUN, [0, 0, 0]);
  const at = [0, 1, 2].map((k) => turn[k] * centre[0] + turn[4 + k] * centre[1] + turn[8 + k] * centre[2]);
  const [x, y] = at.slice(0, 2).map((value) => Math.round(value / texel) * texel);
  const view = [...turn];
  view[12] = -x;
  view[13] = -y;
  view[14] = -at[2] - half * 2;
  const clip = multiply(orthographic(half, 0, half * 4), view);
  return { matrix: multiply(HALF, clip), texel };
}

/** A ball around places with their radii, m: [[x, y, z, radius], …]. */
export function ballAround(places) {
  if (!places.length) return { centre: [0, 0, 0], radius: 1 };
  const low = [0, 1, 2].map((k) => Math.min(...places.map((p) => p[k] - p[3])));
  const high = [0, 1, 2].map((k) => Math.max(...places.map((p) => p[k] + p[3])));
  const centre = scale(add(low, high), 0.5);
  return { centre, radius: Math.hypot(...[0, 1, 2].map((k) => (high[k] - low[k]) / 2)) };
}
