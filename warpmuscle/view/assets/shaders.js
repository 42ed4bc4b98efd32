// What runs on the graphics card. Vertices bring their mesh and their instance with them, and look up what moves in
// textures: the pose of their body, or the points of their muscle.

const ROW_BITS = 10, ROW = 1 << ROW_BITS; // texels
const HORIZON = [0.845, 0.875, 0.9], ZENITH = [0.7, 0.76, 0.81];
// What is behind and below bodies, by day or dark; the ground's own tone is dimmed.
const STAGES = [{ horizon: HORIZON, zenith: ZENITH, dim: 1 }, { horizon: [0.16, 0.18, 0.205], zenith: [0.075, 0.085, 0.1], dim: 0.3 }];
const stage = { ...STAGES[0] };

const LOOK_UP = `#version 300 es
precision highp float; precision highp int; precision highp sampler2D;
vec4 texel(sampler2D table, int k) { return texelFetch(table, ivec2(k & ${ROW - 1}, k >> ${ROW_BITS}), 0); }
vec3 turned(vec4 turn, vec3 v) { return v + 2.0 * cross(turn.xyz, cross(turn.xyz, v) + turn.w * v); }
vec3 turnedBack(vec4 turn, vec3 v) { return turned(vec4(-turn.xyz, turn.w), v); }
`;

// How light falls on a point. It is computed for each pixel, or for each corner where corners are near one another.
const LIGHT = `
uniform vec3 light; uniform vec3 eye; uniform float glass; uniform float shadow;
vec4 lit(vec3 at, vec3 normal, vec4 tint) {
  vec3 n = normalize(normal), v = normalize(eye - at);
  float day = max((dot(n, light) + 0.3) / 1.3, 0.0), sky = 0.5 + 0.5 * n.y, facing = abs(dot(n, v)); // light goes round edges
  float shine = pow(max(dot(n, normalize(light + v)), 0.0), 30.0);
  vec3 seen = tint.rgb * (0.5 + 0.2 * sky + 0.4 * day) + vec3(0.08 * shine);
  float rim = 1.0 - facing; // of glass the edges are seen most
  return vec4(seen, glass > 0.5 ? tint.a * (0.25 + 1.6 * rim * rim) : tint.a);
}
`;
const BY_PIXEL = "out vec3 at; out vec3 normal; out vec4 tint; void light_up() {}";
const BY_CORNER = `vec3 at; vec3 normal; vec4 tint; out vec4 shade;
void light_up() { shade = shadow > 0.5 ? vec4(0.10, 0.13, 0.18, 0.20) : lit(at, normal, tint); }`;
const PIXEL_FRAGMENT = `#version 300 es
precision highp float;
in vec3 at; in vec3 normal; in vec4 tint; out vec4 color;
${LIGHT}
void main() { color = lit(at, normal, tint); }`;
const CORNER_FRAGMENT = `#version 300 es
precision highp float;
in vec4 shade; out vec4 color;
void main() { color = shade; }`;

// An instance is four times four numbers: place in the body and its slot among the poses; turn; radii and length; colour as a
// number, and the radius at the upper end in that of the lower one.
const solidVertex = (lighting) => `${LOOK_UP} ${LIGHT} ${lighting}
layout(location = 0) in vec4 vertex; layout(location = 1) in vec4 faced; layout(location = 2) in vec4 place;
layout(location = 3) in vec4 turn; layout(location = 4) in vec4 size; layout(location = 5) in vec4 look;
uniform sampler2D poses; uniform int shift; uniform mat4 matrix; uniform vec4 ground;
uniform vec4 paint; uniform float facing_eye;
void main() {
  vec4 corner = vertex, outward = faced;
  int slot = 2 * (int(place.w) + (place.w > 0.0 ? shift : 0));
  vec3 body = texel(poses, slot).xyz;
  vec4 facing = texel(poses, slot + 1);
  float taper = corner.w > 0.0 ? look.y : 1.0;
  if (facing_eye > 0.5) { // about its axis towards the eye, or the light
    vec3 to = shadow > 0.5 ? light : eye - body - turned(facing, place.xyz);
    vec2 side = (turnedBack(turn, turnedBack(facing, to)) / max(size.xyz, vec3(1e-6))).xz;
    side /= max(length(side), 1e-6);
    corner.xz = vec2(corner.x * side.y + corner.z * side.x, corner.z * side.y - corner.x * side.x);
    outward.xz = vec2(outward.x * side.y + outward.z * side.x, outward.z * side.y - outward.x * side.x);
  }
  vec3 local = corner.xyz * size.xyz * taper + vec3(0.0, corner.w * size.w, 0.0);
  at = body + turned(facing, place.xyz + turned(turn, local));
  normal = turned(facing, turned(turn, outward.xyz / max(size.xyz, vec3(1e-6))));
  vec3 own = vec3(mod(floor(look.x / 65536.0), 256.0), mod(floor(look.x / 256.0), 256.0), mod(look.x, 256.0)) / 255.0;
  tint = paint.x < 0.0 ? vec4(own, paint.w) : paint;
  if (shadow > 0.5) at -= light * (dot(at, ground.xyz) - ground.w - 0.002) / dot(light, ground.xyz);
  light_up();
  gl_Position = matrix * vec4(at, 1.0);
}`;

