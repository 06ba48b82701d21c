"use strict";
// Curves, and the triangle of mixtures.

// A chart with lines over iterations or over time. A click, a drag and the arrow keys move its cursor.
class Curve extends Drawing {
  #axes = null;

  // `seek(x)` is called when the user moves the cursor to `x`. Without `seek`, the chart has no controls. `step` is how
  // far an arrow key moves the cursor.
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

  // `series`: a list of {name, colour, points: [[x, y], …]}, where `colour` is the name of a colour. If y is not a
  // number, the line has a gap there; if it is a string, that is shown instead of a number. `x`: the range of the
  // horizontal axis. `unit`: the unit of x. Optional: `title`; `cursor`; `digits`, the decimals of numbers at the
  // cursor (default 2); `levels`, numbers at which dashed lines are drawn; `phases`, bands {name, from, to}; `log`,
  // true for a logarithmic vertical axis; `robust`, true if a few extreme numbers do not widen the vertical axis, but are
  // drawn at its ends.
  paint({ series, x, unit, title = "", cursor = null, digits = 2, levels = [], phases = [], log = false, robust = false }, width, height) {
    const up = log ? Math.log10 : y => y;
    const seen = series.flatMap(line => line.points.map(point => point[1])).filter(y => Number.isFinite(y) && (!log || y > 0));
    const numbers = [...seen, ...levels];
    const [low, high] = this.#range(robust && !log ? this.#most(numbers) : numbers, log).map(up);
    const readings = this.#readings(series, cursor, digits, log, width);
    const below = 18 * Math.max(0, ...readings.map(({ line }) => line));
    const [left, top, wide, deep] = [48, 46 + below, width - 56, height - 72 - below];
    const place = ([along, y]) => [left + wide * (along - x[0]) / (x[1] - x[0] || 1), top + deep * (high - up(log ? Math.max(y, 10 ** low) : y)) / (high - low || 1)];
    this.#axes = { x, left, wide, cursor };
    this.#paintAxes({ place, low, high, log, phases, x, unit, left, top, wide, deep });
    for (const level of levels) this.#dashed([place([x[0], level]), place([x[1], level])], "muted");
    const within = point => (robust ? place([point[0], Math.max(low, Math.min(high, point[1]))]) : place(point));
    for (const { points, colour } of series) this.#paintLine(points, log ? place : within, this.colour(colour), log);
    if (cursor !== null) this.#dashed([[place([cursor, 0])[0], top], [place([cursor, 0])[0], top + deep]], "ink");
    this.text(title, 0, 13, "ink", "left", "600 13px");
    for (const { text, colour, line, left: at } of readings) {
      this.disc(at + 4, 29 + 18 * line, 4, this.colour(colour));
      this.text(text, at + 13, 33 + 18 * line);
    }
    for (const { colour, points } of cursor === null ? [] : series) {
      const point = this.#at(points, cursor);
      if (point && Number.isFinite(point[1])) this.disc(...(log ? place : within)(point), 3.5, this.colour(colour), this.colour("paper"));
    }
    if (cursor !== null) this.#tell(series, cursor, digits, unit, log);
  }

  // The numbers without a few extreme ones: those in the range from the 2 % quantile to the 98 % quantile, widened on
  // either side by its size.
  #most(numbers) {
    const sorted = [...numbers].sort((a, b) => a - b);
    const [low, high] = [0.02, 0.98].map(share => sorted[Math.round(share * (sorted.length - 1))]);
    return low < high ? numbers.filter(y => y >= 2 * low - high && y <= 2 * high - low) : numbers;
  }

  // The range of the vertical axis. It begins at zero, or below the least number if that is negative.
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
      this.text(log ? (10 ** (k * step)).toPrecision(1) : decimals(k * step, digitsOf(step)), left - 8, y + 4, "muted", "right");
    }
    const along = roundStep((x[1] - x[0] || 1) * 64 / wide);
    const digits = digitsOf(along);
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

  // The last point at or before the cursor, or else the first point.
  #at(points, cursor) {
    const after = points.findIndex(point => point[0] > cursor + 1e-9);
    return points[after < 0 ? points.length - 1 : Math.max(0, after - 1)];
  }

  #reading(points, cursor, digits, log) {
    const point = this.#at(points, cursor);
    if (typeof point?.[1] === "string") return point[1];
    if (!point || !Number.isFinite(point[1])) return "\u2013";
    return log ? point[1].toExponential(1) : decimals(point[1], digits);
  }

  // Writes the names of the series with their numbers at the cursor, in lines that fit into the drawing.
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

  // Tells screen readers the numbers at the cursor.
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

