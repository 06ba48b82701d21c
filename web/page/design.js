// Designs a robot: runs the iterations, and keeps the robot after each iteration and the delivered robot.
/* global Walker: of robot.js */

import { Refused, Stopped } from "./client.js";

/** A robot with its walk, from an answer of the library. */
export class Walk extends Walker {
  constructor({ robot, world }, { materials, mixtures, walk, along, diverged }) {
    super(robot, world, mixtures, walk);
    Object.assign(this, { materials, along, diverged });
  }

  /** The number of bars of a material. */
  count(material) {
    return this.materials.filter(is => is === material).length;
  }
}

export class Design {
  #client;
  /** Counts the choices of scene and seed. Answers that belong to an earlier choice are dropped. */
  #run = 0;
  /** The value of `#run` for which an iteration is being computed, or null. */
  #iterated = null;
  /** "empty", "preparing", "ready", "working", "paused", "measuring", "finished", "cancelled" or "stopped". */
  state = "empty";
  world = null;
  /** The robot before the first iteration and the robot after each iteration, with the iteration's record. */
  robots = [];
  /** The delivered robot with the user's edits, its measurements, and the verdict on it (null until it is known). */
  delivered = null;
  /** The walk on which the user has sent the robot: after a push, to another world, or to a goal `along` (m along the
   * ground, from the payload at the start), from which it is `left` metres away in the end. Null if there is none. */
  told = null;
  /** The other world in which the robot walks: { world, changes, settings }; null in its own world. `changes` are
   * the kinds of settings that differ, each with its `name` and its `settings`; `settings` are all of them. */
  elsewhere = null;
  seconds = 0;

  /**
   * @param onchange is called after every change.
   * @param panicAfter is, for tests, the iteration after which the library panics.
   */
  constructor(client, onchange, panicAfter = null) {
    this.#client = client;
    this.onchange = onchange;
    this.panicAfter = panicAfter;
  }

  /** The world in which the robot walks. */
  get place() {
    return this.elsewhere?.world ?? this.world;
  }

  get iteration() {
    return this.robots.length - 1;
  }

  /** Whether an iteration is being computed. This can be true even after a pause, until the current iteration ends. */
  get iterates() {
    return this.#iterated !== null && this.#iterated === this.#run;
  }

