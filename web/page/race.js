// Designs robots of several seeds at the same time, each in its own worker. The best one is opened on the page.
/* global decimals: of drawing.js */

import { Client, Stopped } from "./client.js";

/** The most seeds that race. One processor is left to the page. */
const MOST = 4;

export class Race {
  #lanes;
  #clients = [];

  /** @param lanes is the element that shows the seeds. */
  constructor(lanes) {
    this.#lanes = lanes;
  }

  get runs() {
    return this.#clients.length > 0;
  }

  /**
   * Designs the robots of a scene from `seed` on. Resolves to { seed, far, bytes } of the best, where `far` is
   * the distance to quote; null if it is ended. */
  async run(scene, seed) {
    const count = Math.min(MOST, Math.max(2, (navigator.hardwareConcurrency ?? 2) - 1));
    this.#lanes.hidden = false;
    this.#lanes.replaceChildren();
    try {
      const all = Array.from({ length: count }, (_, k) => this.#design(scene, seed + k));
      const finished = (await Promise.all(all)).filter(robot => robot.far !== null);
      return finished.reduce((best, robot) => (best === null || robot.far > best.far ? robot : best), null);
    } catch (error) {
      if (error instanceof Stopped) return null;
      throw error;
    } finally {
      this.end();
    }
  }

  /** Ends the race and its workers. */
  end() {
    for (const client of this.#clients) client.end();
    this.#clients = [];
  }

  async #design(scene, seed) {
    const client = new Client(() => {});
    this.#clients.push(client);
    const lane = this.#lane(seed);
    const { world } = await client.ask({ do: "begin", scene, seed });
    for (let [k, done] = [1, false]; !done; k++) {
      // The distance is shown after every tenth attempt, because it needs another walk.
      const { robot, done: isDone } = await client.ask({ do: "iterate", shown: k % 10 === 0 });
      done = isDone;
      lane(k / world.iterations, robot?.along);
    }
    const { measured } = await client.ask({ do: "deliver", packed: true });
    const far = measured.distance?.p50 ?? null;
    lane(1, far);
    const { bytes } = await client.ask({ do: "share" });
    return { seed, far, bytes };
  }

  /** Adds the line of a seed. Returns a function that shows its progress and its distance. */
  #lane(seed) {
    const make = (name, given) => Object.assign(document.createElement(name), given);
    const [name, bar, far] = [make("span", { textContent: `seed ${seed}` }), make("progress", { value: 0 }), make("span")];
    bar.setAttribute("aria-label", name.textContent);
    const line = make("div");
    line.append(name, bar, far);
    this.#lanes.append(line);
    return (share, along) => {
      bar.value = share;
      if (Number.isFinite(along)) far.textContent = `${decimals(along, 2)} m`;
    };
  }
}
