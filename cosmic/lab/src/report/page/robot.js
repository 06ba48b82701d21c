"use strict";
// A robot that walks on its ground.

// A bar with a smaller fraction of solid material does not count as a connection of its nodes.
const HOLDS = 0.3;
// A bar with a smaller fraction of solid material is drawn as void.
const SEEN = 0.02;
// The fraction of the drawing's height that stays free above the robot: the camera rises with a robot that jumps higher.
const ABOVE = 0.1;

// A robot on its ground. Lengths are metres in the frame of the world.
class Stage extends Drawing {
  #world;
  #drawn = [];
  // The x in the middle of the drawing, and pixels per metre.
  #view = { middle: 0, scale: 1 };

  // `world` has: `width`, how much of the world a canvas shows that is 2.4 times as wide as high; `ground`, its corners
  // [[x, y], …] from left to right; `cos`, the cosine of its incline; `limit`, the strain at which actuators have their
  // full colour. Optional: `payloads`, the nodes that carry one (default [0]); `origin`, the x at which marks along the
  // ground begin (default 0); `skeleton`, the strains at which skeleton bars begin to change their colour and have their
  // full colour (default: they do not change it); `finish`, the x of a finish line.
  constructor(canvas, world) {
    super(canvas);
    this.world = world;
  }

  set world(world) {
    this.#world = { payloads: [0], origin: 0, ...world };
  }

  // Paints one moment. `positions`: [x0, y0, x1, y1, …]. `edges`: a list of [i, j, rest length, material, edge,
  // weight], where the material is 0 (void, drawn faint), 1 (skeleton) or 2 (actuator), and a weight below 1 makes a
  // bar thinner and fainter. `camera`: the point [x, y] that is in the middle of the drawing, above its lower edge.
  // Optional: `top`, the height that must be in view; `trail`, the path of the payload [x, y, …]; `highlight`, an edge; `label`, a text for the upper left
  // corner; `shape`, positions from which strains are computed instead; `colours`, one for each edge, instead of
  // materials and strains; `goal`, the foot [x, y] of a flag, and `goalLabel`, the text at the flag; `ghost`, the positions
  // and edges of another robot, which is drawn faintly; `arrow`, how far [x, y] (pixels) an arrow from the robot points.
  paint({ positions, edges, camera, top = -Infinity, trail = [], highlight = null, label = "", shape = positions, colours = null, goal = null, goalLabel = "", ghost = null, arrow = null }, width, height) {
    const scale = Math.min(2.4 * height, 2 * width) / this.#world.width;
    this.#view = { middle: camera[0], scale };
    const floor = Math.max(camera[1], top - (0.8 - ABOVE) * height / scale);
    const place = (x, y) => [width / 2 + (x - camera[0]) * scale, 0.8 * height - (y - floor) * scale];
    const { payloads } = this.#world;
    this.#paintGround(place, camera[0], width / scale / 2, scale, height);
    if (goal) this.#paintFlag(place(...goal), goalLabel, width, height);
    if (this.#world.finish !== undefined) this.#paintFinish(place(this.#world.finish, levelAt(this.#world.ground, this.#world.finish)), width, height);
    if (ghost) this.#paintGhost(ghost, place, height);
    this.pen.globalAlpha = 0.7;
    const path = [];
    for (let k = 0; k < trail.length; k += 2) path.push(place(trail[k], trail[k + 1]));
    if (trail.length > 0) path.push(place(...positions.slice(2 * payloads[0])));
    this.line(path, this.colour("payload"), 1.5);
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
    for (const i of payloads) this.disc(...node(i), 1.2 + 1.7 * thick, this.colour("payload"), this.colour("paper"));
    if (arrow) this.#paintArrow(node(payloads[0] ?? 0), arrow);
    if (label) this.text(label, 14, 26, "ink", "left", "600 15px");
  }

  // Paints a flag, or an arrow at the edge of the drawing if the flag is beyond that edge.
  #paintFlag([x, y], label, width, height) {
    const [top, colour] = [y - 0.33 * height, this.colour("third")];
    if (x < 0 || x > width) {
      const [tip, back] = x < 0 ? [12, 12] : [width - 12, -12];
      this.line([[tip + back, top - 12], [tip, top], [tip + back, top + 12]], colour, 4);
      this.text(label, tip + 1.8 * back, top + 5, "muted", x < 0 ? "left" : "right", "600 13px");
      return;
    }
    this.line([[x, y], [x, top]], this.colour("muted"), 2);
    const [wide, deep] = [0.08 * height, 0.05 * height];
    this.fill([[x, top], [x + wide, top], [x + wide, top + deep], [x, top + deep]], colour);
    const fits = x + this.measure(label) + 24 < width;
    this.text(label, fits ? x + 2 : x, top - 8, "muted", fits ? "left" : "right", "600 13px");
  }

