"use strict";
// Lines over iterations or over time, with a cursor that a click, a drag or the arrow keys move.

class Curve extends Drawing {
  #axes = null;

  // `seek(x)` is called with the place asked for; without it the drawing is a picture. `step`: of the arrow keys.
  constructor(canvas, seek = null, step = 1) {
    super(canvas);
    if (!seek) return;
    const held = x => Math.min(this.#axes.x[1], Math.max(this.#axes.x[0], x));
    const point = event => {
      if (!this.#axes) return;
      const { left, wide, x: [from, to] } = this.#axes;
      seek(held(from + (to - from) * (event.clientX - canvas.getBoundingClientRect().left - left) / wide));
    };
    canvas.addEventListener("pointerdown", event => {
      canvas.setPointerCapture(event.pointerId);
      point(event);
    });
    canvas.addEventListener("pointermove", event => { if (event.buttons & 1) point(event); });
    canvas.addEventListener("keydown", event => {
      if (!this.#axes) return;
      const { x: [from, to], cursor } = this.#axes;
      const moves = { ArrowLeft: cursor - step, ArrowRight: cursor + step, PageDown: cursor - 10 * step, PageUp: cursor + 10 * step, Home: from, End: to };
      if (!(event.key in moves)) return;
      event.preventDefault();
      seek(held(moves[event.key]));
    });
    canvas.tabIndex = 0;
    canvas.setAttribute("role", "slider");
    for (const bound of ["min", "max", "now"]) canvas.setAttribute(`aria-value${bound}`, 0);
    canvas.style.touchAction = "pan-y";
    canvas.style.cursor = "crosshair";
  }

  // `series`: {name, colour, points: [[x, y], …]} with a colour's name. If y is not a number, the line has a gap; if
  // y is a string, the reading shows it. `x`: range along; `unit`: of x.
  // Optional: `title`, `cursor`, `digits` after the point in readings (2), `levels`: numbers with dashed
  // lines, `phases`: {name, from, to} behind the lines, and `log` for a logarithmic axis up.
  paint({ series, x, unit, title = "", cursor = null, digits = 2, levels = [], phases = [], log = false }, width, height) {
    const up = log ? Math.log10 : y => y;
    const seen = series.flatMap(line => line.points.map(point => point[1])).filter(y => Number.isFinite(y) && (!log || y > 0));
    const [low, high] = this.#range([...seen, ...levels], log).map(up);
    const readings = this.#readings(series, cursor, digits, log, width);
    const below = 18 * Math.max(0, ...readings.map(({ line }) => line));
    const [left, top, wide, deep] = [48, 46 + below, width - 56, height - 72 - below];
    const place = ([along, y]) => [left + wide * (along - x[0]) / (x[1] - x[0] || 1), top + deep * (high - up(log ? Math.max(y, 10 ** low) : y)) / (high - low || 1)];
    this.#axes = { x, left, wide, cursor };
    this.#paintAxes({ place, low, high, log, phases, x, unit, left, top, wide, deep });
    for (const level of levels) this.#dashed([place([x[0], level]), place([x[1], level])], "muted");
    for (const { points, colour } of series) this.#paintLine(points, place, this.colour(colour), log);
    if (cursor !== null) this.#dashed([[place([cursor, 0])[0], top], [place([cursor, 0])[0], top + deep]], "ink");
    this.text(title, 0, 13, "ink", "left", "600 13px");
    for (const { text, colour, line, left: at } of readings) {
      this.disc(at + 4, 29 + 18 * line, 4, this.colour(colour));
      this.text(text, at + 13, 33 + 18 * line);
    }
    for (const { colour, points } of cursor === null ? [] : series) {
      const point = this.#at(points, cursor);
      if (point && Number.isFinite(point[1])) this.disc(...place(point), 3.5, this.colour(colour), this.colour("paper"));
    }
    if (cursor !== null) this.#tell(series, cursor, digits, unit, log);
  }

  // From zero, or from below the least number if that is negative.
  #range(numbers, log) {
    if (numbers.length === 0) return log ? [0.1, 10] : [0, 1];
    const [low, high] = numbers.reduce(([a, b], y) => [Math.min(a, y), Math.max(b, y)], log ? [Infinity, 0] : [0, 0]);
    const head = 0.06 * (high - low || 1);
    return log ? [low, Math.max(high, low * 10)] : [low < 0 ? low - head : 0, high + head];
  }

  #paintAxes({ place, low, high, log, phases, x, unit, left, top, wide, deep }) {
    const pen = this.pen;
    phases.forEach(({ from, to }, k) => {
      const edges = [from, to].map(along => place([along, 1])[0]);
      pen.fillStyle = this.colour("phase");
      if (k % 2 === 1) pen.fillRect(edges[0], top, Math.max(1.5, edges[1] - edges[0]), deep);
    });
    const step = log ? Math.max(1, Math.ceil((high - low) / 4)) : roundStep((high - low) / 4);
    for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9; k++) {
      const y = place([x[0], log ? 10 ** (k * step) : k * step])[1];
      this.line([[left, y], [left + wide, y]], this.colour("rule"), 1);
      const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
      this.text(log ? (10 ** (k * step)).toPrecision(1).replace("-", "\u2212") : decimals(k * step, digits), left - 8, y + 4, "muted", "right");
    }
    const along = roundStep((x[1] - x[0] || 1) * 64 / wide);
    const digits = Math.max(0, -Math.floor(Math.log10(along) + 1e-9));
    const end = Math.floor(x[1] / along + 1e-9);
    this.text(`${decimals(end * along, digits)} ${unit}`, left + wide, top + deep + 18, "muted", "right");
    const room = place([end * along, 1])[0] - this.measure(unit) - 36;
    for (let k = Math.ceil(x[0] / along - 1e-9); k < end; k++) {
      const at = place([k * along, 1])[0];
      if (at < room) this.text(decimals(k * along, digits), at, top + deep + 18, "muted", "center");
    }
  }

