"use strict";

/** Room for the axes of a chart in pixels of the page, and pixels for an inch of a panel's height. */
const AXIS = { x: 36, y: 62 };
const PER_INCH = 77;
const MIN_HEIGHT = 160;
/** Numbers of an axis: those of their kind, without errors of rounding. */
const TICK = new Intl.NumberFormat("en-US", { maximumSignificantDigits: 9 });
const FONT = "12px system-ui, sans-serif";
/** Ends and middle of the colors of a map, red, green, blue: below 0, 0, above 0. */
const MAP_COLORS = [[33, 102, 172], [247, 247, 247], [178, 24, 43]];
/** A point is read from this distance at most, in pixels. */
const REACH = 40;
/** Largest share of a chart's width for the names beside it. */
const NAMES = 0.45;
/** The sample of a name in pixels. */
const SAMPLE = { width: 16, height: 10 };
/** Width of a printed chart: that of A4 without margins, in pixels. */
const PRINTED = 690;

document.documentElement.classList.add("scripted");
const opener = new IntersectionObserver(
  (entries) => entries.filter((each) => each.isIntersecting).forEach(({ target }) => {
    opener.unobserve(target);
    target.panel.open();
  }),
  { rootMargin: "300px" },
);
/** Add the rows of charts of a figure; those with the same x axis are zoomed together. */
function addCharts(figure, rows) {
  const charts = [];
  const host = document.createElement("div");
  host.className = "charts";
  figure.querySelector("script").after(host);
  for (const row of rows) {
    const line = element("div", "", host);
    for (const panel of row) if (panel) charts.push(new PanelChart(line, panel, charts));
  }
  const kinds = new Set(charts.flatMap((chart) => chart.panel.series.map((each) => each.kind)));
  if (kinds.has("band")) addSwitch(host, "95 % bands", "band", charts);
  if (kinds.has("points") && kinds.has("line")) addSwitch(host, "points", "points", charts);
  const reset = element("button", "Reset zoom", host);
  reset.type = "button";
  reset.className = "reset";
  reset.addEventListener("click", () => charts.forEach((chart) => chart.reset()));
}

/** Add a button to a figure that shows or hides a kind of series in all of its charts. */
function addSwitch(host, text, kind, charts) {
  const button = element("button", text, host);
  button.type = "button";
  button.setAttribute("aria-pressed", String(!charts[0].hidden.has(kind)));
  if (kind === "band") button.title = "95 % confidence intervals: noise, errors of the sensors and of the form of the model";
  button.addEventListener("click", () => {
    const shown = button.getAttribute("aria-pressed") === "false";
    button.setAttribute("aria-pressed", String(shown));
    for (const chart of charts) chart.show(kind, shown);
  });
}

function element(name, text, parent) {
  const made = document.createElement(name);
  made.textContent = text;
  parent.append(made);
  return made;
}

/** A chart of a panel. It is drawn when it is nearly in view. */
class PanelChart {
  constructor(row, panel, all) {
    this.panel = panel;
    this.all = all;
    this.limits = { x: panel.limits[0], y: panel.limits[1] };
    this.hidden = new Set(panel.bands ? [] : ["band"]);
    this.title = panel.title || `${panel.y} over ${panel.x}`;
    this.frame = element("figure", "", row);
    this.frame.style.flexGrow = panel.width;
    element("figcaption", this.title, this.frame);
    this.box = element("div", "", this.frame);
    this.box.className = "box";
    this.box.style.minHeight = `${this.size().height}px`;
    this.readout = element("output", "", this.box);
    this.frame.panel = this;
    opener.observe(this.frame);
  }

  open() {
    this.series = this.panel.series.map((each) => ({ ...each, x: numbers(each.x), y: numbers(each.y) }));
    this.rimmed = this.series.some((each) => each.kind === "points");
    this.addNames();
    this.mark = document.createElement("div");
    this.mark.className = "mark";
    this.mark.hidden = true;
    this.plot = new uPlot(this.options(), [null, [[0], [0]]], this.box);
    this.plot.over.append(this.mark);
    this.plot.over.addEventListener("dblclick", () => this.reset());
    this.describe();
    new ResizeObserver(() => this.plot.setSize(this.size())).observe(this.box);
  }

