// Runs the library in its own thread. A message is [number, request], and its answer has the same number.

import { Engine, Refusal } from "./engine.js";

const file = new URL("cosmic.wasm", import.meta.url);
/** The size of the library. build.sh fills it in. */
const BYTES = 0;

/** Tells how much of the library is loaded, at most a hundred times. Resolves when all of it is there. */
async function count({ body }) {
  let [bytes, told] = [0, 0];
  for (const reader = body.getReader();;) {
    const { done, value } = await reader.read();
    if (done && BYTES > 0 && bytes !== BYTES) throw new Error(`${bytes} bytes of ${BYTES} arrived`);
    if (done) return;
    bytes += value.length;
    const share = Math.floor(100 * bytes / BYTES) / 100;
    if (share > told && share < 1) postMessage({ loaded: told = share });
  }
}

async function load() {
  // After a failure, the file in the browser's cache may be the wrong one.
  const answer = await fetch(file, { cache: location.search === "?again" ? "reload" : "default" });
  if (!answer.ok) throw new Error(`the server answers with ${answer.status}`);
  const counted = count(answer.clone());
  const compiled = WebAssembly.compileStreaming(answer)
    // Some file servers send WebAssembly with a wrong type, which streaming does not accept.
    .catch(async () => WebAssembly.compile(await (await fetch(file)).arrayBuffer()));
  await Promise.all([counted, compiled]);
  return new Engine(await compiled);
}

const engine = load();
engine.then(() => postMessage({ loaded: 1 }), error => postMessage({ missing: error.message }));

addEventListener("message", async ({ data: [number, request] }) => {
  // Without the library the page ends this worker.
  if (await engine.then(() => false, () => true)) return;
  try {
    postMessage({ number, ok: (await engine).ask(request) });
  } catch (error) {
    postMessage({ number, error: error.message, stopped: !(error instanceof Refusal) });
  }
});
