"use strict";

/** Intervals of a response that are drawn, and the steps of each. */
const INTERVALS = 300;
const STEPS = 8;
/** When the input jumps, as a share of the duration. */
const JUMP = 0.1;
/** A moment, as a share of a step. */
const MOMENT = 1e-6;
/** Corrections of a step: the second one has the exact velocity of lags, along which a hysteresis changes. */
const CORRECTIONS = 2;
const COURSES = ["step", "sweep"];

/** Return the input of each step at its begin and its end: a step, or a sweep to a value and back. */
function inputCourse(kind, from, to, count) {
  const jump = Math.round(JUMP * count);
  const triangle = (share) => from + (to - from) * (1 - Math.abs(1 - 2 * share));
  return Array.from({ length: count }, (_, i) => {
    if (kind === "sweep") return [triangle(i / count), triangle((i + 1) / count)];
    return i < jump ? [from, from] : [to, to];
  });
}

/** Return (1 - e^-z) / z and (e^-z - 1 + z) / z^2. */
function phi(z) {
  if (z < 1e-3) return [1 - (z / 2) * (1 - z / 3), 0.5 - (z / 6) * (1 - z / 4)];
  const first = -Math.expm1(-z) / z;
  return [first, (1 - first) / z];
}

/**
 * Return states after a step of length h: an exponential trapezoidal rule, exact for a lag at a constant rate whose
 * target is linear. `ratesAt(states, share)` returns derivative and decay rate of each state.
 */
function stepped(states, h, ratesAt) {
  let first = ratesAt(states, 0);
  // At zero slip the size of the slip has no direction: a hysteresis along it is looked at a moment later.
  if (first.some(({ decay }) => decay === 0)) first = ratesAt(states.map((x, i) => x + MOMENT * h * first[i].dot), 0);
  let found = states.map((x, i) => x + h * phi(first[i].decay * h)[0] * first[i].dot);
  for (let k = 0; k < CORRECTIONS; k += 1) {
    const last = ratesAt(found, 1);
    found = states.map((x, i) => {
      const decay = (first[i].decay + last[i].decay) / 2;
      const [whole, rising] = phi(decay * h);
      const change = last[i].dot - first[i].dot + decay * (found[i] - x);
      return x + h * (whole * first[i].dot + rising * change);
    });
  }
  return found;
}

/**
 * Return the response of a tire to a course of one input, from steady state: t, and the input, the forces, the forces
 * in steady state and the states at these times.
 */
function timeResponse(tire, selected, { input, kind, from, to, duration }) {
  const inputs = inputsOf(tire, selected);
  const course = inputCourse(kind, from, to, INTERVALS * STEPS);
  const h = duration / course.length;
  let states = tire.statesAtStart({ ...inputs, [input]: from });
  const names = Object.keys(states);
  states = Object.values(states);
  const found = { t: [], input: [], forces: [], steady: [], states: [] };
  const named = (values) => Object.fromEntries(names.map((name, i) => [name, values[i]]));
  const record = (value) => {
    const at = { ...inputs, [input]: value };
    found.input.push(value);
    found.forces.push(tire.forcesWith(at, named(states)));
    found.steady.push(tire.forces(at));
    found.states.push(named(states));
  };
  course.forEach(([begin, end], i) => {
    if (i % STEPS === 0) {
      found.t.push(i * h);
      record(begin);
    }
    states = stepped(states, h, (x, share) => {
      const rates = tire.rates({ ...inputs, [input]: share ? end : begin }, named(x));
      return names.map((name) => ({ dot: rates[`${name}_dot`], decay: rates[`${name}_decay`] }));
    });
  });
  found.t.push(duration);
  record(course.at(-1)[1]);
  return found;
}
