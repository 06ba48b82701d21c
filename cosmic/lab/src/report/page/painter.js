"use strict";
// How robots are seen, for reports, comparisons and the page in the folder `web`: the projection, what lies on the ground,
// the bars from the farthest to the nearest, and the controls that turn the view. Points are (along, across, above), in
// metres.

// Views, as [yaw, pitch] in degrees. From the side, along points to the right, and across points away from the viewer.
const SIDE = [0, 0];
const THREE_QUARTERS = [-40, 18];
// The fraction of its colour that the farthest bar loses to the colour of the paper.
const FOG = 0.62;
// How far the paper shows on either side of a bar in front of other bars, in pixels.
const HALO = 1.6;
// A bar with a smaller fraction of solid material casts no shadow and hides nothing.
const CASTS = 0.8;
// How far the view sways to either side, in degrees, and the duration of a sway in seconds.
const SWAY = 7;
const SWAYS = 16;

// The view in which a robot is shown at first.
const viewOf = robot => (robot.axes === 3 ? THREE_QUARTERS : SIDE);

// A parallel projection. The file `eye.rs` has the same one for pictures.
class Eye {
  constructor([yaw, pitch]) {
    const turn = degrees => [Math.cos(degrees * Math.PI / 180), Math.sin(degrees * Math.PI / 180)];
    [this.cos, this.sin] = turn(yaw);
    [this.flat, this.tilt] = turn(pitch);
  }

  // Whether the ground is seen as a line.
  get isSide() {
    return this.sin === 0 && this.tilt === 0;
  }

  // How far a point is to the right, up, and away from the viewer.
  see(x, y, z) {
    const away = this.sin * x + this.cos * y;
    return [this.cos * x - this.sin * y, this.flat * z + this.tilt * away, this.flat * away - this.tilt * z];
  }

  // How `see` sees each of the points [x0, y0, z0, x1, …].
  seeAll(points) {
    return points.filter((_, k) => k % 3 === 0).map((x, i) => this.see(x, points[3 * i + 1], points[3 * i + 2]));
  }

  // The vector in the world that points to the right and up on the drawing.
  back(right, up) {
    return [this.cos * right + this.tilt * this.sin * up, this.tilt * this.cos * up - this.sin * right, this.flat * up];
  }
}

// Paints the ground as a grid whose lines are a round number of metres apart, and fades towards the back. `place` maps a
// point to the drawing; `middle` is the point that is on the drawing at the height `base`.
function paintGrid(drawing, { eye, place, middle, base, scale, world }, width, height) {
  const { pen } = drawing;
  const { ground, cos, origin, width: seen } = world;
  const level = x => levelAt(ground, x);
  const step = roundStep(80 / scale);
  // The ground in view, to the right of the middle and away from it, m.
  const half = width / scale / 2;
  const depth = pixels => Math.min(3 * half, pixels / scale / Math.max(eye.tilt, 1e-3));
  const [near, far] = [depth(height - base + 40), depth(base)];
  // The part of the line from (x, y) in the direction (dx, dy) that is in view: its ends, as multiples of (dx, dy).
  const within = (x, y, dx, dy) => {
    let from = -Infinity;
    let to = Infinity;
    const clip = (at, by, low, high) => {
      if (Math.abs(by) > 1e-9) {
        from = Math.max(from, Math.min((low - at) / by, (high - at) / by));
        to = Math.min(to, Math.max((low - at) / by, (high - at) / by));
      } else if (at < low || at > high) to = -Infinity;
    };
    const [a, b] = [x - middle[0], y - middle[1]];
    clip(eye.cos * a - eye.sin * b, eye.cos * dx - eye.sin * dy, -half, half);
    clip(eye.sin * a + eye.cos * b, eye.sin * dx + eye.cos * dy, -near, far);
    return [from, to];
  };
  const corners = [-half, half].flatMap(right => [-near, far].map(away => [eye.cos * right + eye.sin * away, eye.cos * away - eye.sin * right]));
  const reach = axis => corners.map(corner => middle[axis] + corner[axis]);
  const marks = (axis, from, apart) => {
    const [low, high] = [Math.min(...reach(axis)), Math.max(...reach(axis))].map(end => (end - from) / apart);
    return Array.from({ length: Math.max(0, Math.floor(high) - Math.ceil(low) + 1) }, (_, k) => Math.ceil(low) + k);
  };
  pen.beginPath();
  const through = points => points.forEach(([x, y, z], k) => {
    const at = place(x, y, z);
    if (k > 0) pen.lineTo(at[0], at[1]);
    else pen.moveTo(at[0], at[1]);
  });
  for (const k of marks(0, origin, step * cos)) {
    const x = origin + k * step * cos;
    const [from, to] = within(x, 0, 0, 1);
    if (from < to) through([from, to].map(y => [x, y, level(x)]));
  }
  for (const k of marks(1, 0, step)) {
    const [from, to] = within(0, k * step, 1, 0);
    const between = ground.map(([x]) => x).filter(x => from < x && x < to);
    if (from < to) through([from, ...between, to].map(x => [x, k * step, level(x)]));
  }
  const fade = pen.createLinearGradient(0, base + near * eye.tilt * scale, 0, base - far * eye.tilt * scale - 1);
  fade.addColorStop(0.3, drawing.colour("rule"));
  fade.addColorStop(0.95, drawing.colour("back"));
  pen.strokeStyle = fade;
  pen.lineWidth = 1;
  pen.stroke();
  if (!world.isMarked || (width < 320 && height < 240)) return;
  // Numbers in front of the robot, along the ground, or across it if the viewer looks along it.
  const [axis, turn] = Math.abs(eye.cos) > 0.3 ? [0, eye.cos] : [1, eye.sin];
  const apart = Math.max(1, Math.round(0.2 * seen / step)) * step;
  const front = Math.round((middle[1 - axis] - Math.sign(turn) * apart) / step) * step;
  for (const k of marks(axis, axis ? 0 : origin, axis ? step : step * cos)) {
    const at = axis ? k * step : origin + k * step * cos;
    const [x, y] = axis ? place(front, at, level(front)) : place(at, front, level(at));
    if (x > 24 && x < width - 24 && y < height - 16 && y > 48) drawing.text(`${decimals(k * step, digitsOf(step))} m`, x, y + 15, "muted", "center");
  }
}

