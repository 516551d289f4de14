"use strict";

/** What the page shows; controls change it, `render` draws it. */
const DATA = JSON.parse(document.getElementById("data").textContent);
const now = new TireState(DATA.tires[0], GENERATED[0]);
const loaded = now.original();
const other = DATA.tires[1] ? new TireState(DATA.tires[1], GENERATED[1]) : null;
const measured = new MeasuredRows(DATA.rows);
const sweeps = new SweepMemory();
const view = { inputs: {}, over: "alpha", family: false, condition: 0 };
const inputRows = new Map();
const find = (id) => document.getElementById(id);
let panel = null;
let timePanel = null;
let charts = [];
let conditionAxes = [];
let drawn = "";
let seen = null;
let pending = 0;
let delayed = 0;
let resting = 0;

const titlesOf = (specs) => specs.map((each) => each.name).join();
const input = (name) => now.data.inputs.find((each) => each.name === name);
const range = (name) => {
  const { low, high } = input(name);
  return name === "Fz" ? { low: Math.max(low, 0.01 * high), high } : { low, high };
};

/** Return the curves of each chart: which tire, at which load, in which style. */
function sources() {
  const load = view.inputs.Fz;
  const found = [{ label: "as loaded", tire: loaded, load, style: "loaded" }];
  if (other) found.push({ label: other.data.name, tire: other, load, style: extrapolated(other).length ? "otherBeyond" : "other" });
  for (const each of view.family ? familyLoads().filter((load) => !isSelected(load)) : []) {
    found.push({ label: `${shortNumber(Math.round(each))} N`, tire: now, load: each, style: "family", color: loadColor(each) });
  }
  return [...found, { label: "this tire", tire: now, load, style: extrapolated(now).length ? "beyond" : "now" }];
}

/** Return the loads measured at the selected condition, or shares of the selected load within the range of the tire. */
function familyLoads() {
  const { low, high } = range("Fz");
  const found = measuredLoads().map((each) => each.levels.Fz);
  if (found.length > 1) return found;
  return FAMILY.map((share) => share * view.inputs.Fz).filter((load) => load >= 0.99 * low && load <= 1.01 * high);
}

const measuredLoads = () => (measured.conditions.length ? measured.atAllLoads(view.condition) : []);
const isSelected = (load) => Math.abs(load / view.inputs.Fz - 1) < 0.03;
/** Return the colour of a load: the selected one has that of the tire's curve. */
const loadColor = (load) => (isSelected(load) ? STYLES.now.stroke : LOAD_COLORS[familyLoads().indexOf(load) % LOAD_COLORS.length]);

/** Return the selected inputs that are beyond the range of a tire. */
function extrapolated(tire) {
  return tire.data.inputs.filter((each) => isBeyond(each, view.inputs[each.name])).map((each) => each.name);
}

const isBeyond = ({ low, high }, value) => Math.max(low - value, value - high) > 0.01 * (high - low);

/** Return a curve of a tire over an input without its part beyond the range of the tire. */
function within(tire, name, xs, ys) {
  const own = tire.data.inputs.find((each) => each.name === name);
  return ys.map((y, i) => (isBeyond(own, xs[i]) ? null : y));
}

/** Whether several loads are shown unless the user chooses otherwise. */
const familyAtFirst = () => measuredLoads().length > 1;

/** Return the charts for the selected slip: an output or a quantity with a role, over an input. */
function chartSpecs() {
  const first = view.over === "alpha" ? ["Fy", "Mz"] : ["Fx", "Fy"];
  const place = (each) => (first.includes(each.name) ? first.indexOf(each.name) : first.length);
  const outputs = [...now.data.outputs].sort((a, b) => place(a) - place(b));
  const specs = outputs.map((each) => ({ ...each, results: "forces", of: () => each.name, over: view.over, idle: 0 }));
  const weighting = view.over === "alpha" ? "weighting_x" : "weighting_y";
  for (const role of [weighting, "stiffness_y", "stiffness_x", "friction_y", "friction_x"]) {
    const own = now.data.roles[role];
    const over = role === weighting ? view.over : "Fz";
    const idle = role === weighting ? 1 : 0;
    if (own) specs.push({ ...own, results: "quantities", of: (tire) => tire.data.roles[role]?.name, over, idle });
  }
  return specs.filter((each) => !isEmpty(each) || measuredPoints(each.name, each.over).length);
}

/** Return what a chart shows, and that the data of the tire did not determine it. */
const remarked = ({ text, measured }) => (measured ? text : `${text} (not measured)`);

/** Return whether a chart has nothing to show: a force of 0, or a weighting of 1, over the slip for every tire. */
function isEmpty({ results, of, over, idle }) {
  const places = spaced(range(over).low, range(over).high, FEW_POINTS).map((value) => ({ ...view.inputs, [over]: value }));
  const tires = [now, loaded, ...(other ? [other] : [])].filter(of);
  return tires.every((tire) => places.every((at) => (tire[results](inputsOf(tire, at))[of(tire)] ?? idle) === idle));
}

