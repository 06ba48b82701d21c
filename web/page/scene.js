// The scene of the page: a built-in scene, and settings that replace its own. The page's link contains them and the
// seed.

import { CHOICES } from "./chips.js";
import { linkOf, readLink, seedOf } from "./link.js";

/** The page's own scenes, as texts in TOML. */
export const OWN = {
  creature: {
    about: "a small robot of soft bars that may cross, designed in half a minute",
    toml: `base = "earth"
[lattice]
columns = 4
rows = 3
[physics]
steps = 4096
[controller]
hidden = 16
[adam]
rate = 0.008
[robust]
samples = 1
[schedule]
iterations = 120
window = "off"
`,
  },
  real_parts: {
    about: "a small robot of tubes and cylinders that one can buy, designed in three minutes",
    toml: `base = "workshop"
[physics]
steps = 1600
[controller]
hidden = 16
[robust]
samples = 1
[materials]
max_strain = [0.0, 0.0, 0.07]
[actuator]
speed = 0.6
[stops]
stiffness = 6e4
[adam]
rate = 0.008
fine_rate = 0.003
[schedule]
iterations = 60
window = "off"
`,
  },
};

/** The page's own scene of real parts. */
export const REAL = "real_parts";

/** The fields of the form: a key of the scene, the label of the field, and the allowed numbers or words. */
const FIELDS = [
  { key: "lattice.columns", name: "Columns of nodes", min: 2, max: 16, step: 1 },
  { key: "lattice.rows", name: "Rows of nodes", min: 2, max: 16, step: 1 },
  { key: "physics.payload_mass", name: "Cargo, kg", min: 0, max: 1, step: 0.005 },
  { key: "physics.gravity", name: "Gravity, m/s²", min: 0, max: 30, step: 0.1 },
  { key: "physics.incline_deg", name: "Incline, degrees", min: -45, max: 45, step: 1 },
  { key: "physics.contact", name: "Feet", words: { infinite: "never slip", coulomb: "slip (Coulomb)" } },
  { key: "physics.friction", name: "Friction coefficient", min: 0, max: 10, step: 0.1 },
];

/** The nodes and the steps of the page's own scene. */
const OWN_COST = 4 * 3 * 4096;

/** The scene if the link does not name one. */
export const DEFAULT = "creature";
const DEFAULT_SEED = 1;
/** If the worker is busy with an earlier scene, how long to wait before it is restarted, milliseconds. */
const PATIENCE = 1000;
const POINTS = "ground.points";
const PROFILE = "ground.profile";

/** The kinds of settings in which a link may move its robot to another world. */
const VISITS = ["ground", "gravity"];

export class Scene {
  #client;
  #form;
  #own = {};
  #asked = 0;
  /** Asks whether the scene may be changed. Resolves to false if the user wants to keep the robot. */
  #mayChange;
  name = DEFAULT;
  seed = DEFAULT_SEED;
  /** The names from which the robots of the link are designed, and the finished robot of one of them. */
  names = [];
  born = null;
  /** A finished robot in the form that links have; null without a robot. */
  robot = null;
  /** The other world in which that robot walks: a map from kinds of settings to the names of choices. */
  visited = {};
  /** The robot to beat in the form that links have, and the distance that its link claims, m; null if there is none. */
  rival = null;
  claimed = null;
  /** Whether the scene comes from a link, and not from a choice of the visitor. */
  isLinked = false;
  /** The settings that replace the scene's own: a map from keys to values in TOML. */
  changed = new Map();
  /** Whether the library still checks the scene. */
  isChecking = false;
  /** All settings, and the text of `scene.toml`; null until the library has checked the scene. */
  checked = null;

  /**
   * @param mayChange is asked before a change, and resolves to whether the change may be made.
   * @param onchange is called after a change: with null if the scene is valid, otherwise with the error.
   */
  constructor(client, form, mayChange, onchange) {
    this.#client = client;
    this.#form = form;
    this.#mayChange = mayChange;
    this.onchange = onchange;
    this.#build();
    this.read();
  }

