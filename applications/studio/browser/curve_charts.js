"use strict";

Object.assign(STYLES, {
  zero: { stroke: "#3d3d3d", width: 1, dash: [] },
  fit0: { stroke: "#0b4f9c", width: 2.5, dash: [] },
  fit1: { stroke: "#a33b00", width: 2, dash: [10, 4] },
  fit2: { stroke: "#7b3fa0", width: 2, dash: [3, 4] },
  fit3: { stroke: "#3d3d3d", width: 2, dash: [10, 4, 3, 4] },
});

/** Charts of forces over the swept slip at a measured condition: curves of tires over points, and residuals below. */
class CurveCharts {
  constructor(host) {
    this.host = host;
    this.sweeps = new SweepMemory();
    this.loads = [];
  }

  /**
   * Take a condition of the measured rows, or none, and a tire that has the inputs and outputs. `family`: the conditions
   * that differ in load only; their points and curves have the colors of their loads.
   */
  show(condition, tire, withResiduals, family = []) {
    this.condition = condition;
    const text = (each) => `${Math.round(each.levels.Fz)} N`;
    const color = (each, i) => (each === condition ? STYLES.now.stroke : LOAD_COLORS[i % LOAD_COLORS.length]);
    this.loads = family.map((each, i) => ({ condition: each, text: text(each), color: color(each, i) }));
    this.over = condition?.slip || "alpha";
    if (!tire.data.inputs.some((each) => each.name === this.over)) this.over = tire.data.inputs[0].name;
    this.input = tire.data.inputs.find((each) => each.name === this.over);
    this.inputs = Object.fromEntries(tire.data.inputs.map((each) => [each.name, condition?.levels[each.name] ?? (["alpha", "kappa"].includes(each.name) ? 0 : each.nominal)]));
    const measured = tire.data.outputs.filter((each) => !condition || each.name in condition.columns);
    const key = [this.over, withResiduals, ...measured.map((each) => each.name)].join();
    if (key === this.key) return;
    this.key = key;
    this.host.replaceChildren();
    const unit = this.input.unit ? ` (${this.input.unit})` : "";
    const chart = (title, yTitle) => new Chart(this.host, { title, xTitle: `${this.over}${unit}`, yTitle });
    this.charts = measured.map(({ name, unit: of, text }) => ({
      name,
      curves: chart(`${name} over ${this.over}: ${text}`, `${name} (${of})`),
      residuals: withResiduals ? chart(`${name}: measured minus computed`, `residual (${of})`) : null,
    }));
  }

  /** Draw curves of tires: a list of label, style and tire. */
  draw(tires, moving = false) {
    const { low, high } = this.input;
    for (const { name, curves } of this.charts) {
      const drawn = [...this.family(tires.at(-1).tire), ...tires].filter(({ tire }) => tire.data.outputs.some((each) => each.name === name)).map(({ label, style, tire, color, load }) => {
        const outputs = tire.data.outputs.map((each) => each.name);
        const inputs = inputsOf(tire, load ? { ...this.inputs, Fz: load } : this.inputs);
        const found = this.sweeps.sweep(label, tire, inputs, this.over, { low, high }, moving ? MOVING_POINTS : POINTS, "forces", outputs);
        return { label, style, color, x: found.x.map((x) => x * this.input.scale), y: found.curves[name] };
      });
      if (drawn.length) curves.draw(drawn, this.points(name), moving);
      if (!moving) curves.describe();
    }
  }

  /** Draw the residuals of the condition: base64 texts by channel. */
  drawResiduals(channels, moving = false) {
    for (const { name, residuals } of this.charts) {
      const x = this.axis(this.over, this.input.scale);
      if (!residuals || !x || !channels[name]) continue;
      const y = measuredAxis(decoded(channels[name].residuals, Float32Array), 1);
      const ends = x.extent;
      residuals.draw([{ label: "0", style: "zero", x: ends, y: [0, 0] }], [{ x, y }], moving);
      if (!moving) residuals.describe();
    }
  }

  /** Return the curves of a tire at the other loads. */
  family(tire) {
    const others = this.loads.filter(({ condition }) => condition !== this.condition);
    return others.map(({ condition, text, color }) => ({ label: text, style: "family", tire, color, load: condition.levels.Fz }));
  }

  points(name) {
    const shown = this.loads.length ? this.loads : [{ condition: this.condition }];
    return shown.flatMap(({ condition, color }) => {
      const [x, y] = [this.axis(this.over, this.input.scale, condition), this.axis(name, 1, condition)];
      return x && y ? [{ x, y, color }] : [];
    });
  }

  axis(name, scale, condition = this.condition) {
    if (!condition || !(name in condition.columns)) return null;
    condition.axes ??= {};
    condition.axes[name] ??= measuredAxis(condition.columns[name], scale);
    return condition.axes[name];
  }
}

/** Return the state of a tire for the page, with its code from the server. */
async function loadTire(studio, name) {
  const data = await studio.call("tire", { tire: name });
  const code = (await import(`./code/${data.code}.js`)).default;
  return new TireState(data, code);
}
