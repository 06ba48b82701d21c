"use strict";
// Draws robots, curves and mixtures on canvases, for reports, comparisons and the page in the folder `web`.

const FONT = 'system-ui, "Segoe UI", Helvetica, Arial, sans-serif';
const MATERIALS = ["void", "skeleton", "actuator"];
// A bar with a smaller fraction of solid material does not count as a connection of its nodes.
const HOLDS = 0.3;
// A bar with a smaller fraction of solid material is drawn as void.
const SEEN = 0.02;

// A canvas that has the resolution of the screen and the size of its element.
class Drawing {
  #scene = null;
  #colours = new Map();
  #size;
  #inView = true;

  constructor(canvas) {
    this.canvas = canvas;
    this.pen = canvas.getContext("2d");
    this.#size = [canvas.clientWidth, canvas.clientHeight];
    new ResizeObserver(() => {
      this.#size = [canvas.clientWidth, canvas.clientHeight];
      this.#again();
    }).observe(canvas);
    new IntersectionObserver(entries => {
      this.#inView = entries[entries.length - 1].isIntersecting;
      this.#again();
    }).observe(canvas);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
      this.#colours.clear();
      this.#again();
    });
  }

  // Draws `scene`, the data of what is shown, with the method `paint` of each kind of drawing. The scene is drawn again
  // when the canvas comes into view, and when size or colours change.
  draw(scene) {
    this.#scene = scene;
    const [width, height] = this.#size;
    if (!this.#inView || width === 0 || height === 0) return;
    const sharp = devicePixelRatio || 1;
    const [across, down] = [Math.round(width * sharp), Math.round(height * sharp)];
    if (this.canvas.width !== across || this.canvas.height !== down) {
      this.canvas.width = across;
      this.canvas.height = down;
    }
    this.pen.setTransform(across / width, 0, 0, down / height, 0, 0);
    this.pen.clearRect(0, 0, width, height);
    this.pen.lineCap = this.pen.lineJoin = "round";
    this.paint(scene, width, height);
  }

  #again() {
    if (this.#scene !== null) this.draw(this.#scene);
  }

  // The colour of `theme.css` with this name.
  colour(name) {
    return this.#kept(name, () => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim());
  }

  #kept(name, compute) {
    if (!this.#colours.has(name)) this.#colours.set(name, compute());
    return this.#colours.get(name);
  }

  // The colour for a number from 0 to 1, in 9 shades: `--skeleton` at 0, `--beyond` at 1.
  strained(share) {
    const k = Math.round(8 * Math.min(1, Math.max(0, share)));
    return this.#kept(`strained ${k}`, () => {
      const rgb = name => [1, 3, 5].map(i => parseInt(this.colour(name).slice(i, i + 2), 16));
      const end = rgb("beyond");
      return `rgb(${rgb("skeleton").map((from, i) => Math.round(from + k / 8 * (end[i] - from)))})`;
    });
  }

  // The colour for a number from -1 to 1, in 33 shades: `--shorter` at -1, `--rest` at 0, `--longer` at 1.
  shade(share) {
    const k = Math.round(16 * share);
    return this.#kept(k, () => {
      const rgb = name => [1, 3, 5].map(i => parseInt(this.colour(name).slice(i, i + 2), 16));
      const end = rgb(k < 0 ? "shorter" : "longer");
      return `rgb(${rgb("rest").map((from, i) => Math.round(from + Math.abs(k) / 16 * (end[i] - from)))})`;
    });
  }

  line(points, colour, width) {
    const pen = this.pen;
    pen.strokeStyle = colour;
    pen.lineWidth = width;
    pen.beginPath();
    for (const [x, y] of points) pen.lineTo(x, y);
    pen.stroke();
  }

  fill(points, colour) {
    const pen = this.pen;
    pen.beginPath();
    for (const [x, y] of points) pen.lineTo(x, y);
    pen.fillStyle = colour;
    pen.fill();
  }

  disc(x, y, radius, fill, edge) {
    const pen = this.pen;
    pen.beginPath();
    pen.arc(x, y, radius, 0, 2 * Math.PI);
    pen.fillStyle = fill;
    pen.fill();
    if (edge) {
      pen.strokeStyle = edge;
      pen.lineWidth = 1.5;
      pen.stroke();
    }
  }

  text(text, x, y, colour = "muted", align = "left", font = "12px") {
    const pen = this.pen;
    pen.font = `${font} ${FONT}`;
    pen.fillStyle = this.colour(colour);
    pen.textAlign = align;
    pen.fillText(text, x, y);
  }

  // The width of a text in the font of 12 pixels.
  measure(text) {
    this.pen.font = `12px ${FONT}`;
    return this.pen.measureText(text).width;
  }

  // The edge that is nearest to a point of the window and at most 12 pixels away, or null. `marks` is a list of
  // [edge, distance], where `distance` is a function of a place on the canvas.
  nearest(clientX, clientY, marks) {
    const box = this.canvas.getBoundingClientRect();
    let [least, nearest] = [12, null];
    for (const [edge, distance] of marks) {
      const off = distance(clientX - box.left, clientY - box.top);
      if (off < least) [least, nearest] = [off, edge];
    }
    return nearest;
  }
}

// The height at `x` of ground with the corners [[x, y], …]. It is level before the first corner and after the last.
function levelAt(ground, x) {
  const ahead = ground.findIndex(corner => corner[0] > x);
  if (ahead <= 0) return (ahead === 0 ? ground[0] : ground[ground.length - 1] ?? [0, 0])[1];
  const [[x0, y0], [x1, y1]] = [ground[ahead - 1], ground[ahead]];
  return y0 + (y1 - y0) * (x - x0) / (x1 - x0);
}

