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

// Instances of one mesh, each some texels of a table.
class Batch {
  constructor(gl, { vertices, faces }, perVertex, perInstance) {
    Object.assign(this, { gl, faces, perInstance, count: 0, drawable: 0 });
    this.vertices = vertices.length / (4 * perVertex);
    this.mesh = new Table(gl, vertices.length / 4);
    this.mesh.numbers.set(vertices);
    this.mesh.send(vertices.length / 4);
    this.instances = new Table(gl, ROW);
    this.indices = gl.createBuffer();
  }

  push(...numbers) {
    const width = 4 * this.perInstance, room = this.instances.numbers.length / width;
    if (this.count >= room) this.instances.reserve(2 * room * this.perInstance);
    this.instances.numbers.set(numbers, width * this.count++);
  }

  clear() {
    this.count = 0;
  }

  send() {
    const { gl, vertices, faces } = this;
    this.instances.send(this.count * this.perInstance);
    if (this.count <= this.drawable) return;
    this.drawable = Math.max(this.count, 2 * this.drawable);
    const indices = new Uint32Array(faces.length * this.drawable);
    for (let i = 0, at = 0; i < this.drawable; i++)
      for (let k = 0; k < faces.length; k++) indices[at++] = faces[k] + i * vertices;
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, this.indices);
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, indices, gl.STATIC_DRAW);
  }

  // With the program in use whose places of uniforms are given, and tables that its vertices look into by name.
  draw(place, tables) {
    if (!this.count) return;
    const { gl } = this;
    this.mesh.bind(0, place.mesh);
    this.instances.bind(1, place.instances ?? place.stretches);
    Object.entries(tables).forEach(([name, table], k) => table.bind(2 + k, place[name]));
    gl.uniform1i(place.vertices, this.vertices);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, this.indices);
    gl.drawElements(gl.TRIANGLES, this.count * this.faces.length, gl.UNSIGNED_INT, 0);
  }
}