// Paints the shadows that bars cast straight down, and a blob under each node that is near the ground.
function paintShadows(drawing, { place, eye, scale, world }, positions, bars, thick) {
  const { pen } = drawing;
  const [levels, below] = [[], []];
  for (let k = 0; k < positions.length; k += 3) {
    const level = levelAt(world.ground, positions[k]);
    levels.push(level);
    below.push(place(positions[k], positions[k + 1], level));
  }
  const nodes = new Set();
  pen.beginPath();
  for (const bar of bars) {
    if (bar[3] === 0 || bar[5] < CASTS) continue;
    const [from, to] = [below[bar[0]], below[bar[1]]];
    pen.moveTo(from[0], from[1]);
    pen.lineTo(to[0], to[1]);
    nodes.add(bar[0]).add(bar[1]);
  }
  pen.strokeStyle = drawing.colour("shadow");
  pen.lineWidth = 1.7 * thick;
  pen.stroke();
  pen.fillStyle = drawing.colour("shadow");
  const radius = Math.max(2.4 * thick, 0.012 * world.width * scale);
  for (const i of nodes) {
    const near = 1 - (positions[3 * i + 2] - levels[i]) / (0.02 * world.width);
    if (near <= 0) continue;
    pen.globalAlpha = near;
    pen.beginPath();
    pen.ellipse(below[i][0], below[i][1], radius, radius * Math.max(eye.tilt, 0.05), 0, 0, 2 * Math.PI);
    pen.fill();
  }
  pen.globalAlpha = 1;
}

// Paints bars and discs from the farthest to the nearest. `bars`: a list of { from, to, colour, width, share, rank, away,
// hides }, where `from` and `to` are [x, y, away], `share` is how opaque the bar is, `rank` the order of parts at one depth,
// and a bar that `hides` has a halo in the colour of the paper. `discs`: a list of { at, radius, colour, rank, away }.
// `least`: the depth over which the fog becomes as thick as it gets, at least, in the unit of `away`.
function paintBars(drawing, bars, discs, least) {
  const { pen } = drawing;
  const back = drawing.colour("back");
  let near = Infinity;
  let far = -Infinity;
  for (const { away } of bars) {
    near = Math.min(near, away);
    far = Math.max(far, away);
  }
  const isDeep = far - near > 1e-6 * least;
  const deep = Math.max(far - near, least);
  const stroke = (x0, y0, x1, y1, colour, width) => {
    pen.strokeStyle = colour;
    pen.lineWidth = width;
    pen.beginPath();
    pen.moveTo(x0, y0);
    pen.lineTo(x1, y1);
    pen.stroke();
  };
  for (const part of [...bars, ...discs].sort((a, b) => b.away - a.away || a.rank - b.rank)) {
    if (part.at) {
      pen.globalAlpha = 1;
      drawing.disc(part.at[0], part.at[1], part.radius, part.colour, back);
      continue;
    }
    const { from, to, width } = part;
    if (isDeep && part.hides) {
      const x = to[0] - from[0];
      const y = to[1] - from[1];
      // Where bars meet, a halo would cut them.
      const cut = Math.max(2 * width, 4) / (Math.hypot(x, y) || 1);
      if (cut < 0.4) {
        pen.globalAlpha = 1;
        pen.lineCap = "butt";
        stroke(from[0] + cut * x, from[1] + cut * y, to[0] - cut * x, to[1] - cut * y, back, width + 2 * HALO);
        pen.lineCap = "round";
      }
    }
    pen.globalAlpha = part.share * (1 - FOG * Math.min(1, Math.max(0, part.away - near) / deep));
    stroke(from[0], from[1], to[0], to[1], part.colour, width);
  }
  pen.globalAlpha = 1;
}

