// Runs a program compiled for WebAssembly, with the files of the machine: a runner for Cargo.
//   node --no-warnings autodiff/tests/wasi.mjs PROGRAM.wasm [ARGUMENT...]
import { readFile } from 'node:fs/promises'
import { WASI } from 'node:wasi'

const args = process.argv.slice(2)
const preopens = { '/': '/', '.': process.cwd() }
const wasi = new WASI({ version: 'preview1', args, env: process.env, preopens })
const module = await WebAssembly.compile(await readFile(args[0]))
process.exitCode = wasi.start(await WebAssembly.instantiate(module, wasi.getImportObject()))
