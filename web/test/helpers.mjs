// What the tests of the page share: checks, links to scenes, and the use of controls.
import { readFileSync, readdirSync, statSync } from "node:fs";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { Engine } from "../page/engine.js";
import { open as openPage, text } from "./browsers.mjs";

export const here = path => fileURLToPath(new URL(path, import.meta.url));
export const linkTo = (scene, settings) => `#scene=${scene}&seed=1&${settings.map(setting => `set=${encodeURIComponent(setting)}`).join("&")}`;
/** The link to a scene whose design takes only a few seconds. */
export const SMALL = linkTo("stability", [
  "lattice.columns=3", "lattice.rows=3", "physics.steps=512", "schedule.iterations=120", "schedule.attraction_from=40",
  "schedule.snap_at=80", "schedule.horizon=[128, 256]", "loss.window=64",
]);
/** The settings of a small robot that goes where it is told. */
export const TOLD = ["lattice.columns=3", "lattice.rows=3", "controller.hidden=4", "physics.steps=2048", "schedule.iterations=12", "schedule.horizon=[128, 256]", "loss.window=64"];
/** The finished robots of the parade, each with its link, and the first of them. */
export const CAST = JSON.parse(readFileSync(here("../page/cast.json")));
export const HELLO = CAST[0];

/** Opens the page without its greeting and without a design of its own, and unfolds the details. */
export async function open(browser, address, how) {
  const url = new URL(address);
  if (!url.search.includes("greets")) url.search += `${url.search ? "&" : "?"}wait`;
  const opened = await openPage(browser, url.href, how);
  await unfold(opened.page);
  return opened;
}

/** The library of the page, in this process. */
export function library() {
  const built = readdirSync(here("../dist"), { recursive: true }).find(name => name.endsWith("cosmic.wasm"));
  return new Engine(new WebAssembly.Module(readFileSync(here(`../dist/${built}`))));
}

export const unfold = page => page.evaluate(() => { document.getElementById("details").open = true; });

/** Goes back in the history, and waits for the address before. */
export async function goBack(page) {
  const before = page.url();
  await page.evaluate(() => setTimeout(() => history.back()));
  await page.waitForFunction(before => location.href !== before, { timeout: 20_000 }, before);
}

/** Scrolls an element into view. Returns its box in the window. */
export async function boxOf(page, selector) {
  await page.$eval(selector, element => element.scrollIntoView({ block: "center" }));
  return (await page.$(selector)).boundingBox();
}

let failures = 0;
export function check(is, says) {
  console.log(`${is ? "ok  " : "FAIL"} ${says}`);
  if (!is) failures += 1;
}

/** Runs on a page: collects the shifts of its layout, in browsers that report them. */
export function watchShifts() {
  const shift = ({ value, sources }) => `${value.toFixed(5)} by ${sources.map(({ node }) => node?.id || node?.className || node?.nodeName).join(", ")}`;
  if (!PerformanceObserver.supportedEntryTypes.includes("layout-shift")) return;
  globalThis.shifted = [];
  new PerformanceObserver(list => globalThis.shifted.push(...list.getEntries().map(shift))).observe({ type: "layout-shift", buffered: true });
}

/** Checks that the layout has not shifted since `watchShifts`. */
export async function checkShifts(page) {
  const shifted = await page.evaluate(() => globalThis.shifted);
  if (!shifted) return console.log("SKIPPED: this browser does not report shifts of the layout");
  check(shifted.length === 0, `nothing shifts${shifted.map(shift => `\n       ${shift}`).join("")}`);
}

/** The number of checks that have failed. */
export const failed = () => failures;

export const wait = milliseconds => new Promise(resolve => setTimeout(resolve, milliseconds));
export const press = (page, id) => page.$eval(`#${id}`, element => element.click());
export const value = (page, id) => page.$eval(`#${id}`, element => element.value);

/** Checks that the function `is` returns true on the page within a minute. */
export async function until(page, says, is, ...given) {
  check(await page.waitForFunction(is, { timeout: 60_000 }, ...given).then(() => true, () => false), says);
}

export const linkHas = part => decodeURIComponent(location.href.replaceAll("+", " ")).includes(part);

export async function set(page, selector, to) {
  await page.$eval(selector, (element, to) => {
    element.value = to;
    element.dispatchEvent(new Event("input", { bubbles: true }));
    element.dispatchEvent(new Event("change", { bubbles: true }));
  }, to);
}

/** Waits until the page has saved a file whose name matches. */
export async function saved(folder, matches, timeout = 60_000) {
  for (const end = Date.now() + timeout; Date.now() < end; await wait(100)) {
    const name = readdirSync(folder).find(name => matches.test(name));
    if (name && statSync(join(folder, name)).size > 0) return join(folder, name);
  }
  throw new Error(`nothing was saved that matches ${matches}`);
}

export async function close(page, faults) {
  check(faults.length === 0, `no errors, no foreign requests${faults.map(fault => `\n       ${fault}`).join("")}`);
  await page.close();
}
