// The cast: finished robots that walk in a parade while the library loads and the page's own design learns to walk.
/* global Stage: of robot.js; everyFrame: of drawing.js; viewOf: of painter.js */

import { Walk, nameOf } from "./design.js";
import { framed } from "./player.js";
import { REAL } from "./scene.js";
import { metres } from "./words.js";

/** The parade ends when the page's own design walks farther than this, m, but not before this time, milliseconds. */
export const ENOUGH = 1;
const GREETING = 4000;

/** Whether the page may begin a design by itself. */
export function mayBegin() {
  const still = matchMedia("(prefers-reduced-motion: reduce)").matches;
  const saves = navigator.connection?.saveData === true || matchMedia("(prefers-reduced-data: reduce)").matches;
  return !still && !saves && !new URLSearchParams(location.search).has("wait");
}

/** Whether a robot of the parade consists of real parts. */
export const isReal = ({ link }) => new URLSearchParams(link.slice(1)).get("scene") === REAL;

const load = async () => (await fetch(new URL("cast.json", import.meta.url))).json();
let loaded = null;
const cast = () => loaded ??= load();

/** What is measured of these robots: a map from their names. It is empty if they cannot be loaded. */
export async function measuredOfCast() {
  const robots = await cast().catch(() => []);
  return new Map(robots.map(({ link, measured }) => {
    const key = link.slice(1);
    return [nameOf(key, new URLSearchParams(key).get("robot")), measured];
  }));
}

/** A finished robot of real parts. */
export const realRobot = async () => (await cast()).find(isReal);

/** The robots are drawn in turns, in so many frames. */
const TURNS = 3;

export class Parade {
  #place;
  #player;
  #onpick;
  #began = 0;
  #ticks = false;
  /** Whether the visitor has called the robots back. */
  isCalled = false;
  /** The robots: { name, link, walk, measured, stage, time }. */
  robots = [];
  /** For tests: the number of frames and the total time of their scripts in milliseconds. */
  cost = { frames: 0, total: 0 };

  /**
   * @param place is the element for the robots. They walk while `player.playing`.
   * @param onpick is called with the robot that the user touches.
   */
  constructor(place, { player, onpick }) {
    [this.#place, this.#player, this.#onpick] = [place, player, onpick];
  }

  get isOpen() {
    return !this.#place.hidden;
  }

  /** How much longer the robots should be seen, milliseconds. */
  get rest() {
    return GREETING - (performance.now() - this.#began);
  }

  /** Loads the robots and shows them. Resolves to whether they could be loaded. */
  async open() {
    let robots;
    try {
      robots = await cast();
    } catch {
      return false;
    }
    this.#place.hidden = false;
    this.#began = performance.now();
    this.robots = robots.map(robot => this.#add(robot));
    if (!this.#ticks) everyFrame(passed => { if (this.isOpen) this.#tick(passed); });
    this.#ticks = true;
    return true;
  }

  close() {
    this.#place.hidden = true;
    this.isCalled = false;
    this.#place.replaceChildren();
  }

  #add({ name, link, world, robot, measured }) {
    const walk = new Walk(world, { ...robot, diverged: null });
    const canvas = document.createElement("canvas");
    const button = Object.assign(document.createElement("button"), { type: "button" });
    const far = document.createElement("b");
    const label = document.createElement("span");
    far.textContent = metres(measured.distance.p50);
    label.append(name, " ", far);
    button.append(canvas, label);
    button.title = "Make this robot yours";
    this.#place.append(button);
    const stage = new Stage(canvas, walk.world);
    const one = { name, link, walk, measured, stage, time: this.#player.still.matches ? walk.landing : 0 };
    const fit = () => {
      stage.world = { ...framed(walk, canvas), view: viewOf(walk.robot), isMarked: false };
      this.#draw(one);
    };
    new ResizeObserver(fit).observe(canvas);
    button.addEventListener("click", () => this.#onpick(one));
    return one;
  }

  #draw({ walk, stage, time }) {
    stage.draw(Object.assign(walk.at(time), { trail: [] }));
  }

  #tick(passed) {
    // Before time has passed, the robots stand as they were drawn when their size became known.
    if (!this.#player.playing || passed === 0) return;
    const begun = performance.now();
    for (const one of this.robots) one.time = (one.time + passed * this.#player.speed) % one.walk.duration;
    // Every robot is drawn in every third frame, so that slow devices keep up.
    for (let k = this.cost.frames % TURNS; k < this.robots.length; k += TURNS) this.#draw(this.robots[k]);
    this.cost.frames += 1;
    this.cost.total += performance.now() - begun;
  }
}
