// The twin of a design that has no gradients: an evolution for the same scene, in a worker of its own.

import { Client, Stopped } from "./client.js";
import { Walk } from "./design.js";

/** So many robots are tried before the page hears of them. */
const TRIES = 20;

export class Twin {
  #client = null;
  /** The best robot so far; null before the first. */
  walk = null;
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
    const client = new Client(() => {});
    [this.#client, this.walk, this.tries] = [client, null, 0];
    try {
      const { world } = await client.ask({ do: "begin", scene, seed });
      while (this.#client === client) {
        const { tries, robot } = await client.ask({ do: "evolve", tries: TRIES });
        this.tries = tries;
        if (robot !== null) this.walk = new Walk(world, robot);
        this.onchange();
      }
    } catch (error) {
      if (!(error instanceof Stopped)) throw error;
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
