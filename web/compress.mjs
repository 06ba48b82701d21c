// Writes a file compressed by brotli beside every file of a folder.
//   node compress.mjs FOLDER
import { readFileSync, readdirSync, statSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { brotliCompressSync, constants } from "node:zlib";

const [folder] = process.argv.slice(2);
const files = readdirSync(folder, { recursive: true }).map(name => join(folder, name));
let bytes = 0;
for (const file of files.filter(file => statSync(file).isFile() && !/\.(gz|br|png)$/.test(file))) {
  const packed = brotliCompressSync(readFileSync(file), { params: { [constants.BROTLI_PARAM_QUALITY]: 10 } });
  writeFileSync(`${file}.br`, packed);
  bytes += packed.length;
}
console.log(`${folder}: ${Math.round(bytes / 1000)} kB compressed by brotli`);
