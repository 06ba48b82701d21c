// A race of seeds: robots of several seeds are designed at the same time, each in its own worker, and walk side by side.
/* global Eye, SIDE, viewOf: of painter.js; Stage: of robot.js; everyFrame: of drawing.js */

import { Client, Refused, Stopped } from "./client.js";
import { Walk } from "./design.js";
import { metres, shownAs } from "./words.js";

/** The most seeds that race. One processor is left to the page. */
const MOST = 4;
/** A lane shows the latest robot after every attempt whose number is a multiple of this. The walk costs about half an attempt, so
 * a race takes a tenth longer, and in the page's own scene a lane changes about twice a second. */
const SHOWN = 5;
/** Each lane is drawn in every second frame, so that slow devices keep up. */
const TURNS = 2;
/** How long the robots stand at the end of their walk before they start again, seconds. */
const STANDS = 1;
/** The seconds after which most of the change from one robot to the next is done. */
const BLEND = 0.12;
/** Robots in space are seen from the side and a little from above, so that the lanes stay level. */
const ABOVE = [0, 18];
/** The largest fraction of a lane's height that a robot takes at the start. Above it is room to jump. */
const TALLEST = 0.4;
/** The room to the left of the robots in narrow windows, pixels. */
const MARGIN = 20;
/** Lanes lower than this have no marks on the ground, pixels. */
const MARKED = 115;
/** A robot that walks beyond the end of the lanes makes them this many times as long as its distance. */
const LONGER = 1.3;

const listed = words => new Intl.ListFormat("en").format(words);

const capital = words => words[0].toUpperCase() + words.slice(1);

/** Says who won. `ranking` is a list of { name, far } from the first to the last. */
export function outcome([first, ...others]) {
  if (first.far === null) return "Nobody won the race: all robots fall apart.";
  const equal = others.filter(({ far }) => far !== null && metres(far) === metres(first.far));
  if (equal.length > 0) return `${capital(listed([first, ...equal].map(({ name }) => name)))} tie: ${metres(first.far)}.`;
  const named = ({ name, far }) => `${far === null ? "a robot that falls apart" : metres(far)} (${name})`;
  return `${capital(first.name)} won the race: ${metres(first.far)} against ${listed(others.map(named))}.`;
}

/** The robots of several seeds, as entrants of a race. */
export function entrantsFrom(seed) {
  const count = Math.min(MOST, Math.max(2, (navigator.hardwareConcurrency ?? 2) - 1));
  return Array.from({ length: count }, (_, k) => ({ seed: seed + k, name: `seed ${seed + k}` }));
}

export class Race {
  #place;
  #player;
  #onchange;
  /** The line at the best distance so far, this distance, and the length of the lanes, m. */
  #line;
  #best = 0;
  #reach = 0;
  /** The time of all walks, s. */
  #time = 0;
  /** Where the robots start: the x on the canvas, pixels, and pixels per metre. */
  #track = { start: 0, scale: 1 };
  /** Whether a race is in progress. */
  runs = false;
  #all = [];
  /** The lanes of this race: { seed, title, far, walk, … }, where `far` is the distance that the lane shows, m. */
  lanes = [];
  /** For tests: the number of frames and the total time of their scripts in milliseconds. */
  cost = { frames: 0, total: 0 };

