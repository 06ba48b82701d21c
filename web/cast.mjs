// Designs the finished robots that walk on the page while the library loads, and writes their walks, what is measured of
// them, and their links.
//   node web/cast.mjs [--check | --keep] [--program COSMIC] [--runs FOLDER]
// It needs `web/dist` (build.sh) and the program. Finished runs in the folder are not done again. With --check it opens the
// robots of the links instead and compares their walks with the file. With --keep it lets these robots walk again and writes
// their walks and what is measured of them.
import { execFileSync } from "node:child_process";
import { existsSync, mkdirSync, mkdtempSync, readFileSync, readdirSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { parseArgs } from "node:util";
import { gzipSync } from "node:zlib";
import { CHOICES } from "./page/chips.js";
import { Engine } from "./page/engine.js";
import { toBytes, toText } from "./page/packed.js";
import { OWN } from "./page/scene.js";

/** The robots: the scene, the settings that replace its own, the seed, and options of `cosmic optimize`. */
const CAST = {
  "flat ground": { scene: "creature", seed: 1 },
  stairs: { scene: "creature", seed: 1, set: CHOICES.ground.steps },
  "the Moon": { scene: "creature", seed: 4, set: CHOICES.gravity.Moon },
  "long body": { scene: "creature", seed: 1, set: CHOICES.size.long },
  "three dimensions": { scene: "cube", seed: 0, set: { "physics.steps": 4096 }, short: ["--iterations", "60"], hidden: 8 },
  "could be built": { scene: "real_parts", seed: 8 },
};
/** The clocks of a robot in a link, and the hidden units of these robots. */
const CLOCKS = 4;
const HIDDEN = 16;
/** Walks are rounded to multiples of this many units, and end after this many seconds. */
const COARSE = 4;
const SECONDS = 8;

const here = path => fileURLToPath(new URL(path, import.meta.url));
const wasm = process.env.WASM ?? readdirSync(here("dist"), { recursive: true }).filter(name => name.endsWith(".wasm")).map(name => here(`dist/${name}`))[0];
const engine = new Engine(new WebAssembly.Module(readFileSync(wasm)));
const { values: given } = parseArgs({ options: { check: { type: "boolean" }, keep: { type: "boolean" }, program: { type: "string", default: here("../target/release/cosmic") }, runs: { type: "string" } } });
const runs = given.runs ?? mkdtempSync(join(tmpdir(), "cosmic-cast-"));
mkdirSync(runs, { recursive: true });
const file = here("page/cast.json");

/** The scene of a link, in the form that requests have. */
function sceneOf(link) {
  const name = link.get("scene");
  return { scene: OWN[name]?.toml ?? name, settings: link.getAll("set") };
}

/** The robot of a link with its world, as the page needs them. */
function opened(link) {
  const { world, robot: { walk, materials, mixtures, along } } = engine.ask({ do: "open", scene: sceneOf(link), bytes: toBytes(link.get("robot")) });
  return { world, robot: { materials, mixtures, along, walk: coarse(walk) } };
}

/** A walk in fewer bytes. */
function coarse({ every, unit, axes, counts }) {
  const at = counts[0].map(() => 0);
  let before = [...at];
  const rounded = counts.slice(0, Math.floor(SECONDS / every) + 1).map(moved => {
    moved.forEach((by, k) => { at[k] += by; });
    const now = at.map(count => Math.round(count / COARSE));
    const change = now.map((count, k) => count - before[k]);
    before = now;
    return change;
  });
  return { every, unit: COARSE * unit, axes, counts: rounded };
}

/** Lets the program design a robot in open loop, as links need it. Returns the folder of the run. */
function run(name, { scene, seed, set = {}, short = [], hidden = HIDDEN }) {
  const out = join(runs, name.replaceAll(" ", "-"));
  if (existsSync(join(out, "summary.json"))) return out;
  const text = OWN[scene]?.toml;
  const path = text ? join(runs, `${scene}.toml`) : scene;
  if (text) writeFileSync(path, text);
  const settings = { ...set, "controller.policy": "clock", "controller.clocks": CLOCKS, "controller.hidden": hidden };
  const options = Object.entries(settings).flatMap(([key, value]) => ["--set", `${key}=${value}`]);
  execFileSync(given.program, ["optimize", path, "--seed", String(seed), "--threads", "1", "--quiet", "--out", out, ...short, ...options]);
  return out;
}

/** The row of a packed robot: a byte for its scale, and a byte for each number (see `src/packed.rs`). */
function row(numbers) {
  const most = Math.max(...numbers.map(Math.abs));
  const code = Math.min(255, Math.max(0, Math.ceil(128 + 8 * Math.log2(most) - 1e-9)));
  const scale = 2 ** ((code - 128) / 8);
  return [code, ...numbers.map(x => Math.round(127 * x / scale) & 255)];
}

/** Packs the robot of a run for a link. */
function packed(folder) {
  const { materials, controller: { w1, b1, w2, b2, tempo = [0] } } = JSON.parse(readFileSync(join(folder, "design.json")));
  const scene = readFileSync(join(folder, "scene.toml"), "utf8");
  const setting = key => JSON.parse(new RegExp(`^${key} = (.*)$`, "m").exec(scene)[1]);
  const scale = setting("goal_scale");
  // The goal is a constant of the network. Robots in space have a third number in the middle, across.
  const goal = setting("goal").map(x => x * scale);
  if (w1[0].length === CLOCKS + 3 && goal.length === 2) goal.splice(1, 0, 0);
  const biases = b1.map((bias, unit) => goal.reduce((sum, x, k) => sum + w1[unit][CLOCKS + k] * x, bias));
  const quarters = Array.from({ length: Math.ceil(materials.length / 4) }, (_, k) =>
    materials.slice(4 * k, 4 * k + 4).reduce((byte, material, i) => byte | material << 2 * i, 0));
  const solid = [...materials.keys()].filter(edge => materials[edge] > 0);
  return [
    1, b1.length, ...new Uint8Array(new Float32Array(tempo).buffer), ...quarters,
    // The clocks are sin, cos, -sin and -cos.
    ...row(w1.map(weights => weights[0] - weights[2])), ...row(w1.map(weights => weights[1] - weights[3])), ...row(biases),
    ...solid.flatMap(edge => row([...w2[edge], b2[edge]])),
  ];
}

/** The entry of a robot, which is in its link. */
function entry(name, link) {
  const { world, robot } = opened(link);
  const { measured } = engine.judge();
  return { name, link: `#${link}`, world, robot, measured };
}

function designed(name, how) {
  const folder = run(name, how);
  const link = new URLSearchParams({ scene: how.scene, seed: String(how.seed) });
  // As on the page, a link has no settings that the scene has already.
  const { settings } = engine.ask({ do: "check", scene: OWN[how.scene]?.toml ?? how.scene, settings: [] });
  const isOwn = (key, value) => String(key.split(".").reduce((at, part) => at[part], settings)) === value;
  for (const [key, value] of Object.entries(how.set ?? {})) if (!isOwn(key, String(value))) link.append("set", `${key}=${value}`);
  link.set("robot", toText(packed(folder)));
  const made = entry(name, link);
  const { robot, measured } = made;
  const { displacement_robust_p50: median, seconds } = JSON.parse(readFileSync(join(folder, "summary.json")));
  console.log(`${name}: ${robot.along.toFixed(2)} m, median ${measured.distance.p50.toFixed(2)} m (${median.toFixed(2)} m before packing), ${measured.reliability.verdict}; ${seconds.toFixed(0)} s, ${String(link).length} characters in the link`);
  return made;
}

/** Writes the robots of the page. */
function write(robots) {
  const text = `[\n${robots.map(robot => JSON.stringify(robot)).join(",\n")}\n]\n`;
  writeFileSync(file, text);
  console.log(`${text.length} bytes, ${gzipSync(text).length} compressed by gzip`);
}

if (given.check) {
  for (const { name, link, robot, measured } of JSON.parse(readFileSync(file))) {
    const { robot: again } = opened(new URLSearchParams(link.slice(1)));
    const judged = engine.judge();
    const same = JSON.stringify([again, judged]) === JSON.stringify([robot, { measured }]);
    console.log(`${same ? "ok  " : "FAIL"} ${name}: the robot walks as its file says: ${again.along.toFixed(3)} m, ${robot.along.toFixed(3)} m`);
    if (!same) process.exitCode = 1;
  }
} else if (given.keep) {
  write(JSON.parse(readFileSync(file)).map(({ name, link }) => entry(name, new URLSearchParams(link.slice(1)))));
} else {
  write(Object.entries(CAST).map(([name, how]) => designed(name, how)));
}
