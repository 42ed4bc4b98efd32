// Markers that were measured, those of the model, and measured forces on bodies.

const MARKER_TINT = [0.62, 0.86, 0.1], MODELLED_TINT = [0.93, 0.93, 0.95], MISS_TINT = [0.85, 0.1, 0.45];
const MARKER_RADIUS = 0.011; // m, of a body of 75 kg

// Balls where markers are, joined to those of the model by a line as long as the model misses them.
function markMarkers(biped, moment) {
  const { renderer, doll, arrays } = biped, radius = MARKER_RADIUS * doll.scale;
  const measured = biped.between("marker", moment), modelled = biped.between("modelled", moment);
  const seen = arrays.seen ? biped.between("seen", moment) : null;
  biped.markers.forEach((_, k) => {
    if (seen && seen[k] < 0.99) return; // not between a frame with it and one without
    const [a, b] = [measured, modelled].map((all) => add(all.slice(3 * k, 3 * k + 3), biped.offset)), miss = minus(b, a), long = norm(miss);
    renderer.mark("limb", a, UNTURNED, [radius, radius, radius, 0], MARKER_TINT);
    renderer.mark("limb", b, UNTURNED, [0.75 * radius, 0.75 * radius, 0.75 * radius, 0], MODELLED_TINT);
    if (long > radius) renderer.mark("tube", times(add(a, b), 0.5), turnFromY(miss), [0.35 * radius, 1, 0.35 * radius, long], MISS_TINT);
  });
}

function markPlates(biped, moment) {
  const forces = biped.between("plate", moment), points = biped.between("plate_point", moment);
  biped.plates.forEach((side, k) => {
    const force = forces.slice(3 * k, 3 * k + 3), size = norm(force) / biped.doll.weight;
    if (size > 0.02) arrow(biped.renderer, add(points.slice(3 * k, 3 * k + 3), biped.offset), times(unit(force), FORCE_SCALE * size), FORCE_TINT[side === "right" ? 1 : 0]);
  });
}

// What colours of markers mean, and of bones of motions over one another, below the legend.
function addDots(bipeds, over) {
  if (bipeds.some((biped) => biped.markers?.length)) addRow([["markers", MARKER_TINT], ["of the model", MODELLED_TINT]]);
  if (over) bipeds.forEach((biped) => addRow([[biped.label, biped.over ?? BONE_TINT]]));
}

function addRow(entries) {
  const row = document.getElementById("legend").appendChild(document.createElement("div"));
  row.className = "dots";
  for (const [name, tint] of entries) {
    const dot = row.appendChild(document.createElement("i"));
    dot.style.background = `rgb(${tint.map((part) => Math.round(255 * part)).join()})`;
    row.append(name);
  }
}
