// The surface of water: a disc about what is looked at, through which all below it is seen.

const WATER_VERTEX = `#version 300 es
precision highp float;
uniform mat4 matrix; uniform vec3 middle; uniform float level; out vec2 place;
void main() {
  place = 40.0 * vec2(float(gl_VertexID % 2) * 2.0 - 1.0, float(gl_VertexID / 2) * 2.0 - 1.0);
  gl_Position = matrix * vec4(place.x + middle.x, level, place.y + middle.z, 1.0);
}`;
const WATER_FRAGMENT = `#version 300 es
precision mediump float;
in vec2 place; out vec4 color;
void main() { color = vec4(0.30, 0.56, 0.76, 0.36 * (1.0 - smoothstep(5.0, 26.0, length(place)))); }`;

class Water {
  constructor(gl) {
    Object.assign(this, { gl, program: makeProgram(gl, WATER_VERTEX, WATER_FRAGMENT) });
  }

  // After all that is opaque; it hides nothing.
  draw(matrix, middle, level) {
    const { gl, program: { program, place } } = this;
    gl.useProgram(program);
    gl.uniformMatrix4fv(place.matrix, false, matrix);
    gl.uniform3fv(place.middle, middle);
    gl.uniform1f(place.level, level);
    gl.disable(gl.CULL_FACE);
    gl.enable(gl.BLEND);
    gl.depthMask(false);
    gl.drawArrays(gl.TRIANGLE_STRIP, 0, 4);
    gl.depthMask(true);
    gl.disable(gl.BLEND);
    gl.enable(gl.CULL_FACE);
  }
}
