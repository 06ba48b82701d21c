// An evolution for the scene of a design, in a worker of its own. It has no gradients.

import { Client, Refused, Stopped } from "./client.js";
import { Walk } from "./design.js";

/** The page hears of an evolution after so many robots at most, and about as often as this, milliseconds. */
const [MOST, OFTEN] = [64, 150];

export class Twin {
  #client = null;
  /** The best robot so far, and how many robots were tried and how many seconds were computed until it was found; null and 0
   * before the first. */
  walk = null;
  found = 0;
  seconds = 0;
  /** How many robots were tried. */
  tries = 0;

  /** @param onchange is called after every few tries, and at the end. */
  constructor(onchange) {
    this.onchange = onchange;
  }

  get runs() {
    return this.#client !== null;
  }

  /** Tries robots for a scene until it is ended. */
  async run(scene, seed) {
    const client = new Client();
    [this.#client, this.walk, this.found, this.tries, this.seconds] = [client, null, 0, 0, 0];
    let [count, computed] = [1, 0];
    try {
      const { world } = await client.ask({ do: "begin", scene, seed });
      while (this.#client === client) {
        const begun = performance.now();
        const { tries, robot } = await client.ask({ do: "evolve", tries: count });
        const took = performance.now() - begun;
        computed += took / 1000;
        if (took < OFTEN) count = Math.min(MOST, 2 * count);
        this.tries = tries;
        if (robot !== null) [this.walk, this.found, this.seconds] = [new Walk(world, robot), tries, computed];
        this.onchange();
      }
    } catch (error) {
      if (!(error instanceof Stopped)) throw error;
      if (this.#client === client) throw new Refused(`The evolution stopped: ${error.message}`);
    } finally {
      if (this.#client === client) this.end();
    }
  }

  /** Ends the evolution, and forgets its robots. */
  end() {
    if (!this.runs) return;
    this.#client.end();
    this.#client = this.walk = null;
    this.onchange();
  }
}