  /** Whether the robot is told where to go. Such a robot does not fit into a link. */
  get takesGoals() {
    return this.checked?.settings["controller.goals"] === "given";
  }

  /** How many times as much as a walk of the page's own scene a walk costs, roughly: by nodes, steps and kind of step. */
  get cost() {
    const { "lattice.columns": columns, "lattice.rows": rows, "lattice.depth": depth, "lattice.kind": kind, "physics.steps": steps, "physics.integrator": integrator } = this.checked.settings;
    return columns * rows * (kind === "cubic" ? depth : 1) * steps * (integrator === "implicit" ? 10 : 1) / OWN_COST;
  }

  /** The scene in the form that requests have. */
  get asked() {
    return { scene: this.#text, settings: [...this.changed].map(([key, value]) => `${key}=${value}`) };
  }

  /** The name of a built-in scene, or the text of a scene of the page. */
  get #text() {
    return OWN[this.name]?.toml ?? this.name;
  }

  /** The scene and the seed in the form that links have. */
  get key() {
    const link = new URLSearchParams({ scene: this.name, seed: String(this.seed) });
    for (const setting of this.asked.settings) link.append("set", setting);
    return String(link);
  }

  /** Whether names are all that the link needs. */
  get isNamed() {
    const isBorn = this.robot === this.born && Object.keys(this.visited).length === 0;
    return this.names.length > 0 && isBorn && this.rival === null;
  }

  /** The name of the robot; undefined if it has none. */
  get owner() {
    return this.names.find(name => seedOf(name) === this.seed);
  }

  /** The part of the link after `#`. */
  get link() {
    if (this.isNamed) return linkOf(this.names);
    const link = new URLSearchParams(this.key);
    if (this.robot !== null) {
      link.set("robot", this.robot);
      for (const [kind, name] of Object.entries(this.visited)) link.set(kind, name);
    }
    if (this.rival !== null) link.set("rival", this.rival);
    if (this.claimed !== null) link.set("beat", this.claimed.toFixed(2));
    return `#${link}`;
  }

  /** The link that asks others to beat a finished robot, whose distance is `far`. Their design begins with another seed. */
  challenge(robot, far) {
    const link = new URLSearchParams(this.key);
    link.set("seed", String(this.seed + 1));
    link.set("rival", robot);
    link.set("beat", far.toFixed(2));
    return `#${link}`;
  }

