// Plays walks on the stage. When another robot is shown, the drawing changes gradually.
/* global everyFrame: of drawing.js; Eye, Orbit, SIDE, viewOf: of painter.js */

/** The fraction of the stage's width that a robot takes: of a wide stage, and of a narrow one, which is not this many times
 * as wide as high. */
const [WIDE, NARROW, ASPECT] = [1 / 3, 1 / 2, 1.7];
/** The largest fraction of the stage's height that a robot takes. */
const TALLEST = 0.68;
/** The seconds after which most of the change from one robot to the next is done. */
const BLEND = 0.12;
/** With two lanes, the stage shows this many times as much of the world. */
const LANES = 1.7;
/** This many seconds before its end, a walk is lengthened. */
const AHEAD = 0.6;

/** The world of a `Stage` with a `width` that suits a walk and its canvas. */
export function framed({ world, robot }, { clientWidth, clientHeight }) {
  const { start, payloads } = robot;
  const aspect = clientWidth / clientHeight;
  const seen = new Eye(viewOf(robot)).seeAll(start);
  const [across, tall] = [0, 1].map(axis => {
    const places = seen.map(place => place[axis]);
    return Math.max(...places) - Math.min(...places);
  });
  const wide = across * Math.min(2.4 / aspect, 2) / (aspect > ASPECT ? WIDE : NARROW);
  return { ...world, payloads, width: Math.max(wide, tall * Math.min(2.4, 2 * aspect) / TALLEST) };
}

export class Player {
  #stage;
  #walk = null;
  /** The positions and the camera that are shown. Below: their differences from the walk when it began to be shown. */
  #shown = { positions: [], camera: [0, 0, 0], top: 0 };
  #offset = null;
  #blend = 0;
  time = 0;
  speed = 1;
  /** Whether void bars are shown. */
  withVoid = false;
  playing;
  highlight = null;
  /** The foot [x, y, z] of the flag at the robot's goal; null if there is none. */
  goal = null;
  /** The text beside the flag. */
  goalLabel = "";
  /** Another robot's walk, which is drawn faintly; null if there is none. */
  ghost = null;
  /** What is written at the ghost's lane; null if the ghost has no lane, but walks with the robot. */
  #lane = null;
  /** What more material in each bar would bring, from -1 to 1; null if it is not known. */
  tints = null;
  /** How far the user has dragged the robot, [x, y] in pixels; null if it is not dragged. */
  arrow = null;
  /** Whether the walk goes on from another one, and whether it stops at its end and does not begin again. */
  #goesOn = false;
  #stops = false;
  /** A walk that cannot go on. */
  #ends = null;
  /** Lengthens the walk; resolves to the seconds that its beginning loses, to null if it ends, or to
   * undefined if it is to begin again. Null if all walks begin again. */
  lengthen = null;
  /** The lengthening in progress. */
  #lengthening = null;
  /** The number of walks that are being computed. The robot stands still until then. */
  #awaited = 0;
  /** For tests: the number of frames, and the total and the longest time of their scripts in milliseconds. */
  cost = { frames: 0, total: 0, longest: 0 };