  #paintArrow([x, y], [across, down]) {
    const [tip, angle] = [[x + across, y + down], Math.atan2(down, across)];
    const barb = turn => [tip[0] - 16 * Math.cos(angle + turn), tip[1] - 16 * Math.sin(angle + turn)];
    this.line([[x, y], tip], this.colour("accent"), 4);
    this.line([barb(0.5), tip, barb(-0.5)], this.colour("accent"), 4);
  }

  #paintGhost({ positions, edges }, place, height) {
    this.pen.globalAlpha = 0.16;
    const node = i => place(positions[2 * i], positions[2 * i + 1]);
    for (const [i, j, , , , weight] of edges) this.line([node(i), node(j)], this.colour("ink"), Math.max(1.4, height / 130) * weight);
    this.pen.globalAlpha = 1;
  }

  // Paints a finish line: a chequered strip from the ground to the upper edge.
  #paintFinish([x, y], width, height) {
    const side = Math.max(4, height / 30);
    if (x < -2 * side || x > width + 2 * side) return;
    for (let k = 0; y - k * side > -side; k++) {
      for (const column of [0, 1]) {
        this.pen.fillStyle = this.colour((k + column) % 2 ? "rule" : "muted");
        this.pen.fillRect(x + (column - 1) * side, y - (k + 1) * side, side, side);
      }
    }
  }

  #paintBar([i, j, rest, material, e, weight], [from, to], { shape, colours }, thick) {
    this.pen.globalAlpha = material === 0 ? 0.8 : 0.1 + 0.9 * weight;
    let colour = colours?.[e] ?? this.colour(MATERIALS[material]);
    const { skeleton } = this.#world;
    if (!colours && (material === 2 || (material === 1 && skeleton))) {
      const strain = Math.hypot(shape[2 * i] - shape[2 * j], shape[2 * i + 1] - shape[2 * j + 1]) / rest - 1;
      colour = material === 2 ? this.strainColour(strain) : this.strained((Math.abs(strain) - skeleton[0]) / (skeleton[1] - skeleton[0]));
    }
    this.line([from, to], colour, thick * [0.5, 1, 1.45][material] * (0.4 + 0.6 * weight));
  }

  // The colour for an actuator's strain. Strains beyond the limit have a special colour.
  strainColour(strain) {
    const share = strain / this.#world.limit;
    return Math.abs(share) > 1 ? this.colour("beyond") : this.shade(share);
  }

  // Paints the ground, and marks at equal distances along it. Displacements are measured along the ground too.
  #paintGround(place, middle, half, scale, height) {
    const { ground, cos, origin } = this.#world;
    const [left, right] = [middle - half, middle + half];
    const ends = [left, right].map(x => [x, levelAt(ground, x)]);
    const corners = ground.filter(([x]) => left < x && x < right);
    const line = [ends[0], ...corners, ends[1]].map(([x, y]) => place(x, y));
    this.fill([...line, [2 * half * scale, height + 1], [0, height + 1]], this.colour("earth"));
    const named = roundStep(64 / scale);
    const parts = String(named).replace(/[0.]/g, "")[0] === "2" ? 4 : 5;
    const between = named / parts;
    for (let k = Math.ceil((left - origin) / cos / between); origin + k * between * cos <= right; k++) {
      const at = origin + k * between * cos;
      const [x, y] = place(at, levelAt(ground, at));
      this.line([[x, y], [x, y + (k % parts ? 4 : 8)]], this.colour("muted"), 1);
      if (k % parts === 0) this.text(`${decimals(k * between, digitsOf(named))} m`, x, y + 23, "muted", "center");
    }
    this.line(line, this.colour("muted"), 1.5);
  }

  // The box around the bars on the canvas: [left, top, right, bottom] in pixels.
  get box() {
    const [xs, ys] = [0, 1].map(axis => this.#drawn.flatMap(([from, to]) => [from[axis], to[axis]]));
    return [Math.min(...xs), Math.min(...ys), Math.max(...xs), Math.max(...ys)];
  }

  // Whether a point of the window is within the box around the bars, or near it.
  isNear(clientX, clientY, margin = 16) {
    const { left, top } = this.canvas.getBoundingClientRect();
    const [x, y] = [clientX - left, clientY - top];
    const box = this.box;
    return x > box[0] - margin && y > box[1] - margin && x < box[2] + margin && y < box[3] + margin;
  }

  // The x in the world at a point of the window, m.
  xAt(clientX) {
    const { left, width } = this.canvas.getBoundingClientRect();
    return this.#view.middle + (clientX - left - width / 2) / this.#view.scale;
  }

  // The edge at a point of the window, or null.
  edgeAt(clientX, clientY) {
    return this.nearest(clientX, clientY, this.#drawn.map(([[x0, y0], [x1, y1], e]) => [e, (x, y) => {
      const [dx, dy] = [x1 - x0, y1 - y0];
      const share = Math.min(1, Math.max(0, ((x - x0) * dx + (y - y0) * dy) / (dx * dx + dy * dy || 1)));
      return Math.hypot(x0 + share * dx - x, y0 + share * dy - y);
    }]));
  }
}

