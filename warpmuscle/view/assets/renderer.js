// A picture of all bipeds: ground, shadows, solids, muscles, and what is translucent.

const FEW = 4; // bipeds up to which all is drawn finely
const MIN_DETAIL = 0.8; // of the finest one; fewer pixels look poor and gain little, as corners are what costs
const LAYERS = ["flesh", "bone", "near_flesh", "near_bone", "tendon", "surface", "shape", "object", "device"];
const NEAR_LAYERS = { flesh: "near_flesh", bone: "near_bone" }; // of bodies coloured as a whole through which muscles are seen
// From rest to full activation: blue, violet, red, in equal steps of Ottosson's Oklab (2020), each lighter than the last, and
// told apart without red or green cones, too.
// Equal steps to the eye, told apart without one kind of cones, too, and none dark: blue to red, or to yellow, much lighter.
const ACTIVATIONS = [[[0.187, 0.412, 0.811], [0.481, 0.413, 0.719], [0.683, 0.39, 0.598], [0.856, 0.336, 0.436], [1, 0.253, 0.144]], [[0.2, 0.36, 0.68], [0.388, 0.502, 0.633], [0.585, 0.628, 0.558], [0.789, 0.746, 0.435], [1.0, 0.86, 0.12]]];
const TENDON = [0.95, 0.95, 0.97];
const GHOST = [0.25, 0.62, 0.5, 0.3], SURFACE = [0.3, 0.55, 0.75, 0.35], SHAPE = [0.45, 0.45, 0.5, 0.35];
const THROUGH = 0.45, NEAR_GLASS = 0.75; // opacities
const OWN = (alpha) => [-1, 0, 0, alpha];

class Renderer {
  constructor(canvas, ground, bipeds) {
    const slow = isSoftware(), options = { antialias: !slow, stencil: true, alpha: false };
    const gl = canvas.getContext("webgl2", options);
    if (!gl) throw new Error("This browser has no WebGL 2, which the viewer needs.");
    Object.assign(this, { gl, canvas, ground, slow, light: unit([-0.45, 1.0, 0.35]) });
    this.finest = Math.min(window.devicePixelRatio || 1, slow ? 1 : 2); // pixels drawn a pixel of the page
    this.still = slow ? 2 : this.finest; // where nothing moves
    this.detail = this.finest;
    this.spared = 0; // 1: shadows, 2: skin, too, while it moves
    const lightings = [[BY_PIXEL, PIXEL_FRAGMENT], [BY_CORNER, CORNER_FRAGMENT]];
    const [solids, muscles] = [solidVertex, muscleVertex].map((vertex) =>
      lightings.map(([lighting, fragment]) => makeProgram(gl, vertex(lighting), fragment)));
    this.programs = { solids, muscles };
    this.floor = slow ? new Floor(gl) : makeProgram(gl, GROUND_VERTEX, GROUND_FRAGMENT);
    this.sky = makeProgram(gl, SKY_VERTEX, SKY_FRAGMENT);
    this.fine = bipeds <= FEW; // many are small in the picture, and triangles are what they cost
    this.poses = new Table(gl, 2);
    this.points = new Table(gl, 1);
    this.muscles = new Table(gl, 1);
    this.poses.numbers.set([0, 0, 0, 0, 0, 0, 0, 1]); // slot 0: the world
    this.used = { slots: 1, points: 0, muscles: 0 };
    this.chosen = -1;
    this.yellow = false; // whether full activation is yellow rather than red
    this.shaded = ""; // what bodies are coloured by, in place of muscles
    this.shade = () => null;
    this.makeMeshes();
  }

  // Meshes for a picture of what stands still, and for one of many a second that a processor draws.
  makeMeshes() {
    const { gl, fine } = this, solid = (...meshes) => new Batch(gl, meshes, 2, 4);
    const limbs = fine ? [limbMesh(5, 18), limbMesh(2, 8)] : [limbMesh(2, 5), flatLimbMesh()];
    const bones = fine ? [limbMesh(3, 10), limbMesh(1, 6)] : [limbMesh(1, 4), bandMesh(0.8)];
    const tubes = (above) => (fine ? [36, 20] : [10, 5]).map((sectors) => tubeMesh(sectors, above));
    this.layers = {};
    for (const name of LAYERS)
      this.layers[name] = { limb: solid(...(["bone", "near_bone", "tendon"].includes(name) ? bones : limbs)), tube: solid(...tubes(1)), box: solid(boxMesh()), hull: new Mixture(gl, 2, 4) };
    this.marks = { tube: solid(tubeMesh(fine ? 18 : 5), bandMesh()), cone: solid(...tubes(0)), limb: solid(...limbs) };
    this.path = solid(tubeMesh(fine ? 5 : 3), bandMesh());
    const along = fine ? [[18, 6], [8, 4], [3, 2]] : [[5, 3], [2], [2]], around = fine ? [9, 4] : [2, 2];
    const rings = (counts) => counts.map((count, level) => stretchMesh(count, around[level]));
    this.stretches = along.map((counts) => new Batch(gl, rings(counts), 1, 1)); // of muscles of few or many stretches
  }

