/** Skinned bodies: each vertex moves with up to four joints, whose matrices lie in a texture. */

import { LIT, pointAttribute } from './gl.js';
import { rgb } from '../look.js';

const ROW_TEXELS = 1024;

const SKIN = `
invariant gl_Position;
in vec3 place;
in vec3 normal;
in uvec4 joints;
in vec4 weights;
uniform highp sampler2D jointRows;
uniform int row;
out vec3 worldPlace;
out vec3 worldNormal;
void skin() {
  vec4 r0 = vec4(0.0), r1 = vec4(0.0), r2 = vec4(0.0);
  for (int i = 0; i < 4; i++) {
    if (weights[i] == 0.0) continue;
    int at = 3 * int(joints[i]);
    r0 += weights[i] * texelFetch(jointRows, ivec2(at, row), 0);
    r1 += weights[i] * texelFetch(jointRows, ivec2(at + 1, row), 0);
    r2 += weights[i] * texelFetch(jointRows, ivec2(at + 2, row), 0);
  }
  vec4 p = vec4(place, 1.0);
  worldPlace = vec3(dot(r0, p), dot(r1, p), dot(r2, p));
  worldNormal = vec3(dot(r0.xyz, normal), dot(r1.xyz, normal), dot(r2.xyz, normal));
}
`;
const SEEN = `${SKIN} void main() { skin(); gl_Position = toClip * vec4(worldPlace, 1.0); }`;
const SHADING = `${SKIN} void main() {
  skin();
  gl_Position = toShadow * vec4(worldPlace, 1.0);
  gl_Position.xyz = gl_Position.xyz * 2.0 - 1.0;
}`;
const PAINT = `${LIT}
in vec3 worldPlace;
in vec3 worldNormal;
uniform vec4 colour;
out vec4 pixel;
void main() {
  vec3 normal = normalize(worldNormal);
  vec3 painted = lit(colour.rgb, worldPlace, normal);
  float edge = 1.0 - abs(dot(normal, normalize(eye.xyz - worldPlace)));
  float cover = colour.a < 1.0 ? min(1.0, colour.a * (0.5 + 1.6 * edge * edge)) : 1.0;
  pixel = vec4(hazed(painted, worldPlace), cover);
}`;
const NOTHING = 'void main() {}';

/** Draws actors; `kit` as of gl.js. */
export function createBodies(kit) {
  const { gl } = kit;
  const paint = kit.program(SEEN, PAINT);
  const depth = kit.program(SEEN, NOTHING);
  const shade = kit.program(SHADING, NOTHING);
  const meshes = new Map();
  const rows = kit.texture();
  let height = 0;

  function room(count) {
    gl.activeTexture(gl.TEXTURE1);
    gl.bindTexture(gl.TEXTURE_2D, rows);
    if (count <= height) return;
    height = Math.max(16, 2 ** Math.ceil(Math.log2(count)));
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA32F, ROW_TEXELS, height, 0, gl.RGBA, gl.FLOAT, null);
    for (const side of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) {
      gl.texParameteri(gl.TEXTURE_2D, side, gl.NEAREST);
    }
  }

  function mesh(body) {
    if (!meshes.has(body)) meshes.set(body, upload(kit, paint, body.mesh));
    return meshes.get(body);
  }

  function drawOne(program, actor) {
    const { array, count } = mesh(actor.body);
    gl.bindVertexArray(array);
    gl.uniform1i(program.at('row'), actor.row);
    gl.drawElements(gl.TRIANGLES, count, gl.UNSIGNED_INT, 0);
  }

  function begin(program) {
    gl.useProgram(program.id);
    gl.uniform1i(program.at('jointRows'), 1);
    gl.uniform1i(program.at('shadowMap'), 0);
  }

  function colour(actor, alpha) {
    gl.uniform4f(paint.at('colour'), ...rgb(actor.colour), alpha);
  }

  return {
    /** Sends the poses; each actor gets its row. */
    prepare(actors, bodies) {
      const kept = new Set([...bodies, ...actors.map(({ body }) => body)]);
      for (const [body, { parts }] of meshes) {
        if (kept.has(body)) continue;
        kit.drop(...parts);
        meshes.delete(body);
      }
      room(actors.length);
      actors.forEach((actor, row) => {
        actor.row = row;
        gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, row, 3 * actor.body.count, 1, gl.RGBA, gl.FLOAT,
          actor.pose.rows);
      });
    },
    shadows(actors) {
      begin(shade);
      actors.forEach((actor) => drawOne(shade, actor));
    },
    solid(actors) {
      begin(paint);
      for (const actor of actors) {
        colour(actor, 1);
        drawOne(paint, actor);
      }
    },
    /** One translucent surface each, the farthest first: depth alone, then the nearest surface. */
    ghosts(actors) {
      for (const actor of actors) {
        gl.colorMask(false, false, false, false);
        begin(depth);
        drawOne(depth, actor);
        gl.colorMask(true, true, true, true);
        gl.enable(gl.BLEND);
        gl.depthFunc(gl.EQUAL);
        begin(paint);
        colour(actor, 0.42);
        drawOne(paint, actor);
        gl.depthFunc(gl.LEQUAL);
        gl.disable(gl.BLEND);
      }
    },
  };
}

function upload(kit, program, { places, normals, joints, weights, triangles }) {
  const { gl } = kit;
  const array = kit.vertices();
  const parts = [array];
  gl.bindVertexArray(array);
  const attribute = (name, data, count, options) => {
    const buffer = kit.buffer();
    parts.push(buffer);
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ARRAY_BUFFER, data, gl.STATIC_DRAW);
    pointAttribute(gl, program.attribute(name), count, options);
  };
  attribute('place', places, 3);
  attribute('normal', normals, 3, { type: gl.BYTE, unit: true });
  attribute('joints', joints, 4, { type: gl.UNSIGNED_SHORT, whole: true });
  attribute('weights', weights, 4, { type: gl.UNSIGNED_BYTE, unit: true });
  const index = kit.buffer();
  parts.push(index);
  gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, index);
  gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, triangles, gl.STATIC_DRAW);
  gl.bindVertexArray(null);
  return { array, count: triangles.length, parts };
}