// A stretch of a muscle between two of its points, whose fourth numbers say how far along the muscle they are. Of a
// muscle are known: radii of belly and tendon, activation, and the part of its length that is fibre.
const muscleVertex = (lighting) => `${LOOK_UP} ${LIGHT} ${lighting}
layout(location = 0) in vec4 ring; layout(location = 1) in vec4 stretch;
uniform sampler2D points; uniform sampler2D muscles; uniform mat4 matrix; uniform vec3 activation[5]; uniform vec3 tendon; uniform float chosen;
uniform float facing_eye;
vec3 way(vec3 from, vec3 to) { vec3 d = to - from; float l = length(d); return l > 1e-7 ? d / l : vec3(0.0); }
void main() {
  int first = int(stretch.x);
  vec4 a = texel(points, first), b = texel(points, first + 1), muscle = texel(muscles, int(stretch.y));
  vec3 along = way(a.xyz, b.xyz), bend = vec3(0.0);
  if (facing_eye < 0.5) {
    if (ring.x < 0.01 && stretch.z < 0.5) bend = way(texel(points, first - 1).xyz, a.xyz);
    if (ring.x > 0.99 && stretch.w < 0.5) bend = way(b.xyz, texel(points, first + 2).xyz);
  }
  vec3 axis = along + bend;
  axis = length(axis) > 1e-3 ? normalize(axis) : vec3(0.0, 1.0, 0.0);
  vec3 across = normalize(cross(axis, abs(axis.x) < 0.9 ? vec3(1.0, 0.0, 0.0) : vec3(0.0, 1.0, 0.0)));
  float part = 2.0 * (mix(a.w, b.w, ring.x) - 0.5) / muscle.w, bulge = max(1.0 - part * part, 0.0);
  float radius = mix(muscle.y, muscle.x, bulge);
  at = mix(a.xyz, b.xyz, ring.x);
  if (facing_eye > 0.5) across = normalize(cross(eye - at, axis)); // flat, towards the eye
  normal = ring.y * across + ring.z * cross(axis, across);
  at += radius * normal;
  if (facing_eye > 0.5) normal = 0.7 * normal + normalize(eye - at);
  float place = clamp(muscle.z, 0.0, 1.0) * 4.0;
  int k = min(int(place), 3);
  vec3 color = mix(activation[k], activation[k + 1], place - float(k));
  color = mix(tendon, color, smoothstep(0.02, 0.2, bulge));
  if (stretch.y == chosen) color = mix(color, vec3(1.0), 0.55);
  tint = vec4(color, 1.0);
  light_up();
  gl_Position = matrix * vec4(at, 1.0);
}`;

const GROUND_VERTEX = `#version 300 es
uniform mat4 matrix; uniform vec4 ground; uniform vec3 middle; out vec2 place;
void main() {
  vec3 corner = vec3(gl_VertexID % 2 * 2 - 1, 0, gl_VertexID / 2 * 2 - 1); // of a strip of two triangles
  vec2 p = corner.xz * 80.0 + floor(middle.xz);
  vec3 n = ground.xyz;
  vec3 at = vec3(p.x, (ground.w - n.x * p.x - n.z * p.y) / n.y, p.y);
  place = p;
  gl_Position = matrix * vec4(at, 1.0);
}`;
// Squares of 1 m, which fade where they would flicker; lines every 5 m.
const GROUND_FRAGMENT = `#version 300 es
precision highp float;
in vec2 place; uniform vec3 horizon; uniform vec3 middle; uniform float dim; out vec4 color;
void main() {
  vec2 width = max(fwidth(place), vec2(1e-4));
  vec2 wave = clamp((abs(fract(place * 0.5) - 0.5) - 0.25) * 2.0 / width, -1.0, 1.0);
  float calm = 1.0 - smoothstep(0.15, 0.6, max(width.x, width.y));
  float check = 0.5 + 0.5 * wave.x * wave.y * calm;
  vec2 line = abs(fract(place / 5.0 + 0.5) - 0.5) * 5.0;
  float bold = (1.0 - smoothstep(0.0, 1.0, min(line.x / width.x, line.y / width.y) - 0.5)) * calm;
  vec3 tone = mix(vec3(0.735, 0.765, 0.785), vec3(0.76, 0.788, 0.807), check) - 0.045 * bold;
  float fade = smoothstep(5.0, 26.0, length(place - middle.xz));
  color = vec4(mix(dim * tone, horizon, fade), 1.0);
}`;

const SKY_VERTEX = `#version 300 es
uniform float level; out float up;
void main() {
  up = gl_VertexID / 2 == 0 ? max(level, -1.0) : 1.0; // no more of the picture than lies above the horizon
  gl_Position = vec4(float(gl_VertexID % 2 * 2 - 1), up, 0.0, 1.0);
}`;
const SKY_FRAGMENT = `#version 300 es
precision highp float;
in float up; uniform float level; uniform vec3 horizon; uniform vec3 zenith; out vec4 color;
void main() { color = vec4(mix(horizon, zenith, smoothstep(level, level + 1.8, up)), 1.0); }`;

function makeProgram(gl, vertex, fragment) {
  const program = gl.createProgram();
  for (const [type, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
    const shader = gl.createShader(type);
    gl.shaderSource(shader, text);
    gl.compileShader(shader);
    gl.attachShader(program, shader);
  }
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program));
  const place = {};
  for (let i = 0; i < gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS); i++) {
    const name = gl.getActiveUniform(program, i).name.replace("[0]", "");
    place[name] = gl.getUniformLocation(program, name);
  }
  return { program, place };
}
