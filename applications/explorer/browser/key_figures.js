"use strict";

/** Step of a central difference at zero slip. */
const STEP = 1e-5;
const DEGREE = Math.PI / 180;

/** Return the extreme of a curve: its value, where it is, and whether that is at the end of the range. */
function extreme(xs, ys, sign) {
  let best = 0;
  ys.forEach((y, i) => {
    if (sign * y > sign * ys[best]) best = i;
  });
  if (best === 0 || best === ys.length - 1) return { x: xs[best], y: ys[best], end: true };
  const [a, b, c] = [ys[best - 1], ys[best], ys[best + 1]];
  const bend = a - 2 * b + c;
  const shift = bend === 0 ? 0 : (a - c) / (2 * bend);
  return { x: xs[best] + shift * (xs[1] - xs[0]), y: b - ((a - c) * shift) / 4, end: false };
}

function slope(tire, inputs, slip, output) {
  const at = (value) => tire.forces({ ...inputs, [slip]: value })[output];
  return (at(STEP) - at(-STEP)) / (2 * STEP);
}

/** Return key figures of a tire in pure slip: title, unit, value and whether it is at the end of the range. */
function keyFigures(tire, selected, ranges) {
  const inputs = inputsOf(tire, { ...selected, kappa: 0, alpha: 0 });
  const has = (name) => tire.data.outputs.some((each) => each.name === name);
  const rows = [];
  const add = (title, unit, value, end = false) => rows.push({ title, unit, value, end });
  const alphas = spaced(ranges.alpha.low, ranges.alpha.high);
  const kappas = spaced(ranges.kappa.low, ranges.kappa.high);
  const load = inputs.Fz;
  const side = has("Fy") ? sideForce(tire, inputs, alphas, add, has("Mz")) : 0;
  let along = 0;
  if (has("Fx")) {
    const { Fx } = sweep(tire, inputs, "kappa", kappas, "forces", ["Fx"]);
    for (const [name, sign] of [["driving", 1], ["braking", -1]]) {
      const peak = extreme(kappas, Fx, sign);
      along = Math.max(along, Math.abs(peak.y));
      add(`Peak Fx, ${name}`, "N", peak.y, peak.end);
      add(`kappa of peak Fx, ${name}`, "", peak.x, peak.end);
    }
    add("Peak |Fx| per load", "", along / load);
    add("Longitudinal slip stiffness", "N", slope(tire, inputs, "kappa", "Fx"));
  }
  if (along && side) add("Peak |Fx| per peak |Fy|", "", along / side);
  return rows;
}

/** Add the key figures of the side force and the aligning moment; return the peak side force. */
function sideForce(tire, inputs, alphas, add, moment) {
  const load = inputs.Fz;
  const peakAt = (Fz) => {
    const { Fy } = sweep(tire, { ...inputs, Fz }, "alpha", alphas, "forces", ["Fy"]);
    return [extreme(alphas, Fy, 1), extreme(alphas, Fy, -1)];
  };
  const peaks = peakAt(load);
  const size = Math.max(...peaks.map((each) => Math.abs(each.y)));
  peaks.forEach((peak, i) => {
    add(`Peak Fy, ${i ? "negative" : "positive"}`, "N", peak.y, peak.end);
    add(`alpha of peak Fy, ${i ? "negative" : "positive"}`, "deg", peak.x / DEGREE, peak.end);
  });
  add("Peak |Fy| per load", "", size / load);
  const stiffness = slope(tire, inputs, "alpha", "Fy");
  add("Cornering stiffness -dFy/dalpha", "N/rad", -stiffness);
  add("Cornering stiffness per load", "1/rad", -stiffness / load);
  const axle = [0.5, 1.5].map((share) => Math.max(...peakAt(share * load).map((each) => Math.abs(each.y))));
  add("Balance: peak |Fy| of an axle that transfers half the load, to one that does not", "", (axle[0] + axle[1]) / (2 * size));
  if (moment) {
    const { Mz } = sweep(tire, inputs, "alpha", alphas, "forces", ["Mz"]);
    const peak = [extreme(alphas, Mz, 1), extreme(alphas, Mz, -1)].sort((a, b) => Math.abs(b.y) - Math.abs(a.y))[0];
    add("Peak Mz", "N m", peak.y, peak.end);
    add("Pneumatic trail -dMz/dFy at zero slip", "mm", (-1000 * slope(tire, inputs, "alpha", "Mz")) / stiffness);
  }
  return size;
}
