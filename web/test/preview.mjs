// Writes the picture that a link to the page shows in other programs: web/page/preview.png.
//   node test/preview.mjs
import { fileURLToPath } from "node:url";
import { launch, open } from "./browsers.mjs";
import { serve } from "./serve.mjs";

const here = path => fileURLToPath(new URL(path, import.meta.url));
const server = await serve(here("../dist"));
const browser = await launch("chrome");
const { page } = await open(browser, server.address, { width: 1200, height: 630, features: [{ name: "prefers-color-scheme", value: "light" }] });
// The picture shows the stage alone, while the parade walks.
await page.addStyleTag({ content: "header p, #naming, footer, #strip, #worlds, .actions, #status, #saved, details, .key { display: none !important } #stage { height: 520px !important } h1 { font-size: 2.4rem !important }" });
await page.waitForFunction(() => globalThis.parade?.cost?.frames > 90);
await page.screenshot({ path: here("../page/preview.png") });
await browser.close();
server.close();
