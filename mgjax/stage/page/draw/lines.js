/** Lines with a width in pixels and round ends, whole or dashed, and sheets of netting. */

import { COLOUR, pointAttribute } from './gl.js';

const FLOATS = 5;
const STRIDE = 4 * FLOATS;

/**
 * A segment as a rectangle of the screen. Its corners are given without perspective, so that
 * pixels are measured straight; metres along it are carried with their depth.
 */
const SEGMENT = `
in vec2 corner;
in vec3 from;
in vec2 fromMore;  // metres along, share of the width
in vec3 to;
in vec2 toMore;
uniform float width;
uniform float lift;
out vec2 at;        // pixels along and across
out float span;     // pixels from end to end
out vec3 along;     // metres along, share of the width, 1: each by depth
void main() {
  vec4 a = toClip * vec4(from + vec3(0.0, lift, 0.0), 1.0);
  vec4 b = toClip * vec4(to + vec3(0.0, lift, 0.0), 1.0);
  vec2 moreA = fromMore, moreB = toMore;
  const float near = 0.05;
  if (a.w < near && b.w < near) { gl_Position = vec4(2.0, 2.0, 2.0, 1.0); return; }
  if (a.w < near) { float s = (near - a.w) / (b.w - a.w); a = mix(a, b, s); moreA = mix(moreA, moreB, s); }
  if (b.w < near) { float s = (near - b.w) / (a.w - b.w); b = mix(b, a, s); moreB = mix(moreB, moreA, s); }
  vec2 pa = a.xy / a.w * size.xy * 0.5, pb = b.xy / b.w * size.xy * 0.5;
  span = distance(pa, pb);
  vec2 direction = span > 1e-3 ? (pb - pa) / span : vec2(1.0, 0.0);
  float half_ = 0.5 * width * size.z + 1.0;
  float end = corner.x < 0.0 ? 0.0 : 1.0;
  at = vec2(end * span + corner.x * half_, corner.y * half_);
  vec2 p = mix(pa, pb, end) + direction * corner.x * half_ + vec2(-direction.y, direction.x) * corner.y * half_;
  float depth = mix(a.z / a.w, b.z / b.w, end) - 2e-4;
  vec2 more = mix(moreA / a.w, moreB / b.w, end);
  along = vec3(more, mix(1.0 / a.w, 1.0 / b.w, end));
  gl_Position = vec4(p / (size.xy * 0.5), depth, 1.0);
}`;
const SEGMENT_PAINT = `
in vec2 at;
in float span;
in vec3 along;
uniform float width;
uniform vec3 colour;
uniform float dash;
out vec4 pixel;
void main() {
  float radius = 0.5 * width * size.z * along.y / along.z;
  float beyond = max(max(-at.x, at.x - span), 0.0);
  float cover = clamp(radius + 0.5 - length(vec2(beyond, at.y)), 0.0, 1.0);
  float metres = along.x / along.z;
  if (dash > 0.0) {
    float blur = max(fwidth(metres) / dash, 1e-5);
    float wave = abs(fract(metres / dash) - 0.5) * 2.0;
    cover *= clamp((wave - 0.42) / (2.0 * blur) + 0.5, 0.0, 1.0);
  }
  if (cover < 0.01) discard;
  pixel = vec4(colour, cover);
}`;

const SHEET = `
in vec2 corner;
uniform vec3 from;
uniform vec3 to;
out vec2 metres;
void main() {
  vec3 top = mix(from, to, 0.5 + 0.5 * corner.x);
  float share = 0.5 + 0.5 * corner.y;
  metres = vec2((0.5 + 0.5 * corner.x) * distance(from.xz, to.xz), share * top.y);
  gl_Position = toClip * vec4(top.x, share * top.y, top.z, 1.0);
}`;
const SHEET_PAINT = `${COLOUR}
in vec2 metres;
uniform vec3 colour;
out vec4 pixel;
void main() {
  vec2 blur = fwidth(metres / 0.1) + 1e-6;
  vec2 off = abs(fract(metres / 0.1 - 0.5) - 0.5);
  vec2 line = clamp(0.9 - off / blur, 0.0, 1.0) * clamp(0.3 / blur, 0.0, 1.0);
  pixel = vec4(colour, 0.10 + 0.55 * max(line.x, line.y));
}`;

