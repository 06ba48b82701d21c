// The choices of a world and of a size: lists for the ground, the gravity and the size of the robot, and switches for the
// worlds that are most fun. Each choice is a list of settings.

const STEPS = { "ground.profile": "steps", "ground.from": "0.5", "ground.count": "12", "ground.spacing": "0.3", "ground.rise": "0.015" };
const ROUGH = { "ground.profile": "rough", "ground.from": "0.5", "ground.count": "60", "ground.spacing": "0.1", "ground.roughness": "0.02" };
const FLAT = { "ground.profile": "flat" };
const level = { "physics.incline_deg": "0" };
const size = (columns, rows) => ({ "lattice.columns": String(columns), "lattice.rows": String(rows) });

/** The settings of every choice. */
export const CHOICES = {
  ground: {
    flat: { ...FLAT, ...level }, steps: { ...STEPS, ...level }, rough: { ...ROUGH, ...level },
    uphill: { ...FLAT, "physics.incline_deg": "8" }, downhill: { ...FLAT, "physics.incline_deg": "-8" },
  },
  gravity: {
    // The first of each list is the choice before the scene is known.
    Earth: { "physics.gravity": "9.81" }, Moon: { "physics.gravity": "1.62" }, Mars: { "physics.gravity": "3.7" },
    Neptune: { "physics.gravity": "11.2" }, Jupiter: { "physics.gravity": "24.8" },
  },
  size: { small: size(4, 3), tall: size(3, 5), long: size(6, 3), large: size(5, 4) },
};

export class Chips {
  #fields;
  #switches;

  /**
   * @param fields are the lists `ground`, `gravity` and `size`.
   * @param switches are buttons with a list and a choice in `data-kind` and `data-choice`. A switch of the ground that is on
   * goes back to flat ground.
   * @param onchoose is called with the name of the list, the choice, and its settings: keys and values.
   */
  constructor(fields, switches, onchoose) {
    [this.#fields, this.#switches] = [fields, switches];
    for (const button of switches) {
      button.addEventListener("click", () => {
        const { kind, choice } = button.dataset;
        const isOn = button.getAttribute("aria-pressed") === "true";
        if (isOn && kind !== "ground") return;
        const name = isOn ? "flat" : choice;
        onchoose(kind, name, CHOICES[kind][name]);
      });
    }
    for (const [name, field] of Object.entries(fields)) {
      for (const choice of Object.keys(CHOICES[name])) field.add(new Option(choice, choice));
      field.addEventListener("change", () => {
        const settings = CHOICES[name][field.value];
        if (settings) onchoose(name, field.value, settings);
      });
    }
  }

  /** Shows the choices of a scene with these settings. Another setting than those of the lists is "other". */
  show(settings) {
    for (const [name, field] of Object.entries(this.#fields)) {
      const fits = choice => Object.entries(choice).every(([key, value]) => String(settings[key]) === value);
      const found = Object.entries(CHOICES[name]).find(([, choice]) => fits(choice));
      const other = [...field.options].find(({ value }) => value === "");
      if (found) other?.remove();
      else if (!other) field.add(new Option("other", ""));
      field.value = found?.[0] ?? "";
    }
    for (const button of this.#switches) {
      const { kind, choice } = button.dataset;
      button.setAttribute("aria-pressed", this.#fields[kind].value === choice);
    }
  }
}
