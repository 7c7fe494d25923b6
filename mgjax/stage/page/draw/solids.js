/** Balls, capsules and cylinders, many at once: each from one point to another with a radius. */

import { LIT, pointAttribute } from './gl.js';

const FLOATS = 11;
const AROUND = 24;
const CAP = 7;

const PLACED = `
in vec3 offset;
in vec3 normal;
in float end;
in vec3 from;
in vec3 to;
in float radius;
in vec4 colour;
out vec3 worldPlace;
out vec3 worldNormal;
out vec4 paint;
mat3 frame() {
  vec3 along = to - from;
  float span = length(along);
  vec3 z = span > 1e-6 ? along / span : vec3(0.0, 1.0, 0.0);
  vec3 x = normalize(cross(abs(z.y) < 0.9 ? vec3(0.0, 1.0, 0.0) : vec3(1.0, 0.0, 0.0), z));
  return mat3(x, cross(z, x), z);
}
void put() {
  mat3 turn = frame();
  worldPlace = mix(from, to, end) + radius * (turn * offset);
  worldNormal = turn * normal;
  paint = colour;
}
`;
const SEEN = `${PLACED} void main() { put(); gl_Position = toClip * vec4(worldPlace, 1.0); }`;
const SHADING = `${PLACED} void main() {
  put();
  gl_Position = toShadow * vec4(worldPlace, 1.0);
  gl_Position.xyz = gl_Position.xyz * 2.0 - 1.0;
}`;
const PAINT = `${LIT}
in vec3 worldPlace;
in vec3 worldNormal;
in vec4 paint;
out vec4 pixel;
void main() {
  vec3 colour = lit(paint.rgb, worldPlace, normalize(worldNormal));
  pixel = vec4(hazed(colour, worldPlace), paint.a);
}`;

/** Rings of a surface around z: offset, normal and end of each; cylinder caps are flat. */
function rings(flat) {
  const list = [];
  const ring = (out, up, side, slope, end) => list.push({ out, up, side, slope, end });
  if (flat) {
    ring(0, 0, 0, -1, 0);
    ring(1, 0, 0, -1, 0);
    ring(1, 0, 1, 0, 0);
    ring(1, 0, 1, 0, 1);
    ring(1, 0, 0, 1, 1);
    ring(0, 0, 0, 1, 1);
    return list;
  }
  for (let i = 0; i <= 2 * CAP + 1; i += 1) {
    const angle = (Math.PI / 2) * (i <= CAP ? i / CAP - 1 : (i - CAP - 1) / CAP);
    const [c, s] = [Math.cos(angle), Math.sin(angle)];
    ring(c, s, c, s, i <= CAP ? 0 : 1);
  }
  return list;
}

function surface(flat) {
  const list = rings(flat);
  const numbers = [];
  const index = [];
  for (const { out, up, side, slope, end } of list) {
    for (let i = 0; i <= AROUND; i += 1) {
      const turn = (2 * Math.PI * i) / AROUND;
      const [c, s] = [Math.cos(turn), Math.sin(turn)];
      numbers.push(out * c, out * s, up, side * c, side * s, slope, end);
    }
  }
  const row = AROUND + 1;
  for (let r = 0; r + 1 < list.length; r += 1) {
    for (let i = 0; i < AROUND; i += 1) {
      const at = r * row + i;
      index.push(at, at + 1, at + row + 1, at, at + row + 1, at + row);
    }
  }
  return { numbers: new Float32Array(numbers), index: new Uint16Array(index) };
}

/** Draws solids; `kit` as of gl.js. */
export function createSolids(kit) {
  const { gl } = kit;
  const paint = kit.program(SEEN, PAINT);
  const shade = kit.program(SHADING, 'void main() {}');
  const shapes = [createShape(kit, paint, false), createShape(kit, paint, true)];

  function drawAll(program) {
    gl.useProgram(program.id);
    gl.uniform1i(program.at('shadowMap'), 0);
    for (const shape of shapes) {
      if (!shape.count) continue;
      gl.bindVertexArray(shape.array);
      gl.drawElementsInstanced(gl.TRIANGLES, shape.size, gl.UNSIGNED_SHORT, 0, shape.count);
    }
  }

  return {
    /** @param {object[]} solids each with from, to, radius (m), colour [r,g,b] and flat */
    prepare(solids) {
      for (const [flat, shape] of shapes.entries()) {
        const mine = solids.filter((solid) => Boolean(solid.flat) === Boolean(flat));
        const numbers = new Float32Array(FLOATS * mine.length);
        mine.forEach(({ from, to, radius, colour }, i) => {
          numbers.set([...from, ...to, radius, ...colour, 1], FLOATS * i);
        });
        shape.count = mine.length;
        gl.bindBuffer(gl.ARRAY_BUFFER, shape.instances);
        gl.bufferData(gl.ARRAY_BUFFER, numbers, gl.DYNAMIC_DRAW);
      }
    },
    shadows: () => drawAll(shade),
    draw: () => drawAll(paint),
  };
}

function createShape(kit, program, flat) {
  const { gl } = kit;
  const { numbers, index } = surface(flat);
  const array = kit.vertices();
  gl.bindVertexArray(array);
  const [vertices, order, instances] = [kit.buffer(), kit.buffer(), kit.buffer()];
  gl.bindBuffer(gl.ARRAY_BUFFER, vertices);
  gl.bufferData(gl.ARRAY_BUFFER, numbers, gl.STATIC_DRAW);
  const own = (name, count, offset) => pointAttribute(gl, program.attribute(name), count,
    { stride: 28, offset });
  own('offset', 3, 0);
  own('normal', 3, 12);
  own('end', 1, 24);
  gl.bindBuffer(gl.ARRAY_BUFFER, instances);
  const each = (name, count, offset) => pointAttribute(gl, program.attribute(name), count,
    { stride: 4 * FLOATS, offset, each: 1 });
  each('from', 3, 0);
  each('to', 3, 12);
  each('radius', 1, 24);
  each('colour', 4, 28);
  gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, order);
  gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, index, gl.STATIC_DRAW);
  gl.bindVertexArray(null);
  return { array, size: index.length, instances, count: 0 };
}
