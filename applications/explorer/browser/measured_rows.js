"use strict";

/** Measured rows at operating conditions, decoded from the page's data. */
class MeasuredRows {
  constructor(data) {
    this.total = data.total;
    this.conditions = data.conditions.map((each) => ({ ...each, columns: decodedColumns(each.columns) }));
  }

  /** Return the conditions that have all levels but the load in common with a selected one, from the smallest load. */
  atAllLoads(selected) {
    const others = ({ texts }) => JSON.stringify({ ...texts, Fz: "" });
    const found = this.conditions.filter((each) => each.levels.Fz > 0 && others(each) === others(this.conditions[selected]));
    return found.sort((a, b) => a.levels.Fz - b.levels.Fz);
  }

  /** The axes of a grid of conditions: the sweep and each held input with several levels, with their texts. */
  get axes() {
    const names = new Set(this.conditions.flatMap((each) => Object.keys(each.texts)));
    const order = (a, b) => parseFloat(a) - parseFloat(b) || 0;
    const axes = [...names].map((name) => {
      const texts = this.conditions.map((each) => each.texts[name] ?? "swept");
      return { name, texts, choices: [...new Set(texts)].sort(order) };
    });
    return axes.filter((each) => each.choices.length > 1);
  }

  get rows() {
    return this.conditions.reduce((sum, each) => sum + each.rows, 0);
  }
}

function decodedColumns(columns) {
  return Object.fromEntries(
    Object.entries(columns).map(([name, text]) => {
      const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
      return [name, new Float32Array(bytes.buffer)];
    }),
  );
}

/** Return rows, RMSE and R2 of each measured output of some conditions; each row is evaluated at its own inputs. */
function fitQuality(tire, conditions) {
  const sums = new Map();
  for (const condition of conditions) {
    const inputs = Object.fromEntries(tire.data.inputs.map((each) => [each.name, each.nominal]));
    const given = tire.data.inputs.map((each) => each.name).filter((name) => name in condition.columns);
    const outputs = condition.outputs.filter((name) => tire.data.outputs.some((each) => each.name === name));
    for (let i = 0; i < condition.rows; i += 1) {
      for (const name of given) inputs[name] = condition.columns[name][i];
      const forces = tire.forces(inputs);
      for (const name of outputs) {
        const measured = condition.columns[name][i];
        if (Number.isNaN(measured)) continue;
        if (!sums.has(name)) sums.set(name, { rows: 0, squared: 0, mean: 0, spread: 0 });
        const sum = sums.get(name);
        const off = measured - sum.mean;
        sum.rows += 1;
        sum.mean += off / sum.rows;
        sum.spread += off * (measured - sum.mean);
        sum.squared += (forces[name] - measured) ** 2;
      }
    }
  }
  return new Map(
    [...sums].map(([name, { rows, squared, spread }]) => [
      name,
      { rows, rmse: Math.sqrt(squared / rows), r2: spread > 0 ? 1 - squared / spread : NaN },
    ]),
  );
}
