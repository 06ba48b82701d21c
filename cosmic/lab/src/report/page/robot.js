"use strict";
// A robot that walks on its ground.

// A bar with a smaller fraction of solid material does not count as a connection of its nodes.
const HOLDS = 0.3;
// A bar with a smaller fraction of solid material is drawn as void.
const SEEN = 0.02;
// The fraction of the drawing's height that stays free above the robot: the camera rises with a robot that jumps higher.
const ABOVE = 0.1;
// How far the lane of a ghost is above the robot's ground, as a fraction of the drawing's height; and, in views from above,
// behind the robot, as a fraction of the width of the world.
const LANE = [0.42, 0.3];

// A robot on its ground. Lengths are metres in the frame of the world, and points are (along, across, above).
class Stage extends Drawing {
  #world;
  #drawn = [];
  // How points become places on the drawing: the eye, the point that is in the middle, its height in pixels, and pixels
  // per metre.
  #sight = { eye: new Eye(SIDE), middle: [0, 0, 0], base: 0, scale: 1 };
  // The `Orbit` that turns the view; null if it does not turn.
  orbit = null;

  // `world` has: `width`, how much of the world a canvas shows that is 2.4 times as wide as high; `ground`, its corners
  // [[x, z], …] from left to right; `cos`, the cosine of its incline; `limit`, the strain at which actuators have their
  // full colour. Optional: `view`, if the view does not turn (default: from the side); `payloads`, the nodes that carry one
  // (default [0]); `origin`, the x at which marks along the ground begin (default 0); `isMarked`,
  // whether there are marks (default true); `skeleton`, the strains at which
  // skeleton bars begin to change their colour and have their full colour (default: they do not change it); `finish`, the x
  // of a finish line.
  constructor(canvas, world) {
    super(canvas);
    this.world = world;
  }

  set world(world) {
    this.#world = { payloads: [0], origin: 0, view: SIDE, isMarked: true, ...world };
  }

