// Lets the user draw the profile of the ground with a pointer or with keys.
/* global Drawing, levelAt: of drawing.js */

/** The distance between the places whose height can be set, m. Next: their number. A scene has at most 64 points. */
const APART = 0.1;
const PLACES = 40;
/** The largest height or depth of a place, m; and how far a key changes it, m. */
const MOST = 0.1;
const STEP = 0.005;

const round = number => Number(number.toFixed(4));

export class GroundEditor extends Drawing {
  #from = 0.7;
  #heights = new Array(PLACES).fill(0);
  #place = 0;
  #drawing = null;

  /** @param ondrawn is called at the end of a stroke with the points [along, height] of the profile. */
  constructor(canvas, ondrawn) {
    super(canvas);
    this.ondrawn = ondrawn;
    canvas.tabIndex = 0;
    canvas.setAttribute("role", "slider");
    canvas.addEventListener("pointerdown", event => {
      canvas.setPointerCapture(event.pointerId);
      this.#drawing = this.#at(event);
      this.#stroke(event);
    });
    canvas.addEventListener("pointermove", event => { if (this.#drawing) this.#stroke(event); });
    for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, () => this.#finish());
    canvas.addEventListener("keydown", event => this.#key(event));
    this.#again();
  }

  /** Shows a profile. The ground is level as far as the lattice reaches. */
  show(profile, lattice) {
    this.#from = round(Math.max(0.7, Math.ceil((lattice + 0.15) / APART) * APART));
    this.#heights = Array.from({ length: PLACES }, (_, k) => round(levelAt(profile, this.#x(k))));
    this.#again();
  }

  level() {
    this.#set(() => 0);
  }

  stairs() {
    this.#set(k => 0.02 * Math.floor((k + 2) / 3));
  }

  rough() {
    this.#set(k => (k === 0 ? 0 : round((Math.random() - 0.5) * 0.04)));
  }

  paint(_, width, height) {
    const place = (along, y) => [width * (along - this.#from + 0.3) / (PLACES * APART + 0.3), height / 2 - y * 0.42 * height / this.#most()];
    for (const y of [-1, 0, 1].map(k => k * this.#most())) {
      this.line([place(this.#from - 0.3, y), place(9e9, y).with(0, width)], this.colour("rule"), 1);
      this.text(`${Math.round(100 * y)} cm`, 10, place(0, y)[1] + (y < 0 ? -5 : 15));
    }
    const line = [[0, place(0, 0)[1]], ...this.#heights.map((y, k) => place(this.#x(k), y)), [width, place(0, this.#heights.at(-1))[1]]];
    this.fill([...line, [width, height], [0, height]], this.colour("earth"));
    this.line(line, this.colour("ink"), 2);
    for (let k = 0; k < PLACES; k += width < 600 ? 10 : 5) this.text(`${this.#x(k).toFixed(1)} m`, place(this.#x(k), 0)[0], height - 8, "muted", "center");
    this.disc(...place(this.#x(this.#place), this.#heights[this.#place]), 6, this.colour("accent"), this.colour("paper"));
  }

  #x(k) {
    return round(this.#from + k * APART);
  }

  #most() {
    return Math.max(MOST, ...this.#heights.map(Math.abs));
  }

  #at(event) {
    const box = this.canvas.getBoundingClientRect();
    const along = (event.clientX - box.left) / box.width * (PLACES * APART + 0.3) - 0.3;
    const y = (0.5 - (event.clientY - box.top) / box.height) / 0.42 * this.#most();
    return { k: Math.min(PLACES - 1, Math.max(0, Math.round(along / APART))), y: Math.min(MOST, Math.max(-MOST, y)) };
  }

  // A quick pointer skips places between two events; their heights are interpolated.
  #stroke(event) {
    const [from, to] = [this.#drawing, this.#at(event)];
    const count = Math.max(1, Math.abs(to.k - from.k));
    for (let step = 0; step <= count; step++) {
      const share = step / count;
      this.#heights[Math.round(from.k + share * (to.k - from.k))] = round(from.y + share * (to.y - from.y));
    }
    this.#heights[to.k] = round(to.y);
    this.#place = to.k;
    this.#drawing = to;
    this.#again();
  }

  #key(event) {
    const moves = { ArrowLeft: -1, ArrowRight: 1, Home: -PLACES, End: PLACES };
    const lifts = { ArrowUp: STEP, ArrowDown: -STEP, PageUp: 4 * STEP, PageDown: -4 * STEP };
    if (event.key in moves) {
      this.#place = Math.min(PLACES - 1, Math.max(0, this.#place + moves[event.key]));
      this.#again();
    } else if (event.key in lifts) {
      const height = this.#heights[this.#place] + lifts[event.key];
      this.#heights[this.#place] = round(Math.min(MOST, Math.max(-MOST, height)));
      this.#finish();
    } else {
      return;
    }
    event.preventDefault();
  }

  #set(height) {
    this.#heights = this.#heights.map((_, k) => round(Math.min(MOST, height(k))));
    this.#finish();
  }

  #finish() {
    this.#drawing = null;
    this.#again();
    this.ondrawn(this.#points());
  }

  /** The corners of the profile; an empty list for level ground. */
  #points() {
    const all = this.#heights.map((y, k) => [this.#x(k), y]);
    if (all.every(([, y]) => y === 0)) return [];
    const first = [[round(this.#from - APART), 0]];
    return first.concat(all.filter(([, y], k) => {
      const [before, after] = [this.#heights[k - 1] ?? 0, this.#heights[k + 1] ?? y];
      return Math.abs(2 * y - before - after) > 1e-9;
    }));
  }

  #again() {
    this.draw({});
    const [along, height] = [this.#x(this.#place), this.#heights[this.#place]];
    const attributes = { min: -100 * MOST, max: 100 * MOST, now: round(100 * height), text: `${round(100 * height)} cm at ${along} m` };
    for (const [name, value] of Object.entries(attributes)) this.canvas.setAttribute(`aria-value${name}`, value);
  }
}
