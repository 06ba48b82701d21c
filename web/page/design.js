// Designs a robot: the iterations, the robot after each of them, and the delivered robot.
/* global Walker: of drawing.js */

import { Stopped } from "./client.js";

/** A robot of the library's answer, with its walk. */
class Walk extends Walker {
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
  /** The number of the current scene and seed. Answers to requests of earlier ones are dropped. */
  #run = 0;
  /** The run that is being iterated, or null. */
  #iterated = null;
  /** "empty", "preparing", "ready", "working", "paused", "measuring", "finished", "cancelled" or "stopped". */
  state = "empty";
  world = null;
  /** The robots before the first iteration and after each one, with the records of the iterations. */
  robots = [];
  /** The delivered robot, as edited, with its measurements. */
  delivered = null;
  seconds = 0;

  /** @param onchange is called after every change. The library panics after the iteration `panicAfter`. */
  constructor(client, onchange, panicAfter = null) {
    this.#client = client;
    this.onchange = onchange;
    this.panicAfter = panicAfter;
  }

  get iteration() {
    return this.robots.length - 1;
  }

  /** Whether an iteration is being computed. After a pause, the current iteration still has to end. */
  get iterates() {
    return this.#iterated !== null && this.#iterated === this.#run;
  }

  /** The robot of a scene before its first iteration. */
  async prepare(scene, seed) {
    const run = ++this.#run;
    this.#change("preparing");
    const { world, first } = await this.#client.ask({ do: "begin", scene, seed });
    if (run !== this.#run) return;
    this.world = world;
    this.robots = [{ walk: new Walk(world, first), record: null }];
    this.delivered = null;
    this.seconds = 0;
    this.#change("ready");
  }

  /** Iterates until a pause or the end. */
  async work() {
    const run = this.#run;
    this.#change("working");
    // Resumed before the current iteration ended: it goes on.
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
    this.onchange(this.state);
    return done;
  }

  async #deliver(run) {
    this.#change("measuring");
    const measured = await this.#client.ask({ do: "deliver" });
    if (run !== this.#run) return;
    const walk = new Walk(this.world, measured.robot);
    this.delivered = { walk, asDesigned: walk, measured };
    this.#change("finished");
  }

  /** Gives the delivered robot other materials, or its own again. */
  async edit(materials) {
    const run = this.#run;
    const { robot } = await this.#client.ask({ do: "edit", materials });
    if (run !== this.#run) return;
    this.delivered.walk = materials === null ? this.delivered.asDesigned : new Walk(this.world, robot);
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