function buildCharts() {
  const host = find("charts");
  host.replaceChildren();
  const specs = chartSpecs();
  drawn = titlesOf(specs);
  charts = specs.map((spec) => {
    const over = input(spec.over);
    const title = `${spec.name} over ${over.name}: ${remarked(spec)}`;
    const unit = (each) => (each && each !== "1" ? ` (${each})` : "");
    const chart = new Chart(host, { title, xTitle: `${over.name}${unit(over.unit)}`, yTitle: `${spec.name}${unit(spec.unit)}` });
    return { chart, update: (moving) => updateCurves(chart, spec, moving) };
  });
  const has = (name) => now.data.outputs.some((each) => each.name === name);
  if (has("Fx") && has("Fy")) {
    const alphas = ANGLES.map((angle) => angle * DEGREE);
    const title = `Fy over Fx: combined slip, kappa swept at alpha ${ANGLES.join(", ")} deg`;
    const chart = new Chart(host, { title, xTitle: "Fx (N)", yTitle: "Fy (N)", locus: true });
    charts.push({ chart, update: (moving) => updateLoci(chart, alphas, moving) });
  }
  const shown = now.data.outputs.filter((each) => ["Fx", "Fy"].includes(each.name) && input("kappa") && input("alpha"));
  for (const { name, text, unit, measured } of shown) {
    const title = `${name} over kappa and alpha: ${remarked({ text, measured })} of this tire`;
    const chart = new Surface(host, { title, xTitle: "alpha (deg)", yTitle: "kappa", zTitle: `${name} (${unit})` });
    charts.push({ chart, update: () => {}, settle: (shared) => updateSurface(chart, name, shared) });
  }
  seen?.disconnect();
  seen = new IntersectionObserver((entries) => {
    for (const entry of entries) charts.find((each) => each.chart.figure === entry.target).visible = entry.isIntersecting;
    render();
  });
  for (const each of charts) seen.observe(each.chart.figure);
}

/** Draw a chart; while a slider moves, with fewer points. */
function updateCurves(chart, spec, moving = false) {
  const { scale } = input(spec.over);
  const count = moving ? MOVING_POINTS : POINTS;
  const curves = [];
  for (const { label, tire, load, style, color } of sources()) {
    const name = spec.of(tire);
    if (!name || !tire.data.inputs.some((each) => each.name === spec.over)) continue;
    const inputs = { ...view.inputs, Fz: load };
    if (spec.over === "Fz" && style === "family") continue;
    const wanted = wantedNames(tire, spec.results);
    const found = sweeps.sweep(label, tire, inputs, spec.over, range(spec.over), count, spec.results, wanted);
    found.shown ??= found.x.map((x) => x * scale);
    const values = found.curves[name];
    if (values) curves.push({ label, style, color, x: found.shown, y: tire === other ? within(tire, spec.over, found.x, values) : values });
  }
  chart.draw(curves, spec.results === "forces" ? measuredPoints(spec.name, spec.over) : [], moving);
}

function wantedNames(tire, results) {
  return results === "forces" ? tire.data.outputs.map((each) => each.name) : Object.values(tire.data.roles).map((each) => each.name);
}

function updateLoci(chart, alphas, moving = false) {
  const count = moving ? MOVING_POINTS : POINTS;
  const curves = sources().filter((each) => each.style !== "family").flatMap(({ label, tire, style }) =>
    alphas.map((alpha, i) => {
      const place = `${label} ${i}`;
      const inputs = { ...view.inputs, alpha };
      const found = sweeps.sweep(`locus ${place}`, tire, inputs, "kappa", range("kappa"), count, "forces", ["Fx", "Fy"]);
      return { label: place, style, x: found.curves.Fx, y: found.curves.Fy };
    }),
  );
  chart.draw(curves, [], moving);
}

/** Draw a surface; `shared` has the forces that other surfaces have computed for the same state. */
function updateSurface(chart, name, shared) {
  const [alphas, kappas] = ["alpha", "kappa"].map((slip) => spaced(range(slip).low, range(slip).high, SURFACE_POINTS));
  const wanted = now.data.outputs.map((each) => each.name);
  shared.surfaces ??= overSlips(now, view.inputs, alphas, kappas, wanted);
  const { scale } = input("alpha");
  chart.draw(alphas.map((alpha) => alpha * scale), kappas, shared.surfaces[name]);
}

