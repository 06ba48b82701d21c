// Runs the library in its own thread. A message is [number, request], and its answer has the same number.

import { Engine, Refusal } from "./engine.js";

const engine = WebAssembly.compileStreaming(fetch(new URL("cosmic.wasm", import.meta.url)))
  // Some file servers send WebAssembly with a wrong type, which streaming does not accept.
  .catch(async () => WebAssembly.compile(await (await fetch(new URL("cosmic.wasm", import.meta.url))).arrayBuffer()))
  .then(module => new Engine(module));
// If loading fails, nothing is reported here: every request is answered with the error.
engine.then(() => postMessage({ loaded: true }), () => {});

addEventListener("message", async ({ data: [number, request] }) => {
  try {
    postMessage({ number, ok: (await engine).ask(request) });
  } catch (error) {
    postMessage({ number, error: error.message, stopped: !(error instanceof Refusal) });
  }
});
