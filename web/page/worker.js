// Runs the library outside the page's thread. A message is [number, request]; the answer has the same number.

import { Engine, Refusal } from "./engine.js";

const engine = WebAssembly.compileStreaming(fetch(new URL("cosmic.wasm", import.meta.url)))
  // For a file server that does not know the type of WebAssembly.
  .catch(async () => WebAssembly.compile(await (await fetch(new URL("cosmic.wasm", import.meta.url))).arrayBuffer()))
  .then(module => new Engine(module));
// If the library cannot be loaded, every request is answered with the error.
engine.then(() => postMessage({ loaded: true }), () => {});

addEventListener("message", async ({ data: [number, request] }) => {
  try {
    postMessage({ number, ok: (await engine).ask(request) });
  } catch (error) {
    postMessage({ number, error: error.message, stopped: !(error instanceof Refusal) });
  }
});
