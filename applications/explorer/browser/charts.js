"use strict";

/**
 * Lines differ in colour, width and dashes; every colour has a contrast of at least 4.5 on white. Axes are not stretched
 * for the extrapolation of a second tire.
 */
const STYLES = {
  loaded: { stroke: "#3d3d3d", width: 2, dash: [3, 4] },
  other: { stroke: "#a33b00", width: 2, dash: [10, 4] },
  otherBeyond: { stroke: "#a33b00", width: 2, dash: [2, 4], auto: false },
  family: { width: 1.5, dash: [] },
  steady: { stroke: "#4a6fa5", width: 1, dash: [] },
  now: { stroke: "#0b4f9c", width: 2.5, dash: [] },
  beyond: { stroke: "#0b4f9c", width: 2.5, dash: [2, 4] },
};
/** Colours of other loads and of their measured points, from the smallest load. */
const LOAD_COLORS = ["#7b3294", "#b2182b", "#8a5a00", "#00785f", "#c51b7d", "#4d4d4d"];
/** Colour of a measured point without its own. */
const POINT_COLOR = "#00785f";
/** Opacity of a measured point, and the side of its square in pixels of the page. */
const POINT_OPACITY = 0xa0;
const POINT_SIZE = 3;
const CHART_HEIGHT = 260;
/** Half the width of a printed A4 or letter page, less margins and frame. */
const PRINTED_WIDTH = 325;
/** Room beyond the values of an axis, as shares of their range: at rest, and where an axis grows. */
const ROOM = 0.04;
const GROWTH = 0.1;
const FONT = "12px system-ui, sans-serif";

/** A chart of curves and measured points. `locus`: the curves are lists of points in any order. */
class Chart {
  constructor(host, { title, xTitle, yTitle, locus = false }) {
    this.title = title;
    this.locus = locus;
    this.titles = [xTitle, yTitle];
    this.figure = document.createElement("figure");
    const caption = document.createElement("figcaption");
    caption.textContent = title;
    this.box = document.createElement("div");
    this.figure.append(caption, this.box);
    host.append(this.figure);
    this.labels = "";
    this.points = [];
    this.ranges = {};
    this.moving = false;
    this.width = 0;
    new ResizeObserver(() => this.plot?.setSize(this.size())).observe(this.box);
  }

  size() {
    return { width: this.width || Math.max(this.box.clientWidth, 200), height: CHART_HEIGHT };
  }

  /** Take a width, or with 0 that of the page. */
  fit(width) {
    this.width = width;
    this.plot?.setSize(this.size());
  }

  /**
   * Draw curves {label, style, x, y} and lists of points {x, y, color}; all curves of a chart that is no locus have the
   * same x. A colour of a curve replaces that of its style. While they move, axes grow in steps and do not shrink:
   * points are drawn again only if an axis has changed.
   */
  draw(curves, points = [], moving = false) {
    const same = (each, i) => ["x", "y", "color"].every((key) => each[key] === this.points[i][key]);
    if (points.length !== this.points.length || !points.every(same)) this.layer = null;
    this.points = points;
    this.moving = moving;
    const data = this.locus
      ? [null, ...curves.map((each) => [each.x, each.y])]
      : [curves[0].x, ...curves.map((each) => each.y)];
    const labels = curves.map((each) => `${each.label} ${each.style} ${each.color}`).join("|");
    if (labels === this.labels) this.plot.setData(data);
    else {
      this.plot?.destroy();
      this.labels = labels;
      this.plot = new uPlot(this.options(curves), data, this.box);
    }
    this.curves = curves;
  }

  /** Describe the curves in words, for those who do not see them. */
  describe() {
    if (!this.plot) return;
    const canvas = this.plot.ctx.canvas;
    canvas.setAttribute("role", "img");
    canvas.setAttribute("aria-label", `${this.title}. ${this.curves.map(spanText).join(" ")}`);
  }

  options(curves) {
    const axes = this.titles.map((label, i) => ({
      label, font: FONT, labelFont: FONT, labelSize: 22, stroke: "#333", size: i ? 64 : 34,
      grid: { stroke: "#e4e4e4", width: 1 }, ticks: { stroke: "#999", width: 1, size: 4 },
    }));
    const paths = this.locus ? { paths: drawLocus, facets: [{ scale: "x", auto: true }, { scale: "y", auto: true }] } : {};
    return {
      ...this.size(),
      mode: this.locus ? 2 : 1,
      scales: {
        x: { time: false, auto: this.locus, range: (_, low, high) => this.range("x", low, high) },
        y: { auto: true, range: (_, low, high) => this.range("y", low, high) },
      },
      axes,
      series: [
        this.locus ? {} : { label: this.titles[0], value: (_, value) => shortNumber(value) },
        ...curves.map((each) => ({
          label: each.label, ...STYLES[each.style], ...(each.color ? { stroke: each.color } : {}), ...paths,
          points: { show: false }, value: (_, value) => shortNumber(value),
        })),
      ],
      cursor: { drag: { x: true, y: this.locus }, ...(this.locus ? { points: { show: false } } : {}) },
      legend: { show: !this.locus, live: true },
      hooks: { drawClear: [(plot) => this.drawPoints(plot)] },
    };
  }