/** Numbers of a polyline: place, metres from its start, share of its width. Points [x,y,z,…], m. */
export function polyline(points, shares = null) {
  const count = points.length / 3;
  const numbers = new Float32Array(FLOATS * count);
  let along = 0;
  for (let i = 0; i < count; i += 1) {
    if (i > 0) {
      along += Math.hypot(...[0, 1, 2].map((k) => points[3 * i + k] - points[3 * i - 3 + k]));
    }
    for (let k = 0; k < 3; k += 1) numbers[FLOATS * i + k] = points[3 * i + k];
    numbers[FLOATS * i + 3] = along;
    numbers[FLOATS * i + 4] = shares ? shares[i] : 1;
  }
  return numbers;
}

/** Draws lines and nets; `kit` as of gl.js. */
export function createLines(kit) {
  const { gl } = kit;
  const program = kit.program(SEGMENT, SEGMENT_PAINT);
  const sheet = kit.program(SHEET, SHEET_PAINT);
  const corners = kit.buffer();
  gl.bindBuffer(gl.ARRAY_BUFFER, corners);
  gl.bufferData(gl.ARRAY_BUFFER, new Float32Array([-1, -1, 1, -1, -1, 1, 1, 1]), gl.STATIC_DRAW);
  const flat = kit.vertices();
  gl.bindVertexArray(flat);
  pointAttribute(gl, sheet.attribute('corner'), 2);
  const array = kit.vertices();
  gl.bindVertexArray(array);
  pointAttribute(gl, program.attribute('corner'), 2);
  const points = kit.buffer();
  gl.bindBuffer(gl.ARRAY_BUFFER, points);
  const each = (name, count, offset) => pointAttribute(gl, program.attribute(name), count,
    { stride: STRIDE, offset, each: 1 });
  each('from', 3, 0);
  each('fromMore', 2, 12);
  each('to', 3, STRIDE);
  each('toMore', 2, STRIDE + 12);
  gl.bindVertexArray(null);

  return {
    /** @param {object[]} lines each with numbers (of `polyline`), colour [r,g,b], width, dashed */
    draw(lines, { lift = 0 } = {}) {
      if (!lines.length) return;
      gl.useProgram(program.id);
      gl.bindVertexArray(array);
      gl.bindBuffer(gl.ARRAY_BUFFER, points);
      gl.enable(gl.BLEND);
      gl.uniform1f(program.at('lift'), lift);
      for (const { numbers, colour, width, dashed } of lines) {
        const segments = numbers.length / FLOATS - 1;
        if (segments < 1) continue;
        gl.bufferData(gl.ARRAY_BUFFER, numbers, gl.DYNAMIC_DRAW);
        gl.uniform3fv(program.at('colour'), colour);
        gl.uniform1f(program.at('width'), width);
        gl.uniform1f(program.at('dash'), dashed ? 0.24 : 0);
        gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, segments);
      }
      gl.disable(gl.BLEND);
    },
    /** @param {object[]} nets each with from, to (the upper edge, m) and colour [r,g,b] */
    nets(nets) {
      if (!nets.length) return;
      gl.useProgram(sheet.id);
      gl.bindVertexArray(flat);
      gl.enable(gl.BLEND);
      for (const { from, to, colour } of nets) {
        gl.uniform3fv(sheet.at('from'), from);
        gl.uniform3fv(sheet.at('to'), to);
        gl.uniform3fv(sheet.at('colour'), colour);
        gl.drawArrays(gl.TRIANGLE_STRIP, 0, 4);
      }
      gl.disable(gl.BLEND);
    },
  };
}
