/** Programs, buffers and textures of one WebGL2 context, all freed at once. */

/** What every shader starts with: precision, and the numbers of the frame. */
export const HEAD = `#version 300 es
precision highp float;
precision highp int;
precision highp sampler2DShadow;
layout(std140) uniform Frame {
  mat4 toClip;      // world to clip
  mat4 toShadow;    // world to the shadow map, 0 … 1
  vec4 eye;         // m; w: distance at which the haze begins, m
  vec4 light;       // towards the light; w: how dark shadows are
  vec4 lights;      // from above, from below, from the sun; w: distance at which all is haze, m
  vec4 haze;        // colour of the background; w: breadth of a texel of the shadow map, m
  vec4 size;        // breadth and height of the picture, pixels; z: pixels of it in one of the page; w: taps of a shadow
};
`;

/** Numbers of `Frame`, in floats. */
export const FRAME_FLOATS = 16 + 16 + 4 * 5;

/** A context's resources: each maker keeps what it made, `free` deletes all of it. */
export function createKit(gl) {
  const made = new Map();
  const keep = (item, remove) => {
    made.set(item, remove);
    return item;
  };
  const kit = {
    gl,
    program: (vertex, fragment) => keep(link(gl, vertex, fragment), (p) => gl.deleteProgram(p.id)),
    buffer: () => keep(gl.createBuffer(), (b) => gl.deleteBuffer(b)),
    vertices: () => keep(gl.createVertexArray(), (v) => gl.deleteVertexArray(v)),
    texture: () => keep(gl.createTexture(), (t) => gl.deleteTexture(t)),
    framebuffer: () => keep(gl.createFramebuffer(), (f) => gl.deleteFramebuffer(f)),
    renderbuffer: () => keep(gl.createRenderbuffer(), (r) => gl.deleteRenderbuffer(r)),
    /** Deletes some of it. */
    drop(...items) {
      for (const item of items) {
        made.get(item)?.(item);
        made.delete(item);
      }
    },
    free() {
      kit.drop(...made.keys());
    },
  };
  return kit;
}

function link(gl, vertex, fragment) {
  const id = gl.createProgram();
  const shaders = [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]].map(([kind, text]) => {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, HEAD + text);
    gl.compileShader(shader);
    gl.attachShader(id, shader);
    return shader;
  });
  gl.linkProgram(id);
  if (!gl.getProgramParameter(id, gl.LINK_STATUS) && !gl.isContextLost()) {
    const reports = shaders.map((shader) => gl.getShaderInfoLog(shader));
    throw new Error(`a shader does not compile: ${[gl.getProgramInfoLog(id), ...reports].join(' ')}`);
  }
  shaders.forEach((shader) => gl.deleteShader(shader));
  const block = gl.getUniformBlockIndex(id, 'Frame');
  if (block !== gl.INVALID_INDEX) gl.uniformBlockBinding(id, block, 0);
  const names = new Map();
  return {
    id,
    at(name) {
      if (!names.has(name)) names.set(name, gl.getUniformLocation(id, name));
      return names.get(name);
    },
    attribute: (name) => gl.getAttribLocation(id, name),
  };
}

/**
 * Points an attribute of the bound vertex array at the bound buffer.
 * @param {object} options type, `whole` for integers of a shader, `unit` for shares of the type's
 *   range, stride and offset in bytes, `each` 1 for one value an instance
 */
export function pointAttribute(gl, at, count, options = {}) {
  const { type = gl.FLOAT, whole = false, unit = false, stride = 0, offset = 0, each = 0 } = options;
  if (at < 0) return;
  gl.enableVertexAttribArray(at);
  if (whole) gl.vertexAttribIPointer(at, count, type, stride, offset);
  else gl.vertexAttribPointer(at, count, type, unit, stride, offset);
  gl.vertexAttribDivisor(at, each);
}

/** Shaders' colours are linear inside and go to the screen by gamma 2, which costs no power. */
export const COLOUR = `
vec3 linear(vec3 shown) { return shown * shown; }
vec3 shown(vec3 linear) { return sqrt(clamp(linear, 0.0, 1.0)); }
`;

/** How much of the sun arrives at a place of the world: 0 in shadow … 1. */
export const SHADOW = `
uniform sampler2DShadow shadowMap;
float sunAt(vec3 place, vec3 normal) {
  if (size.w < 0.5) return 1.0;
  vec3 at = (toShadow * vec4(place + normal * haze.w * 1.5, 1.0)).xyz;
  if (any(lessThan(at, vec3(0.0))) || any(greaterThan(at, vec3(1.0)))) return 1.0;
  if (size.w < 1.5) return texture(shadowMap, at);
  vec2 texel = 1.5 / vec2(textureSize(shadowMap, 0));
  float sum = texture(shadowMap, at);
  for (int i = 0; i < 8; i++) {
    float turn = float(i) * 2.39996;
    vec2 shift = texel * sqrt(float(i) + 1.0) * vec2(cos(turn), sin(turn));
    sum += texture(shadowMap, vec3(at.xy + shift, at.z));
  }
  return sum / 9.0;
}
`;

/** A matt surface under the sky with a sun, and a brighter rim that parts it from what is behind. */
export const LIT = `${COLOUR}${SHADOW}
vec3 lit(vec3 colour, vec3 place, vec3 normal) {
  vec3 toEye = normalize(eye.xyz - place);
  float facing = dot(normal, light.xyz);
  float sun = facing <= 0.0 ? 0.0 : facing * sunAt(place, normal);
  float around = mix(lights.y, lights.x, 0.5 + 0.5 * normal.y);
  float soft = 0.12 * (0.5 + 0.5 * facing);
  float rim = pow(1.0 - max(0.0, dot(normal, toEye)), 3.0) * 0.16;
  return shown(linear(colour) * (around + soft + lights.z * sun) + rim * lights.x);
}
vec3 hazed(vec3 colour, vec3 place) {
  return mix(colour, haze.rgb, smoothstep(eye.w, lights.w, distance(eye.xyz, place)));
}
`;
