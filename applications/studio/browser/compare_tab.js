"use strict";

/** Upper limit of the fits that are drawn together. */
const MAX_COMPARED = 4;

/** The fits of the project side by side, with their notes. */
class CompareTab {
  constructor(studio) {
    this.studio = studio;
    this.charts = new CurveCharts(find("compare-charts"));
    this.chosen = null;
    this.loaded = new Map();
    find("compare-condition").addEventListener("change", () => this.draw());
  }

  async refresh() {
    const { fits } = this.studio.state;
    this.chosen ??= fits.slice(-2).map((each) => each.number);
    const channels = [...new Set(fits.flatMap((fit) => fit.channels.map((each) => `${each.recording} ${each.channel}`)))];
    const rows = fits.map((fit) => {
      const errors = channels.map((name) => {
        const found = fit.channels.find((each) => `${each.recording} ${each.channel}` === name);
        return found ? `${shortNumber(found.fitted_rmse)} ${found.unit}` : "-";
      });
      return [String(fit.number), this.box(fit), fit.model, fit.verdict, this.note(fit), this.restore(fit), ...errors];
    });
    fillTable(find("fits"), ["fit", "shown", "model", "verdict", "note", "options", ...channels.map((each) => `RMSE ${each}`)], rows);
    await this.show();
  }

  box(fit) {
    const box = element("input", { type: "checkbox", "aria-label": `show fit ${fit.number}` });
    box.checked = this.chosen.includes(fit.number);
    box.addEventListener("change", () => {
      this.chosen = box.checked ? [...this.chosen, fit.number].slice(-MAX_COMPARED) : this.chosen.filter((each) => each !== fit.number);
      this.refresh();
    });
    return box;
  }

  note(fit) {
    const field = element("input", { type: "text", "aria-label": `note of fit ${fit.number}`, maxlength: "2000" });
    field.value = fit.note;
    field.addEventListener("change", () => this.studio.attempt(this.studio.call("note", { fit: fit.number, text: field.value })));
    return field;
  }

  restore(fit) {
    const button = element("button", { type: "button", "aria-label": `Take the options of fit ${fit.number}` }, "Take again");
    button.addEventListener("click", () => this.studio.edit("restore", { fit: fit.number }));
    return button;
  }

  async show() {
    for (const number of this.chosen) {
      if (!this.loaded.has(number)) this.loaded.set(number, await loadTire(this.studio, String(number)));
    }
    if (!this.chosen.length) {
      find("compare-charts").replaceChildren();
      this.charts.key = "";
      find("differences").replaceChildren();
      return;
    }
    if (this.version !== this.studio.state.version) {
      this.measured = new MeasuredRows(await this.studio.call("measured"));
      this.version = this.studio.state.version;
    }
    const titles = this.measured.conditions.map((each, i) => [String(i), each.title]);
    const before = find("compare-condition").value;
    fillChoice(find("compare-condition"), titles, before in titles ? before : "0");
    this.draw();
    this.showDifferences();
  }

  draw() {
    const tires = this.chosen.map((number, i) => ({ label: `fit ${number}`, style: `fit${i}`, tire: this.loaded.get(number) }));
    if (!tires.length) return;
    this.charts.show(this.measured.conditions[Number(find("compare-condition").value)], tires[0].tire, false);
    this.charts.draw(tires);
  }

  showDifferences() {
    const tires = this.chosen.map((number) => this.loaded.get(number));
    const values = tires.map((tire) => new Map(tire.data.coefficients.filter((each) => each.read).map((each) => [each.name, tire.vector[each.name]])));
    const names = [...new Set(values.flatMap((each) => [...each.keys()]))];
    const rows = names
      .map((name) => [name, ...values.map((each) => each.get(name))])
      .filter(([, first, ...others]) => others.some((each) => each !== first))
      .map(([name, ...found]) => [name, ...found.map((each) => (each === undefined ? "-" : shortNumber(each)))]);
    fillTable(find("differences"), ["coefficient", ...this.chosen.map((number) => `fit ${number}`)], rows);
  }
}
