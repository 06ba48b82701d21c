// Lets the finished robot walk in another world: with other gravity, or on other ground.

import { CHOICES } from "./chips.js";

export class Visit {
  #scene;
  #player;
  #design;

  /** @param onvisit is called before the robot is moved to the other world. */
  constructor({ scene, player, design, onvisit }) {
    [this.#scene, this.#player, this.#design] = [scene, player, design];
    this.onvisit = onvisit;
  }

  /** All settings of the world in which the robot walks, from keys to values. */
  get settings() {
    return { ...this.#scene.checked.settings, ...this.#design.elsewhere?.settings };
  }

  /** Moves the robot to a world that differs in one kind of settings ("ground" or "gravity"). `name` says how. */
  async move(kind, name, settings) {
    const design = this.#design;
    const changes = { ...design.elsewhere?.changes, [kind]: { name, settings } };
    const own = this.#scene.checked.settings;
    if (Object.entries(settings).every(([key, value]) => String(own[key]) === value)) delete changes[kind];
    if (Object.keys(changes).length === 0) return design.home();
    this.onvisit();
    await this.#go(changes);
  }

  /** Moves the robot to the world of a link: a map from kinds of settings to names. It begins with the start of its walk. */
  async arrive(visited) {
    const changes = {};
    for (const [kind, name] of Object.entries(visited)) changes[kind] = { name, settings: CHOICES[kind][name] };
    if (Object.keys(changes).length === 0) return;
    this.#player.time = 0;
    await this.#go(changes);
  }

  #go(changes) {
    const settings = Object.assign({}, ...Object.values(changes).map(({ settings }) => settings));
    return this.#player.goOn((_, ongoing) => this.#design.visit({ changes, settings }, ongoing));
  }
}
