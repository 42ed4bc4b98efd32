// A picture of all batches: ground, shadows, solids, and what is translucent.

const FEW = 4; // bipeds up to which all is drawn finely

class Renderer {
  constructor(canvas, ground, bipeds) {
    const slow = isSoftware(), options = { antialias: !slow, stencil: true, alpha: false };
    const gl = canvas.getContext("webgl2", options);
    if (!gl) throw new Error("This browser has no WebGL 2, which the replay needs.");
    this.finest = Math.min(window.devicePixelRatio || 1, slow ? 1 : 2); // pixels drawn a pixel of the page
    this.detail = this.finest;
    this.gl = gl;
    this.canvas = canvas;
    this.ground = ground;
    this.light = unit([-0.45, 1.0, 0.35]);
    this.solid = makeProgram(gl, SOLID_VERTEX, SOLID_FRAGMENT);
    this.floor = makeProgram(gl, GROUND_VERTEX, GROUND_FRAGMENT);
    this.fine = bipeds <= FEW; // many are small in the picture, and triangles are what they cost
    const meshes = this.fine
      ? { sphere: sphereMesh(8, 12), cylinder: tubeMesh(14, 1), box: boxMesh() }
      : { sphere: sphereMesh(4, 7), cylinder: tubeMesh(6, 1), box: boxMesh() };
    const thin = this.fine
      ? { sphere: sphereMesh(5, 8), cylinder: tubeMesh(7, 1), cone: tubeMesh(10, 0) }
      : { sphere: sphereMesh(4, 6), cylinder: tubeMesh(3, 1), cone: tubeMesh(6, 0) };
    const batches = (kinds) => Object.fromEntries(Object.entries(kinds).map(([k, mesh]) => [k, new Batch(gl, mesh)]));
    this.batches = { body: batches(meshes), lines: batches(thin), glass: batches(meshes) };
    this.paths = []; // batches of one instance
  }

  clear() {
    for (const group of Object.values(this.batches)) for (const batch of Object.values(group)) batch.count = 0;
    this.paths = [];
  }

  // A polyline as one batch, to be pushed to `paths` whenever it is to be seen.
  makePath(points, radius, color) {
    const corners = [], faces = [], sectors = this.fine ? 5 : 3;
    points.forEach((p, k) => {
      const turn = turnFromY(minus(points[Math.min(k + 1, points.length - 1)], points[Math.max(k - 1, 0)]));
      for (let j = 0; j <= sectors; j++) {
        const b = (2 * Math.PI * j) / sectors, out = rotate(turn, [Math.cos(b), 0, Math.sin(b)]);
        corners.push(...add(p, times(out, radius)), ...out);
        const i = k * (sectors + 1) + j;
        if (k && j) faces.push(i - sectors - 2, i - 1, i - sectors - 1, i - sectors - 1, i - 1, i);
      }
    });
    const batch = new Batch(this.gl, { corners, faces });
    batch.add([0, 0, 0], [0, 0, 0, 1], [1, 1, 1], color, 1);
    batch.send();
    return batch;
  }

  // Number of instances by group of batches.
  counts() {
    const total = (group) => Object.values(group).reduce((sum, batch) => sum + batch.count, 0);
    const counts = Object.entries(this.batches).map(([name, group]) => [name, total(group)]);
    return { ...Object.fromEntries(counts), paths: this.paths.length };
  }

  // Draw fewer pixels while pictures take too long, and more again where there is time; interval in ms.
  adapt(interval) {
    this.mean = this.mean === undefined ? interval : 0.9 * this.mean + 0.1 * Math.min(interval, 100);
    this.age = (this.age || 0) + 1;
    if (this.age < 12) return;
    const factor = this.mean > 1000 / 31 ? 0.88 : this.mean < 1000 / 50 ? 1.06 : 1;
    this.detail = Math.min(Math.max(factor * this.detail, 0.5 * this.finest), this.finest);
    if (factor !== 1) this.age = 0;
  }

  resize(still) {
    const { canvas } = this, detail = still ? this.finest : this.detail;
    const width = Math.round(canvas.clientWidth * detail), height = Math.round(canvas.clientHeight * detail);
    if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
    return width / Math.max(height, 1);
  }

  draw(matrix, eye, middle) {
    const gl = this.gl, { body, lines, glass } = this.batches, all = (group) => Object.values(group);
    for (const group of [body, lines, glass]) all(group).forEach((batch) => batch.count && batch.send());
    gl.viewport(0, 0, this.canvas.width, this.canvas.height);
    gl.clearColor(...BACKGROUND, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT | gl.STENCIL_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    gl.depthFunc(gl.LEQUAL);
    if (this.ground.visible) this.drawGround(matrix, middle);
    gl.useProgram(this.solid.program);
    const { place } = this.solid;
    gl.uniformMatrix4fv(place.matrix, false, matrix);
    gl.uniform3fv(place.light, this.light);
    gl.uniform3fv(place.eye, eye);
    gl.uniform4f(place.ground, ...this.ground.normal, this.ground.height);
    gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
    if (this.ground.visible) {
      gl.uniform1f(place.shadow, 1); // each pixel once, however many shapes lie above it
      gl.enable(gl.BLEND);
      gl.enable(gl.STENCIL_TEST);
      gl.stencilFunc(gl.EQUAL, 0, 255);
      gl.stencilOp(gl.KEEP, gl.KEEP, gl.INCR);
      gl.enable(gl.POLYGON_OFFSET_FILL); // the ground is wide, and its depth not exact everywhere
      gl.polygonOffset(-1, -64);
      gl.depthMask(false);
      [...all(body), ...all(glass)].forEach((batch) => batch.draw(place));
      gl.depthMask(true);
      gl.disable(gl.POLYGON_OFFSET_FILL);
      gl.disable(gl.STENCIL_TEST);
      gl.disable(gl.BLEND);
    }
    gl.uniform1f(place.shadow, 0);
    [...all(body), ...all(lines), ...this.paths].forEach((batch) => batch.draw(place));
    if (this.fine) {
      gl.colorMask(false, false, false, false); // of what is translucent only the front
      all(glass).forEach((batch) => batch.draw(place));
      gl.colorMask(true, true, true, true);
    }
    gl.enable(gl.BLEND);
    all(glass).forEach((batch) => batch.draw(place));
    gl.disable(gl.BLEND);
  }

  drawGround(matrix, middle) {
    const gl = this.gl, { program, place } = this.floor;
    gl.useProgram(program);
    gl.uniformMatrix4fv(place.matrix, false, matrix);
    gl.uniform4f(place.ground, ...this.ground.normal, this.ground.height);
    gl.uniform3fv(place.middle, middle);
    gl.uniform3fv(place.background, BACKGROUND);
    gl.drawArrays(gl.TRIANGLE_STRIP, 0, 4);
  }
}

// Whether WebGL is computed without a graphics card, where smooth edges cost too much.
function isSoftware() {
  const gl = document.createElement("canvas").getContext("webgl2"), info = gl && gl.getExtension("WEBGL_debug_renderer_info");
  const name = info ? gl.getParameter(info.UNMASKED_RENDERER_WEBGL) : "";
  if (gl) gl.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|software|basic render/i.test(name);
}
