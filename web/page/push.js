// Pushes the robot: drag it on the stage, and let go.

/** A drag that is shorter than this many pixels is a click. */
const CLICK = 14;
/** The speed that a drag over the width of the robot's world gives, m/s; and the largest speed of a push. */
const STRONG = 6;
const MOST = 3;

export class Push {
  #canvas;
  #stage;
  #player;
  #design;
  #from = null;
  #pushed = false;

  /**
   * @param isShown returns whether the finished robot is on the stage.
   * @param onpush is called before the robot is pushed.
   * @param onerror is called with the error of a push that failed.
   */
  constructor({ canvas, stage, player, design, isShown, onpush, onerror }) {
    [this.#canvas, this.#stage, this.#player, this.#design] = [canvas, stage, player, design];
    Object.assign(this, { onpush, onerror });
    // A drag that begins elsewhere turns the view. Two fingers turn it everywhere.
    const isTaken = ({ clientX, clientY }) => isShown() && stage.isNear(clientX, clientY);
    canvas.addEventListener("pointerdown", event => {
      this.#pushed = false;
      this.#from = event.isPrimary && isTaken(event) ? [event.clientX, event.clientY] : null;
      this.#show(null);
    });
    stage.orbit.listen(canvas, {
      isTaken,
      // Arrow keys choose bars of a planar robot.
      takesArrows: () => !canvas.classList.contains("editable") || stage.orbit.isOfSpace,
      onturn: () => { if (!player.playing) player.paint(); },
    });
    canvas.addEventListener("pointermove", event => {
      if (this.#from) this.#show(this.#dragged(event));
    });
    canvas.addEventListener("pointerup", event => this.#end(event));
    canvas.addEventListener("pointercancel", () => {
      this.#from = null;
      this.#show(null);
    });
    // A drag is not a click.
    canvas.addEventListener("click", event => { if (this.#pushed) event.stopImmediatePropagation(); }, true);
  }

  #dragged({ clientX, clientY }) {
    const by = [clientX - this.#from[0], clientY - this.#from[1]];
    return Math.hypot(...by) < CLICK ? null : by;
  }

  #show(arrow) {
    this.#player.arrow = arrow;
    if (!this.#player.playing) this.#player.paint();
  }

  async #end(event) {
    if (this.#from === null) return;
    const by = this.#dragged(event);
    this.#show(null);
    this.#from = null;
    if (by === null) return;
    this.#pushed = true;
    const { width } = this.#canvas.getBoundingClientRect();
    const held = x => Math.min(MOST, Math.max(-MOST, x));
    const [across, down] = by.map(x => held(STRONG * x / width));
    await this.push(this.#stage.pushOf(across, down));
  }

  /** Pushes the robot at this moment of its walk. `velocity` is [along, across, above] in m/s. */
  async push(velocity) {
    this.onpush();
    try {
      await this.#player.goOn((frame, ongoing) => this.#design.push(velocity, frame, ongoing));
    } catch (error) {
      this.onerror(error);
    }
  }
}
