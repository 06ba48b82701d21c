"use strict";
// A robot on its ground. Lengths are metres in the frame of the world.

class Stage extends Drawing {
  #world;
  #shades = null;
  #drawn = [];

  // `world`: `width` of what is shown where the element is 2.4 times as wide as high, `ground` as corners
  // [[x, y], …] from left to right, `cos` of its incline, `limit` of an actuator's strain. What may be left out:
  // `payloads`, the nodes that carry one ([0]), and `origin`, the x at which marks along the ground begin (0).
  constructor(canvas, world) {
    super(canvas);
    this.world = world;
  }

  set world(world) {
    this.#world = { payloads: [0], origin: 0, ...world };
  }

  recoloured() {
    this.#shades = null;
  }

  // A moment: `positions` [x0, y0, x1, y1, …]; `edges` as [i, j, rest length, material, edge's number, weight],
  // where the material is 0 (void, faint), 1 (skeleton) or 2 (actuator), and the weight, 1 if absent, makes a bar
  // thinner and fainter; `camera` [x, y], seen in the middle above the lower edge. What may be left out: `trail`
  // of the payload [x, y, …], `highlight` as an edge's number, `label` in the upper left corner, `shape`: positions
  // that strains are taken from, and `colours` by edge in place of materials and strains.
  paint({ positions, edges, camera, trail = [], highlight = null, label = "", shape = positions, colours = null }, width, height) {
    const scale = Math.min(2.4 * height, 2 * width) / this.#world.width;
    const place = (x, y) => [width / 2 + (x - camera[0]) * scale, 0.8 * height - (y - camera[1]) * scale];
    this.#paintGround(place, camera[0], width / scale / 2, scale, height);
    this.pen.globalAlpha = 0.7;
    const path = [];
    for (let k = 0; k < trail.length; k += 2) path.push(place(trail[k], trail[k + 1]));
    if (trail.length > 0) path.push(place(...positions.slice(2 * this.#world.payloads[0])));
    this.line(path, this.colour("payload"), 1.5);
    this.pen.globalAlpha = 1;
    const node = i => place(positions[2 * i], positions[2 * i + 1]);
    this.#drawn = edges.map(([i, j, , , e]) => [node(i), node(j), e]);
    const thick = Math.min(6, Math.max(1.4, height / 130));
    const chosen = this.#drawn.find(([, , e]) => e === highlight);
    this.pen.globalAlpha = 0.35;
    if (chosen) this.line(chosen.slice(0, 2), this.colour("accent"), 3 * thick + 6);
    for (const material of [0, 1, 2]) {
      edges.forEach((edge, k) => {
        if (edge[3] === material) this.#paintBar(edge, this.#drawn[k], { shape, colours }, thick);
      });
    }
    this.pen.globalAlpha = 1;
    for (const i of this.#world.payloads) this.disc(...node(i), 1.2 + 1.7 * thick, this.colour("payload"), this.colour("paper"));
    if (label) this.text(label, 14, 26, "ink", "left", "600 15px");
  }

  #paintBar([i, j, rest, material, e, weight = 1], [from, to], { shape, colours }, thick) {
    this.pen.globalAlpha = material === 0 ? 0.8 : 0.1 + 0.9 * weight;
    let colour = colours?.[e] ?? this.colour(["void", "skeleton", "actuator"][material]);
    if (material === 2 && !colours) {
      const length = Math.hypot(shape[2 * i] - shape[2 * j], shape[2 * i + 1] - shape[2 * j + 1]);
      colour = this.strainColour(length / rest - 1);
    }
    this.line([from, to], colour, thick * [0.5, 1, 1.45][material] * (0.4 + 0.6 * weight));
  }

  // The colour of an actuator's strain: one of its own beyond the limit.
  strainColour(strain) {
    const share = strain / this.#world.limit;
    return Math.abs(share) > 1 ? this.colour("beyond") : this.shade(share);
  }

  // The colour of a share from -1 to 1.
  shade(share) {
    this.#shades ??= this.ramp(33);
    return this.#shades[Math.round(16 * (1 + share))];
  }

  // Marks stand along the ground, as displacements are measured.
  #paintGround(place, middle, half, scale, height) {
    const { ground, cos, origin } = this.#world;
    const level = x => levelAt(ground, x);
    const [left, right] = [middle - half, middle + half];
    const corners = ground.filter(([x]) => left < x && x < right);
    const line = [[left, level(left)], ...corners, [right, level(right)]].map(([x, y]) => place(x, y));
    const pen = this.pen;
    pen.beginPath();
    for (const [x, y] of line) pen.lineTo(x, y);
    pen.lineTo(2 * half * scale, height + 1);
    pen.lineTo(0, height + 1);
    pen.fillStyle = this.colour("earth");
    pen.fill();
    const named = roundStep(64 / scale);
    const parts = String(named).replace(/[0.]/g, "")[0] === "2" ? 4 : 5;
    const between = named / parts;
    for (let k = Math.ceil((left - origin) / cos / between); origin + k * between * cos <= right; k++) {
      const along = k * between;
      const at = origin + along * cos;
      const [x, y] = place(at, level(at));
      this.line([[x, y], [x, y + (k % parts ? 4 : 8)]], this.colour("muted"), 1);
      if (k % parts === 0) this.text(`${decimals(along, Math.max(0, -Math.floor(Math.log10(named) + 1e-9)))} m`, x, y + 23, "muted", "center");
    }
    this.line(line, this.colour("muted"), 1.5);
  }

  // The number of the edge at a point of the window, or null.
  edgeAt(clientX, clientY) {
    const box = this.canvas.getBoundingClientRect();
    const [x, y] = [clientX - box.left, clientY - box.top];
    let [least, nearest] = [12, null];
    for (const [[x0, y0], [x1, y1], e] of this.#drawn) {
      const [dx, dy] = [x1 - x0, y1 - y0];
      const share = Math.min(1, Math.max(0, ((x - x0) * dx + (y - y0) * dy) / (dx * dx + dy * dy || 1)));
      const off = Math.hypot(x0 + share * dx - x, y0 + share * dy - y);
      if (off < least) [least, nearest] = [off, e];
    }
    return nearest;
  }
}
