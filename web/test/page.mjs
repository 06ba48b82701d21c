// Tests every control of the page in real browsers, the files that it saves, and the saved robot in the native program.
//   node test/page.mjs [--shots FOLDER] [--program COSMIC] [--browser chrome or firefox]
// If a browser or the program is missing, its tests are skipped, and the output says so. Exits with 1 if a check fails.
import { mkdtempSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { parseArgs } from "node:util";
import { installed, launch, ready } from "./browsers.mjs";
import { building, choosing, editingInSpace, evolving, listing, twins } from "./building.mjs";
import { cancelled, designing, editing, files, framed, motionless, playing, scenes, stopping, unreliable } from "./controls.mjs";
import { SMALL, checkShifts, close, failed, here, open } from "./helpers.mjs";
import { asks, births, headlines, links, naming, refusedLinks } from "./links.mjs";
import { beating, comparing, focusing, gaining, loading, measuring, missing, picking, recalling, switches, takingBack, tinting } from "./moments.mjs";
import { racing, standing } from "./races.mjs";
import { serve } from "./serve.mjs";
import { shots, stranger, without } from "./strangers.mjs";
import { aside, errand, goingOn, judging, moon, space, visiting, worlds } from "./worlds.mjs";

const { values: given } = parseArgs({ options: { shots: { type: "string" }, browser: { type: "string" }, program: { type: "string", default: here("../../target/release/cosmic") } } });

/** What works alike in both browsers. */
async function everywhere(browser, address, folder) {
  const { page, faults } = await open(browser, address + SMALL);
  await ready(page);
  await designing(page);
  await playing(page);
  await editing(page);
  await files(page, folder, given.program);
  await checkShifts(page);
  await scenes(page, address);
  await close(page, faults);
  await stopping(browser, address);
  await unreliable(browser, address);
  await refusedLinks(browser, address);
  await cancelled(browser, address);
  await errand(browser, address);
  await aside(browser, address);
  await worlds(browser, address);
  await moon(browser, address);
  await headlines(browser, address);
  await links(browser, address);
  await switches(browser, address);
  await recalling(browser, address);
  await takingBack(browser, address);
  await beating(browser, address);
  await tinting(browser, address);
  await racing(browser, address);
  await asks(browser, address);
  await births(browser, address);
  await choosing(browser, address);
  await building(browser, address, folder);
  await twins(browser, address);
}

async function inChromium(address) {
  const folder = mkdtempSync(join(tmpdir(), "cosmic-page-"));
  const browser = await launch("chrome", { downloadBehavior: { policy: "allow", downloadPath: folder } });
  try {
    await everywhere(browser, address, folder);
    await motionless(browser, address);
    await framed(browser, address);
    await space(browser, address);
    await standing(browser, address);
    await stranger(browser, address);
    await picking(browser, address);
    await focusing(browser, address);
    await loading(browser, address);
    await measuring(browser, address);
    await missing(browser);
    await without(browser, address);
    if (given.shots) await shots(browser, address, given.shots, ["light", "dark"]);
  } finally {
    await browser.close();
  }
}

/** In Firefox, preferences take the place of what the protocol of Chromium sets. */
async function inFirefox(address) {
  const folder = mkdtempSync(join(tmpdir(), "cosmic-page-"));
  const saves = { "browser.download.folderList": 2, "browser.download.dir": folder, "browser.download.alwaysOpenPanel": false };
  const firefox = async (prefs, use) => {
    const browser = await launch("firefox", { extraPrefsFirefox: prefs });
    try {
      await use(browser);
    } finally {
      await browser.close();
    }
  };
  await firefox(saves, browser => everywhere(browser, address, folder));
  await firefox({ "ui.prefersReducedMotion": 1 }, async browser => {
    await motionless(browser, address);
    await framed(browser, address);
  });
  for (const [scheme, number] of given.shots ? [["light", 1], ["dark", 0]] : []) {
    await firefox({ "layout.css.prefers-color-scheme.content-override": number }, browser => shots(browser, address, join(given.shots, "firefox"), [scheme]));
  }
}

goingOn();
visiting();
judging();
gaining();
comparing();
naming();
listing();
editingInSpace();
evolving();
const server = await serve(here("../dist"));
for (const [browser, test] of [["chrome", inChromium], ["firefox", inFirefox]]) {
  if (given.browser && given.browser !== browser) continue;
  if (installed(browser)) await test(server.address);
  else console.log(`SKIPPED: no ${browser === "chrome" ? "Chromium" : "Firefox"}`);
}
server.close();
console.log(failed() === 0 ? "the page: all checks passed" : `the page: ${failed()} checks failed`);
process.exitCode = failed() === 0 ? 0 : 1;
