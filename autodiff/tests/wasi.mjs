// Runs a program compiled for WebAssembly: a runner for Cargo. The program sees the files of the current
// folder, by relative paths and by absolute ones.
//   node --no-warnings autodiff/tests/wasi.mjs PROGRAM.wasm [ARGUMENT...]
import { readFile } from 'node:fs/promises'
import { WASI } from 'node:wasi'

const args = process.argv.slice(2)
const here = process.cwd()
const preopens = { '/': here, [here]: here }
const wasi = new WASI({ version: 'preview1', args, env: process.env, preopens })
const module = await WebAssembly.compile(await readFile(args[0]))
process.exitCode = wasi.start(await WebAssembly.instantiate(module, wasi.getImportObject()))
