// Plays walks on the stage: one robot turns into the next without a jump.
/* global everyFrame: of drawing.js */

/** A void bar that is longer than so many rest lengths leads to a node that was left behind. */
const LEFT_BEHIND = 2;
/** Seconds in which most of the difference between two robots is gone. */
const BLEND = 0.12;

export class Player {
  #stage;
  #walk = null;
  #bars = [];
  #shown = new Float32Array(0);
  #offset = new Float32Array(0);
  #camera = 0;
  #cameraOffset = 0;
  #blend = 0;
  time = 0;
  speed = 1;
  /** Whether void bars are shown, for a robot that was shown with them. */
  withVoid = false;
  playing;
  highlight = null;
  /** The longest and the mean time of a picture's script in milliseconds, for tests. */
  cost = { frames: 0, total: 0, longest: 0 };

  /** @param ontime is called with the time after every picture. */
  constructor(stage, ontime) {
    this.#stage = stage;
    this.ontime = ontime;
    this.still = matchMedia("(prefers-reduced-motion: reduce)");
    this.playing = !this.still.matches;
    everyFrame(passed => this.#tick(passed));
  }

  get walk() {
    return this.#walk;
  }

  /** Shows a robot from now on, at the same time of its walk. */
  show(walk, { withVoid = false, restart = false } = {}) {
    const same = this.#walk?.world === walk.world;
    if (!same) this.#stage.world = walk.world.drawn;
    const count = 2 * walk.world.rest.length;
    const before = same ? this.#shown.slice() : null;
    const cameraBefore = this.#camera;
    if (!same || restart) this.time = 0;
    // What does not move by itself is shown where it has got to.
    if (this.still.matches && !this.playing && !restart) this.time = walk.duration;
    this.#walk = walk;
    this.#shown = new Float32Array(count);
    this.withVoid = withVoid;
    this.#bars = walk.bars(withVoid);
    walk.positions(this.time, this.#shown);
    const blends = before !== null && !restart && this.playing;
    this.#blend = blends ? 1 : 0;
    if (blends) {
      this.#offset = before.map((place, k) => place - this.#shown[k]);
      this.#cameraOffset = cameraBefore - walk.camera(this.time);
    }
    if (!this.playing) this.paint();
  }

  /** Whether a void bar is at the robot. */
  #isNear([i, j, rest]) {
    const [at, body] = [this.#shown, this.#walk.body];
    const length = Math.hypot(at[2 * i] - at[2 * j], at[2 * i + 1] - at[2 * j + 1]);
    return (body.has(i) || body.has(j)) && length < LEFT_BEHIND * rest;
  }

  toggle() {
    this.playing = !this.playing;
    if (this.playing && this.#walk && this.time >= this.#walk.duration) this.time = 0;
  }

  seek(time) {
    this.time = time;
    this.paint();
  }

  paint() {
    const walk = this.#walk;
    if (!walk) return;
    walk.positions(this.time, this.#shown);
    this.#camera = walk.camera(this.time);
    if (this.#blend > 0.01) {
      for (let k = 0; k < this.#shown.length; k++) this.#shown[k] += this.#blend * this.#offset[k];
      this.#camera += this.#blend * this.#cameraOffset;
    }
    this.#stage.draw({
      positions: this.#shown,
      edges: this.#bars.filter(bar => bar[3] !== 0 || (this.withVoid && this.#isNear(bar))),
      camera: [this.#camera, walk.world.floor(this.#camera)],
      trail: walk.trail(this.time),
      highlight: this.highlight,
    });
    this.ontime(this.time);
  }

  #tick(passed) {
    if (!this.playing || !this.#walk) return;
    const begun = performance.now();
    this.time += passed * this.speed;
    if (this.time > this.#walk.duration) {
      this.time = 0;
      this.#blend = 0;
    }
    this.#blend *= Math.exp(-passed / BLEND);
    this.paint();
    const took = performance.now() - begun;
    this.cost.frames += 1;
    this.cost.total += took;
    this.cost.longest = Math.max(this.cost.longest, took);
  }
}