/** Return the measured points over a slip: those of the selected condition, and at the other loads that are shown. */
function measuredPoints(output, over) {
  const selected = measured.conditions[view.condition];
  const conditions = view.family && familyAtFirst() ? measuredLoads() : selected ? [selected] : [];
  const drawn = ({ columns, slip }) => output in columns && over in columns && (!slip || slip === over);
  return conditions.filter(drawn).map((each) => {
    each.axes ??= {};
    each.axes[over] ??= measuredAxis(each.columns[over], input(over).scale);
    each.axes[output] ??= measuredAxis(each.columns[output], 1);
    return { x: each.axes[over], y: each.axes[output], color: conditions.length > 1 ? loadColor(each.levels.Fz) : POINT_COLOR };
  });
}

/** Draw visible charts in the next frame; everything else when no change has followed for a moment. */
function render() {
  if (!pending) {
    pending = requestAnimationFrame(() => {
      pending = 0;
      for (const each of charts) if (each.visible) each.update(true);
    });
  }
  clearTimeout(delayed);
  clearTimeout(resting);
  delayed = setTimeout(() => {
    if (titlesOf(chartSpecs()) !== drawn) buildCharts();
    const shared = {};
    for (const each of charts) if (each.visible) drawWhole(each, shared);
    timePanel.draw();
    showNumbers();
    showQuality();
    showStatus();
    showKey();
    writeHash();
    drawRest(charts.filter((each) => !each.visible), shared);
  }, 150);
}

function drawWhole(each, shared) {
  each.update();
  each.settle?.(shared);
  each.chart.describe();
}

/** Draw charts that are out of sight one after another, so that a change is not kept waiting: they are there when scrolled to. */
function drawRest([first, ...others], shared) {
  if (!first) return;
  resting = setTimeout(() => {
    drawWhole(first, shared);
    drawRest(others, shared);
  });
}

/** Draw all charts in the width of a printed column, or again in that of the page. */
function drawForPrint(printed) {
  const shared = {};
  for (const each of charts) {
    each.chart.fit(printed ? PRINTED_WIDTH : 0);
    drawWhole(each, shared);
  }
  timePanel.fit(printed ? PRINTED_WIDTH : 0);
}

function showNumbers() {
  const ranges = { alpha: range("alpha"), kappa: range("kappa") };
  const shown = [["this tire", now], ["as loaded", loaded], ...(other ? [[other.data.name, other]] : [])];
  const figures = shown.map(([, tire]) => new Map(keyFigures(tire, view.inputs, ranges).map((each) => [each.title, each])));
  const text = (each) => (each ? `${shortNumber(each.value)}${each.end ? "*" : ""}` : "-");
  const rows = [...figures[0].values()].map((each) => {
    const before = figures[1].get(each.title).value;
    const change = before ? `${shortNumber(Number((100 * (each.value / before - 1)).toFixed(2)))} %` : "-";
    return [each.title, each.unit, ...figures.map((map) => text(map.get(each.title))), change];
  });
  fillTable(find("numbers"), ["Figure", "Unit", ...shown.map(([title]) => title), "Change"], rows);
}

function showQuality() {
  if (!measured.conditions.length) return;
  const selected = measured.conditions[view.condition];
  const tires = [["this tire", now], ["as loaded", loaded], ...(other ? [[other.data.name, other]] : [])];
  const rows = [];
  for (const [title, conditions] of [["condition", [selected]], ["all rows", measured.conditions]]) {
    const found = tires.map(([, tire]) => fitQuality(tire, conditions));
    for (const [output, each] of found[0]) {
      const cells = found.flatMap((map) => (map.has(output) ? [map.get(output).rmse, map.get(output).r2].map(shortNumber) : ["-", "-"]));
      rows.push([`${output}, ${title}`, String(each.rows), ...cells]);
    }
  }
  fillTable(find("quality"), ["Output", "Rows", ...tires.flatMap(([title]) => [`RMSE, ${title}`, `R2, ${title}`])], rows);
}

function showStatus() {
  const tire = changeText(now.changes());
  const inputs = [...inputRows].filter(([, row]) => row.changed).map(([name]) => name).join(", ");
  const changed = [tire && `Changed: ${tire}.`, inputs && `Inputs changed: ${inputs}.`].filter(Boolean).join(" ");
  const beyond = [now, ...(other ? [other] : [])].filter((each) => extrapolated(each).length);
  const notes = beyond.map((each) => ` Extrapolated: ${extrapolated(each).join(", ")} beyond the range of ${each === now ? "the tire" : each.data.name}.`);
  find("status").textContent = (changed || "Nothing is changed.") + notes.join("");
}

/** Return an input of the page without changes: the level of the selected condition, or nominal. */
function unchanged({ name, nominal }) {
  return measured.conditions[view.condition]?.levels[name] ?? nominal;
}

function resetInputs() {
  for (const each of now.data.inputs) view.inputs[each.name] = unchanged(each);
}