  /** Add a button for each name beside the axes, at the height where its line ends. */
  addNames() {
    this.names = element("div", "", this.box);
    this.names.className = "names";
    for (const [name, , height] of this.panel.names) {
      const button = element("button", "", this.names);
      button.type = "button";
      button.title = name;
      button.style.bottom = `${100 * height}%`;
      button.setAttribute("aria-pressed", "true");
      drawSample(element("canvas", "", button), this.series.filter((each) => each.label === name && each.kind !== "band"));
      element("span", name, button);
      button.addEventListener("click", () => {
        const shown = this.hidden.has(name);
        button.setAttribute("aria-pressed", String(shown));
        this.show(name, shown);
      });
    }
  }

  /** Return the width of the names beside the axes. */
  margin() {
    this.names.style.width = `${this.size().width}px`; // the names are out of its flow
    const widest = Math.max(0, ...Array.from(this.names.children, (each) => each.offsetWidth));
    const width = Math.min(widest + 4, NAMES * this.size().width);
    this.names.style.width = `${width}px`;
    return width;
  }

  /** Show or hide the series with a name or of a kind. */
  show(name, shown) {
    this.hidden[shown ? "delete" : "add"](name);
    this.plot?.redraw(false);
  }

  isShown(series) {
    return !this.hidden.has(series.label) && !this.hidden.has(series.kind);
  }

  size() {
    return { width: Math.max(this.box.clientWidth, 150), height: Math.max(this.panel.height * PER_INCH, MIN_HEIGHT) };
  }

  options() {
    const axis = (label, i) => ({
      label, font: FONT, labelFont: FONT, labelSize: 22, stroke: "#333", size: i ? AXIS.y : AXIS.x, space: i ? 22 : 50,
      values: (plot, ticks) => ticks.map((tick) => TICK.format(tick)),
      grid: { stroke: "#e4e4e4", width: 1 }, ticks: { stroke: "#999", width: 1, size: 4 },
    });
    return {
      ...this.size(),
      mode: 2,
      padding: [8, () => this.margin(), 0, 0],
      scales: { x: { time: false, range: () => this.limits.x }, y: { range: () => this.limits.y } },
      axes: [this.panel.x, this.panel.y].map(axis),
      series: [{}, { paths: () => null, facets: [{ scale: "x", auto: true }, { scale: "y", auto: true }] }],
      legend: { show: false },
      cursor: { drag: { x: true, y: true, setScale: false, uni: 20 }, points: { show: false } },
      hooks: {
        draw: [(plot) => this.draw(plot)],
        setSelect: [(plot) => this.zoomToSelection(plot)],
        setCursor: [(plot) => this.read(plot)],
      },
    };
  }

  zoomToSelection(plot) {
    const { left, top, width, height } = plot.select;
    if (!width && !height) return;
    const range = {};
    if (width) range.x = [plot.posToVal(left, "x"), plot.posToVal(left + width, "x")];
    if (height && height < plot.over.clientHeight) range.y = [plot.posToVal(top + height, "y"), plot.posToVal(top, "y")];
    plot.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
    this.zoom(range);
  }

  /** Take limits, and the same ones along x in the panels with the same axis. */
  zoom(range) {
    const together = range.x && this.panel.x_axis ? this.all.filter((each) => each.panel.x_axis === this.panel.x_axis) : [];
    for (const each of together) if (each !== this) each.setLimits({ x: range.x });
    this.setLimits(range);
    const zoomed = this.all.some((each) => JSON.stringify([each.limits.x, each.limits.y]) !== JSON.stringify(each.panel.limits));
    this.frame.closest(".charts").classList.toggle("zoomed", zoomed);
  }

  setLimits(range) {
    this.limits = { ...this.limits, ...range };
    if (!this.plot) return;
    this.plot.batch(() => {
      for (const axis of ["x", "y"]) {
        const [min, max] = this.limits[axis];
        this.plot.setScale(axis, { min, max });
      }
    });
    this.describe();
  }

  reset() {
    const [x, y] = this.panel.limits;
    this.zoom({ x, y });
  }

