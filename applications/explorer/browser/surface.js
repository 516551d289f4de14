"use strict";

/** Points of a surface along each axis. */
const SURFACE_POINTS = 33;
/** Colours from the smallest to the largest value: red, green, blue. */
const SURFACE_COLORS = [[68, 1, 84], [59, 82, 139], [33, 145, 140], [94, 201, 98], [253, 231, 37]];
/** First view, and how far an arrow key or a pixel of dragging turns it, rad. */
const SURFACE_VIEW = { turn: -0.6, tilt: 0.5 };
/** Room for titles and numbers around a surface, pixels. */
const SURFACE_MARGIN = 36;
const SURFACE_STEP = { key: 0.15, pixel: 0.01 };

/** A force over two slips as a surface that can be turned by dragging or with the arrow keys. */
class Surface {
  constructor(host, { title, xTitle, yTitle, zTitle }) {
    this.title = title;
    this.titles = [xTitle, yTitle, zTitle];
    this.view = { ...SURFACE_VIEW };
    this.width = 0;
    this.figure = document.createElement("figure");
    const caption = document.createElement("figcaption");
    caption.textContent = title;
    this.canvas = document.createElement("canvas");
    this.canvas.tabIndex = 0;
    this.canvas.className = "surface";
    this.canvas.setAttribute("role", "img");
    this.canvas.setAttribute("aria-label", title);
    this.figure.append(caption, this.canvas);
    host.append(this.figure);
    this.canvas.addEventListener("pointermove", (event) => {
      if (event.buttons) this.turn(SURFACE_STEP.pixel * event.movementX, SURFACE_STEP.pixel * event.movementY);
    });
    this.canvas.addEventListener("keydown", (event) => {
      const turns = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
      if (!turns) return;
      event.preventDefault();
      this.turn(SURFACE_STEP.key * turns[0], SURFACE_STEP.key * turns[1]);
    });
    new ResizeObserver(() => this.paint()).observe(this.figure);
  }

  /** Take a width, or with 0 that of the page. */
  fit(width) {
    this.width = width;
    this.paint();
  }

  turn(around, over) {
    this.view.turn += around;
    this.view.tilt = Math.min(Math.max(this.view.tilt + over, 0.05), 1.5);
    this.paint();
  }

  /** Draw values over x and y: `rows[j][i]` belongs to xs[i] and ys[j]. */
  draw(xs, ys, rows) {
    this.data = { xs, ys, rows };
    this.paint();
  }

  describe() {
    if (!this.data) return;
    const [least, most] = this.extent();
    const about = `${this.title}. From ${shortNumber(least)} to ${shortNumber(most)}. Arrow keys turn it.`;
    this.canvas.setAttribute("aria-label", about);
  }

  extent() {
    const values = this.data.rows.flat().filter(Number.isFinite);
    return [Math.min(...values), Math.max(...values)];
  }

  /** Return what takes a point of the unit cube to the canvas, and its distance from the viewer. */
  projection(width, height) {
    const { turn, tilt } = this.view;
    const reach = 0.5 * (Math.abs(Math.cos(turn)) + Math.abs(Math.sin(turn)));
    const rise = 0.4 * Math.cos(tilt) + reach * Math.sin(tilt);
    const size = Math.min((width / 2 - SURFACE_MARGIN) / reach, (height / 2 - SURFACE_MARGIN) / rise);
    return (u, v, w) => {
      const across = (u - 0.5) * Math.cos(turn) - (v - 0.5) * Math.sin(turn);
      const away = (u - 0.5) * Math.sin(turn) + (v - 0.5) * Math.cos(turn);
      const up = 0.8 * (w - 0.5) * Math.cos(tilt) + away * Math.sin(tilt);
      return [width / 2 + size * across, 0.5 * height - size * up, away];
    };
  }

  paint() {
    if (!this.data) return;
    const width = this.width || Math.max(this.figure.clientWidth - 14, 200);
    const height = CHART_HEIGHT;
    Object.assign(this.canvas, { width: width * devicePixelRatio, height: height * devicePixelRatio });
    Object.assign(this.canvas.style, { width: `${width}px`, height: `${height}px` });
    const context = this.canvas.getContext("2d");
    context.scale(devicePixelRatio, devicePixelRatio);
    const [least, most] = this.extent();
    const at = this.projection(width, height);
    for (const { corners, value } of this.faces(at, least, most)) {
      context.beginPath();
      for (const [x, y] of corners) context.lineTo(x, y);
      context.closePath();
      context.fillStyle = surfaceColor(value);
      context.fill();
      context.strokeStyle = "rgba(255, 255, 255, 0.35)";
      context.stroke();
    }
    this.paintAxes(context, at, least, most);
  }

  /** Return the faces from the farthest to the nearest, so that near ones cover far ones. */
  faces(at, least, most) {
    const { rows } = this.data;
    const share = (value) => (value - least) / (most - least || 1);
    const [columns, lines] = [rows[0].length - 1, rows.length - 1];
    const faces = [];
    for (let j = 0; j < lines; j += 1) {
      for (let i = 0; i < columns; i += 1) {
        const places = [[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]];
        const corners = places.map(([a, b]) => at(a / columns, b / lines, share(rows[b][a])));
        const value = places.reduce((sum, [a, b]) => sum + share(rows[b][a]), 0) / 4;
        faces.push({ corners, value, away: corners.reduce((sum, corner) => sum + corner[2], 0) });
      }
    }
    return faces.sort((a, b) => b.away - a.away);
  }

  paintAxes(context, at, least, most) {
    const { xs, ys } = this.data;
    const edges = [
      [this.titles[0], [0, 0, 0], [1, 0, 0], xs[0], xs.at(-1)],
      [this.titles[1], [1, 0, 0], [1, 1, 0], ys[0], ys.at(-1)],
      [this.titles[2], [0, 0, 0], [0, 0, 1], least, most],
    ];
    context.font = FONT;
    context.textAlign = "center";
    for (const [title, from, to, low, high] of edges) {
      const [start, end] = [at(...from), at(...to)];
      context.strokeStyle = "#4d5866";
      context.beginPath();
      context.moveTo(start[0], start[1]);
      context.lineTo(end[0], end[1]);
      context.stroke();
      context.fillStyle = "#333";
      const below = to[2] ? -6 : 14;
      context.fillText(shortNumber(Number(low.toPrecision(3))), start[0], start[1] + (to[2] ? 26 : 14));
      context.fillText(shortNumber(Number(high.toPrecision(3))), end[0], end[1] + below);
      context.fillText(title, (start[0] + end[0]) / 2, (start[1] + end[1]) / 2 + (to[2] ? 0 : 26));
    }
  }
}

/** Return the colour of a share between 0 and 1. */
function surfaceColor(share) {
  const place = Math.min(Math.max(share, 0), 1) * (SURFACE_COLORS.length - 1);
  const first = Math.min(Math.floor(place), SURFACE_COLORS.length - 2);
  const part = place - first;
  const mixed = SURFACE_COLORS[first].map((each, i) => Math.round(each + part * (SURFACE_COLORS[first + 1][i] - each)));
  return `rgb(${mixed.join()})`;
}