  /**
   * @param ontime is called after every frame with the time of the walk.
   * @param onstop is called when a walk stops at its end.
   */
  constructor(stage, ontime, onstop) {
    this.#stage = stage;
    stage.orbit = new Orbit(SIDE);
    this.ontime = ontime;
    this.onstop = onstop;
    this.still = matchMedia("(prefers-reduced-motion: reduce)");
    this.playing = !this.still.matches;
    everyFrame(passed => this.#tick(passed));
    new ResizeObserver(() => {
      if (this.#walk === null) return;
      this.#fit();
      this.paint();
    }).observe(stage.canvas);
  }

  get lane() {
    return this.#lane;
  }

  set lane(lane) {
    const fits = (lane === null) === (this.#lane === null);
    this.#lane = lane;
    if (!fits && this.#walk) this.#fit();
  }

  get walk() {
    return this.#walk;
  }

  /** The number of the frame that is shown, in the last piece of the walk. */
  get frame() {
    return this.#walk ? Math.max(0, this.#walk.at(this.time).frame - this.#walk.lead) : 0;
  }

  /**
   * Shows another robot from now on, at the current time. If it `goesOn`, its walk begins where the last one was left. If
   * it `stops`, its walk does not begin again at its end.
   */
  show(walk, { withVoid = false, restart = false, goesOn = false, stops = false } = {}) {
    const same = this.#walk?.world === walk.world;
    if (!same || restart || goesOn) this.time = 0;
    this.#goesOn = goesOn;
    this.#stops = stops;
    // With reduced motion, nothing moves by itself, so the robot is shown at the end of its walk, on the ground.
    if (this.still.matches && !this.playing && !restart) this.time = walk.landing;
    this.#walk = walk;
    this.#ends = null;
    if (!same) this.#fit();
    this.withVoid = withVoid;
    const blends = (goesOn || (same && !restart)) && this.playing;
    this.#blend = blends ? 1 : 0;
    if (blends) {
      const { positions, camera, top } = walk.at(this.time);
      const from = (before, now) => now.map((x, k) => before[k] - x);
      this.#offset = { positions: from(this.#shown.positions, positions), camera: from(this.#shown.camera, camera), top: this.#shown.top - top };
    }
    if (!this.playing) this.paint();
  }

  #fit() {
    this.#stage.orbit.home = viewOf(this.#walk.robot);
    const world = framed(this.#walk, this.#stage.canvas);
    this.#stage.world = { ...world, width: world.width * (this.#lane === null ? 1 : LANES) };
  }

  /** The void bars between nodes of the robot, in the editor. */
  get absent() {
    if (!this.withVoid) return [];
    const { body, edges } = this.#walk;
    return edges.filter(([i, j, , material]) => material === 0 && body.has(i) && body.has(j));
  }

  /**
   * Lets the robot stand still in this frame of its walk while `ask(frame, ongoing)` computes how it goes on from there.
   * `ask` calls `ongoing` before the new walk is shown.
   */
  async goOn(ask) {
    this.#awaited += 1;
    try {
      await this.#lengthening;
      await ask(this.frame, () => { this.playing = !this.still.matches; });
    } finally {
      this.#awaited -= 1;
    }
  }

  toggle() {
    this.playing = !this.playing;
    if (this.playing && this.#walk && this.time >= this.#walk.duration) this.time = 0;
  }

  seek(time) {
    // A walk that was lengthened in the meantime has forgotten its first seconds.
    this.time = Math.max(0, time);
    this.#blend = 0;
    this.paint();
  }

  paint() {
    const walk = this.#walk;
    if (!walk) return;
    const moment = walk.at(this.time);
    this.#shown = moment;
    if (this.#blend > 0.01) {
      const moved = name => moment[name].map((x, k) => x + this.#blend * this.#offset[name][k]);
      this.#shown = { positions: moved("positions"), camera: moved("camera"), top: moment.top + this.#blend * this.#offset.top };
    }
    // In the editor void bars can be clicked, so they are not drawn fainter than others.
    const edges = [...moment.edges, ...this.absent.map(([i, j, rest, , e]) => [i, j, rest, 0, e, 1])];
    this.#stage.draw({ ...moment, ...this.#shown, edges, highlight: this.highlight, goal: this.goal, goalLabel: this.goalLabel, ghost: this.#ghostNow, tints: this.tints, arrow: this.arrow });
    this.ontime(this.time);
  }

  get #ghostNow() {
    if (this.ghost === null || this.#goesOn || this.ghost === this.#walk) return null;
    return { positions: this.ghost.at(this.time).positions, edges: this.ghost.bars, lane: this.#lane };
  }

  /** Lets the walk go on for another piece. */
  async #goFurther() {
    const walk = this.#walk;
    const dropped = await this.lengthen(walk);
    if (dropped === null) this.#ends = walk;
    else if (dropped !== undefined && walk === this.#walk) this.time = Math.max(0, this.time - dropped);
  }

  #tick(passed) {
    if (!this.playing || this.#awaited > 0 || !this.#walk) return;
    const begun = performance.now();
    this.time += passed * this.speed;
    this.#stage.orbit.sway(passed);
    const left = this.#walk.duration - this.time;
    const goesFurther = this.lengthen !== null && !this.#stops && this.ghost === null && this.#ends !== this.#walk;
    if (goesFurther && left < AHEAD * this.speed && this.#lengthening === null) {
      this.#lengthening = this.#goFurther().finally(() => { this.#lengthening = null; });
    }
    if (left < 0 && this.#lengthening !== null) this.time = this.#walk.duration;
    if (this.time > this.#walk.duration) {
      this.time = this.#stops ? this.#walk.duration : 0;
      this.#blend = 0;
      if (this.#stops) {
        this.playing = false;
        this.onstop();
      }
    }
    this.#blend *= Math.exp(-passed / BLEND);
    this.paint();
    const took = performance.now() - begun;
    this.cost.frames += 1;
    this.cost.total += took;
    this.cost.longest = Math.max(this.cost.longest, took);
  }
}