  // Room for the bodies, points and muscles of a biped; returns where they begin.
  reserve(bodies, points, muscles) {
    const first = { ...this.used };
    this.used = { slots: first.slots + bodies, points: first.points + points, muscles: first.muscles + muscles };
    this.points.reserve(this.used.points + 1);
    this.muscles.reserve(this.used.muscles);
    this.poses.reserve(4 * this.used.slots); // once more for ghosts
    return first;
  }

  // What a second pose of a body is behind its first.
  get shift() {
    return this.used.slots - 1;
  }

  // Add a solid to a layer; `kind` is "limb", "tube", "box", or "hull", whose mesh is given.
  addSolid(layer, kind, mesh, slot, position, turn, size, color, taper) {
    const batch = this.layers[layer][kind], numbers = [...position, slot, ...turn, ...size, packed(color), taper, 0, 0];
    if (kind === "hull") batch.add(this.slow ? [mesh, coarseMesh(mesh)] : [mesh], numbers);
    else batch.push(...numbers);
  }

  addStretch(point, muscle, first, last, stretches) {
    this.stretches[stretches <= 2 ? 0 : stretches <= 6 ? 1 : 2].push(point, muscle, Number(first), Number(last));
  }

  mark(kind, position, turn, size, color, taper = 1) {
    this.marks[kind].push(...position, 0, ...turn, ...size, packed(color), taper, 0, 0);
  }

  // A polyline as a tube.
  addPath(points, radius, color) {
    for (let k = 1; k < points.length; k++) {
      const along = minus(points[k], points[k - 1]), length = norm(along);
      if (length < 1e-6) continue;
      const size = [radius, 1, radius, length];
      this.path.push(...times(add(points[k], points[k - 1]), 0.5), 0, ...turnFromY(along), ...size, packed(color), 1, 0, 0);
    }
  }

  clearFigures() {
    for (const layer of Object.values(this.layers)) for (const batch of Object.values(layer)) batch.clear();
    this.stretches.forEach((batch) => batch.clear());
  }

  clearMarks() {
    for (const batch of Object.values(this.marks)) batch.clear();
  }

  // Number of instances by what they are.
  counts() {
    const total = (group) => Object.values(group).reduce((sum, batch) => sum + batch.count, 0);
    const layers = Object.entries(this.layers).map(([name, layer]) => [name, total(layer)]);
    return { ...Object.fromEntries(layers), muscles: total(this.stretches), marks: total(this.marks), path: this.path.count };
  }

  // Draw fewer pixels while pictures take too long, then no shadows, then no skin that muscles are seen through; and more
  // again where there is time. What stands still has all of it. Interval in ms.
  adapt(interval) {
    this.mean = this.mean === undefined ? interval : 0.9 * this.mean + 0.1 * Math.min(interval, 100);
    this.age = (this.age || 0) + 1;
    if (this.age < 12) return;
    const factor = this.mean > 1000 / 31 ? 0.88 : this.mean < 1000 / 50 ? 1.06 : 1;
    const least = MIN_DETAIL * this.finest;
    if (factor < 1 && this.detail <= least) this.spared = Math.min(this.spared + Number(this.slow), 2);
    else if (factor > 1 && this.spared) this.spared--;
    else this.detail = Math.min(Math.max(factor * this.detail, least), this.finest);
    if (factor !== 1) this.age = 0;
  }

  resize(still) {
    const { canvas } = this, detail = still ? this.still : this.detail;
    this.level = Number(this.slow && !still);
    const width = Math.round(canvas.clientWidth * detail), height = Math.round(canvas.clientHeight * detail);
    if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
    return width / Math.max(height, 1);
  }

  send() {
    const { slots, points, muscles } = this.used;
    this.poses.send(4 * slots);
    this.points.send(points + 1);
    this.muscles.send(muscles);
  }

