// The attempts as a row of small robots on the curve of their distances. A pointer or the arrow keys choose one.
/* global Drawing, decimals: of drawing.js; Eye, viewOf: of painter.js */

/** The width of a small robot's place, pixels. */
const PLACE = 84;
/** The height of a small robot as a fraction of the strip. */
const TALL = 0.36;
/** The free space at both ends, pixels. */
const EDGE = 8;

export class Strip extends Drawing {
  #onlook;
  #last = 0;
  #shown = 0;

  /** @param onlook is called with the attempt that the user chose. */
  constructor(canvas, onlook) {
    super(canvas);
    this.#onlook = onlook;
    canvas.tabIndex = 0;
    canvas.setAttribute("role", "slider");
    for (const bound of ["min", "max", "now"]) canvas.setAttribute(`aria-value${bound}`, 0);
    canvas.addEventListener("pointerdown", event => {
      canvas.setPointerCapture(event.pointerId);
      this.#point(event);
    });
    canvas.addEventListener("pointermove", event => { if (event.buttons & 1) this.#point(event); });
    canvas.addEventListener("keydown", event => this.#key(event));
    this.draw({ robots: [], attempts: 1, shown: 0 });
  }

  // Keys choose from what is told here, also while the strip is out of view and not painted.
  draw(scene) {
    this.#last = scene.robots.length - 1;
    this.#shown = scene.shown;
    super.draw(scene);
  }

  /** `robots` are those of a design, `attempts` is the number that it will have, `shown` is the attempt on the stage. */
  paint({ robots, attempts, shown }, width, height) {
    const far = robots.map(({ walk }) => walk.along ?? 0);
    const most = Math.max(0.5, ...far);
    const [foot, head] = [height - 5, height * (1 - TALL) - 14];
    const place = k => [EDGE + (width - 2 * EDGE) * k / attempts, foot - head * Math.max(0, far[k]) / most];
    this.canvas.dataset.attempts = attempts;
    if (robots.length > 1) {
      const line = robots.map((_, k) => place(k));
      this.fill([[EDGE, height], ...line, [line.at(-1)[0], height]], this.colour("phase"));
      this.line(line, this.colour("accent"), 2);
    }
    this.line([[0, height - 1], [width, height - 1]], this.colour("rule"), 1.5);
    if (robots.length > 0) {
      this.pen.globalAlpha = 0.5;
      this.line([[place(shown)[0], 4], [place(shown)[0], height]], this.colour("muted"), 1.5);
      this.pen.globalAlpha = 1;
    }
    const count = Math.max(2, Math.floor(width / PLACE));
    for (let k = 0; k < count; k++) {
      const at = Math.round(attempts * (k + 0.5) / count);
      if (at < robots.length) this.#robot(robots[at].walk, ...place(at), height * TALL);
    }
    if (robots.length > 1) this.disc(...place(shown), 5, this.colour("accent"), this.colour("paper"));
    this.#tell(far[shown], attempts);
  }

  /** Paints a robot as it is at the start of its walk, with its feet at a point. */
  #robot(walk, x, y, tall) {
    const { start } = walk.robot;
    const seen = new Eye(viewOf(walk.robot)).seeAll(start);
    const [xs, ys] = [0, 1].map(axis => seen.map(place => place[axis]));
    const [left, low] = [Math.min(...xs), Math.min(...ys)];
    const scale = tall / Math.max(0.1, Math.max(...ys) - low);
    const half = scale * (Math.max(...xs) - left) / 2;
    const node = i => [x - half + scale * (seen[i][0] - left), y - 4 - scale * (seen[i][1] - low)];
    // The many undecided bars of a robot in space would hide one another.
    const [power, least] = walk.robot.axes === 3 ? [4, 0.4] : [1, 1.2];
    for (const [i, j, , material, , weight] of walk.bars.filter(([i]) => walk.body.has(i))) {
      this.pen.globalAlpha = 0.1 + 0.9 * weight ** power;
      this.line([node(i), node(j)], this.colour(material === 2 ? "actuator" : "skeleton"), least + weight);
    }
    this.pen.globalAlpha = 1;
    for (const i of walk.robot.payloads) this.disc(...node(i), 3, this.colour("payload"));
  }

  #point({ clientX }) {
    const { left, width } = this.canvas.getBoundingClientRect();
    this.#look(Math.round((clientX - left - EDGE) / (width - 2 * EDGE) * this.canvas.dataset.attempts));
  }

  #key(event) {
    const moves = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1, PageDown: -10, PageUp: 10, Home: -Infinity, End: Infinity };
    if (!(event.key in moves)) return;
    event.preventDefault();
    this.#look(this.#shown + moves[event.key]);
  }

  #look(attempt) {
    if (this.#last >= 0) this.#onlook(Math.min(this.#last, Math.max(0, attempt)));
  }

  #tell(far, attempts) {
    const text = far === undefined ? "no version yet" : `version ${this.#shown}: ${decimals(far, 2)} m`;
    const attributes = { min: 0, max: attempts, now: this.#shown, text };
    for (const [name, value] of Object.entries(attributes)) this.canvas.setAttribute(`aria-value${name}`, value);
  }
}
