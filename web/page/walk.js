// A robot and its rollout, ready to be drawn at any time.
/* global levelAround, bodyOf: from drawing.js */

const MATERIALS = ["void", "skeleton", "actuator"];
/** Seconds over which the camera averages, so that it does not shake. */
const STEADY = 1;
/** The least share of a material that is drawn. */
const SEEN = 0.06;
/** Seconds of the payload's path that are drawn. */
const TRAIL = 6;

export { MATERIALS };

/** A lattice in its world, as `begin` answers. */
export class World {
  constructor({ rest, edges, lengths, payloads, width, cos, ground, limit, every, iterations, snap }) {
    Object.assign(this, { rest, edges, lengths, payloads, every, iterations, snap });
    /** What the drawing of a robot asks for. */
    this.drawn = { width, ground, cos, limit, payloads, origin: rest[payloads[0] ?? 0][0] };
  }

  /** The height of the ground that the camera looks at. */
  floor(x) {
    return levelAround(this.drawn.ground, x, this.drawn.width / 4);
  }
}

export class Walk {
  #coordinates;
  #middles;
  #trail;

  /** @param numbers the shares of all edges, then the positions of the rollout, as the library answers. */
  constructor(world, { materials, along, diverged }, numbers) {
    Object.assign(this, { world, materials, along, diverged });
    const shares = 3 * world.edges.length;
    this.mixtures = numbers.subarray(0, shares);
    this.#coordinates = numbers.subarray(shares);
    this.frames = this.#coordinates.length / (2 * world.rest.length);
    this.duration = (this.frames - 1) * world.every;
    const payload = world.payloads[0] ?? 0;
    /** The nodes that the camera follows: all nodes that are connected to the payload. */
    this.body = bodyOf([payload], world.edges, e => 1 - this.mixture(e)[0]);
    this.#middles = this.#smoothed(this.#bodyMiddles());
    this.#trail = new Float32Array(2 * this.frames);
    for (let k = 0; k < this.frames; k++) this.#trail.set(this.#node(k, payload), 2 * k);
  }

  /**
   * Bars as the drawing takes them. An undecided one is two, skeleton and actuator, each as faint as its share is
   * small. A void one is there only where it is asked for.
   */
  bars(withVoid) {
    const bars = [];
    this.world.edges.forEach(([i, j], e) => {
      const shares = this.mixture(e);
      const drawn = [1, 2].filter(material => shares[material] > SEEN);
      for (const material of drawn) bars.push([i, j, this.world.lengths[e], material, e, shares[material]]);
      if (drawn.length === 0 && withVoid) bars.push([i, j, this.world.lengths[e], 0, e, 1]);
    });
    return bars;
  }

  mixture(e) {
    return this.mixtures.subarray(3 * e, 3 * e + 3);
  }

  /** How many bars there are of a material. */
  count(material) {
    return this.materials.filter(is => is === material).length;
  }

  /** Positions at a time, into an array of the same length as the lattice's coordinates. */
  positions(time, into) {
    const { index, share } = this.#at(time);
    const count = into.length;
    const [from, to] = [index * count, Math.min(index + 1, this.frames - 1) * count];
    for (let k = 0; k < count; k++) {
      into[k] = this.#coordinates[from + k] * (1 - share) + this.#coordinates[to + k] * share;
    }
  }

  camera(time) {
    const { index, share } = this.#at(time);
    const next = Math.min(index + 1, this.frames - 1);
    return this.#middles[index] * (1 - share) + this.#middles[next] * share;
  }

  /** The payload's path up to a time. */
  trail(time) {
    const { index } = this.#at(time);
    const first = Math.max(0, index - Math.round(TRAIL / this.world.every));
    return this.#trail.subarray(2 * first, 2 * (index + 1));
  }

  #at(time) {
    const place = Math.min(Math.max(0, time / this.world.every), this.frames - 1);
    return { index: Math.floor(place), share: place % 1 };
  }

  #node(frame, node) {
    const at = 2 * (frame * this.world.rest.length + node);
    return this.#coordinates.subarray(at, at + 2);
  }

  #bodyMiddles() {
    return Float64Array.from({ length: this.frames }, (_, k) => {
      let [low, high] = [Infinity, -Infinity];
      for (const node of this.body) {
        const x = this.#node(k, node)[0];
        [low, high] = [Math.min(low, x), Math.max(high, x)];
      }
      return (low + high) / 2;
    });
  }

  #smoothed(numbers) {
    const half = Math.round(STEADY / 2 / this.world.every);
    const sums = [0];
    for (const number of numbers) sums.push(sums.at(-1) + number);
    return numbers.map((_, k) => {
      const [from, to] = [Math.max(0, k - half), Math.min(numbers.length, k + half + 1)];
      return (sums[to] - sums[from]) / (to - from);
    });
  }
}
