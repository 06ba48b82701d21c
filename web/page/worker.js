// Runs the library in its own thread. A message is [number, request], and its answer has the same number.

import { Engine, Refusal } from "./engine.js";

const file = new URL("cosmic.wasm", import.meta.url);
/** The size of the library. build.sh fills it in. */
const BYTES = 0;

/** Tells how much of the library is loaded, at most a hundred times. */
async function count({ body }) {
  let [bytes, told] = [0, 0];
  const reader = body.getReader();
  for (;;) {
    const { done, value } = await reader.read();
    if (done) return;
    bytes += value.length;
    const share = Math.floor(100 * bytes / BYTES) / 100;
    if (share > told && share < 1) postMessage({ loaded: told = share });
  }
}

const response = fetch(file).then(answer => {
  count(answer.clone()).catch(() => {});
  return answer;
});
const engine = WebAssembly.compileStreaming(response)
  // Some file servers send WebAssembly with a wrong type, which streaming does not accept.
  .catch(async () => WebAssembly.compile(await (await fetch(file)).arrayBuffer()))
  .then(module => new Engine(module));
// If loading fails, nothing is reported here: every request is answered with the error.
engine.then(() => postMessage({ loaded: 1 }), () => {});

addEventListener("message", async ({ data: [number, request] }) => {
  try {
    postMessage({ number, ok: (await engine).ask(request) });
  } catch (error) {
    postMessage({ number, error: error.message, stopped: !(error instanceof Refusal) });
  }
});
