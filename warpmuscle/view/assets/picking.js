// Names: what is under the pointer, a muscle or a body, and labels over bipeds.

const NEAR = 7; // px from a muscle
const PICKED = 4; // bipeds nearest to the pointer that are looked at
const FEW_WHOLE_LABELS = 4; // up to which a label stays in the picture where its biped leaves it
const AT_TOP = 60; // px; what begins above lies over the heads of bipeds
const EDGE = 3; // px, that labels keep from the edges of their picture
const FEW_LABELS = 16; // beyond which only the chosen biped has one

// What is nearest to a place in a picture of some size: biped, muscle or body, and a name; null if nothing is there.
function pick(bipeds, matrix, width, height, x, y, shown) {
  const screen = (array, at) => onScreen(matrix, [array[at], array[at + 1], array[at + 2]], width, height);
  const away = (biped) => {
    const at = screen(biped.renderer.poses.numbers, 8 * biped.first.slots);
    return at ? Math.hypot(at[0] - x, at[1] - y) : Infinity;
  };
  const near = bipeds.map((biped) => [away(biped), biped]).sort((a, b) => a[0] - b[0]).slice(0, PICKED);
  let found = null;
  const offer = (pixels, depth, what) => {
    if (pixels <= 0 && (!found || depth < found.depth)) found = { depth, ...what };
  };
  if (shown.muscles) for (const [, biped] of near.filter(([, one]) => one.muscled)) offerMuscles(biped, screen, x, y, offer);
  if (!found) for (const [, biped] of near) offerBodies(biped, screen, x, y, offer);
  return found;
}

function offerMuscles(biped, screen, x, y, offer) {
  const { start } = biped, points = biped.renderer.points.numbers, from = 4 * biped.first.points;
  const places = Array.from({ length: start[biped.names.length] }, (_, k) => screen(points, from + 4 * k));
  const unknown = biped.arrays.routed ? [] : biped.routes; // which are not drawn
  for (let m = 0; m < biped.names.length; m++)
    for (let k = unknown.includes(m) ? start[m + 1] : start[m] + 1; k < start[m + 1]; k++)
      if (places[k] && places[k - 1])
        offer(fromStretch(places[k - 1], places[k], x, y) - NEAR, places[k][2], { biped, muscle: m, name: biped.names[m] });
}

function offerBodies(biped, screen, x, y, offer) {
  const poses = biped.renderer.poses.numbers;
  for (const piece of biped.doll.pieces) {
    if (piece.layer !== "flesh") continue;
    const at = 8 * (biped.first.slots + piece.body), size = piece.reach ?? Math.max(...(piece.radii ?? [0.05]));
    const world = (p) => add([poses[at], poses[at + 1], poses[at + 2]], rotate(Array.from(poses.slice(at + 4, at + 8)), p));
    const [a, b] = (piece.start ? [piece.start, piece.end] : [piece.position ?? piece.middle, piece.position ?? piece.middle]).map(world);
    const [p, q, edge] = [screen(a, 0), screen(b, 0), screen(add(a, [0, size, 0]), 0)];
    if (p && q && edge)
      offer(fromStretch(p, q, x, y) - Math.hypot(edge[0] - p[0], edge[1] - p[1]), p[2], { biped, body: piece.body, name: biped.doll.names[piece.body] });
  }
}

// Distance of a place on the screen from a stretch between two others.
function fromStretch(a, b, x, y) {
  const dx = b[0] - a[0], dy = b[1] - a[1], square = dx * dx + dy * dy;
  const part = square > 0 ? Math.min(Math.max(((x - a[0]) * dx + (y - a[1]) * dy) / square, 0), 1) : 0;
  return Math.hypot(a[0] + part * dx - x, a[1] + part * dy - y);
}

// The names of several bipeds, over their heads.
const STANDING = 0.9; // m, height of the centre of mass of a body of 75 kg that stands

// What stands over a motion: what it is called and, once it has failed, how and when.
function labelOf({ label, ended, until }, time) {
  return ended && time >= (until ?? -Infinity) ? `${label}: ${ended}` : label;
}

// How much of the top of the picture tools and legend cover between two places from its left, px.
function covered(left, right) {
  return Math.max(...["tools", "legend"].map((name) => {
    const { offsetTop: top, offsetLeft: from, offsetWidth: wide, offsetHeight: tall } = document.getElementById(name);
    return top < AT_TOP && right >= from && left <= from + wide ? top + tall : 0;
  }));
}

class Labels {
  constructor(player) {
    this.player = player;
    this.elements = player.bipeds.length < 2 && !player.bipeds[0]?.ended ? [] : player.bipeds.map((biped) => {
      const label = document.getElementById("labels").appendChild(document.createElement("span"));
      label.textContent = biped.label;
      return label;
    });
  }

  draw(views) {
    const { bipeds, selected, shown, time } = this.player;
    const placed = this.elements.flatMap((label, k) => {
      label.hidden = !shown.labels || (bipeds.length > FEW_LABELS && k !== selected);
      if (label.hidden) return [];
      const biped = bipeds[k], text = labelOf(biped, time);
      if (label.textContent !== text) label.textContent = text;
      const above = biped.com(biped.moment(time)), tall = biped.doll.scale;
      const up = above[1] - groundHeight(this.player.renderer.ground, above[0], above[2]); // little of who has fallen
      above[1] += 0.85 * tall * Math.min(Math.max(up / (STANDING * tall), 0.3), 1);
      const { matrix, pixels } = views[k] ?? views[0], at = onScreen(matrix, above, pixels[2], pixels[3]);
      label.hidden = !at || (bipeds.length > FEW_WHOLE_LABELS && !isWithin(at, pixels[2], pixels[3]));
      label.classList.toggle("chosen", k === selected);
      return label.hidden ? [] : [{ label, at, pixels, depth: k === selected ? 0 : at[2] }];
    });
    this.spread(placed.sort((a, b) => a.depth - b.depth));
  }

  // Put labels where there is room, the chosen one and near ones first: of few, one goes above what it would cover; of more,
  // it is left out.
  spread(placed) {
    const taken = [], few = this.elements.length <= FEW_WHOLE_LABELS;
    const within = (value, low, high) => Math.min(Math.max(value, low), Math.max(low, high));
    for (const { label, at, pixels: [x, y, width, height] } of placed) {
      const half = 0.5 * label.offsetWidth, tall = label.offsetHeight, middle = x + within(at[0], half + EDGE, width - half - EDGE);
      const over = covered(middle - half, middle + half);
      const lowest = y + tall + EDGE + (y < 1 ? over : 0), covers = (one, at) => Math.abs(one.middle - middle) < one.half + half && Math.abs(one.bottom - at) < tall;
      let bottom = within(y + at[1], lowest, y + height - EDGE);
      const free = taken.map((one) => one.bottom - tall - 1).concat(bottom).sort((a, b) => b - a).filter((to) => to <= bottom && to >= lowest);
      const found = (few ? free : [bottom]).find((to) => !taken.some((one) => covers(one, to)));
      label.style.visibility = found === undefined && !few ? "hidden" : "visible";
      bottom = found ?? bottom;
      Object.assign(label.style, { left: `${middle}px`, top: `${bottom}px` });
      if (label.style.visibility === "visible") taken.push({ middle, half, bottom });
    }
  }
}