  /**
   * @param place is the element for the lanes. The robots walk while `player.playing`.
   * @param onchange is called when a race begins or ends.
   */
  constructor(place, { player, onchange }) {
    [this.#place, this.#player, this.#onchange] = [place, player, onchange];
    everyFrame(passed => { if (this.runs) this.#tick(passed); });
    new ResizeObserver(() => this.#fit()).observe(place);
  }

  /** The sentence about a race in progress. */
  get words() {
    return `${capital(listed(this.lanes.map(({ title }) => title)))} race: a robot is designed from each of them. The robot that walks farthest takes the stage.`;
  }

  /**
   * Designs the robots of a scene. Each of the `entrants` is { seed, name }. Resolves to a list of { seed, name, far, measured,
   * bytes } from the first to the last, where `far` is the distance to quote, null if the robot falls apart; to null if the race is ended.
   */
  async run(scene, entrants) {
    if (this.#all.length === 0) this.#build(MOST);
    for (const [k, { element }] of this.#all.entries()) element.hidden = k >= entrants.length;
    this.lanes = this.#all.slice(0, entrants.length);
    [this.#best, this.#reach, this.#time] = [0, 0, 0];
    this.#line.textContent = this.#place.style.cssText = "";
    this.lanes.forEach((lane, k) => this.#open(lane, entrants[k]));
    this.runs = true;
    this.#place.hidden = false;
    this.#onchange();
    this.#place.scrollIntoView({ block: "nearest" });
    try {
      // All begin together, after the last worker has loaded.
      await Promise.all(this.lanes.map(lane => this.#begin(lane, scene)));
      const finished = await Promise.all(this.lanes.map(lane => this.#design(lane)));
      return finished.sort((a, b) => (b.far ?? -Infinity) - (a.far ?? -Infinity));
    } catch (error) {
      if (!(error instanceof Stopped)) throw error;
      if (this.runs) throw new Refused(`The race stopped: ${error.message}`);
      return null;
    } finally {
      this.end();
    }
  }

  /** Ends the race and its workers. */
  end() {
    if (!this.runs) return;
    for (const { client } of this.lanes) client.end();
    this.runs = false;
    this.#place.hidden = true;
    this.#onchange();
  }

  async #begin(lane, scene) {
    const { world, first } = await lane.client.ask({ do: "begin", scene, seed: lane.seed });
    lane.world = world;
    lane.attempt.textContent = `version 0 / ${world.iterations}`;
    this.#show(lane, new Walk(world, first));
  }

  async #design(lane) {
    const { client, world } = lane;
    for (let [k, done] = [1, false]; !done; k++) {
      const answer = await client.ask({ do: "iterate", shown: k % SHOWN === 0 });
      done = answer.done;
      lane.attempt.textContent = `version ${k} / ${world.iterations}`;
      if (answer.robot) this.#show(lane, new Walk(world, answer.robot));
    }
    lane.attempt.textContent = "measuring …";
    const { robot, measured } = await client.ask({ do: "deliver", packed: true });
    const far = measured.distance?.p50 ?? null;
    lane.attempt.textContent = "finished, typical";
    this.#show(lane, new Walk(world, robot), far);
    const { bytes } = await client.ask({ do: "share" });
    return { seed: lane.seed, name: lane.title, far, measured, bytes };
  }

  /** Adds the lanes, which all races use. */
  #build(count) {
    const make = (name, parent, given = {}) => parent.appendChild(Object.assign(document.createElement(name), given));
    this.#all = Array.from({ length: count }, () => {
      const element = make("div", this.#place);
      element.setAttribute("role", "group");
      const canvas = make("canvas", element);
      canvas.setAttribute("role", "img");
      const label = make("p", element);
      const [distance, name, attempt] = ["b", "span", "small"].map(part => make(part, label));
      const stage = new Stage(canvas, { width: 1, ground: [[0, 0]], cos: 1, limit: 1 });
      return { element, canvas, label, distance, name, attempt, stage };
    });
    make("i", this.#place, { className: "start" });
    this.#line = make("i", this.#place, { className: "best" });
  }

  /** Gives a lane to an entrant. */
  #open(lane, { seed, name }) {
    Object.assign(lane, { seed, title: name, far: null, walk: null, blend: 0, client: new Client() });
    lane.name.textContent = name;
    lane.element.setAttribute("aria-label", capital(name));
    lane.element.className = "";
    lane.canvas.setAttribute("aria-label", `The robot of ${name}`);
    [lane.distance.textContent, lane.attempt.textContent] = ["–", "loading …"];
    // The canvas still shows the last race.
    lane.canvas.style.visibility = "hidden";
  }

  /** Shows another robot in a lane from now on, at the current time. */
  #show(lane, walk, far = walk.along) {
    const before = lane.walk && this.#player.playing ? this.#momentOf(lane).positions : null;
    Object.assign(lane, { walk, far, blend: 0 });
    if (before) {
      const { positions } = this.#momentOf(lane);
      Object.assign(lane, { blend: 1, offset: before.map((x, k) => x - positions[k]) });
    }
    lane.canvas.style.visibility = "";
    lane.distance.textContent = shownAs(far);
    const farthest = Math.max(...this.lanes.map(({ far }) => far ?? -Infinity));
    for (const { element, far } of this.lanes) element.classList.toggle("leads", far === farthest);
    this.#best = Math.max(this.#best, walk.along ?? 0);
    this.#fit();
  }

  /** Gives all lanes the same scale, at which a robot fits into the height of a lane and the best distance into its width. */
  #fit() {
    const shown = this.lanes.filter(({ walk }) => walk);
    if (!this.runs || shown.length === 0) return;
    const [{ canvas: { clientWidth: width, clientHeight: height }, label, walk: { robot, world } }] = shown;
    const view = viewOf(robot) === SIDE ? SIDE : ABOVE;
    const seen = new Eye(view).seeAll(robot.start);
    const [[left, right], [low, high]] = [0, 1].map(axis => [Math.min, Math.max].map(end => end(...seen.map(at => at[axis]))));
    // The label is to the left of the robots, or, in narrow windows, above them.
    const beside = label.offsetWidth < width / 2 ? label.offsetWidth : MARGIN;
    const room = width - beside;
    const scaleFor = reach => Math.min(TALLEST * height / (high - low), room / (right - left + reach));
    const within = room / scaleFor(this.#reach) - (right - left);
    if (this.#best * world.cos > within) this.#reach = LONGER * this.#best * world.cos;
    const scale = scaleFor(this.#reach);
    const start = beside + scale * (world.origin - left);
    this.#track = { start, scale };
    this.#place.style.setProperty("--start", `${start}px`);
    this.#place.style.setProperty("--best", `${start + scale * this.#best * world.cos}px`);
    this.#line.textContent = this.#best > 0 ? `best ${metres(this.#best)}` : "";
    this.#line.classList.toggle("far", start + scale * this.#best > 0.7 * width);
    for (const lane of shown) {
      const isMarked = view === SIDE && lane === this.lanes.at(-1) && height > MARKED;
      lane.stage.world = { ...world, payloads: robot.payloads, width: Math.min(2.4 * height, 2 * width) / scale, view, isMarked };
      this.#draw(lane);
    }
  }

  /** What a lane shows now. Where nothing moves, the robots stand at the end of their walk. */
  #momentOf({ walk, blend, offset }) {
    const { still, playing } = this.#player;
    const moment = walk.at(still.matches && !playing ? walk.duration : this.#time);
    if (blend > 0.01) moment.positions = moment.positions.map((x, k) => x + blend * offset[k]);
    return moment;
  }

  #draw(lane) {
    const { start, scale } = this.#track;
    const moment = this.#momentOf(lane);
    // The camera does not follow a robot along its lane, but up and down the ground.
    const along = lane.walk.world.origin + (lane.canvas.clientWidth / 2 - start) / scale;
    lane.stage.draw({ ...moment, trail: [], camera: [along, ...moment.camera.slice(1)] });
  }

  #tick(passed) {
    const shown = this.lanes.filter(({ walk }) => walk);
    if (!this.#player.playing || shown.length === 0) return;
    const begun = performance.now();
    const lap = STANDS + Math.max(...shown.map(({ walk }) => walk.duration));
    this.#time = (this.#time + passed * this.#player.speed) % lap;
    for (const lane of shown) lane.blend *= Math.exp(-passed / BLEND);
    for (let k = this.cost.frames % TURNS; k < shown.length; k += TURNS) this.#draw(shown[k]);
    this.cost.frames += 1;
    this.cost.total += performance.now() - begun;
  }
}