// The mean height of ground over `width` around `x`. A camera that follows it does not jump where the ground has a
// step.
function levelAround(ground, x, width) {
  const levels = Array.from({ length: 17 }, (_, k) => levelAt(ground, x + width * (k / 16 - 0.5)));
  return levels.reduce((sum, level) => sum + level, 0) / levels.length;
}

// Calls `tick(seconds)` for every frame of the screen. `seconds` is the time since the last frame.
function everyFrame(tick) {
  let last = null;
  const frame = stamp => {
    // Limited, so that a page that was hidden does not jump ahead.
    tick(last === null ? 0 : Math.min(0.1, (stamp - last) / 1000));
    last = stamp;
    requestAnimationFrame(frame);
  };
  requestAnimationFrame(frame);
}

// Calls `toggle` when the space bar is pressed, unless the focus is in a text field. The bar then has no other effect.
function playBySpace(toggle) {
  for (const kind of ["keydown", "keyup"]) {
    addEventListener(kind, event => {
      const field = event.target.closest?.("input:not([type=range]), textarea, [contenteditable]");
      if (event.key !== " " || field || event.ctrlKey || event.metaKey || event.altKey) return;
      event.preventDefault();
      if (kind === "keydown" && !event.repeat) toggle();
    }, true);
  }
}

const startsPlaying = () => !matchMedia("(prefers-reduced-motion: reduce)").matches;

// A number with `digits` decimals and a typographic minus sign.
const decimals = (x, digits) => x.toFixed(digits).replace("-", "\u2212");

// The smallest of 1, 2 and 5 times a power of ten that is at least `least`.
function roundStep(least) {
  const decade = 10 ** Math.floor(Math.log10(least));
  return [1, 2, 5, 10].find(k => k * decade >= least * (1 - 1e-9)) * decade;
}

// The number of decimals that multiples of a step need.
const digitsOf = step => Math.max(0, -Math.floor(Math.log10(step) + 1e-9));

// A robot on its ground. Lengths are metres in the frame of the world.
class Stage extends Drawing {
  #world;
  #drawn = [];

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
  // Optional: `trail`, the path of the payload [x, y, …]; `highlight`, an edge; `label`, a text for the upper left
  // corner; `shape`, positions from which strains are computed instead; `colours`, one for each edge, instead of
  // materials and strains; `goal`, the foot [x, y] of a flag, and `goalLabel`, the text at the flag; `ghost`, the positions
  // and edges of another robot, which is drawn faintly; `arrow`, how far [x, y] (pixels) an arrow from the robot points.
  paint({ positions, edges, camera, trail = [], highlight = null, label = "", shape = positions, colours = null, goal = null, goalLabel = "", ghost = null, arrow = null }, width, height) {
    const scale = Math.min(2.4 * height, 2 * width) / this.#world.width;
    const place = (x, y) => [width / 2 + (x - camera[0]) * scale, 0.8 * height - (y - camera[1]) * scale];
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

  // Whether a point of the window is within the box around the bars, or near it.
  isNear(clientX, clientY, margin = 16) {
    const box = this.canvas.getBoundingClientRect();
    const within = (at, places) => at > Math.min(...places) - margin && at < Math.max(...places) + margin;
    const ends = this.#drawn.flatMap(([from, to]) => [from, to]);
    return within(clientX - box.left, ends.map(([x]) => x)) && within(clientY - box.top, ends.map(([, y]) => y));
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
    return { places, trail, cameras: this.#follow(places) };
  }

  // The path of the camera: the middle of the body and the ground around it, averaged over a second so that the picture
  // does not shake.
  #follow(places) {
    const middles = places.map(frame => {
      const along = [...this.body].map(node => frame[2 * node]);
      return (Math.min(...along) + Math.max(...along)) / 2;
    });
    const around = Math.max(0, Math.round(0.5 / (this.walk?.every ?? 1)));
    const { width, ground } = this.world;
    return middles.map((_, k) => {
      const near = middles.slice(Math.max(0, k - around), k + around + 1);
      const x = near.reduce((sum, middle) => sum + middle, 0) / near.length;
      return [x, levelAround(ground, x, width / 4)];
    });
  }

  // What a `Stage` paints at a time, and how far the payload has moved along the ground by then, in metres.
  at(time) {
    const { places, trail, cameras } = this.#frames;
    const place = this.walk ? Math.min(time / this.walk.every, places.length - 1) : 0;
    const [k, next] = [Math.floor(place), Math.ceil(place)];
    const between = (from, to) => from.map((x, i) => x + (place - k) * (to[i] - x));
    const positions = between(places[k], places[next]);
    const payload = 2 * this.robot.payloads[0];
    const [along, up] = [0, 1].map(axis => positions[payload + axis] - places[0][payload + axis]);
    return {
      positions, frame: Math.round(place), shape: places[Math.round(place)], edges: this.bars,
      camera: between(cameras[k], cameras[next]), trail: trail.slice(0, 2 * k + 2),
      metres: along * this.world.cos + up * this.world.sin,
    };
  }
}

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
      this.text(log ? (10 ** (k * step)).toPrecision(1).replace("-", "\u2212") : decimals(k * step, digitsOf(step)), left - 8, y + 4, "muted", "right");
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
    return log ? point[1].toExponential(1).replace("-", "\u2212") : decimals(point[1], digits);
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
