// Designs a robot: runs the iterations, and keeps the robot after each iteration and the delivered robot.
/* global Walker: of robot.js; levelAt: of drawing.js */

import { Refused, Stopped } from "./client.js";
import { Judge, judged } from "./judge.js";
import { toBytes, toText } from "./packed.js";

/** A node counts as on the ground if it is less than this many mean lengths of a bar above it. */
const NEAR = 0.02;
/** How much of a walk stays before the piece that follows it, seconds. */
const KEPT = 4;
/** The gradient is asked for after every attempt whose number is a multiple of this. */
const WEIGHED = 4;

/** Names a robot in a link, and its scene, for what is known about it. `key` has them both, or only the scene. */
export function nameOf(key, robot) {
  const link = new URLSearchParams(key);
  link.delete("seed");
  link.set("robot", robot);
  return String(link);
}

/** A robot whose worker stopped stays without measurements. */
function unlessStopped(error) {
  if (!(error instanceof Stopped)) throw error;
  return null;
}

/** A robot with its walk, from an answer of the library. */
export class Walk extends Walker {
  /** Where the walk began on the axis, m along the ground. */
  #before = 0;
  #jump = null;
  /** The frames before the walk was lengthened. */
  #own = null;
  /** The time at which the frames begin, s, and the number of frames before the last piece of the walk. */
  began = 0;
  lead = 0;

  constructor({ robot, world }, { materials, mixtures, walk, along, diverged }) {
    super(robot, world, mixtures, walk);
    Object.assign(this, { materials, along, diverged, took: this.duration });
  }