/** Show the state in all controls, and draw. */
function showAll() {
  panel.show();
  for (const [name, row] of inputRows) {
    row.markAsUnchanged(displayed(input(name), unchanged(input(name))));
    row.show(displayed(input(name), view.inputs[name]));
  }
  for (const radio of document.getElementsByName("over")) radio.checked = radio.value === view.over;
  find("family").checked = view.family;
  for (const { name, texts } of conditionAxes) find(`condition-${name}`).value = texts[view.condition];
  timePanel.show();
  buildCharts();
  render();
}

function buildInputs() {
  for (const each of now.data.inputs) {
    const { name, text, unit } = each;
    const [lower, upper, initial] = [each.low, each.high, each.nominal].map((value) => displayed(each, value));
    const spec = { id: `input-${name}`, label: name, text, unit, lower, upper, value: initial };
    const row = new SliderRow(spec, (value) => {
      view.inputs[name] = entered(each, value);
      render();
    });
    inputRows.set(name, row);
    find("inputs").append(row.row);
  }
  for (const name of ["alpha", "kappa"].filter(input)) {
    const radio = element("input", { type: "radio", name: "over", id: `over-${name}`, value: name });
    radio.addEventListener("change", () => {
      view.over = name;
      showAll();
    });
    find("axis").append(element("label", { class: "check", for: radio.id }, radio, ` ${name}`));
  }
}

/** Show the line of each tire and the color of each load. */
function showKey() {
  const entry = (kind, text, color = "") => {
    const sign = element("span", { class: kind, "aria-hidden": "true" });
    sign.style.borderColor = color;
    return element("li", {}, sign, text);
  };
  const loads = sources().filter((each) => each.style === "family");
  find("key").replaceChildren(
    entry("line now", loads.length ? `this tire, ${Math.round(view.inputs.Fz)} N` : "this tire"),
    entry("line loaded", "as loaded"),
    ...(other ? [entry("line other", other.data.name)] : []),
    ...loads.map((each) => entry("line family", each.label, each.color)),
    ...(measured.conditions.length ? [loads.length ? entry("point", "measured, in the color of its load", STYLES.now.stroke) : entry("point", "measured")] : []),
  );
}

/** Return the condition with a text on an axis that differs on the fewest others from the selected condition. */
function nearestCondition(texts, wanted) {
  const apart = (i) => conditionAxes.filter((axis) => axis.texts[i] !== axis.texts[view.condition]).length;
  const found = texts.map((_, i) => i).filter((i) => texts[i] === wanted);
  return found.reduce((best, i) => (apart(i) < apart(best) ? i : best));
}

function chooseCondition(index) {
  view.condition = index;
  view.over = measured.conditions[index].slip || view.over;
  resetInputs();
  showAll();
}

function buildMeasured() {
  if (!measured.conditions.length) return;
  find("measured").hidden = false;
  find("condition-choice").hidden = false;
  conditionAxes = measured.axes;
  for (const { name, texts, choices } of conditionAxes) {
    const select = element("select", { id: `condition-${name}` }, ...choices.map((text) => element("option", { value: text }, text)));
    select.addEventListener("change", () => chooseCondition(nearestCondition(texts, select.value)));
    find("condition-choice").append(element("label", { for: select.id }, `${name} `, select));
  }
  const shown = measured.rows < measured.total ? `${measured.rows} of ${measured.total} rows are in this page, selected at random` : `${measured.total} rows`;
  find("measured-note").textContent = `${shown}. Rows that a fit would exclude are not among them. Each row is evaluated at its own inputs, in steady state.`;
}

function start() {
  find("subtitle").textContent = [now, other].filter(Boolean).map(({ data }) => `${data.name}: ${data.title} (${data.model})`).join("; ");
  panel = new CoefficientPanel(find("coefficients"), now, other, render);
  const found = Object.fromEntries(["input", "kind", "from", "to", "unit", "duration"].map((id) => [id, find(`time-${id}`)]));
  const elements = { ...found, section: find("time"), host: find("responses") };
  timePanel = new TimePanel(elements, { now, loaded, other }, () => view.inputs, render);
  buildInputs();
  buildMeasured();
  find("save").addEventListener("click", () => saveFile(`${now.data.file_name}.tir`, propertyFile(now)));
  find("reset-all").addEventListener("click", () => {
    now.reset();
    resetInputs();
    timePanel.reset();
    showAll();
  });
  find("family").addEventListener("change", () => {
    view.family = find("family").checked;
    render();
  });
  for (const id of ["search", "changed-only"]) {
    find(id).addEventListener("input", () => panel.filter(find("search").value, find("changed-only").checked));
  }
  addEventListener("beforeprint", () => drawForPrint(true));
  addEventListener("afterprint", () => drawForPrint(false));
  addEventListener("hashchange", () => {
    readHash();
    showAll();
  });
  readHash();
  showAll();
}

start();
