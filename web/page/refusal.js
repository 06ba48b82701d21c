// Shows why the library refused something: at the field that the reason is about, or under the main button.

import { Refused, Stopped } from "./client.js";
import { cut } from "./link.js";

/** The most characters of a refusal. */
const MOST = 1000;

export class Refusals {
  #text;
  #details;
  #scene;
  /** The element before which the text is if it does not belong to a field. */
  #before;

  constructor({ text, details, scene, before }) {
    [this.#text, this.#details, this.#scene, this.#before] = [text, details, scene, before];
  }

  /** Shows an error of the library. A stopped worker is shown in a dialog instead. Other errors are thrown again. */
  show(error) {
    if (error instanceof Stopped) return;
    if (!(error instanceof Refused)) throw error;
    const field = this.#details.open ? this.#scene.fieldOf(error.message) : undefined;
    if (field) field.form.append(this.#text);
    field?.setAttribute("aria-invalid", "true");
    field?.setAttribute("aria-describedby", this.#text.id);
    this.say(error.message, field);
  }

  /** Shows a text, under the main button unless it belongs to a field. */
  say(text, field) {
    if (!field) this.#before.before(this.#text);
    // Links may have names of any length.
    this.#text.textContent = text.replace(/\S{41,}/g, cut).slice(0, MOST);
  }

  forget() {
    this.#text.textContent = "";
    for (const field of document.querySelectorAll("[aria-invalid]")) {
      field.removeAttribute("aria-invalid");
      field.removeAttribute("aria-describedby");
    }
  }
}
