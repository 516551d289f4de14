"use strict";

/** Nominal values: factor of the unit of the field. */
const NOMINAL = { Fz0: 1, R0: 1, p0: 1000 };
const CHOICES = { model: "mf61", recipe: "", start: "" };

/** The fit: its options, its curves and residuals over the measured rows, sliders for its coefficients. */
class FitTab {
  constructor(studio) {
    this.studio = studio;
    this.charts = new CurveCharts(find("charts"));
    this.measured = null;
    this.now = null;
    for (const [id, standard] of Object.entries(CHOICES)) this.listen(find(id), standard);
    for (const id of Object.keys(NOMINAL)) find(id).addEventListener("change", () => this.setNominal());
    find("run-fit").addEventListener("click", () => studio.run(["fit"]));
    find("condition").addEventListener("change", () => this.showCondition());
    find("reset").addEventListener("click", () => {
      this.now.reset();
      this.panel.show();
      this.changed();
    });
    find("start-from").addEventListener("click", () => studio.edit("start_from", this.content()));
    for (const id of ["search", "changed-only"]) {
      find(id).addEventListener("input", () => this.panel?.filter(find("search").value, find("changed-only").checked));
    }
  }

  /** Set the key of the project file that a choice stands for; the default is no key. */
  listen(choice, standard) {
    choice.addEventListener("change", () => this.studio.set("fit", choice.id, choice.value === standard ? null : choice.value || null));
  }

  /** Show the options of a fit that have choices, before the nominal values. */
  showOptions(options, fit) {
    for (const { name, label, choices, default: standard } of options) {
      if (!document.getElementById(name)) {
        const choice = element("select", { id: name });
        this.listen(choice, standard);
        find("Fz0").parentElement.before(element("p", {}, element("label", { for: name }, label), " ", choice));
      }
      fillChoice(find(name), choices, fit[name] ?? standard);
    }
  }

  setNominal() {
    const given = Object.entries(NOMINAL).map(([id, scale]) => [id, find(id).valueAsNumber * scale]).filter(([, x]) => Number.isFinite(x));
    const others = Object.entries(this.studio.state.sections.fit?.nominal ?? {}).filter(([name]) => !(name in NOMINAL));
    const nominal = Object.fromEntries([...given, ...others]);
    this.studio.set("fit", "nominal", given.length ? nominal : null);
  }

  async refresh() {
    const { sections, steps } = this.studio.state;
    const fit = sections.fit ?? {};
    const choices = await this.studio.call("choices");
    fillChoice(find("model"), Object.entries(choices.models).map(([name, title]) => [name, `${name}: ${title}`]), fit.model ?? CHOICES.model);
    fillChoice(find("recipe"), [["", "of the model"], ...choices.recipes.map((name) => [name, name])], fit.recipe ?? "");
    this.showOptions(choices.options, fit);
    const starts = [["", "generic"], ["features", "read from the data"], ...(fit.start && fit.start !== "features" ? [[fit.start, fit.start]] : [])];
    fillChoice(find("start"), starts, fit.start ?? "");
    for (const [id, scale] of Object.entries(NOMINAL)) find(id).value = fit.nominal?.[id] === undefined ? "" : fit.nominal[id] / scale;
    this.showEffects(choices, fit.effects ?? choices.default);
    const step = steps.find((each) => each.command === "fit");
    const fitted = Boolean(step && step.status !== null);
    this.showVerdict(fitted ? step : null);
    find("run-fit").disabled = this.studio.running || !steps.length;
    if (!this.studio.running) await this.showTire(fitted ? "result" : "live");
  }

  /** Show the verdict of a fit; while the next one runs, that of the earlier one remains. */
  showVerdict(step) {
    const [verdict, reasons] = [find("verdict"), find("reasons")];
    const keeps = !step && this.studio.running && verdict.textContent;
    for (const each of [verdict, reasons]) each.classList.toggle("earlier", Boolean(keeps));
    if (keeps) return;
    verdict.textContent = step ? step.headline : "Not fitted yet";
    verdict.className = `verdict ${step ? step.rating : ""}`;
    reasons.replaceChildren(...(step ? step.summary : []).map((line) => element("li", {}, line)));
  }

  showEffects(choices, chosen) {
    const boxes = choices.effects.map(({ name, physics }) => {
      const box = element("input", { type: "checkbox", id: `use-${name}` });
      box.checked = chosen.includes(name);
      box.addEventListener("change", () => {
        const effects = box.checked ? [...chosen, name] : chosen.filter((each) => each !== name);
        this.studio.set("fit", "effects", effects);
      });
      return element("label", { class: "check", title: physics }, box, ` ${name}`);
    });
    find("effects").replaceChildren(...boxes);
    find("effects-title").textContent = `Effects: ${chosen.length} of ${choices.effects.length}`;
  }

