// A minimal file server for tests: a folder, and the types that browsers require.
//   node serve.mjs [FOLDER [PORT]]
import { readFile } from "node:fs/promises";
import { createServer } from "node:http";
import { extname, join, normalize } from "node:path";
import { fileURLToPath } from "node:url";

const TYPES = { ".html": "text/html", ".css": "text/css", ".js": "text/javascript", ".wasm": "application/wasm", ".svg": "image/svg+xml", ".json": "application/json", ".png": "image/png" };

/** The bytes of a piece. */
const PIECE = 2 ** 17;

/**
 * Serves a folder, the library in pieces with a `pause` (milliseconds) between them. Returns the address and a function that
 * stops the server.
 * @param spoil may answer requests for the library in its own way: it returns whether it does.
 */
export async function serve(folder, port = 0, pause = 0, spoil = () => false) {
  const server = createServer(async (request, response) => {
    const path = normalize(decodeURIComponent(new URL(request.url, "http://here").pathname));
    const file = join(folder, path.endsWith("/") ? `${path}index.html` : path);
    try {
      const bytes = await readFile(file);
      if (file.endsWith(".wasm") && spoil(response, bytes)) return;
      response.writeHead(200, { "content-type": TYPES[extname(file)] ?? "application/octet-stream" });
      for (let at = 0; pause > 0 && file.endsWith(".wasm") && at < bytes.length; at += PIECE) {
        response.write(bytes.subarray(at, at + PIECE));
        await new Promise(resolve => setTimeout(resolve, pause));
      }
      response.end(pause > 0 && file.endsWith(".wasm") ? undefined : bytes);
    } catch {
      response.writeHead(404).end();
    }
  });
  await new Promise(resolve => server.listen(port, "127.0.0.1", resolve));
  return { address: `http://127.0.0.1:${server.address().port}/`, close: () => server.close() };
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  const { address } = await serve(process.argv[2] ?? fileURLToPath(new URL("../dist", import.meta.url)), Number(process.argv[3] ?? 8000));
  console.log(address);
}
