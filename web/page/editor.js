// Edits the delivered robot. The user clicks on a bar, or uses the controls below the stage.
/* global MATERIALS: of drawing.js */

export class Editor {
  #canvas;
  #stage;
  #player;
  #parts;
  #design;
  /** The bars, ordered from left to right and from bottom to top by their positions at rest. */
  #order = [];
  #bar = null;
  /** The materials before each edit. */
  #before = [];
  #busy = Promise.resolve();

  /**
   * @param isShown returns whether the finished robot is on the stage. Only then can its bars be clicked.
   * @param onedit is called before the robot is edited.
   * @param onerror is called with the error of an edit that failed.
   */
  constructor({ canvas, stage, player, parts, isShown, onedit, onerror }) {
    [this.#canvas, this.#stage, this.#player, this.#parts] = [canvas, stage, player, parts];
    Object.assign(this, { isShown, onedit, onerror });
    parts.previous.addEventListener("click", () => this.#step(-1));
    parts.next.addEventListener("click", () => this.#step(1));
    parts.undo.addEventListener("click", () => this.#undo());
    for (const radio of parts.materials) radio.addEventListener("change", () => this.#give(Number(radio.value)));
    canvas.addEventListener("click", event => this.#click(event));
    canvas.addEventListener("pointermove", event => this.#hover(event));
    canvas.addEventListener("pointerleave", () => this.#mark(this.#bar));
    canvas.addEventListener("keydown", event => this.#key(event));
  }

  /** Begins editing the delivered robot of `design`. With null, ends editing. */
  open(design) {
    this.#design = design;
    this.#bar = null;
    this.#before = [];
    this.#parts.fieldset.disabled = design === null;
    this.#canvas.classList.toggle("editable", design !== null);
    if (design === null) {
      this.#parts.legend.textContent = "After a design, click a bar above: void, skeleton, actuator.";
      for (const radio of this.#parts.materials) radio.checked = false;
      this.#mark(null);
      return;
    }
    this.#parts.legend.textContent = "Click a bar above, or choose one here. Every click changes its material, and the robot walks with it.";
    const { start, edges } = design.world.robot;
    const middle = ([i, j]) => [2, 0, 1].map(axis => Math.round(1e6 * (start[3 * i + axis] + start[3 * j + axis])));
    const middles = edges.map(middle);
    const before = (a, b) => a.map((x, k) => x - b[k]).find(off => off !== 0) ?? 0;
    this.#order = [...edges.keys()].sort((a, b) => before(middles[a], middles[b]));
  }

  #step(by) {
    const count = this.#order.length;
    const at = this.#bar === null ? (by > 0 ? -1 : 0) : this.#order.indexOf(this.#bar);
    this.#choose(this.#order[(at + by + count) % count]);
  }

  #choose(bar) {
    this.#bar = bar;
    const material = this.#design.delivered.walk.materials[bar];
    this.#parts.legend.textContent = `Bar ${bar} of ${this.#order.length}: ${MATERIALS[material]}`;
    for (const radio of this.#parts.materials) radio.checked = Number(radio.value) === material;
    this.#mark(bar);
  }

  #mark(bar) {
    this.#player.highlight = bar;
    if (!this.#player.playing) this.#player.paint();
  }

  #click(event) {
    if (!this.#design || !this.isShown()) return;
    const bar = this.#stage.edgeAt(event.clientX, event.clientY);
    if (bar === null) return;
    this.#bar = bar;
    this.#cycle();
  }

  #cycle() {
    this.#give((this.#design.delivered.walk.materials[this.#bar] + 1) % MATERIALS.length);
  }

  #hover(event) {
    if (this.#design && this.isShown()) this.#mark(this.#stage.edgeAt(event.clientX, event.clientY) ?? this.#bar);
  }

  #key(event) {
    // The arrow keys may have turned the view.
    if (!this.#design || event.defaultPrevented) return;
    const moves = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1 };
    if (event.key in moves) {
      this.#step(moves[event.key]);
    } else if (event.key === "Enter" && this.#bar !== null) {
      this.#cycle();
    } else {
      return;
    }
    event.preventDefault();
  }

  #give(material) {
    if (this.#bar === null) this.#bar = this.#order[0];
    const [bar, design] = [this.#bar, this.#design];
    // Edits wait for one another, so that a quick second click edits the result of the first click.
    this.#busy = this.#busy.then(async () => {
      const materials = [...design.delivered.walk.materials];
      this.#before.push([...materials]);
      materials[bar] = material;
      await this.#apply(materials);
      if (this.#design === design) this.#choose(bar);
    });
  }

  #undo() {
    const design = this.#design;
    this.#busy = this.#busy.then(async () => {
      await this.#apply(null);
      if (this.#design === design && this.#bar !== null) this.#choose(this.#bar);
    });
  }

  /** Takes the last edit back. Without edits since the robot was opened, shows the designed robot. */
  takeBack() {
    const design = this.#design;
    this.#busy = this.#busy.then(async () => {
      const now = String(design.delivered.walk.materials);
      let before = null;
      // Back in the history of the browser may have taken edits back already.
      do before = this.#before.pop() ?? null; while (before !== null && String(before) === now);
      await this.#apply(before);
    });
  }

  async #apply(materials) {
    this.onedit();
    try {
      await this.#design.edit(materials);
    } catch (error) {
      this.onerror(error);
    }
  }
}