  #paintLine(points, place, colour, log) {
    let part = [];
    const end = () => {
      if (part.length === 1) this.disc(...part[0], 2, colour);
      if (part.length > 1) this.line(part, colour, 1.75);
      part = [];
    };
    for (const point of points) {
      if (Number.isFinite(point[1]) && (!log || point[1] >= 0)) part.push(place(point));
      else end();
    }
    end();
  }

  #dashed(points, colour) {
    this.pen.setLineDash([4, 4]);
    this.line(points, this.colour(colour), 1);
    this.pen.setLineDash([]);
  }

  // The last point at or before the cursor, or the first.
  #at(points, cursor) {
    const after = points.findIndex(point => point[0] > cursor + 1e-9);
    return points[after < 0 ? points.length - 1 : Math.max(0, after - 1)];
  }

  #reading(points, cursor, digits, log) {
    const point = this.#at(points, cursor);
    if (typeof point?.[1] === "string") return point[1];
    if (!point || !Number.isFinite(point[1])) return "\u2013";
    return log ? point[1].toExponential(1).replace("-", "\u2212") : decimals(point[1], digits);
  }

  // Names, each with its number at the cursor, in lines that are as wide as the drawing.
  #readings(series, cursor, digits, log, width) {
    let [at, line] = [0, 0];
    return series.map(({ name, colour, points }) => {
      const text = cursor === null ? name : `${name} ${this.#reading(points, cursor, digits, log)}`;
      const wide = this.measure(text) + 28;
      if (at > 0 && at + wide - 14 > width) [at, line] = [0, line + 1];
      at += wide;
      return { text, colour, line, left: at - wide };
    });
  }

  // What the drawing says at the cursor, for those who do not see it.
  #tell(series, cursor, digits, unit, log) {
    const canvas = this.canvas;
    if (canvas.getAttribute("role") !== "slider") return;
    canvas.setAttribute("aria-valuemin", this.#axes.x[0]);
    canvas.setAttribute("aria-valuemax", this.#axes.x[1]);
    canvas.setAttribute("aria-valuenow", decimals(cursor, 2));
    const said = series.map(({ name, points }) => `${name} ${this.#reading(points, cursor, digits, log)}`);
    canvas.setAttribute("aria-valuetext", `${unit} ${+cursor.toFixed(2)}: ${said.join(", ")}`);
  }
}
