// Lets the finished robot walk on in another world: with other gravity, or on other ground.

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
    const [design, player] = [this.#design, this.#player];
    const changes = { ...design.elsewhere?.changes, [kind]: { name, settings } };
    const own = this.#scene.checked.settings;
    if (Object.entries(settings).every(([key, value]) => String(own[key]) === value)) delete changes[kind];
    if (Object.keys(changes).length === 0) return design.home();
    // A robot that has fallen apart cannot walk on.
    if (design.told?.walk.along === null) await design.home();
    this.onvisit();
    const all = Object.assign({}, ...Object.values(changes).map(({ settings }) => settings));
    await player.goOn((frame, ongoing) => design.visit({ changes, settings: all }, frame, ongoing));
  }
}