// Draws the mixtures of edges as points of a triangle whose corners are void, skeleton and actuator.
class Ternary extends Drawing {
  #spots = [];

  // `mixtures`: [void, skeleton, actuator] of every edge. `delivered`: the final material of each edge (0, 1 or 2),
  // which determines its colour. Optional: `paths`, for each edge the list of its mixtures over the iterations, if it
  // has one; `highlight`, an edge.
  paint({ mixtures, delivered, paths = [], highlight = null }, width, height) {
    const side = Math.min(width - 88, (height - 104) / Math.sqrt(0.75));
    const [middle, bottom] = [width / 2, height / 2 + side * Math.sqrt(0.1875) + 2];
    const corners = [[middle - side / 2, bottom], [middle + side / 2, bottom], [middle, bottom - side * Math.sqrt(0.75)]];
    const place = mixture => [0, 1].map(axis => corners.reduce((sum, corner, k) => sum + mixture[k] * corner[axis], 0));
    this.#paintFrame(corners, place);
    const colours = ["muted", "skeleton", "actuator"].map(name => this.colour(name));
    const radius = Math.max(2.2, Math.min(3.6, side / 90));
    const path = (e, share, thick) => {
      this.pen.globalAlpha = share;
      this.line(paths[e].map(place), colours[delivered[e]], thick);
    };
    const ring = (e, share) => {
      this.pen.globalAlpha = share;
      this.disc(...place(paths[e][paths[e].length - 1]), 2 * radius + 3, "transparent", colours[delivered[e]]);
    };
    const moved = Object.keys(paths).filter(e => paths[e]);
    for (const e of moved) path(e, 0.13, 1);
    // Draw a single ring for all edges of one material that end at the same spot.
    const ends = new Map(moved.map(e => [`${place(paths[e][paths[e].length - 1]).map(Math.round)},${delivered[e]}`, e]));
    for (const e of ends.values()) ring(e, 0.5);
    this.pen.globalAlpha = 1;
    this.#spots = this.#spread(mixtures.map(place), 2.15 * radius);
    this.#spots.forEach(([x, y], e) => this.disc(x, y, radius, colours[delivered[e]]));
    if (highlight === null || !mixtures[highlight]) return;
    if (paths[highlight]) {
      path(highlight, 0.9, 2);
      ring(highlight, 0.9);
    }
    this.pen.globalAlpha = 1;
    this.disc(...this.#spots[highlight], radius + 3, this.colour("accent"), this.colour("paper"));
  }

  #paintFrame(corners, place) {
    for (let k = 1; k < 5; k++) {
      const [a, b] = [k / 5, 1 - k / 5];
      for (const ends of [[[a, b, 0], [a, 0, b]], [[b, a, 0], [0, a, b]], [[b, 0, a], [0, b, a]]]) {
        this.line(ends.map(place), this.colour("rule"), 1);
      }
    }
    this.line([...corners, corners[0]], this.colour("muted"), 1);
    MATERIALS.forEach((name, k) => this.text(name, corners[k][0], corners[k][1] + [46, 46, -36][k], "ink", "center", "13px"));
  }

  // Moves points that are at the same spot apart, like the seeds of a sunflower, so that each can be seen.
  #spread(points, apart) {
    const met = new Map();
    return points.map(([x, y]) => {
      const spot = `${Math.round(x / apart)},${Math.round(y / apart)}`;
      const k = met.get(spot) ?? 0;
      met.set(spot, k + 1);
      const [off, angle] = [0.56 * apart * Math.sqrt(k), 2.39996 * k];
      return [x + off * Math.cos(angle), y + off * Math.sin(angle)];
    });
  }

  // The edge at a point of the window, or null.
  edgeAt(clientX, clientY) {
    return this.nearest(clientX, clientY, this.#spots.map((spot, e) => [e, (x, y) => Math.hypot(spot[0] - x, spot[1] - y)]));
  }
}
