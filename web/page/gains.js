// Shows the gradient while a robot is designed: each bar has a tint for what more material in it would bring, and a touch
// says it in words.
/* global decimals: of drawing.js */

/** The change of a bar about which the words are: this share of its material. */
const PART = 0.1;

const centimetres = x => `${x < 0 ? "-" : "+"}${decimals(Math.abs(100 * x), Math.abs(x) < 0.01 ? 2 : 1)} cm`;

/** What a tenth more or less in a bar would bring by the gradient; `farther` is what it brought when it was tried, or null. */
export function gainWords({ gains, seconds }, bar, farther = null) {
  const gain = PART * gains[bar];
  const way = gain < 0 ? "Thinner" : "Thicker";
  const tried = farther === null ? "" : ` Tried: ${centimetres(farther)}.`;
  return `${way} here: ${centimetres(Math.abs(gain))} in ${decimals(seconds, 1)} s.${tried}`;
}

export class Gains {
  #stage;
  #player;
  #design;
  #text;
  #bar = null;
  #said = null;

  /**
   * @param text is the element for the words.
   * @param isShown returns whether the robot in design is on the stage.
   */
  constructor({ canvas, stage, player, design, text, isShown, onerror }) {
    [this.#stage, this.#player, this.#design, this.#text] = [stage, player, design, text];
    Object.assign(this, { isShown, onerror });
    canvas.addEventListener("click", event => {
      if (this.#isOpen) this.#choose(stage.edgeAt(event.clientX, event.clientY));
    });
    // The key Enter goes through the bars, from the one that matters most.
    canvas.addEventListener("keydown", event => {
      if (event.key !== "Enter" || !this.#isOpen) return;
      const { gains } = this.#design.gains;
      const order = [...gains.keys()].sort((a, b) => Math.abs(gains[b]) - Math.abs(gains[a]));
      this.#choose(order[(order.indexOf(this.#bar) + 1) % order.length]);
      event.preventDefault();
    });
  }

  get #isOpen() {
    return this.#design.gains !== null && this.isShown();
  }

  /** Shows the tints of the robot on the stage, and the words about the bar that was touched. */
  show() {
    const { gains } = this.#isOpen ? this.#design : { gains: null };
    const most = gains && Math.max(1e-9, ...gains.gains.map(Math.abs));
    this.#player.tints = gains && gains.gains.map(gain => gain / most);
    if (gains === null && this.#bar !== null) {
      this.#bar = this.#said = this.#player.highlight = null;
    }
    this.#text.hidden = this.#bar === null;
    if (this.#bar !== null && this.#said !== gains) this.#say(gains, null);
    return gains !== null;
  }

  #say(gains, farther) {
    this.#said = gains;
    this.#text.textContent = gainWords(gains, this.#bar, farther);
  }

  async #choose(bar) {
    this.#bar = this.#player.highlight = bar;
    this.#said = null;
    this.show();
    if (!this.#player.playing) this.#player.paint();
    if (bar === null) return;
    try {
      const { gains } = this.#design.gains;
      const tried = await this.#design.weigh([bar, gains[bar] < 0 ? -PART : PART]);
      if (tried === null || this.#bar !== bar) return;
      this.show();
      this.#say(this.#design.gains, tried.farther);
    } catch (error) {
      this.onerror(error);
    }
  }
}