  // Paints one moment. `positions`: [x0, y0, z0, x1, …]. `edges`: a list of [i, j, rest length, material, edge,
  // weight], where the material is 0 (void, drawn faint), 1 (skeleton) or 2 (actuator), and a bar with a weight below 1 is
  // thinner and fainter; undecided bars are hairlines. `camera`: the point that is in the middle of the drawing, above its
  // lower edge.
  // Optional: `top`, the height that must be in view; `level`, the point whose height on the drawing is that of the camera
  // (default: the camera); `trail`, the path of the payload [x, y, z, …]; `highlight`, an edge; `label`, a text for the
  // upper left corner; `shape`, positions from which strains are computed instead; `colours`, one for each edge, instead of
  // materials and strains; `goal`, the foot [x, y, z] of a flag, and `goalLabel`, the text at the flag; `ghost`, the positions
  // and edges of another robot, which is drawn faintly, and, if it has its own `lane`, the words there; `tints`, from -1 to 1 for every
  // edge, a colour beside its bar; `arrow`, how far [x, y] (pixels) an arrow from the robot points.
  paint({ positions, edges, camera, top = -Infinity, level = camera, trail = [], highlight = null, label = "", shape = positions, colours = null, goal = null, goalLabel = "", ghost = null, tints = null, arrow = null }, width, height) {
    const eye = new Eye(this.orbit?.view ?? this.#world.view);
    const scale = Math.min(2.4 * height, 2 * width) / this.#world.width;
    const base = (0.8 - 0.3 * eye.tilt) * height;
    const [right, , away] = eye.see(...camera);
    const up = eye.see(...level)[1];
    // The camera rises with a robot that would leave the drawing.
    const rise = Math.max(0, eye.flat * (top - level[2]) + 0.1 * eye.tilt * this.#world.width - (base / height - ABOVE) * height / scale);
    const place = (x, y, z) => {
      const seen = eye.see(x, y, z);
      return [width / 2 + (seen[0] - right) * scale, base - (seen[1] - up - rise) * scale, seen[2] - away];
    };
    // The point of the ground in the middle of the drawing, at the height `base`.
    const deep = eye.sin * level[0] + eye.cos * level[1];
    const middle = [eye.cos * right + eye.sin * deep, eye.cos * deep - eye.sin * right, level[2]];
    const sight = { eye, place, middle, base: base + rise * scale, scale, world: this.#world };
    this.#sight = sight;
    const { payloads, ground, finish } = this.#world;
    const thick = Math.min(6, Math.max(1.4, height / 130));
    if (eye.isSide) this.#paintGround(place, camera[0], width / scale / 2, scale, height);
    else {
      paintGrid(this, sight, width, height);
      paintShadows(this, sight, positions, edges, thick);
    }
    if (goal) this.#paintFlag(place(...goal), goalLabel, width, height);
    if (finish !== undefined && eye.isSide) this.#paintFinish(place(finish, 0, levelAt(ground, finish)), width, height);
    if (finish !== undefined && !eye.isSide) this.#paintFinishLine(finish, place);
    const nodes = [];
    for (let k = 0; k < positions.length; k += 3) nodes.push(place(positions[k], positions[k + 1], positions[k + 2]));
    if (ghost) this.#paintGhost(ghost, { place, isSide: eye.isSide, middle: camera[0], half: width / scale / 2 }, width, height);
    this.pen.globalAlpha = 0.7;
    const path = [];
    for (let k = 0; k < trail.length; k += 3) path.push(place(trail[k], trail[k + 1], trail[k + 2]));
    if (trail.length > 0) path.push(nodes[payloads[0]]);
    this.line(path, this.colour("payload"), 1.5);
    this.#drawn = edges.map(edge => [nodes[edge[0]], nodes[edge[1]], edge[4]]);
    const chosen = highlight === null ? undefined : this.#drawn.find(([, , e]) => e === highlight);
    if (tints) this.#paintTints(tints, thick);
    this.pen.globalAlpha = 0.35;
    if (chosen) this.line(chosen.slice(0, 2), this.colour("accent"), 3 * thick + 6);
    const bars = edges.map(edge => this.#bar(edge, nodes[edge[0]], nodes[edge[1]], shape, colours, thick));
    const discs = payloads.map(i => ({ at: nodes[i], radius: 1.2 + 1.7 * thick, colour: this.colour("payload"), rank: 3, away: nodes[i][2] }));
    paintBars(this, bars, discs, 0.1 * this.#world.width);
    if (arrow) this.#paintArrow(nodes[payloads[0] ?? 0], arrow);
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

  #paintGhost({ positions, edges, lane = null }, { place, isSide, middle, half }, width, height) {
    const [up, behind] = lane === null ? [0, 0] : isSide ? [LANE[0] * height, 0] : [0, LANE[1] * this.#world.width];
    const there = (x, y, z) => place(x, y + behind, z).map((at, axis) => (axis === 1 ? at - up : at));
    const node = i => there(positions[3 * i], positions[3 * i + 1], positions[3 * i + 2]);
    if (lane !== null) {
      const ground = this.#groundLine(there, middle, half);
      this.line(ground, this.colour("rule"), 1.5);
      const [x, y] = node(this.#world.payloads[0] ?? 0);
      const [low, high] = [14, width - 14];
      this.text(lane, low, ground[0][1] + 18, "muted", "left", "600 13px");
      // A chevron at the edge shows where a robot out of view is.
      const [tip, back] = x < 0 ? [low, 12] : [high, -12];
      if (x < 0 || x > width) this.line([[tip + back, y - 12], [tip, y], [tip + back, y + 12]], this.colour("muted"), 4);
    }
    this.pen.globalAlpha = lane === null ? 0.16 : 0.5;
    for (const [i, j, , , , weight] of edges) this.line([node(i), node(j)], this.colour("ink"), Math.max(1.4, height / 130) * weight);
    this.pen.globalAlpha = 1;
  }

  // Paints the tints beside the bars: `--good` where more material is better, `--fourth` where less is.
  #paintTints(tints, thick) {
    for (const [from, to, e] of this.#drawn) {
      this.pen.globalAlpha = 0.6 * Math.sqrt(Math.abs(tints[e]));
      this.line([from, to], this.colour(tints[e] > 0 ? "good" : "fourth"), 3 * thick);
    }
    this.pen.globalAlpha = 1;
  }

  // The line of the ground around the middle of the drawing.
  #groundLine(place, middle, half) {
    const { ground } = this.#world;
    const [left, right] = [middle - half, middle + half];
    const ends = [left, right].map(x => [x, levelAt(ground, x)]);
    const corners = ground.filter(([x]) => left < x && x < right);
    return [ends[0], ...corners, ends[1]].map(([x, z]) => place(x, 0, z));
  }

  // Paints a finish line across the ground: a chequered strip.
  #paintFinishLine(x, place) {
    const { width, ground } = this.#world;
    const side = width / 50;
    for (let k = -12; k < 12; k++) {
      for (const column of [0, 1]) {
        const corners = [[column - 1, k], [column, k], [column, k + 1], [column - 1, k + 1]];
        const at = ([along, across]) => place(x + along * side, across * side, levelAt(ground, x + along * side));
        this.fill(corners.map(at), this.colour((k + column) % 2 ? "rule" : "muted"));
      }
    }
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

  // A bar in the form that `paintBars` takes. Indices are faster than destructuring until the browser has compiled them.
  #bar(edge, from, to, shape, colours, thick) {
    const material = edge[3];
    const weight = edge[5];
    let colour = colours?.[edge[4]] ?? this.colour(MATERIALS[material]);
    const { skeleton } = this.#world;
    if (!colours && (material === 2 || (material === 1 && skeleton))) {
      const strain = distance(shape, edge[0], edge[1]) / edge[2] - 1;
      colour = material === 2 ? this.strainColour(strain) : this.strained((Math.abs(strain) - skeleton[0]) / (skeleton[1] - skeleton[0]));
    }
    // Bars between two materials are hairlines, which become thick as they are decided.
    const width = material === 0 ? 0.5 * thick * weight : Math.max(0.7, thick * (material === 2 ? 1.45 : 1) * weight ** 5);
    const share = material === 0 ? 0.8 : 0.1 + 0.9 * weight;
    return { from, to, colour, width, share, rank: material, hides: material > 0 && weight > CASTS, away: (from[2] + to[2]) / 2 };
  }

  // The colour for an actuator's strain. Strains beyond the limit have a special colour.
  strainColour(strain) {
    const share = strain / this.#world.limit;
    return Math.abs(share) > 1 ? this.colour("beyond") : this.shade(share);
  }

  // Paints the ground from the side, and marks at equal distances along it. Displacements are measured along the ground too.
  #paintGround(place, middle, half, scale, height) {
    const { ground, cos, origin } = this.#world;
    const [left, right] = [middle - half, middle + half];
    const line = this.#groundLine(place, middle, half);
    this.fill([...line, [2 * half * scale, height + 1], [0, height + 1]], this.colour("earth"));
    this.line(line, this.colour("muted"), 1.5);
    if (!this.#world.isMarked) return;
    const named = roundStep(64 / scale);
    const parts = String(named).replace(/[0.]/g, "")[0] === "2" ? 4 : 5;
    const between = named / parts;
    for (let k = Math.ceil((left - origin) / cos / between); origin + k * between * cos <= right; k++) {
      const at = origin + k * between * cos;
      const [x, y] = place(at, 0, levelAt(ground, at));
      this.line([[x, y], [x, y + (k % parts ? 4 : 8)]], this.colour("muted"), 1);
      if (k % parts === 0) this.text(`${decimals(k * between, digitsOf(named))} m`, x, y + 23, "muted", "center");
    }
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

  // The place [x, y] of the ground at a point of the window, m. Seen from the side, it has the y of the middle of the view.
  groundAt(clientX, clientY) {
    const { left, top, width } = this.canvas.getBoundingClientRect();
    const { eye, middle, base, scale } = this.#sight;
    const right = (clientX - left - width / 2) / scale;
    const away = eye.tilt > 0.02 ? (base - (clientY - top)) / scale / eye.tilt : 0;
    if (eye.tilt <= 0.02) return [middle[0] + right / (eye.cos || 1), middle[1]];
    return [middle[0] + eye.cos * right + eye.sin * away, middle[1] + eye.cos * away - eye.sin * right];
  }

  // The velocity in the world of a push that moves points by (x, y) pixels to the right and down on the drawing.
  pushOf(x, y) {
    return this.#sight.eye.back(x, -y);
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

// The distance between two nodes, m.
const distance = (at, i, j) => Math.hypot(at[3 * i] - at[3 * j], at[3 * i + 1] - at[3 * j + 1], at[3 * i + 2] - at[3 * j + 2]);

// Returns a function that computes the value of a frame when it is first needed, so that a walk can begin at once.
function kept(compute) {
  const values = [];
  return frame => (values[frame] ??= compute(frame));
}

// A robot and its walk.
class Walker {
  #unpacked = null;

  // `robot` has: `edges` [[i, j], …]; `rest`, their rest lengths (m); `axes`, 3 if it is in
  // space; `start`, the positions at the start [x0, y0, z0, …] (m); and `payloads`. `world` is that of a `Stage`, and also has `sin`, the sine of its incline. `mixtures`: void,
  // skeleton and actuator of every edge, in thousandths. `walk`, which may be null, has: `every`, the seconds between
  // two frames; `axes`, 3 if it is in space; and `counts`, how far the nodes move between two frames, in multiples of `unit`
  // (m): along and above, or along, across and above.
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

  // Replaces the frames of the walk.
  set frames(walk) {
    this.walk = walk;
    this.#unpacked = null;
  }

  // The positions in a frame of the walk.
  placesAt(frame) {
    return this.#frames.places[frame];
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
    const { counts, unit, axes = 2 } = this.walk ?? { counts: [this.robot.start], unit: 1, axes: 3 };
    const at = new Float64Array(counts[0].length);
    const places = counts.map(moved => {
      const place = new Float64Array(3 * at.length / axes);
      for (let k = 0; k < at.length; k++) {
        at[k] += moved[k];
        place[axes === 3 ? k : 3 * (k >> 1) + 2 * (k & 1)] = at[k] * unit;
      }
      return place;
    });
    const payload = 3 * this.robot.payloads[0];
    const trail = new Float64Array(3 * places.length);
    places.forEach((frame, k) => trail.set(frame.subarray(payload, payload + 3), 3 * k));
    return { places, trail, cameraAt: this.#follow(places), topAt: this.#topsOf(places) };
  }

  // The number of frames in half a second.
  get #around() {
    return Math.max(0, Math.round(0.5 / (this.walk?.every ?? 1)));
  }

  // The height of the body in a frame, with its highest places within half a second, averaged over a second: the camera
  // rises before the robot jumps, and does not shake.
  #topsOf(places) {
    const heightAt = kept(frame => this.#extent(places[frame], 2)[1]);
    return this.#averaged(kept(frame => {
      const last = this.#last(frame);
      let most = -Infinity;
      for (let k = this.#first(frame); k <= last; k++) most = Math.max(most, heightAt(k));
      return most;
    }));
  }

  // The camera in a frame: the middle of the body and the ground around it, averaged over a second so that the picture
  // does not shake.
  #follow(places) {
    const { width, ground } = this.world;
    const [xAt, yAt] = [0, 1].map(axis => this.#averaged(kept(frame => {
      const [least, most] = this.#extent(places[frame], axis);
      return (least + most) / 2;
    })));
    return kept(frame => [xAt(frame), yAt(frame), levelAround(ground, xAt(frame), width / 4)]);
  }

  // Averages a number of every frame over a second.
  #averaged(numberAt) {
    return kept(frame => {
      const first = this.#first(frame);
      const last = this.#last(frame);
      let sum = 0;
      for (let k = first; k <= last; k++) sum += numberAt(k);
      return sum / (last - first + 1);
    });
  }

