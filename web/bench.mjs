// Compares the library in WebAssembly with the native program: processor time and displacement.
//   node web/bench.mjs [--seeds 8] [--program COSMIC] [--write]
// --write puts the table into docs/web.md. Run `web/build.sh` and `cargo build --release` first.
import { execFileSync, spawnSync } from "node:child_process";
import { mkdtempSync, readFileSync, readdirSync, rmSync, writeFileSync } from "node:fs";
import { cpus, tmpdir } from "node:os";
import { join } from "node:path";
import { parseArgs } from "node:util";
import { fileURLToPath } from "node:url";
import { brotliCompressSync, gzipSync } from "node:zlib";
import { Engine } from "./page/engine.js";

const here = path => fileURLToPath(new URL(path, import.meta.url));
const SCENES = ["stability", "five_by_five"];
const { values: given, positionals } = parseArgs({
  allowPositionals: true,
  options: {
    seeds: { type: "string", default: "8" },
    program: { type: "string", default: here("../target/release/cosmic") },
    write: { type: "boolean", default: false },
  },
});

/** The files of the page whose names `fit`. */
const built = fit => readdirSync(here("dist"), { recursive: true }).filter(fit).map(name => join(here("dist"), name));

/** Designs a robot with the WebAssembly library in this process, and prints the result. */
function inWebAssembly(scene, seed) {
  const engine = new Engine(new WebAssembly.Module(readFileSync(built(name => name.endsWith("cosmic.wasm"))[0])));
  engine.ask({ do: "begin", scene: { scene, settings: [] }, seed });
  while (!engine.ask({ do: "iterate", shown: false }).done);
  const { measured } = engine.ask({ do: "deliver", packed: false });
  const { user, system } = process.cpuUsage();
  console.log(JSON.stringify({ seconds: (user + system) / 1e6, far: measured.distance.p50 }));
}

function asProcess(scene, seed) {
  return JSON.parse(execFileSync(process.execPath, [here("bench.mjs"), scene, String(seed)]));
}

function natively(scene, seed) {
  const folder = mkdtempSync(join(tmpdir(), "cosmic-bench-"));
  const out = join(folder, "run");
  const command = `TIMEFORMAT='%U %S'; time "${given.program}" optimize ${scene} --seed ${seed} --threads 1 --quiet --out "${out}" >/dev/null`;
  const { status, stderr } = spawnSync("bash", ["-c", command], { encoding: "utf8" });
  if (status !== 0) throw new Error(stderr);
  const seconds = stderr.trim().split("\n").at(-1).split(" ").reduce((sum, part) => sum + Number(part), 0);
  const far = JSON.parse(readFileSync(join(out, "summary.json"))).displacement_robust_p50;
  rmSync(folder, { recursive: true });
  return { seconds, far };
}

const sorted = numbers => [...numbers].sort((a, b) => a - b);
const median = numbers => {
  const half = (numbers.length - 1) / 2;
  const [low, high] = [Math.floor(half), Math.ceil(half)].map(k => sorted(numbers)[k]);
  return (low + high) / 2;
};
const range = (numbers, digits) => `${sorted(numbers)[0].toFixed(digits)} to ${sorted(numbers).at(-1).toFixed(digits)}`;

function measured() {
  const seeds = Array.from({ length: Number(given.seeds) }, (_, seed) => seed);
  return SCENES.map(scene => {
    const rows = seeds.map(seed => {
      const row = { native: natively(scene, seed), wasm: asProcess(scene, seed) };
      console.error(`${scene} ${seed}: ${row.native.seconds.toFixed(1)} s and ${row.wasm.seconds.toFixed(1)} s, ${row.native.far.toFixed(2)} m and ${row.wasm.far.toFixed(2)} m`);
      return row;
    });
    return { scene, rows };
  });
}

function table(all) {
  const row = ({ scene, rows }) => {
    const [native, wasm] = ["native", "wasm"].map(where => ({ seconds: rows.map(row => row[where].seconds), far: rows.map(row => row[where].far) }));
    const cells = [
      `\`${scene}\``,
      `${median(native.seconds).toFixed(1)} (${range(native.seconds, 1)})`,
      `${median(wasm.seconds).toFixed(1)} (${range(wasm.seconds, 1)})`,
      median(rows.map(row => row.wasm.seconds / row.native.seconds)).toFixed(1),
      `${median(native.far).toFixed(2)} (${range(native.far, 2)})`,
      `${median(wasm.far).toFixed(2)} (${range(wasm.far, 2)})`,
    ];
    return `| ${cells.join(" | ")} |`;
  };
  const heads = ["scene", "native, s", "WebAssembly, s", "ratio", "native, m", "WebAssembly, m"];
  return [`| ${heads.join(" | ")} |`, `|${" --- |".repeat(heads.length)}`, ...all.map(row)].join("\n");
}

function size() {
  const files = built(name => /\.[a-z]+$/.test(name) && !/\.(gz|br)$/.test(name)).map(file => readFileSync(file));
  const sum = pack => Math.round(files.reduce((sum, file) => sum + pack(file).length, 0) / 1000);
  return `The page has ${sum(file => file)} kB, ${sum(file => gzipSync(file, { level: 9 }))} kB compressed by gzip, ${sum(file => brotliCompressSync(file))} kB by brotli.`;
}

if (positionals.length === 2) {
  inWebAssembly(positionals[0], Number(positionals[1]));
} else {
  const text = `${table(measured())}\n\nProcessor time of 300 iterations and the delivery, median and range over ${given.seeds} seeds; Node ${process.versions.node} on ${cpus()[0].model}. ${size()}`;
  console.log(text);
  if (given.write) {
    const page = here("../docs/web.md");
    const [before, after] = ["<!-- table -->", "<!-- end of the table -->"].map(mark => readFileSync(page, "utf8").split(mark));
    writeFileSync(page, `${before[0]}<!-- table -->\n${text}\n<!-- end of the table -->${after[1]}`);
  }
}