  /**
   * Lets the walk go on with a piece that begins with its last frame. Its first frames are forgotten, so that a long walk
   * stays small. Returns the duration of the forgotten part, s.
   */
  lengthen({ walk: piece }) {
    const before = this.walk;
    this.#own ??= { walk: before, before: this.#before };
    const jump = this.jump;
    const kept = Math.min(before.counts.length - 1, Math.round(KEPT / before.every));
    const first = before.counts.length - 1 - kept;
    const dropped = first * before.every;
    const { metres } = this.at(dropped);
    const at = before.counts[0].map((_, k) => before.counts.slice(0, first + 1).reduce((sum, moved) => sum + moved[k], 0));
    this.frames = { ...before, counts: [at, ...before.counts.slice(first + 1), ...piece.counts.slice(1)] };
    [this.#before, this.began, this.lead] = [metres, this.began + dropped, kept];
    this.#jump = Math.max(jump, this.#highest(kept));
    return dropped;
  }

  /** Goes back to the frames that the walk had before it was lengthened. */
  rewind() {
    if (!this.#own) return;
    this.frames = this.#own.walk;
    [this.#before, this.began, this.lead, this.#jump, this.#own] = [this.#own.before, 0, 0, null, null];
  }

  /** The greatest height of the whole body above the ground so far, m. */
  get jump() {
    this.#jump ??= this.#highest(0);
    return this.#jump;
  }

  #highest(from) {
    if (!this.walk) return 0;
    const { ground } = this.world;
    const body = [...this.body];
    let most = 0;
    for (let frame = from; frame < this.walk.counts.length; frame++) {
      const positions = this.placesAt(frame);
      let least = Infinity;
      for (const i of body) least = Math.min(least, positions[3 * i + 2] - levelAt(ground, positions[3 * i]));
      most = Math.max(most, least);
    }
    return most;
  }

  /**
   * A walk on which the robot was sent from another one. It ends with the last frame in which the robot is on the ground,
   * so that the robot does not stop in mid-air. Its axis begins where the robot was sent off, or, if it `keepsAxis`, where
   * the axis of the robot's own walk begins.
   */
  static sent(place, answer, keepsAxis) {
    const walk = new Walk(place, answer);
    if (walk.along === null) return walk;
    const counts = walk.walk.counts.slice(0, walk.#landing() + 1);
    const ended = new Walk(place, { ...answer, walk: { ...walk.walk, counts } });
    const { positions } = ended.at(0);
    const payload = 3 * place.robot.payloads[0];
    if (keepsAxis) {
      const [dx, dz] = [0, 2].map(axis => positions[payload + axis] - place.robot.start[payload + axis]);
      ended.#before = dx * place.world.cos + dz * place.world.sin;
    } else {
      ended.world = { ...place.world, origin: positions[payload] };
    }
    ended.along = ended.at(ended.duration).metres;
    return ended;
  }

  at(time) {
    const moment = super.at(time);
    moment.metres += this.#before;
    return moment;
  }

  /** The time of the last frame in which the robot is on the ground, s. */
  get landing() {
    return this.walk ? this.#landing() * this.walk.every : 0;
  }

  /** The last frame in which a node of the body is on the ground; the last frame of all if the robot flies for more than
   * three quarters of the walk. */
  #landing() {
    const { robot: { rest }, world: { ground } } = this;
    const last = this.walk.counts.length - 1;
    const near = NEAR * rest.reduce((sum, length) => sum + length, 0) / rest.length;
    const stands = frame => {
      const positions = this.placesAt(frame);
      return [...this.body].some(i => positions[3 * i + 2] < levelAt(ground, positions[3 * i]) + near);
    };
    for (let frame = last; frame > last / 4; frame--) if (stands(frame)) return frame;
    return last;
  }

  /** The number of bars of a material. */
  count(material) {
    return this.materials.filter(is => is === material).length;
  }
}

export class Design {
  #client;
  /** Counts the choices of scene and seed. Answers that belong to an earlier choice are dropped. */
  #run = 0;
  /** The value of `#run` for which an iteration is being computed, or null. */
  #iterated = null;
  /** "empty", "asking", "preparing", "ready", "working", "paused", "measuring", "finished", "cancelled" or "stopped". */
  state = "empty";
  world = null;
  /** The robot before the first iteration and the robot after each iteration, with the iteration's record and the seconds that
   * all iterations took until then. */
  robots = [];
  /** The finished robot with the user's edits: its `walk`, its `link` (null if it does not fit into one), and what is
   * `measured` (null until it is known). `designed` has the same of the robot before the edits. */
  delivered = null;
  /** The designs that links can lead back to: a map from scene and seed to the attempts, the seconds, the designed robot,
   * and the links of its edits. */
  #kept = new Map();
  #judge = new Judge();
  /** The scene of this design in the form that requests have. */
  #scene = null;
  /** What was measured before a robot is opened: a map from `nameOf`. */
  known = new Map();
  /** Whether another robot is about to take the place of the finished one. */
  isReplacing = false;
  /** Scene and seed of this design. */
  key = null;
  /** The walk on which the user has sent the robot: after a push, to another world, or to the goal `to`, which is [along,
   * across] from the payload at the start (m); in the end the robot is `left` metres away from it. Null if there is none. */
  told = null;
  /** The other world in which the robot walks: { world, changes, settings }; null in its own world. `changes` are
   * the kinds of settings that differ, each with its `name` and its `settings`; `settings` are all of them. */
  elsewhere = null;
  seconds = 0;
  /** What more material in each bar of the robot in design would bring: { gains, seconds }, in metres for a whole bar within
   * the first seconds; null if it is not known. */
  gains = null;
  /** The name from which the robot is designed; undefined if there is none. */
  owner;
  /** How many times as much as usual a walk costs that waits for a click. */
  costs = 1;
  /** The evolution that races this design. */
  twin = null;
  /** The robot to beat: { walk, link, measured, claimed }; null if there is none. */
  rival = null;

  /**
   * @param onchange is called after every change.
   * @param panicAfter is, for tests, the iteration after which the library panics.
   */
  constructor(client, onchange, panicAfter = null) {
    this.#client = client;
    this.onchange = onchange;
    this.panicAfter = panicAfter;
  }

  /** The world in which the robot walks. */
  get place() {
    return this.elsewhere?.world ?? this.world;
  }

  get iteration() {
    return this.robots.length - 1;
  }

  /** Whether an iteration is being computed. This can be true even after a pause, until the current iteration ends. */
  get iterates() {
    return this.#iterated !== null && this.#iterated === this.#run;
  }

  /** Prepares the robot of a scene before its first iteration. `key` stands for the scene and the seed. */
  async prepare(scene, seed, key) {
    const run = ++this.#run;
    this.#change("preparing");
    const { world, first } = await this.#client.ask({ do: "begin", scene, seed });
    if (run !== this.#run) return;
    this.world = world;
    this.robots = [{ walk: new Walk(world, first), record: null }];
    this.delivered = null;
    this.#stayHome();
    [this.#scene, this.key] = [scene, key];
    this.seconds = 0;
    this.#change("ready");
  }

  /** Opens the finished robot of a link. If it was designed on this page, it keeps its attempts. */
  async open(scene, link, key) {
    const kept = this.#kept.get(key);
    const isKept = kept !== undefined && (kept.designed.link === link || kept.edits.has(link));
    if (isKept && this.state === "finished" && this.key === key) return this.restore(link);
    const run = ++this.#run;
    this.#change("preparing");
    const designed = isKept ? kept.designed : { link, measured: this.known.get(nameOf(key, link)) ?? null };
    const { world, robot } = await this.#client.ask({ do: "open", scene, bytes: toBytes(designed.link) });
    if (run !== this.#run) return;
    this.world = world;
    const walk = new Walk(world, robot);
    this.robots = isKept ? kept.robots : [{ walk, record: null }];
    this.seconds = isKept ? kept.seconds : 0;
    [this.#scene, this.key] = [scene, key];
    this.#finish({ ...designed, walk });
    if (designed.link !== link) await this.restore(link);
  }

  /** Shows a robot that has no edits as the finished one. */
  #finish(designed) {
    this.delivered = { ...designed, designed };
    this.#stayHome();
    this.#change("finished");
  }

  /** The link of the robot that was designed on this page from a scene and a seed; null if there is none. */
  linkOf(key) {
    return this.#kept.get(key)?.designed.link ?? null;
  }

  /** Whether the robot was designed on this page, so that its attempts are known. */
  get hasAttempts() {
    return this.robots.length > 1;
  }

  /** The robot of the best attempt so far; null before the first attempt. */
  get best() {
    const far = ({ walk }) => walk.along ?? -Infinity;
    return this.robots.slice(1).reduce((best, robot) => (best === null || far(robot) > far(best) ? robot : best), null);
  }

  /** Does iterations until a pause or the end. */
  async work() {
    const run = this.#run;
    this.#change("working");
    // If the user resumes before the current iteration has ended, the earlier call continues.
    if (this.#iterated === run) return;
    this.#iterated = run;
    try {
      while (this.state === "working") {
        const done = await this.#iterate(run);
        if (run !== this.#run) return;
        if (done) await this.#deliver(run);
      }
    } catch (error) {
      if (run === this.#run && !(error instanceof Stopped)) this.#change("paused");
      throw error;
    } finally {
      if (this.#iterated === run) this.#iterated = null;
    }
  }

  pause() {
    this.#change("paused");
  }

  /** Stops waiting for the current run. */
  abandon(state) {
    this.#run += 1;
    this.#change(state);
  }

  async #iterate(run) {
    if (this.iteration === this.panicAfter) {
      this.panicAfter = null;
      await this.#client.ask({ do: "panic" });
    }
    const begun = performance.now();
    const { robot, record, done } = await this.#client.ask({ do: "iterate", shown: true });
    if (run !== this.#run) return false;
    this.seconds += (performance.now() - begun) / 1000;
    this.robots.push({ walk: new Walk(this.world, robot), record, seconds: this.seconds });
    this.#stayHome();
    const isUndecided = ["co_design", "attraction"].includes(record.phase);
    if (!isUndecided) this.gains = null;
    else if (this.iteration % WEIGHED === 0) await this.weigh();
    if (run !== this.#run) return false;
    this.onchange(this.state);
    return done;
  }

  /** Asks for the gradient of the distance after the last attempt. `tried` is a bar and a share of material: the answer then
   * also says how much farther the robot gets with this share more. Resolves to null if the robot has no such gradient. */
  async weigh(tried = null) {
    const run = this.#run;
    try {
      const weighed = await this.#client.ask({ do: "gains", tried });
      if (run !== this.#run) return null;
      this.gains = weighed;
      return weighed;
    } catch (error) {
      if (error instanceof Refused) return null;
      throw error;
    }
  }

  /** Gets to know the robot of a link to a scene as the one to beat; null if there is none. It is measured later. */
  async meet(scene, link, key) {
    const name = link && nameOf(key, link);
    if (link === null) this.rival = null;
    if (link === null || this.rival?.name === name) return;
    const run = ++this.#run;
    this.#change("preparing");
    const { world, robot } = await this.#client.ask({ do: "open", scene, bytes: toBytes(link) });
    if (run !== this.#run) return;
    const measured = this.known.get(name) ?? null;
    const rival = { walk: new Walk(world, robot), link, name, measured };
    this.rival = rival;
    if (measured === null) this.#measureRival(scene, rival);
  }

  async #measureRival(scene, rival) {
    rival.measured = await this.#judge.measure(scene, rival.link, () => this.rival === rival).catch(unlessStopped);
    this.onchange(this.state);
  }

  async #deliver(run) {
    this.#change("measuring");
    const { robot, measured } = await this.#client.ask({ do: "deliver", packed: true });
    const link = await this.#share();
    if (run !== this.#run) return;
    const designed = { walk: new Walk(this.world, robot), link, measured };
    const { robots, seconds } = this;
    if (link !== null) this.#kept.set(this.key, { robots, seconds, designed, edits: new Set() });
    this.#finish(designed);
  }

  /** The finished robot, with its edits, as text for a link; null if it does not fit into a link. */
  async #share() {
    try {
      return toText((await this.#client.ask({ do: "share" })).bytes);
    } catch (error) {
      if (error instanceof Refused) return null;
      throw error;
    }
  }

  /** Gives the finished robot other materials, or, for null, the designed ones again. */
  async edit(materials) {
    const { designed } = this.delivered;
    const isOther = materials !== null && materials.some((material, e) => material !== designed.walk.materials[e]);
    await this.#replace({ do: "edit", materials: isOther ? materials : null }, isOther);
  }

  /** Shows the robot of a link to this design: the designed robot, or one of its edits. */
  async restore(link) {
    if (link === this.delivered.designed.link) return this.edit(null);
    await this.#replace({ do: "restore", bytes: toBytes(link) }, true);
  }

  async #replace(request, isOther) {
    const run = this.#run;
    this.isReplacing = true;
    const ask = async () => [(await this.#client.ask(request)).robot, isOther ? await this.#share() : null];
    const [robot, link] = await ask().finally(() => { this.isReplacing = false; });
    if (run !== this.#run) return;
    const { designed } = this.delivered;
    designed.walk.rewind();
    this.delivered = { ...(isOther ? { walk: new Walk(this.world, robot), link, measured: null } : designed), designed };
    if (isOther && link !== null) this.#kept.get(this.key)?.edits.add(link);
    this.#stayHome();
    this.onchange(this.state);
    this.judge();
  }

  /** Lets the finished robot, with its edits, walk in its own world again, from the start. */
  home() {
    const { walk, designed } = this.delivered;
    return this.edit(walk === designed.walk ? null : walk.materials);
  }

  /** Measures and judges the finished robot, while it already walks. */
  async judge() {
    const { delivered } = this;
    if (delivered?.measured !== null) return;
    const isWanted = () => this.delivered === delivered;
    const { link } = delivered;
    delivered.isMeasuring = true;
    this.onchange(this.state);
    const measuring = link === null ? judged(this.#client, isWanted) : this.#judge.measure(this.#scene, link, isWanted);
    const measured = await measuring.catch(unlessStopped);
    delivered.isMeasuring = false;
    if (!isWanted()) return;
    if (delivered.walk === delivered.designed.walk) delivered.designed.measured = measured;
    delivered.measured = measured;
    this.onchange(this.state);
  }

  #stayHome() {
    this.told = this.elsewhere = null;
  }

  /**
   * Lets the latest robot walk on to a goal, from a frame of its walk. `to` is its place [along, across], m.
   * @param ontold is called before the walk is shown.
   */
  async tell(to, frame, ontold) {
    const run = this.#run;
    const { robot, left } = await this.#client.ask({ do: "tell", to, frame });
    if (run === this.#run) this.#send(robot, { to, left }, ontold);
  }

  /** Lets the latest robot walk on after a push, from a frame of its walk. `velocity` is [along, across, above] in m/s. */
  async push(velocity, frame, onpushed) {
    const run = this.#run;
    const { robot } = await this.#client.ask({ do: "push", velocity, frame });
    if (run === this.#run) this.#send(robot, {}, onpushed);
  }

  /** Lets the walk on the stage go on from its last frame. Resolves to the seconds by which its beginning is forgotten; null
   * if it cannot go on. */
  async lengthen(walk) {
    const run = this.#run;
    const { robot } = await this.#client.ask({ do: "push", velocity: [0, 0, 0], frame: walk.walk.counts.length - 1 - walk.lead });
    if (run !== this.#run || walk !== (this.told ?? this.delivered)?.walk || robot.walk === null) return null;
    return walk.lengthen(robot);
  }

  /** Lets the finished robot walk in another world, from the start. `there` has the `changes` and the `settings` of that world. */
  async visit(there, onvisit) {
    const run = this.#run;
    const settings = Object.entries(there.settings).map(([key, value]) => `${key}=${value}`);
    const { world, robot } = await this.#client.ask({ do: "visit", settings });
    if (run !== this.#run) return;
    this.elsewhere = { ...there, world };
    this.#send(robot, { visits: true }, onvisit);
  }

  #send(robot, { to = null, left = null, visits = false }, onsent) {
    const walk = Walk.sent(this.place, robot, to !== null);
    // The page also shows the place at the end. Both numbers are to fit together.
    if (left !== null && this.place.robot.axes === 2) left = Math.abs(to[0] - walk.along);
    this.told = { walk, to, left, visits };
    onsent();
    this.onchange(this.state);
  }

  /** The pieces of the finished robot, with its edits, and the set points of its actuators: { pieces, drive }. */
  async lists() {
    return this.#client.ask({ do: "shop" });
  }

  /** The texts of `design.json` and `scene.toml` for the finished robot: { design, scene }. */
  async files() {
    return this.#client.ask({ do: "design" });
  }

  #change(state) {
    this.state = state;
    if (!["working", "paused"].includes(state)) this.gains = null;
    this.onchange(state);
  }
}
