// One stride: curves over the gait cycle, from contact to contact of their own foot, as the mean and the band of the strides.

const STRIDE_SAMPLES = 51, PERCENTS = [0, 50, 100];

// The gait cycles that a curve is cut by: of its own foot, of the left one where it has no side.
function cyclesOf(biped, side) {
  return biped.cycles[side === "right" ? "right" : "left"] ?? [];
}

function hasStrides(biped) {
  return Object.keys(biped.cycles).length > 0 && ["left", "right"].every((side) => (biped.cycles[side] ?? []).length > 0);
}

// The mean of a quantity over strides and its standard deviation, at each of the samples; `value` is what it is in a frame.
function meanStride(biped, side, value) {
  const mean = new Float64Array(STRIDE_SAMPLES), square = new Float64Array(STRIDE_SAMPLES), cycles = cyclesOf(biped, side);
  for (const [from, to] of cycles)
    for (let k = 0; k < STRIDE_SAMPLES; k++) {
      const { frame, next, part } = biped.moment(from + ((to - from) * k) / (STRIDE_SAMPLES - 1)), a = value(frame);
      const at = a + part * (value(next) - a);
      mean[k] += at / cycles.length;
      square[k] += (at * at) / cycles.length;
    }
  return { mean, sd: square.map((s, k) => Math.sqrt(Math.max(s - mean[k] * mean[k], 0))), count: cycles.length };
}

// How far a time is in the stride of a side, 0 to 1; null outside of all strides.
function strideAt(biped, side, time) {
  const cycle = cyclesOf(biped, side).find(([from, to]) => time >= from && time < to);
  return cycle ? (time - cycle[0]) / (cycle[1] - cycle[0]) : null;
}

// The time that is so far in the stride of a side that is nearest to another time.
function timeInStride(biped, side, part, near) {
  const away = ([from, to]) => (near < from ? from - near : near >= to ? near - to : 0);
  const [from, to] = [...cyclesOf(biped, side)].sort((a, b) => away(a) - away(b))[0];
  return from + part * (to - from);
}