  /** Show a tire of the server: the fitted one, or that of a fit that runs or will run. */
  async showTire(name) {
    if (!this.studio.state.steps.length) return;
    const tire = await loadTire(this.studio, name);
    const sameTire = this.now && this.name === name && JSON.stringify(this.now.data) === JSON.stringify(tire.data);
    if (!sameTire) {
      const sameSliders = name === "live" && this.name === "live" && this.now.data.code === tire.data.code;
      this.name = name;
      this.now = tire;
      this.loaded = tire.original();
      if (!sameSliders) find("coefficients").replaceChildren();
      if (!sameSliders || !this.studio.running) {
        find("coefficients").replaceChildren();
        this.panel = new CoefficientPanel(find("coefficients"), tire, null, () => this.changed());
        this.panel.show();
        this.addLocks();
      }
    }
    await this.showMeasured();
  }

  /** Add a button to each coefficient: the next fit does not change its value. */
  addLocks() {
    const fixed = this.studio.state.sections.fit?.fixed ?? {};
    for (const [name, row] of this.panel.rows) {
      const frozen = name in fixed;
      const text = frozen ? "Frozen" : "Freeze";
      const lock = element("button", { type: "button", class: "lock", "aria-pressed": String(frozen), "aria-label": `${text} ${name}` }, text);
      lock.addEventListener("click", async () => {
        const { [name]: _, ...others } = fixed;
        const changed = frozen ? others : { ...others, [name]: row.value };
        await this.studio.set("fit", "fixed", Object.keys(changed).length ? changed : null);
      });
      row.row.querySelector(".head").append(lock);
    }
  }

  async showMeasured() {
    const { version } = this.studio.state;
    if (this.version !== version) {
      this.measured = new MeasuredRows(await this.studio.call("measured"));
      this.version = version;
      const before = find("condition").value;
      const titles = this.measured.conditions.map((each, i) => [String(i), each.title]);
      fillChoice(find("condition"), titles, before in titles ? before : "0");
    }
    this.showCondition();
  }

  showCondition() {
    const selected = Number(find("condition").value);
    this.charts.show(this.measured.conditions[selected], this.now, true, this.measured.conditions.length ? this.measured.atAllLoads(selected) : []);
    this.showLoads();
    this.draw(false);
    this.compute();
  }

  showLoads() {
    const entries = this.charts.loads.map(({ text, color }) => {
      const swatch = element("span", { class: "line", "aria-hidden": "true" });
      swatch.style.borderColor = color;
      return element("li", {}, swatch, text);
    });
    find("load-key").replaceChildren(...entries);
  }

  draw(moving) {
    const tires = [{ label: "as fitted", style: "loaded", tire: this.loaded }, { label: "this tire", style: "now", tire: this.now }];
    this.charts.draw(tires, moving);
  }

  /** Draw a change of a slider in the next frame; residuals and errors when the server has computed them. */
  changed() {
    this.moved = performance.now();
    if (!this.pending) {
      this.pending = requestAnimationFrame(() => {
        this.pending = 0;
        this.draw(true);
        this.drawn = performance.now();
      });
    }
    this.compute();
    clearTimeout(this.resting);
    this.resting = setTimeout(() => {
      this.draw(false);
      if (this.errors) this.charts.drawResiduals(this.errors);
    }, 200);
  }

  content() {
    const { data, values, on } = this.now;
    return { tire: this.name, model: data.model, effects: [...on], values: Object.fromEntries(values) };
  }

  /** Let the server compute residuals and errors; while it does, only the latest change waits. */
  async compute() {
    if (this.computing) {
      this.waits = true;
      return;
    }
    this.computing = true;
    try {
      const condition = Number(find("condition").value || 0);
      this.errors = await this.studio.call("errors", { ...this.content(), condition });
      this.charts.drawResiduals(this.errors, true);
      this.showErrors();
      this.computed = performance.now();
    } catch (error) {
      this.studio.fail(error.message);
    }
    this.computing = false;
    if (this.waits) {
      this.waits = false;
      this.compute();
    }
  }

  showErrors() {
    const text = (each) => [String(each.rows), shortNumber(each.rmse), shortNumber(each.r2)];
    const rows = Object.entries(this.errors).map(([name, { all, condition }]) => [name, ...text(all), ...text(condition)]);
    const head = ["channel", "rows", "RMSE", "R2"];
    fillTable(find("quality"), [...head, ...head.slice(1).map((each) => `${each}, condition`)], rows);
  }
}
