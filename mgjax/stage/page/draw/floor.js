/** The floor with its grid, shadows on it, haze in the distance, and the background above. */

import { COLOUR, SHADOW, pointAttribute } from './gl.js';

const REACH = 400;

const FLOOR = `
in vec2 corner;
out vec3 place;
void main() {
  place = vec3(eye.x + corner.x * ${REACH}.0, 0.0, eye.z + corner.y * ${REACH}.0);
  gl_Position = toClip * vec4(place, 1.0);
}`;
const FLOOR_PAINT = `${COLOUR}${SHADOW}
in vec3 place;
uniform vec3 floorColour;
uniform vec3 fineColour;
uniform vec3 metreColour;
out vec4 pixel;
float grid(vec2 at, vec2 blur, float wide) {
  vec2 off = abs(fract(at - 0.5) - 0.5);
  vec2 line = clamp(wide + 0.5 - off / blur, 0.0, 1.0) * clamp(0.35 / blur, 0.0, 1.0);
  return max(line.x, line.y);
}
void main() {
  vec2 blur = fwidth(place.xz) + 1e-6;
  float far = smoothstep(eye.w, lights.w, distance(eye.xyz, place));
  if (far > 0.995) { pixel = vec4(haze.rgb, 1.0); return; }
  vec3 colour = mix(floorColour, fineColour, grid(place.xz * 4.0, blur * 4.0, 0.2));
  colour = mix(colour, metreColour, grid(place.xz, blur, 0.35));
  float sun = sunAt(place, vec3(0.0));
  colour *= 1.0 - light.w * (1.0 - sun);
  pixel = vec4(mix(colour, haze.rgb, far), 1.0);
}`;

/** The background: haze at the horizon, another colour above. */
const BEHIND = `
in vec2 corner;
uniform vec3 left;
uniform vec3 right;
uniform vec3 up;
out vec3 direction;
void main() {
  direction = mix(left, right, 0.5 + 0.5 * corner.x) + up * corner.y;
  gl_Position = vec4(corner, 1.0, 1.0);
}`;
const BEHIND_PAINT = `
in vec3 direction;
uniform vec3 above;
out vec4 pixel;
void main() {
  float rise = clamp(normalize(direction).y * 2.2, 0.0, 1.0);
  pixel = vec4(mix(haze.rgb, above, rise), 1.0);
}`;

/** Contact shadows: soft dark spots on the floor under what is near it. */
const SPOT = `
in vec2 corner;
in vec4 spot;  // x, z, radius (m), how dark
out vec2 at;
out float dark;
void main() {
  at = corner;
  dark = spot.w;
  gl_Position = toClip * vec4(spot.x + corner.x * spot.z, 0.0, spot.y + corner.y * spot.z, 1.0);
}`;
const SPOT_PAINT = `
in vec2 at;
in float dark;
out vec4 pixel;
void main() {
  float fade = max(0.0, 1.0 - dot(at, at));
  pixel = vec4(0.0, 0.0, 0.0, dark * fade * fade);
}`;

/** Draws floor and background; `kit` as of gl.js. */
export function createFloor(kit) {
  const { gl } = kit;
  const floor = kit.program(FLOOR, FLOOR_PAINT);
  const behind = kit.program(BEHIND, BEHIND_PAINT);
  const spot = kit.program(SPOT, SPOT_PAINT);
  const corners = kit.buffer();
  gl.bindBuffer(gl.ARRAY_BUFFER, corners);
  gl.bufferData(gl.ARRAY_BUFFER, new Float32Array([-1, -1, -1, 1, 1, -1, 1, 1]), gl.STATIC_DRAW);
  const [plane, wall, decals] = [floor, behind, spot].map((program) => {
    const array = kit.vertices();
    gl.bindVertexArray(array);
    gl.bindBuffer(gl.ARRAY_BUFFER, corners);
    pointAttribute(gl, program.attribute('corner'), 2);
    return array;
  });
  const spots = kit.buffer();
  gl.bindBuffer(gl.ARRAY_BUFFER, spots);
  pointAttribute(gl, spot.attribute('spot'), 4, { each: 1 });
  gl.bindVertexArray(null);

  return {
    floor(theme) {
      gl.useProgram(floor.id);
      gl.uniform3fv(floor.at('floorColour'), theme.floor);
      gl.uniform3fv(floor.at('fineColour'), theme.fine);
      gl.uniform3fv(floor.at('metreColour'), theme.metre);
      gl.uniform1i(floor.at('shadowMap'), 0);
      gl.bindVertexArray(plane);
      gl.drawArrays(gl.TRIANGLE_STRIP, 0, 4);
    },
    /** @param {number[]} numbers x, z, radius (m) and darkness of each spot */
    spots(numbers) {
      if (!numbers.length) return;
      gl.useProgram(spot.id);
      gl.bindVertexArray(decals);
      gl.bindBuffer(gl.ARRAY_BUFFER, spots);
      gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(numbers), gl.DYNAMIC_DRAW);
      gl.enable(gl.BLEND);
      gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, numbers.length / 4);
      gl.disable(gl.BLEND);
    },
    /** @param {object} corners directions of the picture's edges, of camera.js `edges` */
    background(theme, { left, right, up }) {
      gl.useProgram(behind.id);
      gl.uniform3fv(behind.at('left'), left);
      gl.uniform3fv(behind.at('right'), right);
      gl.uniform3fv(behind.at('up'), up);
      gl.uniform3fv(behind.at('above'), theme.above);
      gl.bindVertexArray(wall);
      gl.drawArrays(gl.TRIANGLE_STRIP, 0, 4);
    },
  };
}
