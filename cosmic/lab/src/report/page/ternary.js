"use strict";
// The mixtures of edges in a triangle whose corners are void, skeleton and actuator.

class Ternary extends Drawing {
  #spots = [];

  // `mixtures`: [void, skeleton, actuator] of every edge; `delivered`: the material that each edge ends as (0, 1
  // or 2), which gives its colour. What may be left out: `paths`, for edges that have one the mixtures on the
  // way, and `highlight` as an edge's number.
  paint({ mixtures, delivered, paths = [], highlight = null }, width, height) {
    const side = Math.min(width - 88, (height - 104) / Math.sqrt(0.75));
    const [middle, bottom] = [width / 2, height / 2 + side * Math.sqrt(0.1875) + 2];
    const corners = [[middle - side / 2, bottom], [middle + side / 2, bottom], [middle, bottom - side * Math.sqrt(0.75)]];
    const place = mixture => [0, 1].map(axis => corners.reduce((sum, corner, k) => sum + mixture[k] * corner[axis], 0));
    this.#paintFrame(corners, place);
    const colours = ["muted", "skeleton", "actuator"].map(name => this.colour(name));
    const walk = (e, share, thick) => {
      this.pen.globalAlpha = share;
      this.line(paths[e].map(place), colours[delivered[e]], thick);
    };
    const radius = Math.max(2.2, Math.min(3.6, side / 90));
    for (const e in paths) if (paths[e]) walk(e, 0.13, 1);
    this.#paintEnds(paths, place, delivered, colours, radius);
    this.#spots = this.#spread(mixtures.map(place), 2.15 * radius);
    this.#spots.forEach(([x, y], e) => this.disc(x, y, radius, colours[delivered[e]]));
    if (highlight !== null && mixtures[highlight]) this.#paintChosen(highlight, paths, walk, place, colours[delivered[highlight]], radius);
    this.pen.globalAlpha = 1;
  }

  // A ring where paths end, once for those of a material that end at one spot.
  #paintEnds(paths, place, delivered, colours, radius) {
    const ends = new Map();
    for (const e in paths) {
      if (!paths[e]) continue;
      const [x, y] = place(paths[e][paths[e].length - 1]).map(Math.round);
      ends.set(`${x},${y},${delivered[e]}`, [x, y, colours[delivered[e]]]);
    }
    this.pen.globalAlpha = 0.5;
    for (const [x, y, colour] of ends.values()) this.disc(x, y, 2 * radius + 3, "transparent", colour);
    this.pen.globalAlpha = 1;
  }

  // The way of one edge to the ring of its delivered material, and where it is on it.
  #paintChosen(e, paths, walk, place, colour, radius) {
    if (paths[e]) {
      walk(e, 0.9, 2);
      const [x, y] = place(paths[e][paths[e].length - 1]);
      this.disc(x, y, 2 * radius + 3, "transparent", colour);
    }
    this.pen.globalAlpha = 1;
    this.disc(...this.#spots[e], radius + 3, this.colour("accent"), this.colour("paper"));
  }

  #paintFrame(corners, place) {
    for (let k = 1; k < 5; k++) {
      const [a, b] = [k / 5, 1 - k / 5];
      for (const ends of [[[a, b, 0], [a, 0, b]], [[b, a, 0], [0, a, b]], [[b, 0, a], [0, b, a]]]) {
        this.line(ends.map(place), this.colour("rule"), 1);
      }
    }
    this.line([...corners, corners[0]], this.colour("muted"), 1);
    const names = [["void", 46], ["skeleton", 46], ["actuator", -36]];
    names.forEach(([name, below], k) => this.text(name, corners[k][0], corners[k][1] + below, "ink", "center", "13px"));
  }

  // Points at one spot are laid out around it like the seeds of a sunflower, so that each can be seen.
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

  // The number of the edge at a point of the window, or null.
  edgeAt(clientX, clientY) {
    const box = this.canvas.getBoundingClientRect();
    let [least, nearest] = [12, null];
    this.#spots.forEach(([x, y], e) => {
      const off = Math.hypot(x + box.left - clientX, y + box.top - clientY);
      if (off < least) [least, nearest] = [off, e];
    });
    return nearest;
  }
}
