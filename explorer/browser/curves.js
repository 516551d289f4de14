"use strict";

/** Points of a curve. */
const POINTS = 201;
/** Loads of the family of curves, as shares of the selected load. */
const FAMILY = [0.5, 0.75, 1, 1.25, 1.5];
/** Slip angles of the curves of combined slip, deg. */
const ANGLES = [2, 4, 8, 12];

function spaced(low, high, count = POINTS) {
  return Array.from({ length: count }, (_, i) => low + ((high - low) * i) / (count - 1));
}

/** Return the inputs of a tire from the selected ones; inputs that the selection lacks are nominal. */
function inputsOf(tire, selected) {
  return Object.fromEntries(tire.data.inputs.map((each) => [each.name, selected[each.name] ?? each.nominal]));
}

/** Return results over one input: arrays by name. `results` is "forces" or "quantities". */
function sweep(tire, selected, name, values, results, wanted) {
  const inputs = inputsOf(tire, selected);
  const found = Object.fromEntries(wanted.map((each) => [each, new Array(values.length)]));
  values.forEach((value, i) => {
    inputs[name] = value;
    const now = tire[results](inputs);
    for (const each of wanted) found[each][i] = now[each];
  });
  return found;
}

/** Return Fx and Fy over kappa at constant slip angles: a pair of lists for each. */
function combinedSlip(tire, selected, range, alphas) {
  const kappas = spaced(range.low, range.high);
  return alphas.map((alpha) => {
    const { Fx, Fy } = sweep(tire, { ...selected, alpha }, "kappa", kappas, "forces", ["Fx", "Fy"]);
    return [Fx, Fy];
  });
}

/** Return results over alpha and kappa: a list of rows, one for each kappa, for each wanted force. */
function overSlips(tire, selected, alphas, kappas, wanted) {
  const rows = kappas.map((kappa) => sweep(tire, { ...selected, kappa }, "alpha", alphas, "forces", wanted));
  return Object.fromEntries(wanted.map((name) => [name, rows.map((row) => row[name])]));
}