  /** Return the range of an axis with room for the measured points. */
  range(axis, low, high) {
    if (low === null || low === undefined) return [0, 1];
    let [from, to] = [low, high];
    for (const each of this.zoomed() ? [] : this.points) {
      const [least, most] = each[axis].extent;
      from = Math.min(from, least);
      to = Math.max(to, most);
    }
    const size = to - from || Math.abs(to) || 1;
    if (axis === "x" && !this.locus) return [from, to];
    const held = this.ranges[axis];
    const fits = held && held[0] <= from && to <= held[1];
    if (!this.moving || this.zoomed() || !held) this.ranges[axis] = [from - ROOM * size, to + ROOM * size];
    else if (!fits) this.ranges[axis] = [Math.min(held[0], from - GROWTH * size), Math.max(held[1], to + GROWTH * size)];
    return this.ranges[axis];
  }

  zoomed() {
    return Boolean(this.plot?.select.width);
  }

  /** Draw the measured points from a layer of their own, made again when a scale or the size has changed. */
  drawPoints(plot) {
    if (!this.points.length) return;
    const { left, top, width, height } = plot.bbox;
    const { x, y } = plot.scales;
    const key = [left, top, width, height, x.min, x.max, y.min, y.max].join();
    if (this.layer?.key !== key) {
      const canvas = document.createElement("canvas");
      canvas.width = width;
      canvas.height = height;
      const across = (value) => ((value - x.min) / (x.max - x.min)) * width;
      const down = (value) => (1 - (value - y.min) / (y.max - y.min)) * height;
      fillSquares(canvas, this.points, across, down);
      this.layer = { key, canvas };
    }
    plot.ctx.drawImage(this.layer.canvas, left, top);
  }
}

/** Fill a square at each point of a layer. Pixels are set directly: thousands of rectangles would take a frame's time. */
function fillSquares(canvas, points, across, down) {
  const { width, height } = canvas;
  const context = canvas.getContext("2d");
  const image = context.createImageData(width, height);
  const pixels = new Uint32Array(image.data.buffer);
  const size = Math.round(POINT_SIZE * devicePixelRatio);
  for (const { x, y, color = POINT_COLOR } of points) {
    const pixel = pixelOf(color);
    for (let i = 0; i < x.values.length; i += 1) {
      const left = Math.round(across(x.values[i]) - size / 2);
      const top = Math.round(down(y.values[i]) - size / 2);
      for (let row = Math.max(top, 0); row < Math.min(top + size, height); row += 1) {
        for (let column = Math.max(left, 0); column < Math.min(left + size, width); column += 1) {
          pixels[row * width + column] = pixel;
        }
      }
    }
  }
  context.putImageData(image, 0, 0);
}

/** Return a colour "#rrggbb" as the bytes opacity, blue, green, red. */
function pixelOf(color) {
  const [red, green, blue] = [1, 3, 5].map((at) => parseInt(color.slice(at, at + 2), 16));
  return ((POINT_OPACITY << 24) | (blue << 16) | (green << 8) | red) >>> 0;
}

/** Draw a curve whose points are in any order; nothing remains for the library to draw. */
function drawLocus(plot, index) {
  uPlot.orient(plot, index, (series, _x, _y, scaleX, scaleY, toX, toY, left, top, width, height) => {
    const [xs, ys] = plot.data[index];
    const { ctx } = plot;
    ctx.save();
    ctx.beginPath();
    ctx.rect(left, top, width, height);
    ctx.clip();
    ctx.beginPath();
    xs.forEach((x, i) => ctx.lineTo(toX(x, scaleX, width, left), toY(ys[i], scaleY, height, top)));
    ctx.strokeStyle = series.stroke();
    ctx.lineWidth = series.width * devicePixelRatio;
    ctx.setLineDash((series.dash ?? []).map((each) => each * devicePixelRatio));
    ctx.stroke();
    ctx.restore();
  });
  return null;
}

/** Return measured values in the unit of an axis, and their extent. */
function measuredAxis(values, scale) {
  const converted = Float32Array.from(values, (value) => value * scale);
  let [least, most] = [Infinity, -Infinity];
  for (const value of converted) {
    if (value < least) least = value;
    if (value > most) most = value;
  }
  return { values: converted, extent: [least, most] };
}

/** Return a number with at most five significant digits. */
function shortNumber(value) {
  if (value === null || value === undefined) return "-";
  if (!Number.isFinite(value)) return String(value);
  return String(Number(value.toPrecision(5)));
}

function spanText(curve) {
  const finite = curve.y.filter(Number.isFinite);
  if (!finite.length) return `${curve.label}: no value.`;
  const [least, most] = finite.reduce(([a, b], y) => [Math.min(a, y), Math.max(b, y)], [Infinity, -Infinity]);
  return `${curve.label}: from ${shortNumber(least)} to ${shortNumber(most)}.`;
}
