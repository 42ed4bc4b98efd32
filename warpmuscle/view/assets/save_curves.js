// Curves to keep: as a picture, as a drawing that papers can print, and as numbers.

const SAVES = { PNG: savePng, SVG: saveSvg, CSV: saveCsv };

function savePng(plots, name) {
  const canvas = document.createElement("canvas"), { wide, tall } = plots.whole(), ratio = 2;
  Object.assign(canvas, { width: ratio * wide, height: ratio * tall });
  const pen = canvas.getContext("2d");
  pen.scale(ratio, ratio);
  pen.fillStyle = "#ffffff";
  pen.fillRect(0, 0, wide, tall);
  plots.drawWhole(pen);
  canvas.toBlob((blob) => blob && download(`${name}.png`, blob));
}

function saveSvg(plots, name) {
  const { wide, tall } = plots.whole(), pen = new SvgPen(wide, tall);
  plots.drawWhole(pen);
  download(`${name}.svg`, new Blob([pen.text()], { type: "image/svg+xml" }));
}

function saveCsv(plots, name) {
  const quoted = (text) => `"${text.replaceAll('"', '""').replace(/^([=+\-@])/, "'$1")}"`; // no formula for a spreadsheet
  const rows = plots.table().map((row) => row.map((cell) => (typeof cell === "number" ? (Number.isFinite(cell) ? `${Number(cell.toPrecision(6))}` : "") : quoted(cell))).join(","));
  download(`${name}.csv`, new Blob([`${rows.join("\n")}\n`], { type: "text/csv" }));
}

// What a canvas' pen does, as far as curves need it, written as SVG.
class SvgPen {
  constructor(wide, tall) {
    Object.assign(this, { wide, tall, parts: [], path: [], open: 0, dash: [], saved: [], globalAlpha: 1 });
  }

  save() {
    this.saved.push(this.open);
  }

  restore() {
    for (const before = this.saved.pop(); this.open > before; this.open--) this.parts.push("</svg>");
  }

  beginPath() {
    this.path = [];
  }

  lineTo(x, y) {
    this.path.push([x, y]);
  }

  // The only way that is clipped to.
  rect(x, y, w, h) {
    this.path = [[x, y], [x + w, y], [x + w, y + h], [x, y + h]];
  }

  clip() {
    const [[x, y], , [right, below]] = this.path, box = [x, y, right - x, below - y]; // a drawing within shows no more than its box
    this.parts.push(`<svg x="${x}" y="${y}" width="${box[2]}" height="${box[3]}" viewBox="${box.join(" ")}">`);
    this.open++;
  }

  setLineDash(dash) {
    this.dash = dash;
  }

  way() {
    return this.path.map(([x, y], k) => `${k ? "L" : "M"}${x.toFixed(2)} ${y.toFixed(2)}`).join("");
  }

  stroke() {
    const dash = this.dash.length ? ` stroke-dasharray="${this.dash.join(" ")}"` : "";
    this.parts.push(`<path d="${this.way()}" fill="none" stroke="${this.strokeStyle}" stroke-width="${this.lineWidth}"${dash}/>`);
  }

  fill() {
    this.parts.push(`<path d="${this.way()}Z" fill="${this.fillStyle}" fill-opacity="${this.globalAlpha}"/>`);
  }

  fillText(text, x, y) {
    const safe = text.replace(/[&<>"]/g, (letter) => `&#${letter.charCodeAt(0)};`), anchor = { left: "start", right: "end", center: "middle" }[this.textAlign];
    this.parts.push(`<text x="${x.toFixed(2)}" y="${y.toFixed(2)}" text-anchor="${anchor}" fill="${this.fillStyle}">${safe}</text>`);
  }

  measureText(text) {
    return { width: 6.1 * text.length };
  }

  text() {
    return `<svg xmlns="http://www.w3.org/2000/svg" width="${this.wide}" height="${this.tall}" viewBox="0 0 ${this.wide} ${this.tall}" font-family="system-ui, sans-serif" font-size="11">${this.parts.join("")}</svg>`;
  }
}