  // The first and the last frame within half a second.
  #first(frame) {
    return Math.max(0, frame - this.#around);
  }

  #last(frame) {
    return Math.min(this.walk ? this.walk.counts.length - 1 : 0, frame + this.#around);
  }

  // The least and the greatest coordinate of the body on an axis.
  #extent(positions, axis) {
    let least = Infinity;
    let most = -Infinity;
    for (const node of this.body) {
      const x = positions[3 * node + axis];
      least = Math.min(least, x);
      most = Math.max(most, x);
    }
    return [least, most];
  }

  // What a `Stage` paints at a time, and how far the payload has moved along the ground by then, in metres.
  at(time) {
    const { places, trail, cameraAt, topAt } = this.#frames;
    const place = this.walk ? Math.min(time / this.walk.every, places.length - 1) : 0;
    const [k, next] = [Math.floor(place), Math.ceil(place)];
    const share = place - k;
    const between = (from, to) => from + share * (to - from);
    const positions = places[k].slice();
    const after = places[next];
    for (let i = 0; i < positions.length; i++) positions[i] += share * (after[i] - positions[i]);
    const payload = 3 * this.robot.payloads[0];
    const [along, up] = [0, 2].map(axis => positions[payload + axis] - places[0][payload + axis]);
    return {
      positions, frame: Math.round(place), shape: places[Math.round(place)], edges: this.bars,
      camera: cameraAt(k).map((from, axis) => between(from, cameraAt(next)[axis])), top: between(topAt(k), topAt(next)),
      trail: trail.subarray(0, 3 * k + 3),
      metres: along * this.world.cos + up * this.world.sin,
    };
  }
}