// A robot and its walk.
class Walker {
  #unpacked = null;

  // `robot` has: `edges` [[i, j], …]; `rest`, their rest lengths (m); `start`, the positions at the start [x0, y0, …]
  // (m); and `payloads`. `world` is that of a `Stage`, and also has `sin`, the sine of its incline. `mixtures`: void,
  // skeleton and actuator of every edge, in thousandths. `walk`, which may be null, has: `every`, the seconds between
  // two frames; and `counts`, how far the nodes move between two frames, in multiples of `unit` (m).
  constructor(robot, world, mixtures, walk) {
    Object.assign(this, { robot, world, walk });
    this.mixtures = mixtures.map(shares => shares.map(share => share / 1000));
    this.edges = robot.edges.map(([i, j], e) => {
      const [, skeleton, actuator] = this.mixtures[e];
      const weight = skeleton + actuator;
      return [i, j, robot.rest[e], weight < SEEN ? 0 : skeleton >= actuator ? 1 : 2, e, weight];
    });
    this.bars = this.edges.filter(edge => edge[3] > 0);
    this.body = this.#bodyOf(robot.payloads);
  }

  // The payloads, and all nodes that bars connect to them.
  #bodyOf(payloads) {
    const body = new Set(payloads);
    const bars = this.bars.filter(bar => bar[5] > HOLDS);
    for (let before = -1; before !== body.size;) {
      before = body.size;
      for (const [i, j] of bars) if (body.has(i) || body.has(j)) body.add(i).add(j);
    }
    return body;
  }

  // The duration of the walk in seconds.
  get duration() {
    return this.walk ? this.walk.every * (this.walk.counts.length - 1) : 0;
  }

  get #frames() {
    this.#unpacked ??= this.#unpack();
    return this.#unpacked;
  }

  #unpack() {
    const { counts, unit } = this.walk ?? { counts: [this.robot.start], unit: 1 };
    let at = new Float64Array(counts[0].length);
    const places = counts.map(moved => {
      at = at.map((count, k) => count + moved[k]);
      return at.map(count => count * unit);
    });
    const payload = this.robot.payloads[0];
    const trail = places.flatMap(frame => [...frame.subarray(2 * payload, 2 * payload + 2)]);
    return { places, trail, cameras: this.#follow(places), tops: this.#topsOf(places) };
  }

  // The number of frames in half a second.
  get #around() {
    return Math.max(0, Math.round(0.5 / (this.walk?.every ?? 1)));
  }

  // The height of the body in every frame, with its highest places within half a second, averaged over a second: the
  // camera rises before the robot jumps, and does not shake.
  #topsOf(places) {
    const near = (list, k) => list.slice(Math.max(0, k - this.#around), k + this.#around + 1);
    const heights = places.map(frame => Math.max(...[...this.body].map(node => frame[2 * node + 1])));
    const highest = heights.map((_, k) => Math.max(...near(heights, k)));
    return highest.map((_, k) => near(highest, k).reduce((sum, height) => sum + height, 0) / near(highest, k).length);
  }

  // The path of the camera: the middle of the body and the ground around it, averaged over a second so that the picture
  // does not shake.
  #follow(places) {
    const middles = places.map(frame => {
      const along = [...this.body].map(node => frame[2 * node]);
      return (Math.min(...along) + Math.max(...along)) / 2;
    });
    const around = this.#around;
    const { width, ground } = this.world;
    return middles.map((_, k) => {
      const near = middles.slice(Math.max(0, k - around), k + around + 1);
      const x = near.reduce((sum, middle) => sum + middle, 0) / near.length;
      return [x, levelAround(ground, x, width / 4)];
    });
  }

  // What a `Stage` paints at a time, and how far the payload has moved along the ground by then, in metres.
  at(time) {
    const { places, trail, cameras, tops } = this.#frames;
    const place = this.walk ? Math.min(time / this.walk.every, places.length - 1) : 0;
    const [k, next] = [Math.floor(place), Math.ceil(place)];
    const between = (from, to) => from.map((x, i) => x + (place - k) * (to[i] - x));
    const positions = between(places[k], places[next]);
    const payload = 2 * this.robot.payloads[0];
    const [along, up] = [0, 1].map(axis => positions[payload + axis] - places[0][payload + axis]);
    return {
      positions, frame: Math.round(place), shape: places[Math.round(place)], edges: this.bars,
      camera: between(cameras[k], cameras[next]), top: between([tops[k]], [tops[next]])[0], trail: trail.slice(0, 2 * k + 2),
      metres: along * this.world.cos + up * this.world.sin,
    };
  }
}
