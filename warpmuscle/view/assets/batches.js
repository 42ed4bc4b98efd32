// Tables on the graphics card, and batches of instances that look into them.

// Numbers in texels of four, which are never filtered.
class Table {
  constructor(gl, texels) {
    this.gl = gl;
    this.texture = gl.createTexture();
    this.rows = 0;
    this.reserve(texels);
    gl.bindTexture(gl.TEXTURE_2D, this.texture);
    for (const name of ["TEXTURE_MIN_FILTER", "TEXTURE_MAG_FILTER"])
      gl.texParameteri(gl.TEXTURE_2D, gl[name], gl.NEAREST);
  }

  // Room for so many texels; what is there stays.
  reserve(texels) {
    const rows = Math.max(1, Math.ceil(texels / ROW));
    if (this.numbers && rows * ROW * 4 <= this.numbers.length) return;
    const wider = new Float32Array(rows * ROW * 4);
    if (this.numbers) wider.set(this.numbers);
    this.numbers = wider;
  }

  // Bring the first texels to the card.
  send(texels) {
    const { gl, numbers } = this, all = numbers.length / (4 * ROW), rows = Math.min(all, Math.ceil(texels / ROW));
    gl.bindTexture(gl.TEXTURE_2D, this.texture);
    if (this.rows !== all) gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA32F, ROW, all, 0, gl.RGBA, gl.FLOAT, numbers);
    else if (rows)
      gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, ROW, rows, gl.RGBA, gl.FLOAT, numbers.subarray(0, rows * 4 * ROW));
    this.rows = all;
  }

  bind(unit, place) {
    this.gl.activeTexture(this.gl.TEXTURE0 + unit);
    this.gl.bindTexture(this.gl.TEXTURE_2D, this.texture);
    this.gl.uniform1i(place, unit);
  }
}

// Instances of one shape, some vertices of four numbers each. The shape has meshes of several levels of detail, finest
// first; a flat one has only the side that is turned to the eye. A batch is one plain draw, in which every vertex has the
// numbers of its instance: without a graphics card, an instance of an instanced draw costs as much as a hundred triangles,
// and a look into a texture as much as all the rest of a vertex.
class Batch {
  constructor(gl, meshes, perVertex, perInstance) {
    Object.assign(this, { gl, perVertex, perInstance, count: 0, version: 0, numbers: new Float32Array(64 * perInstance) });
    this.meshes = meshes.map(({ vertices, faces, flat = false }) => {
      const state = gl.createVertexArray(), corners = gl.createBuffer(), indices = gl.createBuffer();
      gl.bindVertexArray(state);
      gl.bindBuffer(gl.ARRAY_BUFFER, corners);
      for (let k = 0; k < perVertex + perInstance; k++) {
        gl.enableVertexAttribArray(k);
        gl.vertexAttribPointer(k, 4, gl.FLOAT, false, 16 * (perVertex + perInstance), 16 * k);
      }
      gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, indices);
      gl.bindVertexArray(null);
      return { vertices, faces, flat, state, corners, indices, room: 0, version: -1 };
    });
  }

  push(...numbers) {
    const width = 4 * this.perInstance;
    if (this.numbers.length <= width * this.count) {
      const wider = new Float32Array(2 * this.numbers.length);
      wider.set(this.numbers);
      this.numbers = wider;
    }
    this.numbers.set(numbers, width * this.count++);
    this.version++;
  }

  clear() {
    this.count = 0;
    this.version++;
  }

  // Bind the mesh of a level of detail with all instances as they are now.
  bind(level) {
    const { gl, count, perVertex, perInstance } = this, mesh = this.meshes[Math.min(level, this.meshes.length - 1)];
    gl.bindVertexArray(mesh.state);
    if (mesh.version === this.version) return mesh;
    const own = 4 * perVertex, width = 4 * perInstance, corners = mesh.vertices.length / own;
    const all = new Float32Array(count * corners * (own + width));
    for (let i = 0, at = 0; i < count; i++)
      for (let k = 0; k < corners; k++) {
        for (let n = 0; n < own; n++) all[at++] = mesh.vertices[own * k + n];
        for (let n = 0; n < width; n++) all[at++] = this.numbers[width * i + n];
      }
    gl.bindBuffer(gl.ARRAY_BUFFER, mesh.corners);
    gl.bufferData(gl.ARRAY_BUFFER, all, gl.DYNAMIC_DRAW);
    mesh.version = this.version;
    if (count > mesh.room) this.index(mesh, corners);
    return mesh;
  }

  index(mesh, corners) {
    const { gl } = this, { faces } = mesh;
    mesh.room = Math.max(this.count, 2 * mesh.room);
    const indices = new Uint32Array(faces.length * mesh.room);
    for (let i = 0, at = 0; i < mesh.room; i++)
      for (let k = 0; k < faces.length; k++) indices[at++] = faces[k] + i * corners;
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, indices, gl.STATIC_DRAW);
  }

  // With the program in use whose places of uniforms are given.
  draw(place, level) {
    if (!this.count) return;
    const { gl } = this, mesh = this.bind(level);
    gl.uniform1f(place.facing_eye, Number(mesh.flat));
    gl.drawElements(gl.TRIANGLES, this.count * mesh.faces.length, gl.UNSIGNED_INT, 0);
    gl.bindVertexArray(null);
  }
}

// Solids of different shapes in one draw: with many, each draw costs as much as hundreds of triangles.
class Mixture {
  constructor(gl, perVertex, perInstance) {
    Object.assign(this, { gl, perVertex, perInstance, items: [], levels: [] });
  }

  get count() {
    return this.items.length;
  }

  // A solid with its meshes, finest first, and its numbers.
  add(meshes, numbers) {
    this.items.push({ meshes, numbers });
    this.levels = [];
  }

  clear() {
    this.items = [];
    this.levels = [];
  }

  // All solids as they are at a level of detail, as one mesh that has one instance.
  merged(level) {
    const vertices = [], faces = [], own = 4 * this.perVertex;
    for (const { meshes, numbers } of this.items) {
      const mesh = meshes[Math.min(level, meshes.length - 1)], first = vertices.length / (own + numbers.length);
      for (let at = 0; at < mesh.vertices.length; at += own) vertices.push(...mesh.vertices.slice(at, at + own), ...numbers);
      for (const corner of mesh.faces) faces.push(first + corner);
    }
    const batch = new Batch(this.gl, [{ vertices, faces }], this.perVertex + this.perInstance, 0);
    batch.count = 1;
    return batch;
  }

  draw(place, level) {
    if (this.count) (this.levels[level] ??= this.merged(level)).draw(place, 0);
  }
}
