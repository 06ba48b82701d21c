// Designs the finished robot that walks on the page while the library loads, and writes its walk and its link.
//   node web/hello.mjs [--check]
// It needs `web/dist` (build.sh). With --check it opens the robot of the link instead and compares its walk with the file.
import { readFileSync, readdirSync, writeFileSync } from "node:fs";
import { fileURLToPath } from "node:url";
import { Engine } from "./page/engine.js";
import { toBytes, toText } from "./page/packed.js";
import { OWN } from "./page/scene.js";

const here = path => fileURLToPath(new URL(path, import.meta.url));
const wasm = process.env.WASM ?? readdirSync(here("dist"), { recursive: true }).filter(name => name.endsWith(".wasm")).map(name => here(`dist/${name}`))[0];
const SEED = Number(process.env.SEED ?? 1);
const engine = new Engine(new WebAssembly.Module(readFileSync(wasm)));
const scene = { scene: OWN.creature.toml, settings: [] };

/** The robot of a link with its world, as the page needs them. Positions are needed only for the solid bars. */
const opened = text => engine.ask({ do: "open", scene, bytes: toBytes(text) });

const file = here("page/hello.json");
if (process.argv.includes("--check")) {
  const kept = JSON.parse(readFileSync(file));
  const { robot } = opened(new URLSearchParams(kept.link.slice(1)).get("robot"));
  const same = JSON.stringify(robot.walk) === JSON.stringify(kept.robot.walk);
  console.log(`${same ? "ok  " : "FAIL"} the finished robot walks as its file says: ${robot.along.toFixed(3)} m, ${kept.robot.along.toFixed(3)} m`);
  process.exitCode = same ? 0 : 1;
} else {
  engine.ask({ do: "begin", scene, seed: SEED });
  while (!engine.ask({ do: "iterate", shown: false }).done);
  const designed = engine.ask({ do: "deliver", packed: true });
  const packed = toText(engine.ask({ do: "share" }).bytes);
  const { world, robot } = opened(packed);
  const link = `#${new URLSearchParams({ scene: "creature", seed: String(SEED), robot: packed })}`;
  const text = JSON.stringify({ link, world, robot });
  writeFileSync(file, `${text}\n`);
  console.log(`designed ${designed.robot.along.toFixed(2)} m, in the link ${robot.along.toFixed(2)} m; ${link.length} characters, ${text.length} bytes`);
}
