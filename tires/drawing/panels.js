"use strict";

/** Room for the axes of a chart, and its height, in pixels of the page. */
const AXIS = { x: 36, y: 62 };
const CHART_HEIGHT = 300;
const FONT = "12px system-ui, sans-serif";
/** Dashes of a line by the style of the figure, in widths of a line. */
const DASHES = { "--": [7, 4], "-.": [7, 3, 1, 3], ":": [2, 3] };
/** A point is read from this distance at most, in pixels. */
const REACH = 40;

for (const data of document.querySelectorAll("script.panels")) offer(data.parentElement, data);

/** Put a button over a figure that shows its charts in place of it. */
function offer(figure, data) {
  const button = element("button", "Zoom and read values", figure.before.bind(figure));
  button.type = "button";
  button.className = "offer";
  button.setAttribute("aria-expanded", "false");
  let charts = null;
  button.addEventListener("click", () => {
    const opened = button.getAttribute("aria-expanded") === "false";
    button.setAttribute("aria-expanded", String(opened));
    button.textContent = opened ? "Show the figure" : "Zoom and read values";
    figure.classList.toggle("charted", opened);
    if (opened) charts ??= new Charts(figure, JSON.parse(data.textContent));
  });
}

function element(name, text, place) {
  const made = document.createElement(name);
  made.textContent = text;
  place(made);
  return made;
}

/** The charts of a figure. Those that share an axis in the figure are zoomed together along it. */
class Charts {
  constructor(figure, panels) {
    const host = element("div", "", figure.append.bind(figure));
    host.className = panels.every((each) => each.shared) ? "charts column" : "charts";
    this.all = panels.map((panel) => new PanelChart(host, panel, (range) => this.zoomTogether(range)));
  }

  zoomTogether(range) {
    for (const each of this.all) if (each.panel.shared) each.zoom({ x: range });
  }
}

class PanelChart {
  constructor(host, panel, zoomShared) {
    this.panel = panel;
    this.zoomShared = zoomShared;
    this.series = panel.series.map((each) => ({ ...each, x: numbers(each.x), y: numbers(each.y), shown: true }));
    this.limits = { x: panel.limits[0], y: panel.limits[1] };
    const frame = element("figure", "", host.append.bind(host));
    this.title = panel.title || `${panel.y} over ${panel.x}`;
    element("figcaption", this.title, frame.append.bind(frame));
    this.addToggles(element("div", panel.legend, frame.append.bind(frame)));
    this.box = element("div", "", frame.append.bind(frame));
    this.readout = element("output", "", frame.append.bind(frame));
    this.mark = document.createElement("div");
    this.mark.className = "mark";
    this.mark.hidden = true;
    this.plot = new uPlot(this.options(), [null, [[0], [0]]], this.box);
    this.plot.over.append(this.mark);
    this.plot.over.addEventListener("dblclick", () => this.reset());
    this.describe();
    new ResizeObserver(() => this.plot.setSize(this.size())).observe(this.box);
  }

  /** Add a button for each named series that hides it, and what has its color, and one for the zoom. */
  addToggles(bar) {
    bar.className = "toggles";
    const named = this.series.filter((each) => each.label);
    const rest = this.series.filter((each) => !each.label && each.kind === "points");
    for (const [label, members] of [
      ...named.map((each) => [each.label, [each, ...this.series.filter((other) => other.kind === "band" && other.color === each.color)]]),
      ...(rest.length ? [["points", rest]] : []),
    ]) {
      const button = element("button", label, bar.append.bind(bar));
      button.type = "button";
      button.setAttribute("aria-pressed", "true");
      button.style.setProperty("--color", members[0].color);
      button.style.setProperty("--dashes", members[0].kind === "points" ? "dotted" : DASHES[members[0].dashes] ? "dashed" : "solid");
      button.addEventListener("click", () => {
        for (const each of members) each.shown = !each.shown;
        button.setAttribute("aria-pressed", String(members[0].shown));
        this.plot.redraw(false);
      });
    }
    const reset = element("button", "Reset zoom", bar.append.bind(bar));
    reset.type = "button";
    reset.className = "reset";
    reset.addEventListener("click", () => this.reset());
  }