  /** Prepares the robot of a scene before its first iteration. */
  async prepare(scene, seed) {
    const run = ++this.#run;
    this.#change("preparing");
    const { world, first } = await this.#client.ask({ do: "begin", scene, seed });
    if (run !== this.#run) return;
    this.world = world;
    this.robots = [{ walk: new Walk(world, first), record: null }];
    this.delivered = null;
    this.#stayHome();
    this.seconds = 0;
    this.#change("ready");
  }

  /** Opens a finished robot. `bytes` are those of a link. */
  async open(scene, bytes) {
    const run = ++this.#run;
    this.#change("preparing");
    const { world, robot } = await this.#client.ask({ do: "open", scene, bytes });
    if (run !== this.#run) return;
    this.world = world;
    const walk = new Walk(world, robot);
    this.robots = [{ walk, record: null }];
    this.delivered = { walk, asDesigned: walk, measured: null, verdict: null };
    this.#stayHome();
    this.seconds = 0;
    this.#change("finished");
    await this.#judge(run);
  }

  /** The delivered robot, with its edits, in bytes for a link; null if it does not fit into a link. */
  async pack() {
    try {
      return (await this.#client.ask({ do: "share" })).bytes;
    } catch (error) {
      if (error instanceof Refused) return null;
      throw error;
    }
  }

  /** The robot of the best attempt so far; null before the first attempt. */
  get best() {
    const far = ({ walk }) => walk.along ?? -Infinity;
    return this.robots.slice(1).reduce((best, robot) => (best === null || far(robot) > far(best) ? robot : best), null);
  }

  /** Does iterations until a pause or the end. */
  async work() {
    const run = this.#run;
    this.#change("working");
    // If the user resumes before the current iteration has ended, the earlier call continues.
    if (this.#iterated === run) return;
    this.#iterated = run;
    try {
      while (this.state === "working") {
        const done = await this.#iterate(run);
        if (run !== this.#run) return;
        if (done) await this.#deliver(run);
      }
    } catch (error) {
      if (run === this.#run && !(error instanceof Stopped)) this.#change("paused");
      throw error;
    } finally {
      if (this.#iterated === run) this.#iterated = null;
    }
  }

  pause() {
    this.#change("paused");
  }

  /** Stops waiting for the current run. */
  abandon(state) {
    this.#run += 1;
    this.#change(state);
  }

  async #iterate(run) {
    if (this.iteration === this.panicAfter) {
      this.panicAfter = null;
      await this.#client.ask({ do: "panic" });
    }
    const begun = performance.now();
    const { robot, record, done } = await this.#client.ask({ do: "iterate", shown: true });
    if (run !== this.#run) return false;
    this.seconds += (performance.now() - begun) / 1000;
    this.robots.push({ walk: new Walk(this.world, robot), record });
    this.#stayHome();
    this.onchange(this.state);
    return done;
  }

  async #deliver(run) {
    this.#change("measuring");
    const measured = await this.#client.ask({ do: "deliver" });
    if (run !== this.#run) return;
    const walk = new Walk(this.world, measured.robot);
    this.delivered = { walk, asDesigned: walk, measured, verdict: measured.verdict };
    this.#stayHome();
    this.#change("finished");
  }

  /** Gives the delivered robot other materials, or, for null, the designed ones again. */
  async edit(materials) {
    const run = this.#run;
    const { robot } = await this.#client.ask({ do: "edit", materials });
    if (run !== this.#run) return;
    const { asDesigned, measured } = this.delivered;
    this.delivered.walk = materials === null ? asDesigned : new Walk(this.world, robot);
    this.delivered.verdict = materials === null ? measured?.verdict ?? null : null;
    this.#stayHome();
    this.onchange(this.state);
    if (this.delivered.verdict === null) await this.#judge(run);
  }

  /** Lets the finished robot, with its edits, walk in its own world again, from the start. */
  home() {
    const { walk, asDesigned } = this.delivered;
    return this.edit(walk === asDesigned ? null : walk.materials);
  }

  /** Asks for the verdict on the finished robot. Its walk is shown before, because the verdict takes longer. */
  async #judge(run) {
    const { walk } = this.delivered;
    const { verdict } = await this.#client.ask({ do: "judge" });
    if (run !== this.#run || this.delivered.walk !== walk) return;
    this.delivered.verdict = verdict;
    this.onchange(this.state);
  }

  #stayHome() {
    this.told = this.elsewhere = null;
  }

  /**
   * Lets the latest robot walk on to a goal, from a frame of its walk.
   * @param ontold is called before the walk is shown.
   */
  async tell(along, frame, ontold) {
    const run = this.#run;
    const { robot, left } = await this.#client.ask({ do: "tell", along, frame });
    if (run === this.#run) this.#send(robot, { along, left }, ontold);
  }

  /** Lets the latest robot walk on after a push, from a frame of its walk. `velocity` is [x, y] in m/s. */
  async push(velocity, frame, onpushed) {
    const run = this.#run;
    const { robot } = await this.#client.ask({ do: "push", velocity, frame });
    if (run === this.#run) this.#send(robot, {}, onpushed);
  }

  /**
   * Lets the latest robot walk on in another world, from a frame of its walk. `there` has the `changes` and the `settings`
   * of that world.
   */
  async visit(there, frame, onvisit) {
    const run = this.#run;
    const settings = Object.entries(there.settings).map(([key, value]) => `${key}=${value}`);
    const { world, robot } = await this.#client.ask({ do: "visit", settings, frame });
    if (run !== this.#run) return;
    this.elsewhere = { ...there, world };
    this.#send(robot, { visits: true }, onvisit);
  }

  #send(robot, { along = null, left = null, visits = false }, onsent) {
    this.told = { walk: new Walk(this.place, robot), along, left, visits };
    onsent();
    this.onchange(this.state);
  }

  /** The text of `design.json`. */
  async file() {
    return this.#client.ask({ do: "design" });
  }

  #change(state) {
    this.state = state;
    this.onchange(state);
  }
}
