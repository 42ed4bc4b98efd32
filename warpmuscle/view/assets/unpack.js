// Numbers and arrays of the page, as `packing.py` wrote them.

async function inflate(text) {
  const packed = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

async function unpack(table, text) {
  const bytes = await inflate(text);
  let first = 0;
  return table.map((entry) => {
    const frames = entry.shape[0], columns = entry.low.length, count = frames * columns;
    const values = new Float32Array(count), wide = entry.bits > 8, mask = wide ? 65535 : 255, top = 2 ** entry.bits - 1;
    for (let c = 0; c < columns; c++) {
      let whole = 0;
      for (let f = 0; f < frames; f++) {
        const place = first + c * frames + f;
        whole = (whole + bytes[place] + (wide ? bytes[place + count] << 8 : 0)) & mask;
        values[f * columns + c] = entry.low[c] + (entry.width[c] * whole) / top;
      }
    }
    first += wide ? 2 * count : count;
    return values;
  });
}
