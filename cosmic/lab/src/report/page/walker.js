"use strict";
// A robot on its way, as it stands in a page: positions are differences of counts from one frame to the next.

class Walker {
  #unpacked = null;

  // `robot`: `edges` [[i, j], …], their lengths at `rest` (m), `start` positions (m) and `payloads`; `world` as a
  // `Stage` takes it, with `sin`; `mixtures` of every edge in thousandths; `walk`, or null if there is none.
  constructor(robot, world, mixtures, walk) {
    Object.assign(this, { robot, world, walk });
    this.mixtures = mixtures.map(shares => shares.map(share => share / 1000));
    this.edges = robot.edges.map(([i, j], e) => {
      const [, skeleton, actuator] = this.mixtures[e];
      const weight = skeleton + actuator;
      return [i, j, robot.rest[e], weight < 0.02 ? 0 : skeleton >= actuator ? 1 : 2, e, weight];
    });
    this.bars = this.edges.filter(edge => edge[3] > 0);
  }

  // Seconds of the walk.
  get duration() {
    return this.walk ? this.walk.every * (this.walk.counts.length - 1) : 0;
  }

  get #frames() {
    this.#unpacked ??= this.#unpack();
    return this.#unpacked;
  }

  #unpack() {
    const { counts, unit } = this.walk ?? { counts: [this.robot.start], unit: 1 };
    let at = new Float64Array(counts[0].length);
    const places = counts.map(moved => {
      at = at.map((count, k) => count + moved[k]);
      return at.map(count => count * unit);
    });
    const payload = this.robot.payloads[0];
    const trail = places.flatMap(frame => [...frame.subarray(2 * payload, 2 * payload + 2)]);
    return { places, trail, cameras: this.#follow(places) };
  }

  // The middle of the payload's body over a second, so that the camera does not shake, and the ground around it.
  #follow(places) {
    const body = [...bodyOf(this.robot.payloads, this.bars, e => this.bars[e][5])];
    const middles = places.map(frame => {
      const along = body.map(node => frame[2 * node]);
      return (Math.min(...along) + Math.max(...along)) / 2;
    });
    const around = Math.max(0, Math.round(0.5 / (this.walk?.every ?? 1)));
    const { width, ground } = this.world;
    return middles.map((_, k) => {
      const near = middles.slice(Math.max(0, k - around), k + around + 1);
      const x = near.reduce((sum, middle) => sum + middle, 0) / near.length;
      return [x, levelAround(ground, x, width / 4)];
    });
  }

  // The moment at a time: what a `Stage` draws, and the metres that the payload got along the ground.
  at(time) {
    const { places, trail, cameras } = this.#frames;
    const place = this.walk ? Math.min(time / this.walk.every, places.length - 1) : 0;
    const [k, next] = [Math.floor(place), Math.ceil(place)];
    const between = (from, to) => from.map((x, i) => x + (place - k) * (to[i] - x));
    const positions = between(places[k], places[next]);
    const payload = 2 * this.robot.payloads[0];
    const [along, up] = [0, 1].map(axis => positions[payload + axis] - places[0][payload + axis]);
    return {
      positions, frame: Math.round(place), shape: places[Math.round(place)], edges: this.bars,
      camera: between(cameras[k], cameras[next]), trail: trail.slice(0, 2 * k + 2),
      metres: along * this.world.cos + up * this.world.sin,
    };
  }
}

// Plays and pauses by the space bar wherever the focus is, but where text is typed. Nothing else acts on it then.
function playBySpace(toggle) {
  for (const kind of ["keydown", "keyup"]) {
    addEventListener(kind, event => {
      const field = event.target.closest?.("input:not([type=range]), textarea, [contenteditable]");
      if (event.key !== " " || field || event.ctrlKey || event.metaKey || event.altKey) return;
      event.preventDefault();
      if (kind === "keydown" && !event.repeat) toggle();
    }, true);
  }
}

const startsPlaying = () => !matchMedia("(prefers-reduced-motion: reduce)").matches;
