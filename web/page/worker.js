// Runs the library off the page's thread. A message is [number, request]; the answer bears its number.

import { Engine, Refusal } from "./engine.js";

const engine = WebAssembly.compileStreaming(fetch(new URL("cosmic.wasm", import.meta.url)))
  // A file server that does not know WebAssembly's type.
  .catch(async () => WebAssembly.compile(await (await fetch(new URL("cosmic.wasm", import.meta.url))).arrayBuffer()))
  .then(module => new Engine(module));
// If the library cannot be loaded, every request is answered with the error.
engine.then(() => postMessage({ loaded: true }), () => {});

addEventListener("message", async ({ data: [number, request] }) => {
  try {
    const { ok, numbers } = (await engine).ask(request);
    postMessage({ number, ok, numbers }, [numbers.buffer]);
  } catch (error) {
    postMessage({ number, error: error.message, stopped: !(error instanceof Refusal) });
  }
});