  size() {
    return { width: Math.max(this.box.clientWidth, 200), height: CHART_HEIGHT };
  }

  options() {
    const axis = (label, i) => ({
      label, font: FONT, labelFont: FONT, labelSize: 22, stroke: "#333", size: i ? AXIS.y : AXIS.x,
      grid: { stroke: "#e4e4e4", width: 1 }, ticks: { stroke: "#999", width: 1, size: 4 },
    });
    return {
      ...this.size(),
      mode: 2,
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
    if (this.panel.shared && range.x) this.zoomShared(range.x);
  }

  zoom(range) {
    this.limits = { ...this.limits, ...range };
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
    if (this.panel.shared) this.zoomShared(x);
  }

  describe() {
    const [x, y] = [this.limits.x, this.limits.y].map((each) => each.map(short).join(" to "));
    this.readout.textContent = `${this.panel.x}: ${x}; ${this.panel.y}: ${y}`;
    const canvas = this.plot.ctx.canvas;
    canvas.setAttribute("role", "img");
    canvas.setAttribute("aria-label", `${this.title}. ${this.readout.textContent}`);
  }

  draw(plot) {
    const { ctx, bbox } = plot;
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
    ctx.clip();
    for (const each of this.series) if (each.shown) drawSeries(plot, each);
    ctx.restore();
  }

  /** Show the values of the nearest point, and mark it. */
  read(plot) {
    const { left, top } = plot.cursor;
    let found = null;
    let least = REACH ** 2;
    for (const series of this.series) {
      if (!series.shown || !["line", "points"].includes(series.kind)) continue;
      for (let i = 0; i < series.x.length; i += 1) {
        const distance = (plot.valToPos(series.x[i], "x") - left) ** 2 + (plot.valToPos(series.y[i], "y") - top) ** 2;
        if (distance < least) [found, least] = [{ series, x: series.x[i], y: series.y[i] }, distance];
      }
    }
    this.mark.hidden = !found || left < 0;
    if (this.mark.hidden) return;
    this.mark.style.left = `${plot.valToPos(found.x, "x")}px`;
    this.mark.style.top = `${plot.valToPos(found.y, "y")}px`;
    const name = found.series.label || (found.series.kind === "points" ? "point" : "line");
    const thinned = found.series.step > 1 ? `; 1 of ${found.series.step} points is shown` : "";
    this.readout.textContent = `${name}: ${this.panel.x} ${short(found.x)}, ${this.panel.y} ${short(found.y)}${thinned}`;
  }
}

function drawSeries(plot, series) {
  const { ctx, bbox } = plot;
  const across = (value) => plot.valToPos(value, "x", true);
  const down = (value) => plot.valToPos(value, "y", true);
  ctx.fillStyle = series.color;
  ctx.strokeStyle = series.color;
  ctx.globalAlpha = series.opacity ?? 1;
  if (series.kind === "points") {
    const size = (series.x.length === 1 ? 7 : Math.min(Math.max(series.width, 2), 3)) * devicePixelRatio;
    series.x.forEach((x, i) => ctx.fillRect(across(x) - size / 2, down(series.y[i]) - size / 2, size, size));
  } else {
    ctx.lineWidth = series.width * devicePixelRatio;
    ctx.setLineDash((DASHES[series.dashes] ?? []).map((each) => each * devicePixelRatio));
    ctx.beginPath();
    if (series.kind === "across") [bbox.left, bbox.left + bbox.width].forEach((x) => ctx.lineTo(x, down(series.y[0])));
    else if (series.kind === "upright") [bbox.top, bbox.top + bbox.height].forEach((y) => ctx.lineTo(across(series.x[0]), y));
    else drawPieces(ctx, series, across, down);
    if (series.kind === "band") ctx.fill();
    else ctx.stroke();
    ctx.setLineDash([]);
  }
  ctx.globalAlpha = 1;
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

function numbers(text) {
  return new Float32Array(Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0)).buffer);
}

/** Return a number with at most five significant digits. */
function short(value) {
  return String(Number(value.toPrecision(5)));
}
