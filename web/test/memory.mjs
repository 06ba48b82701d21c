// Designs robots one after another, uses each of them, and prints the memory of the library after every robot.
//   node test/memory.mjs [--minutes 5]
// Exits with 1 if the memory still grows after the first third of the robots.
import { readFileSync, readdirSync } from "node:fs";
import { parseArgs } from "node:util";
import { fileURLToPath } from "node:url";
import { Engine } from "../page/engine.js";
import { OWN } from "../page/scene.js";

const here = path => fileURLToPath(new URL(path, import.meta.url));
const { values: { minutes } } = parseArgs({ options: { minutes: { type: "string", default: "5" } } });
const wasm = readdirSync(here("../dist"), { recursive: true }).find(name => name.endsWith("cosmic.wasm"));
const engine = new Engine(new WebAssembly.Module(readFileSync(here(`../dist/${wasm}`))));
// A quarter of the steps, so that there are four times as many robots.
const scene = { scene: OWN.creature.toml, settings: ["physics.steps=1024"] };

/** Designs a robot, and does with it what a visitor of the page does. */
function round(seed) {
  engine.ask({ do: "begin", scene, seed });
  while (!engine.ask({ do: "iterate", shown: true }).done);
  const { robot } = engine.ask({ do: "deliver", packed: true });
  engine.ask({ do: "visit", settings: ["physics.gravity=3.7", "physics.incline_deg=8"] });
  engine.ask({ do: "push", velocity: [1, 0, 1], frame: 5 });
  engine.ask({ do: "edit", materials: robot.materials });
  engine.judge();
  engine.ask({ do: "open", scene, bytes: engine.ask({ do: "share" }).bytes });
}

const used = [];
for (const end = Date.now() + 60_000 * Number(minutes); Date.now() < end || used.length < 3;) {
  round(used.length);
  used.push(engine.bytes / 2 ** 20);
  console.log(`robot ${used.length}: ${used.at(-1).toFixed(1)} MiB`);
}
const [early, last] = [used[Math.floor(used.length / 3)], used.at(-1)];
console.log(`${used.length} robots: ${early.toFixed(1)} MiB after the first third, ${last.toFixed(1)} MiB in the end`);
process.exitCode = last > early ? 1 : 0;
