// Measures finished robots in a worker of its own, so that nothing on the page waits for it.

import { Client } from "./client.js";
import { toBytes } from "./packed.js";

/** If a measurement that nobody wants any more takes longer than this, its worker is restarted, milliseconds. */
const PATIENCE = 500;

export class Judge {
  #client = null;
  /** The work so far, and whether its result is still wanted. */
  #before = Promise.resolve();
  #isWanted = () => false;

  /**
   * Measures the robot of a link to a scene, one measurement after the other.
   * @param isWanted returns whether the result is still wanted.
   * @returns what is measured; null if it is not wanted any more.
   */
  measure(scene, link, isWanted) {
    if (this.#client?.busyFor > PATIENCE && !this.#isWanted()) this.#client.start();
    const measured = this.#before.then(() => this.#measure(scene, link, isWanted));
    this.#before = measured.catch(() => {});
    return measured;
  }

  async #measure(scene, link, isWanted) {
    if (!isWanted()) return null;
    this.#isWanted = isWanted;
    this.#client ??= new Client({ onstop: () => { this.#client = null; }, onmissing: () => { this.#client = null; } });
    const client = this.#client;
    await client.ask({ do: "open", scene, bytes: toBytes(link) });
    return judged(client, isWanted);
  }
}

/** Measures the finished robot of a worker until nothing is left to measure. Resolves to null if the result is not wanted. */
export async function judged(client, isWanted) {
  while (isWanted()) {
    const { measured } = await client.ask({ do: "judge" });
    if (measured !== null) return measured;
  }
  return null;
}
