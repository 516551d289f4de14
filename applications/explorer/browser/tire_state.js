"use strict";

/** Return the names on which lines depend with a set of effects, as Structure.reached does in Python. */
function reached(lines, targets, effects) {
  const numbers = new Map();
  const reads = new Map();
  for (const [name, own, earlier, cases] of lines) {
    const present = own.filter((effect) => effects.has(effect));
    const found = cases.find(
      ([on, known]) =>
        on.length === present.length &&
        on.every((effect) => effects.has(effect)) &&
        earlier.every((each, i) => (numbers.get(each) ?? "") === known[i]),
    );
    reads.set(name, found[3]);
    if (found[2]) numbers.set(name, found[2]);
  }
  const needed = new Set(targets);
  for (const [name] of [...lines].reverse()) {
    if (needed.has(name)) for (const each of reads.get(name)) needed.add(each);
  }
  return needed;
}

/** Iterations of an equilibrium end when no state changes by more than this share; their largest number. */
const CONVERGED = 1e-13;
const MAX_ITERATIONS = 100;

/** A tire whose coefficients and effects can be changed. */
class TireState {
  constructor(data, code) {
    this.data = data;
    this.code = code;
    this.values = new Map(data.coefficients.map((each) => [each.name, each.value]));
    this.on = new Set(data.effects.filter((each) => each.on).map((each) => each.name));
    this.all = new Set(data.effects.map((each) => each.name));
    this.always = this.live(this.all);
    this.version = 0;
    this.update();
  }

  /** Return what reaches an output with a set of effects, as Model.reached does in Python. */
  live(effects) {
    const targets = new Set(this.data.targets);
    for (;;) {
      const found = reached(this.data.lines, targets, effects);
      // A state is an input of the lines, but depends on lines of its own.
      const behind = this.data.states.filter((each) => found.has(each.name)).flatMap((each) => each.lines);
      if (behind.every((name) => targets.has(name))) return found;
      for (const name of behind) targets.add(name);
    }
  }

  /** Return the tire as it was loaded. */
  original() {
    return new TireState(this.data, this.code);
  }

  set(name, value) {
    this.values.set(name, value);
    this.rewrite();
  }

  switch(effect, on) {
    if (on) this.on.add(effect);
    else this.on.delete(effect);
    this.update();
  }

  reset() {
    for (const each of this.data.coefficients) this.values.set(each.name, each.value);
    this.on = new Set(this.data.effects.filter((each) => each.on).map((each) => each.name));
    this.update();
  }

  /** Compute what depends on coefficients and effects. */
  update() {
    const live = this.live(this.on);
    this.idle = new Set([...this.values.keys()].filter((name) => this.always.has(name) && !live.has(name)));
    this.rewrite();
    this.zero = this.data.effects.filter((each) => each.input && !this.on.has(each.name)).map((each) => each.input);
    this.states = this.data.states.filter((each) => each.effects.some((effect) => this.on.has(effect)));
  }

  /** Write the coefficients of the code again; results of an earlier version are not those of this tire. */
  rewrite() {
    this.vector = this.written();
    this.version += 1;
  }

  /** Return the coefficients of the code by name: those of absent effects are neutral. */
  written() {
    const vector = {};
    for (const each of this.data.coefficients) {
      const neutral = this.idle.has(each.name) && each.neutral !== null;
      vector[each.name] = neutral ? each.neutral : this.values.get(each.name);
    }
    for (const each of this.data.effects) {
      if (!this.on.has(each.name)) for (const [name, factor] of each.rescales) vector[name] *= factor;
    }
    return vector;
  }

  /** Return inputs with absent effects silent and every state 0. */
  silent(inputs) {
    const silent = { ...inputs };
    for (const name of this.zero) silent[name] = 0;
    for (const state of this.data.states) silent[state.name] = 0;
    return silent;
  }

  /**
   * Return silent inputs with every state in equilibrium, as in Python's `equilibrium`; at the start of a recording a
   * state that declares a start value has that. A temperature has the selected value, else that of the start.
   */
  acting(inputs, start = false) {
    const acting = this.silent(inputs);
    if (!this.states.length) return acting;
    for (let i = 0; i < MAX_ITERATIONS; i += 1) {
      const lines = this.code.quantities(acting, this.vector);
      let converged = true;
      for (const state of this.states) {
        const before = acting[state.name];
        let now = (state.temperature ? inputs[state.name] : undefined) ?? lines[state.start];
        if (state.settles && !(state.declares_start && (start || state.temperature))) {
          now = i === 0 ? lines[state.target] : (before + lines[state.target]) / 2;
        }
        acting[state.name] = now;
        converged = converged && Math.abs(now - before) <= CONVERGED * Math.abs(now);
      }
      if (converged) break;
    }
    return acting;
  }

  /** Return the states at the start of a recording, lagged slips first. */
  statesAtStart(inputs) {
    const acting = this.acting(inputs, true);
    const slips = { kappa_lagged: acting.kappa, tan_alpha_lagged: Math.tan(acting.alpha) };
    const lagged = this.data.lags.map(({ name }) => [name, slips[name]]);
    return Object.fromEntries([...lagged, ...this.states.map(({ name }) => [name, acting[name]])]);
  }

  /** Return derivative and decay rate of states: `NAME_dot` and `NAME_decay`. */
  rates(inputs, states) {
    if (!Object.keys(states).length) return {};
    const silent = this.silent(inputs);
    const rates = this.code.states({ ...silent, ...states }, this.vector);
    if (!this.states.length || !this.data.lags.length) return rates;
    // Relaxation lengths are those without states of effects, as in Python.
    const slips = Object.fromEntries(this.data.lags.map(({ name }) => [name, states[name]]));
    const lagged = this.code.states({ ...silent, ...slips }, this.vector);
    for (const { name } of this.data.lags) {
      for (const key of [`${name}_dot`, `${name}_decay`]) rates[key] = lagged[key];
    }
    return rates;
  }

  /** Return forces at lagged slips and states. */
  forcesWith(inputs, states) {
    const { kappa_lagged: kappa, tan_alpha_lagged: tangent } = states;
    const acting = { ...this.silent(inputs), ...states };
    if (kappa !== undefined) acting.kappa = kappa;
    if (tangent !== undefined) acting.alpha = Math.atan(tangent);
    return this.code.forces(acting, this.vector);
  }

  forces(inputs) {
    return this.code.forces(this.acting(inputs), this.vector);
  }

  quantities(inputs) {
    return this.code.quantities(this.acting(inputs), this.vector);
  }

  /** Return what differs from the tire as loaded: names of coefficients and of effects. */
  changes() {
    return {
      coefficients: this.data.coefficients.filter((each) => this.values.get(each.name) !== each.value),
      effects: this.data.effects.filter((each) => this.on.has(each.name) !== each.on),
    };
  }
}