  // Draw what `shown` says in parts of the picture, each as it is seen through a matrix by an eye near a middle.
  draw(views, shown) {
    const gl = this.gl, { canvas } = this;
    this.send();
    gl.clearColor(1, 1, 1, 1); // what lies between parts
    gl.clear(gl.COLOR_BUFFER_BIT);
    gl.enable(gl.SCISSOR_TEST);
    for (const { matrix, eye, at, box } of views) {
      const [left, top, wide, tall] = box, { width, height } = canvas;
      const [x0, x1] = [left, left + wide].map((part) => Math.round(part * width));
      const [y0, y1] = [1 - top - tall, 1 - top].map((part) => Math.round(part * height));
      gl.viewport(x0, y0, x1 - x0, y1 - y0);
      gl.scissor(x0, y0, x1 - x0, y1 - y0);
      gl.clearColor(...stage.horizon, 1);
      gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT | gl.STENCIL_BUFFER_BIT);
      this.drawView(matrix, eye, at, shown);
    }
    gl.disable(gl.SCISSOR_TEST);
  }

  drawView(matrix, eye, middle, shown) {
    const gl = this.gl, { flesh, bone, near_flesh, near_bone, tendon, surface, shape, object, device } = this.layers;
    const muscles = shown.muscles && this.stretches.some((b) => b.count);
    gl.enable(gl.DEPTH_TEST);
    gl.disable(gl.CULL_FACE);
    gl.depthFunc(gl.LEQUAL);
    gl.blendFuncSeparate(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA, gl.ZERO, gl.ONE);
    if (this.ground.visible) {
      this.drawSky(matrix, eye, middle);
      this.drawGround(matrix, middle);
    }
    gl.enable(gl.CULL_FACE); // all else is closed, or faces the eye
    const { programs } = this, lighting = Number(this.level > 0);
    if (muscles) this.drawMuscles(programs.muscles[lighting], matrix, eye);
    const spared = this.level ? this.spared : 0;
    if (this.ground.visible && !spared && (shown.flesh || shown.bones)) this.drawShadows(shown.flesh ? [flesh, near_flesh] : [bone, near_bone], matrix, eye, middle);
    this.solid = this.begin(programs.solids[lighting], matrix, eye, { poses: this.poses });
    if (shown.bones) this.drawSolids(this.shaded && shown.flesh ? [near_bone] : [bone, near_bone], OWN(1));
    if (muscles) this.drawSolids([tendon], OWN(1));
    this.drawSolids([object, device, this.marks, ...(shown.path ? [{ path: this.path }] : [])], OWN(1));
    const opaque = this.shaded || (!muscles && !(this.fine && shown.bones)); // what is inside is to be seen
    if (shown.flesh && opaque) this.drawSolids([flesh], OWN(1));
    gl.enable(gl.BLEND);
    if (shown.shapes) this.drawGlass([shape], SHAPE);
    if (shown.surfaces) this.drawGlass([surface], SURFACE);
    if (shown.flesh) this.drawGlass([near_flesh], OWN(NEAR_GLASS), true);
    if (shown.flesh && !opaque && spared < 2) this.drawGlass([flesh], OWN(this.fine ? 0.2 : 0.42));
    if (this.fine) this.drawThrough({ tube: this.marks.tube, cone: this.marks.cone });
    if (shown.desired) {
      gl.uniform1i(this.solid.place.shift, this.shift);
      this.drawGlass([flesh], GHOST);
      gl.uniform1i(this.solid.place.shift, 0);
    }
    gl.disable(gl.BLEND);
    this.drawWater(matrix, middle);
  }

  begin({ program, place }, matrix, eye, tables) {
    const gl = this.gl;
    gl.useProgram(program);
    Object.entries(tables).forEach(([name, table], k) => table.bind(k, place[name]));
    gl.uniformMatrix4fv(place.matrix, false, matrix);
    gl.uniform3fv(place.light, this.light);
    gl.uniform3fv(place.eye, eye);
    gl.uniform1f(place.shadow, 0);
    gl.uniform1f(place.glass, 0);
    gl.uniform1i(place.shift, 0);
    return { program, place };
  }

  drawSolids(groups, paint) {
    this.gl.uniform4f(this.solid.place.paint, ...paint);
    for (const group of groups)
      for (const batch of Object.values(group)) batch.draw(this.solid.place, this.level);
  }

  // Only the front of it, and its edges most, where it is large.
  drawGlass(groups, paint, large = this.fine) {
    const gl = this.gl;
    if (large && !this.level) {
      gl.colorMask(false, false, false, false);
      this.drawSolids(groups, paint);
      gl.colorMask(true, true, true, true);
    }
    gl.uniform1f(this.solid.place.glass, Number(large));
    this.drawSolids(groups, paint);
    gl.uniform1f(this.solid.place.glass, 0);
  }

  // What lies behind others, too, faintly: a force runs along the leg that it acts on.
  drawThrough(group) {
    const gl = this.gl;
    gl.disable(gl.DEPTH_TEST);
    this.drawSolids([group], OWN(THROUGH));
    gl.enable(gl.DEPTH_TEST);
  }

  drawMuscles(program, matrix, eye) {
    const gl = this.gl, { place } = this.begin(program, matrix, eye, { points: this.points, muscles: this.muscles });
    gl.uniform3fv(place.activation, ACTIVATIONS[Number(this.yellow)].flat());
    gl.uniform3fv(place.tendon, TENDON);
    gl.uniform1f(place.chosen, this.chosen);
    this.stretches.forEach((batch) => batch.draw(place, this.level));
  }

  // Each pixel once, however many shapes lie above it.
  drawShadows(layers, matrix, eye, middle) {
    const gl = this.gl;
    this.solid = this.begin(this.programs.solids[1], matrix, eye, { poses: this.poses });
    gl.uniform4f(this.solid.place.ground, ...shadowPlane(this.ground, middle));
    gl.uniform1f(this.solid.place.shadow, 1);
    gl.enable(gl.BLEND);
    gl.enable(gl.STENCIL_TEST);
    gl.stencilFunc(gl.EQUAL, 0, 255);
    gl.stencilOp(gl.KEEP, gl.KEEP, gl.INCR);
    gl.enable(gl.POLYGON_OFFSET_FILL); // the ground is wide, and its depth not exact everywhere
    gl.polygonOffset(-1, -64);
    gl.depthMask(false);
    this.drawSolids([...layers, this.layers.object], OWN(1));
    gl.depthMask(true);
    gl.disable(gl.POLYGON_OFFSET_FILL);
    gl.disable(gl.STENCIL_TEST);
    gl.disable(gl.BLEND);
  }

  // Behind all, darker from the horizon upwards.
  drawSky(matrix, eye, middle) {
    const gl = this.gl, { program, place } = this.sky, along = minus(middle, eye);
    const far = onScreen(matrix, add(eye, times(unit([along[0], 0, along[2]]), 1e4)), 2, 2), level = far ? 1 - far[1] : 9;
    if (level >= 1) return;
    gl.disable(gl.DEPTH_TEST);
    gl.useProgram(program);
    gl.uniform3fv(place.horizon, stage.horizon);
    gl.uniform3fv(place.zenith, stage.zenith);
    gl.uniform1f(place.level, level);
    gl.drawArrays(gl.TRIANGLE_STRIP, 0, 4);
    gl.enable(gl.DEPTH_TEST);
  }

  drawWater(matrix, middle) {
    if (this.ground.water === null || this.ground.water === undefined) return;
    this.water ??= new Water(this.gl);
    this.water.draw(matrix, middle, this.ground.water);
  }

  drawGround(matrix, middle) {
    if (this.terrainOf !== this.ground) {
      this.terrain?.free();
      this.terrain = this.ground.terrain?.length ? new Terrain(this.gl, this.ground.terrain) : null;
      this.terrainOf = this.ground;
    }
    if (this.terrain) return void this.terrain.draw(matrix, middle, this.light);
    if (this.slow) return void this.floor.draw(matrix, middle, this.ground);
    const gl = this.gl, { program, place } = this.floor;
    gl.useProgram(program);
    gl.uniformMatrix4fv(place.matrix, false, matrix);
    gl.uniform4f(place.ground, ...this.ground.normal, this.ground.height);
    gl.uniform3fv(place.middle, middle);
    gl.uniform3fv(place.horizon, stage.horizon);
    gl.uniform1f(place.dim, stage.dim);
    gl.drawArrays(gl.TRIANGLE_STRIP, 0, 4);
  }
}

// A colour of three parts up to 1 as one number.
function packed(color) {
  const [r, g, b] = color.map((part) => Math.round(255 * part));
  return 65536 * r + 256 * g + b;
}

// Whether WebGL is computed without a graphics card, where smooth edges cost too much.
function isSoftware() {
  const gl = document.createElement("canvas").getContext("webgl2"), info = gl && gl.getExtension("WEBGL_debug_renderer_info");
  const name = info ? gl.getParameter(info.UNMASKED_RENDERER_WEBGL) : "";
  if (gl) gl.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|software|basic render/i.test(name);
}
