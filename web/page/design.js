// Designing: iterations one after the other, the robot after each of them, and the one that is delivered.

import { Stopped } from "./client.js";
import { Walk, World } from "./walk.js";

export class Design {
  #client;
  /** What is asked for counts only as long as no other scene or seed is. */
  #run = 0;
  /** The run that is iterated, or null. */
  #iterated = null;
  /** "empty", "preparing", "ready", "working", "paused", "measuring", "finished", "cancelled" or "stopped". */
  state = "empty";
  world = null;
  /** The robot before the first iteration and after every one, with its record. */
  robots = [];
  /** The robot that was delivered, as edited, with what was measured of it. */
  delivered = null;
  seconds = 0;

  /** @param onchange is called after every change; `panicAfter`: an iteration after which the library is to stop. */
  constructor(client, onchange, panicAfter = null) {
    this.#client = client;
    this.onchange = onchange;
    this.panicAfter = panicAfter;
  }

  get iteration() {
    return this.robots.length - 1;
  }

  /** Whether an iteration is being computed. After a pause the current iteration still has to end. */
  get iterates() {
    return this.#iterated !== null && this.#iterated === this.#run;
  }

  /** The robot of a scene before its first iteration. */
  async prepare(scene, seed) {
    const run = ++this.#run;
    this.#change("preparing");
    const { ok, numbers } = await this.#client.ask({ do: "begin", scene, seed });
    if (run !== this.#run) return;
    this.world = new World(ok.world);
    this.robots = [{ walk: new Walk(this.world, ok.first, numbers), record: null }];
    this.delivered = null;
    this.seconds = 0;
    this.#change("ready");
  }

  /** Iterates until it is paused, or all is done. */
  async work() {
    const run = this.#run;
    this.#change("working");
    // Resumed before the iteration at hand was done: it goes on.
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

  /** What was asked for is no longer waited for. */
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
    const { ok, numbers } = await this.#client.ask({ do: "iterate", shown: true });
    if (run !== this.#run) return false;
    this.seconds += (performance.now() - begun) / 1000;
    this.robots.push({ walk: new Walk(this.world, ok.robot, numbers), record: ok.record });
    this.onchange(this.state);
    return ok.done;
  }

  async #deliver(run) {
    this.#change("measuring");
    const { ok, numbers } = await this.#client.ask({ do: "deliver" });
    if (run !== this.#run) return;
    const walk = new Walk(this.world, ok.robot, numbers);
    this.delivered = { walk, asDesigned: walk, measured: ok };
    this.#change("finished");
  }

  /** Gives the delivered robot other materials, or its own again. */
  async edit(materials) {
    const run = this.#run;
    const { ok, numbers } = await this.#client.ask({ do: "edit", materials });
    if (run !== this.#run) return;
    this.delivered.walk = materials === null ? this.delivered.asDesigned : new Walk(this.world, ok.robot, numbers);
    this.onchange(this.state);
  }

  /** The text of `design.json`. */
  async file() {
    return (await this.#client.ask({ do: "design" })).ok;
  }

  #change(state) {
    this.state = state;
    this.onchange(state);
  }
}
