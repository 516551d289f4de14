"use strict";

/** Points of a curve: at rest, and while a slider moves. */
const POINTS = 201;
const MOVING_POINTS = 101;
/** Points by which a curve that is the same everywhere is recognized. */
const FEW_POINTS = 5;
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

/** The latest curves of each kind: those of a tire and of inputs that have not changed are not computed again. */
class SweepMemory {
  constructor() {
    this.found = new Map();
  }

  /** Return `sweep` between the ends of a range; `kind` is that of the curves, one of which is kept. */
  sweep(kind, tire, selected, name, { low, high }, count, results, wanted) {
    const place = [kind, name, results].join();
    const key = [tire.version, low, high, count, ...Object.values({ ...selected, [name]: 0 })].join();
    if (this.found.get(place)?.key !== key) {
      const x = spaced(low, high, count);
      this.found.set(place, { key, x, curves: sweep(tire, selected, name, x, results, wanted) });
    }
    return this.found.get(place);
  }
}

/** Return results over alpha and kappa: a list of rows, one for each kappa, for each wanted force. */
function overSlips(tire, selected, alphas, kappas, wanted) {
  const rows = kappas.map((kappa) => sweep(tire, { ...selected, kappa }, "alpha", alphas, "forces", wanted));
  return Object.fromEntries(wanted.map((name) => [name, rows.map((row) => row[name])]));
}
