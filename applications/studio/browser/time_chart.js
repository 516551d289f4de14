"use strict";

/** Colours of the states of rows, as in the style sheet: fitted, excluded, held out, then reasons of the fit. */
const STATE_COLORS = ["#0b4f9c", "#77818d", "#7b3fa0", "#1c2430", "#1c2430", "#b85c00", "#c79400", "#d01030"];
const TIME_HEIGHT = 280;

/** The time history of a channel, each row in the colour of its state; dragging selects rows. */
class TimeChart {
  constructor(host, selected) {
    this.host = host;
    this.selected = selected;
    new ResizeObserver(() => this.plot?.setSize(this.size())).observe(host);
  }

  size() {
    return { width: Math.max(this.host.clientWidth, 200), height: TIME_HEIGHT };
  }

  draw(name, { step, unit, values, codes, sweeps }) {
    this.plot?.destroy();
    this.step = step;
    this.values = decoded(values, Float32Array);
    this.codes = decoded(codes, Uint8Array);
    this.sweeps = sweeps;
    const rows = Array.from(this.values, (_, i) => 1 + i * step);
    const axis = (label, size) => ({ label, size, font: FONT, labelFont: FONT, labelSize: 22, stroke: "#333", grid: { stroke: "#e4e4e4" } });
    this.plot = new uPlot(
      {
        ...this.size(),
        scales: { x: { time: false } },
        axes: [axis("row", 34), axis(`${name} (${unit})`, 64)],
        series: [{ label: "row" }, { label: name, paths: () => null, points: { show: false }, value: (_, value) => shortNumber(value) }],
        cursor: { drag: { x: true, y: false, setScale: false } },
        hooks: { drawClear: [(plot) => this.drawRows(plot)], setSelect: [(plot) => this.select(plot)] },
      },
      [rows, this.values],
      this.host,
    );
    const [least, most] = [Math.min, Math.max].map((of) => shortNumber(this.values.reduce((a, b) => (Number.isNaN(b) ? a : of(a, b)), this.values[0])));
    const canvas = this.plot.ctx.canvas;
    canvas.setAttribute("role", "img");
    canvas.setAttribute("aria-label", `${name} over rows, from ${least} to ${most} ${unit}`);
  }

  drawRows(plot) {
    const { ctx } = plot;
    const { left, top, width, height } = plot.bbox;
    ctx.save();
    ctx.beginPath();
    ctx.rect(left, top, width, height);
    ctx.clip();
    ctx.fillStyle = "#eef1f5";
    this.sweeps.forEach(([first, last], i) => {
      const from = plot.valToPos(first, "x", true);
      if (i % 2 === 0) ctx.fillRect(from, top, plot.valToPos(last, "x", true) - from, height);
    });
    const size = 2 * devicePixelRatio;
    STATE_COLORS.forEach((color, code) => {
      ctx.fillStyle = color;
      for (let i = 0; i < this.values.length; i += 1) {
        if (this.codes[i] !== code) continue;
        ctx.fillRect(plot.valToPos(1 + i * this.step, "x", true) - size / 2, plot.valToPos(this.values[i], "y", true) - size / 2, size, size);
      }
    });
    ctx.restore();
  }

  select(plot) {
    const { left, width } = plot.select;
    if (!width) return;
    const at = (x) => Math.round(plot.posToVal(x, "x"));
    this.selected(Math.max(at(left), 1), at(left + width));
  }

  /** Mark rows that were entered. */
  mark(first, last) {
    if (!this.plot) return;
    const left = this.plot.valToPos(first, "x");
    this.plot.setSelect({ left, top: 0, width: this.plot.valToPos(last, "x") - left, height: this.plot.over.clientHeight }, false);
  }
}