  describe() {
    const [x, y] = [this.limits.x, this.limits.y].map((each) => each.map(short).join(" to "));
    const canvas = this.plot.ctx.canvas;
    canvas.setAttribute("role", "img");
    canvas.setAttribute("aria-label", `${this.title}. ${this.panel.x}: ${x}; ${this.panel.y}: ${y}`);
  }

  draw(plot) {
    const { ctx, bbox } = plot;
    const across = (value) => plot.valToPos(value, "x", true);
    const down = (value) => plot.valToPos(value, "y", true);
    const edges = { left: bbox.left + bbox.width, top: bbox.top, height: bbox.height };
    for (const [side, place] of Object.entries(edges)) this.names.style[side] = `${place / devicePixelRatio}px`;
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
    ctx.clip();
    if (this.panel.cells) drawCells(ctx, this.panel.cells, across, down);
    ctx.fillStyle = "#8c8c8c";
    for (const y of this.panel.across) ctx.fillRect(bbox.left, down(y), bbox.width, devicePixelRatio);
    for (const x of this.panel.upright) ctx.fillRect(across(x), bbox.top, devicePixelRatio, bbox.height);
    for (const each of this.series) if (this.isShown(each)) drawSeries(ctx, each, across, down, this.rimmed);
    ctx.restore();
  }

  /** Show the values of the nearest point and mark it, or those of the cell of a map. */
  read(plot) {
    const { left, top } = plot.cursor;
    let found = null;
    let least = REACH ** 2;
    for (const series of this.series) {
      if (!this.isShown(series) || (series.kind !== "line" && series.kind !== "points")) continue;
      for (let i = 0; i < series.x.length; i += 1) {
        const distance = (plot.valToPos(series.x[i], "x") - left) ** 2 + (plot.valToPos(series.y[i], "y") - top) ** 2;
        if (distance < least) [found, least] = [{ series, x: series.x[i], y: series.y[i] }, distance];
      }
    }
    this.mark.hidden = !found || left < 0;
    if (this.mark.hidden) {
      const at = () => cellText(this.panel.cells, plot.posToVal(left, "x"), plot.posToVal(top, "y"));
      this.readout.textContent = this.panel.cells && left >= 0 ? at() : "";
      return;
    }
    this.mark.style.left = `${plot.valToPos(found.x, "x")}px`;
    this.mark.style.top = `${plot.valToPos(found.y, "y")}px`;
    const { label, kind, step } = found.series;
    const name = [label, kind === "points" ? "point" : label ? "" : "line"].filter(Boolean).join(", ");
    const thinned = step > 1 ? `; 1 of ${step} points is shown` : "";
    this.readout.textContent = `${name}: ${this.panel.x} ${short(found.x)}, ${this.panel.y} ${short(found.y)}${thinned}`;
  }
}

function drawSeries(ctx, series, across, down, rimmed = false) {
  const scale = devicePixelRatio * 1.33; // from points
  ctx.fillStyle = series.color;
  ctx.globalAlpha = series.opacity;
  ctx.beginPath();
  if (series.kind !== "points") drawPieces(ctx, series, across, down);
  if (series.kind === "band" || series.kind === "area") ctx.fill();
  if (series.kind === "line") {
    if (rimmed) stroke(ctx, "#fff", (series.size + 1) * scale, []);
    stroke(ctx, series.color, series.size * scale, series.dashes.map((each) => each * series.size * scale));
  }
  if (series.marker) drawMarkers(ctx, series, across, down, scale);
  ctx.globalAlpha = 1;
}

function stroke(ctx, color, width, dashes) {
  ctx.strokeStyle = color;
  ctx.lineWidth = width;
  ctx.setLineDash(dashes);
  ctx.stroke();
  ctx.setLineDash([]);
}

/** Draw a line that is interrupted where a value is missing. */
function drawPieces(ctx, series, across, down) {
  let joined = false;
  series.x.forEach((x, i) => {
    const known = Number.isFinite(x) && Number.isFinite(series.y[i]);
    if (known) joined ? ctx.lineTo(across(x), down(series.y[i])) : ctx.moveTo(across(x), down(series.y[i]));
    joined = known;
  });
}