  /** Chooses a built-in scene with its own settings. */
  choose(name) {
    return this.#change(() => {
      this.name = name;
      this.changed.clear();
    });
  }

  /** Replaces settings: a list of [key, value]. */
  set(...settings) {
    return this.#change(() => settings.forEach(([key, value]) => this.changed.set(key, value)));
  }

  async setSeed(seed) {
    return this.#change(() => { this.seed = seed; }, true);
  }

  /** Makes a change if the user agrees. Resolves to whether it was made. */
  async #change(make, keepsRival = false) {
    const agreed = await this.#mayChange();
    if (agreed) {
      this.robot = this.born = null;
      this.visited = {};
      this.names = [];
      this.isLinked = false;
      if (!keepsRival) this.rival = this.claimed = null;
      make();
      await this.check();
    } else {
      this.#show();
    }
    return agreed;
  }

  /** Sets the ground to a profile with these points [along, height]. Without points, the ground is level. */
  setGround(points) {
    return this.#change(() => {
      this.changed.delete(POINTS);
      this.changed.set(PROFILE, points.length > 0 ? "points" : "flat");
      if (points.length > 0) this.changed.set(POINTS, `[${points.map(([x, y]) => `[${x}, ${y}]`).join(", ")}]`);
      if (points.length === 0 && this.#own[PROFILE] === "flat") this.changed.delete(PROFILE);
    });
  }

  /**
   * Lets the library check the scene. If it is called again before the answer, only the last answer counts.
   * @returns whether the answer counts.
   */
  async check() {
    const asked = ++this.#asked;
    this.isChecking = true;
    if (this.#client.busyFor > PATIENCE) this.#client.start();
    try {
      const own = await this.#client.ask({ do: "check", scene: this.#text, settings: [] });
      const { toml, profile, settings } = await this.#client.ask({ do: "check", ...this.asked });
      if (asked !== this.#asked) return false;
      this.#own = flat(own.settings);
      this.checked = { toml, profile, settings: flat(settings) };
      for (const [key, value] of this.changed) {
        if (key !== POINTS && String(this.#own[key]) === value) this.changed.delete(key);
      }
      this.#show();
      this.isChecking = false;
      await this.onchange(null);
    } catch (error) {
      if (asked !== this.#asked) return false;
      this.checked = null;
      this.isChecking = false;
      await this.onchange(error);
    }
    return asked === this.#asked;
  }

  #build() {
    for (const { key, name, words, ...limits } of FIELDS) {
      const label = document.createElement("label");
      label.textContent = name;
      const field = document.createElement(words ? "select" : "input");
      if (words) {
        for (const [word, says] of Object.entries(words)) field.add(new Option(says, word));
      } else {
        Object.assign(field, { type: "number", required: true, ...limits });
      }
      field.name = key;
      field.addEventListener("change", () => field.value === "" ? this.#show() : this.set([key, field.value]));
      label.append(field);
      this.#form.append(label);
    }
    this.#form.addEventListener("submit", event => event.preventDefault());
  }

  #show() {
    if (this.checked === null) return;
    for (const { key, words } of FIELDS) {
      const [field, value] = [this.#form.elements[key], String(this.checked.settings[key])];
      // A scene may have a value that the form does not offer, so it is added.
      if (words && !(value in words) && ![...field.options].some(option => option.value === value)) field.add(new Option(value, value));
      field.value = value;
    }
    this.#form.elements["physics.friction"].disabled = this.checked.settings["physics.contact"] !== "coulomb";
  }

  /** The field of the setting that an error is about; undefined if the form does not have it. */
  fieldOf(message) {
    const about = FIELDS.find(({ key }) => message.includes(`\`${key}\``) || message.includes(key));
    return about && this.#form.elements[about.key];
  }

  /** Reads the link in the address. */
  read() {
    const { names, link } = readLink(location.hash);
    this.names = names;
    this.born = null;
    this.isLinked = true;
    this.name = link.get("scene")?.toLowerCase() ?? DEFAULT;
    this.robot = link.get("robot");
    const seed = names.length > 0 ? seedOf(names[0]) : Number(link.get("seed") ?? (link.has("scene") ? 0 : DEFAULT_SEED));
    this.seed = Number.isSafeInteger(seed) && seed >= 0 ? seed : DEFAULT_SEED;
    this.changed.clear();
    for (const setting of link.getAll("set")) {
      const at = setting.indexOf("=");
      if (at > 0) this.changed.set(setting.slice(0, at).trim().toLowerCase(), setting.slice(at + 1));
    }
    this.rival = link.get("rival");
    const claimed = Number(link.get("beat") ?? NaN);
    this.claimed = this.rival !== null && Number.isFinite(claimed) ? claimed : null;
    this.visited = {};
    for (const kind of VISITS) {
      const name = Object.keys(CHOICES[kind]).find(name => name.toLowerCase() === link.get(kind)?.toLowerCase());
      if (this.robot !== null && name !== undefined) this.visited[kind] = name;
    }
  }
}

/** Turns nested sections of settings into a flat object with keys like `section.key`. */
function flat(settings) {
  const entries = Object.entries(settings).flatMap(([section, keys]) =>
    Object.entries(keys).map(([key, value]) => [`${section}.${key}`, value]));
  return Object.fromEntries(entries);
}
