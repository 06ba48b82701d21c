// Tells the robot where to go: by a click on the ground of the stage, or by the slider below it.
/* global decimals, levelAt: of drawing.js */

/** Goals may be this many times as far away as those that the robot is trained for. */
const BEYOND = 2;
/** The number of steps of the slider to each side. */
const STEPS = 30;
/** The states of a design in which a robot can be told where to go. */
const LISTENS = ["ready", "working", "paused", "finished"];

export class Errand {
  #stage;
  #player;
  #design;
  #parts;
  /** The goal that the robot has before it is told another one: its components in the ground's frame, m. */
  #own = [0, 0];
  /** The farthest goals along the ground and across, m. */
  #most = [0, 0];
  /** The goal [along, across] that the user chose last, while the library still computes the walk to an earlier one. */
  #next = null;
  #asks = false;

  /**
   * @param ontell is called when the user has chosen a goal.
   * @param onerror is called with the error of a walk that failed.
   */
  constructor({ canvas, stage, player, design, parts, ontell, onerror }) {
    [this.#stage, this.#player, this.#design, this.#parts] = [stage, player, design, parts];
    Object.assign(this, { ontell, onerror });
    parts.slider.addEventListener("input", () => this.#name(Number(parts.slider.value)));
    parts.slider.addEventListener("change", () => this.#tell([Number(parts.slider.value), this.#place[1]]));
    canvas.addEventListener("click", event => {
      // While the robot can be edited, a click on a bar changes the bar.
      const edits = canvas.classList.contains("editable") && stage.edgeAt(event.clientX, event.clientY) !== null;
      if (this.#listens && !edits) this.#tell(this.#placeAt(event));
    });
  }

  get #listens() {
    return !this.#parts.row.hidden && LISTENS.includes(this.#design.state);
  }

  /** Shows the controls if the goals of a scene with these settings are given. */
  open(settings) {
    const { row, slider } = this.#parts;
    row.hidden = settings["controller.goals"] !== "given";
    this.#most = ["along", "across"].map(axis => BEYOND * Math.max(...settings[`goals.${axis}`].map(Math.abs)));
    const [most] = this.#most;
    Object.assign(slider, { min: -most, max: most, step: most / STEPS });
    this.#own = settings["controller.goal"];
  }

  /** Shows the goal in the controls. Returns the foot [x, y, z] of its flag; null if goals are not given. */
  show() {
    const { row, slider } = this.#parts;
    slider.disabled = !this.#listens;
    if (row.hidden || this.#design.place === null) return null;
    const { world } = this.#design.place;
    const [along, across] = this.#place;
    slider.value = along;
    this.#name(along);
    const foot = world.origin + along * world.cos;
    return [foot, this.#start[1] + across, levelAt(world.ground, foot)];
  }

  /** Where the payload is at the start, [x, y, z]. */
  get #start() {
    const { robot: { start, payloads: [payload] } } = this.#design.place;
    return start.slice(3 * payload, 3 * payload + 3);
  }

  /** The place of the goal along the ground and across, m from the payload at the start. */
  get #place() {
    const { told, place: { world, robot } } = this.#design;
    if (told?.to) return told.to;
    const [x, y, z] = this.#start;
    const along = this.#own[0] - (x * world.cos + z * world.sin);
    // A goal of two numbers is along the ground and above it.
    const across = this.#own.length > 2 ? this.#own[1] : 0;
    return [along, robot.axes === 3 ? across - y : 0];
  }

  #name(along) {
    this.#parts.place.textContent = `${decimals(along, 2)} m`;
    this.#parts.slider.setAttribute("aria-valuetext", this.#parts.place.textContent);
  }

  /** The place of the ground at a point of the window, along and across, m from the payload at the start. */
  #placeAt({ clientX, clientY }) {
    const { world } = this.#design.place;
    const [x, y] = this.#stage.groundAt(clientX, clientY);
    const place = [(x - world.origin) / world.cos, y - this.#start[1]];
    return place.map((at, axis) => Math.min(this.#most[axis], Math.max(-this.#most[axis], at)));
  }

  async #tell(to) {
    this.#next = to;
    if (this.#asks) return;
    this.#asks = true;
    this.ontell();
    if (this.#design.state === "working") this.#design.pause();
    try {
      while (this.#next !== null) {
        const to = this.#next;
        this.#next = null;
        await this.#player.goOn((frame, ongoing) => this.#design.tell(to, frame, ongoing));
      }
    } catch (error) {
      this.onerror(error);
    } finally {
      this.#next = null;
      this.#asks = false;
    }
  }
}