// Turns the view: by a drag with the mouse or a finger, by two fingers, and by the arrow keys. The key Home turns it back.
// The view of a robot in space sways slowly until it is turned, unless the reader prefers less motion.
class Orbit {
  #home;
  #view;
  #isTurned = false;
  #swayed = 0;
  #still = matchMedia("(prefers-reduced-motion: reduce)");

  constructor(home) {
    this.home = home;
  }

  // The view at first, and after the key Home.
  set home(home) {
    if (this.#home === home) return;
    this.#home = home;
    this.reset();
  }

  // Whether the robot that is shown is in space.
  get isOfSpace() {
    return this.#home !== SIDE;
  }

  get view() {
    const [yaw, pitch] = this.#view;
    const sways = this.isOfSpace && !this.#isTurned && !this.#still.matches;
    return sways ? [yaw + SWAY * Math.sin(2 * Math.PI * this.#swayed / SWAYS), pitch] : [yaw, pitch];
  }

  reset() {
    this.#view = [...this.#home];
    this.#isTurned = false;
    this.#swayed = 0;
  }

  turn(yaw, pitch) {
    this.#view = this.view.map((angle, k) => angle + [yaw, pitch][k]);
    this.#view[0] -= 360 * Math.round(this.#view[0] / 360);
    this.#view[1] = Math.min(90, Math.max(0, this.#view[1]));
    this.#isTurned = true;
  }

  // Lets the view sway for some seconds.
  sway(seconds) {
    this.#swayed += seconds;
  }

  // Turns the view by drags and keys on a canvas. `isTaken(event)` returns whether a drag with one pointer has another
  // effect there; `takesArrows()` whether arrow keys turn the view without Shift. `onturn` is called after every turn.
  listen(canvas, { isTaken = () => false, takesArrows = () => true, onturn = () => {} } = {}) {
    const fingers = new Map();
    let [way, isFree] = [0, false];
    canvas.tabIndex = 0;
    canvas.setAttribute("role", "application");
    canvas.style.touchAction = "pan-y";
    canvas.addEventListener("pointerdown", event => {
      if (event.button > 0) return;
      if (event.isPrimary) fingers.clear();
      fingers.set(event.pointerId, [event.clientX, event.clientY]);
      if (fingers.size === 1) [way, isFree] = [0, !isTaken(event)];
    });
    canvas.addEventListener("pointermove", event => {
      const before = fingers.get(event.pointerId);
      if (!before || !(isFree || fingers.size > 1)) return;
      const [dx, dy] = [event.clientX - before[0], event.clientY - before[1]];
      way += Math.hypot(dx, dy);
      // A click may move the pointer a little.
      if (way < 5 && fingers.size === 1) return;
      if (!canvas.hasPointerCapture(event.pointerId)) canvas.setPointerCapture(event.pointerId);
      fingers.set(event.pointerId, [event.clientX, event.clientY]);
      this.turn(0.4 * dx / fingers.size, 0.4 * dy / fingers.size);
      onturn();
    });
    for (const kind of ["pointerup", "pointercancel"]) canvas.addEventListener(kind, event => fingers.delete(event.pointerId));
    // Two fingers turn the view and do not move the page.
    canvas.addEventListener("touchmove", event => { if (event.touches.length > 1) event.preventDefault(); }, { passive: false });
    // A drag is not a click.
    canvas.addEventListener("click", event => { if (way >= 5) event.stopImmediatePropagation(); }, true);
    canvas.addEventListener("keydown", event => {
      const turns = { ArrowLeft: [-5, 0], ArrowRight: [5, 0], ArrowUp: [0, 5], ArrowDown: [0, -5] };
      const turn = turns[event.key];
      if (event.ctrlKey || event.metaKey || event.altKey || !(event.key === "Home" || (turn && (event.shiftKey || takesArrows())))) return;
      event.preventDefault();
      if (turn) this.turn(...turn);
      else this.reset();
      onturn();
    });
  }
}