function drawMarkers(ctx, series, across, down, scale) {
  const half = Math.max(series.kind === "points" ? series.size : 4, 2) * 0.5 * scale;
  ctx.beginPath();
  series.x.forEach((value, i) => {
    const [x, y] = [across(value), down(series.y[i])];
    ctx.moveTo(x + half, y);
    ctx.arc(x, y, half, 0, 7);
  });
  if (series.marker === "ring") stroke(ctx, series.color, scale, []);
  else ctx.fill();
}

/** Draw what a name stands for: a piece of its line, and its marker. */
function drawSample(canvas, members) {
  canvas.width = SAMPLE.width * devicePixelRatio;
  canvas.height = SAMPLE.height * devicePixelRatio;
  canvas.style.width = `${SAMPLE.width}px`;
  const across = (share) => share * canvas.width;
  const down = (share) => share * canvas.height;
  for (const { kind, ...look } of members) {
    const shape = kind === "area" ? { x: [0, 1, 1, 0], y: [0, 0, 1, 1] } : kind === "line" ? { x: [0, 1], y: [0.5, 0.5] } : { x: [0.5], y: [0.5] };
    drawSeries(canvas.getContext("2d"), { ...look, kind, ...shape, size: kind === "points" ? 6 : look.size }, across, down);
  }
}

function drawCells(ctx, cells, across, down) {
  ctx.font = `${11 * devicePixelRatio}px system-ui, sans-serif`;
  ctx.textAlign = "center";
  ctx.textBaseline = "middle";
  cells.counts.forEach((column, i) => column.forEach((count, j) => {
    const [left, right, low, high] = [across(cells.x[i]), across(cells.x[i + 1]), down(cells.y[j]), down(cells.y[j + 1])];
    const share = cells.means[i][j] === null ? null : Math.max(-1, Math.min(1, cells.means[i][j] / cells.limit));
    ctx.fillStyle = share === null ? "#d9d9d9" : mixed(share);
    ctx.fillRect(left, high, right - left - devicePixelRatio, low - high - devicePixelRatio);
    if (!count || !cells.numbered || right - left < 8 * devicePixelRatio * String(count).length) return;
    ctx.fillStyle = Math.abs(share) > 0.6 ? "#fff" : "#000";
    ctx.fillText(count, (left + right) / 2, (low + high) / 2);
  }));
}

/** Return the color of a share of the largest mean. */
function mixed(share) {
  const [from, to] = [MAP_COLORS[1], MAP_COLORS[share < 0 ? 0 : 2]];
  return `rgb(${from.map((part, i) => Math.round(part + Math.abs(share) * (to[i] - part))).join()})`;
}

function cellText(cells, x, y) {
  const [i, j] = [cells.x.findLastIndex((edge) => edge <= x), cells.y.findLastIndex((edge) => edge <= y)];
  const count = cells.counts[i]?.[j];
  if (count === undefined) return "";
  const mean = cells.means[i][j];
  return `${cells.label}: ${mean === null ? "-" : short(mean)}, ${count} rows`;
}

/** Return the numbers that chart_data.py writes as 16-bit integers; the largest is none. */
function numbers({ low, unit, steps }) {
  const integers = new Uint16Array(Uint8Array.from(atob(steps), (letter) => letter.charCodeAt(0)).buffer);
  return Float64Array.from(integers, (integer) => (integer === 65535 ? NaN : low + unit * integer));
}

/** Return a number with at most five significant digits. */
function short(value) {
  return String(Number(value.toPrecision(5)));
}

/** Open every section, and draw every chart in the width of the paper; undone after printing. */
function print(begins) {
  for (const details of document.querySelectorAll("details")) {
    if (begins) details.dataset.open = String(details.open);
    details.open = begins || details.dataset.open === "true";
  }
  for (const { panel } of document.querySelectorAll(".charts figure")) {
    if (begins && !panel.plot) panel.open();
    panel.plot?.setSize({ ...panel.size(), ...(begins ? { width: PRINTED } : {}) });
  }
}

addEventListener("beforeprint", () => print(true));
addEventListener("afterprint", () => print(false));
for (const data of document.querySelectorAll("script.panels")) addCharts(data.parentElement, JSON.parse(data.textContent));
