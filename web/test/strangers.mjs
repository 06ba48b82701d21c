// What a stranger sees: the first seconds, browsers that cannot run the page, and pictures.
import { mkdirSync } from "node:fs";
import { join } from "node:path";
import { pathToFileURL } from "node:url";
import { open as openPage, ready, text } from "./browsers.mjs";
import { here, SMALL, HELLO, open, unfold, check, checkShifts, wait, value, until, watchShifts, close } from "./helpers.mjs";

/** The most milliseconds that the scripts of a frame should take. */
const FRAME = 4;

/** A stranger opens the page: finished robots walk at once, a design begins by itself, and takes the stage when it walks. */
export async function stranger(browser, address) {
  for (const slower of [1, 4]) {
    const page = await browser.newPage();
    if (slower > 1) await page.emulateCPUThrottling(slower);
    await page.evaluateOnNewDocument(watchShifts);
    await page.evaluateOnNewDocument(() => {
      const first = {};
      globalThis.first = first;
      const look = () => {
        if (first.step === undefined && globalThis.parade?.cost?.frames > 5) first.step = performance.now();
        if (first.stage === undefined && globalThis.parade?.robots?.length > 0 && !globalThis.parade.isOpen) first.stage = [performance.now(), document.getElementById("along").textContent, document.getElementById("status").textContent];
        if (first.attempt === undefined && document.getElementById("strip")?.getAttribute("aria-valuenow") > 0) first.attempt = performance.now();
        if (first.walk === undefined && /: 0\.[1-9]|: [1-9]/.test(document.getElementById("strip")?.getAttribute("aria-valuetext") ?? "")) first.walk = performance.now();
        requestAnimationFrame(look);
      };
      look();
    });
    await page.goto(address);
    await page.waitForFunction(() => globalThis.first.step !== undefined && globalThis.first.walk !== undefined, { timeout: 120_000 });
    const seconds = time => (time / 1000).toFixed(1);
    const first = await page.evaluate(() => globalThis.first);
    console.log(`     a processor ${slower} times slower: the parade walks after ${seconds(first.step)} s, the first attempt is over after ${seconds(first.attempt)} s, the design walks 0.1 m after ${seconds(first.walk)} s`);
    check(first.step < first.attempt, "the parade walks before the library has designed anything");
    const { frames, total } = await page.evaluate(() => globalThis.parade.cost);
    // The time is not checked, because it depends on the machine.
    console.log(`     a frame of the parade takes ${(total / frames).toFixed(2)} ms of script, and should take at most ${FRAME}`);
    await page.waitForFunction(() => document.getElementById("design").textContent === "Design another", { timeout: 240_000 });
    const { stage } = await page.evaluate(() => globalThis.first);
    console.log(`     after ${seconds(stage[0])} s: ${stage[1]}; ${stage[2]}`);
    check(/^The page’s own design walks ([1-9]\.\d+) m now/.test(stage[2]), "it takes the stage when it walks a metre, with a sentence");
    check(/Finished after 120 versions/.test(await text(page, "status")), `and the design begins by itself: ${await text(page, "status")}`);
    await checkShifts(page);
    await page.close();
  }
  const { page: first, faults: wrong } = await openPage(browser, address);
  await first.waitForSelector("#parade button:nth-child(6)");
  await first.select("#chip-gravity", "Moon");
  await until(first, "the finished robot that greets walks on with the gravity of the Moon", () => document.getElementById("status").textContent.startsWith("The same robot, now with the gravity of the Moon"));
  await close(first, wrong);
  const { page, faults } = await openPage(browser, address, { features: [{ name: "prefers-reduced-motion", value: "reduce" }] });
  await ready(page);
  await wait(1500);
  check(await text(page, "design") === "Design a robot" && !(await page.$eval("#parade", parade => parade.hidden)), "with reduced motion no design begins by itself");
  check(await page.evaluate(() => globalThis.parade.cost.frames) === 0, "and the robots of the parade stand");
  await close(page, faults);
}

/** The page says why it cannot work without scripts, without WebAssembly and from a file. It works without a network. */
export async function without(browser, address) {
  const page = await browser.newPage();
  await page.setJavaScriptEnabled(false);
  await page.goto(address);
  check((await page.evaluate(() => document.querySelector("noscript").innerText)).includes("needs JavaScript"), "without scripts the page says what it needs");
  await page.setJavaScriptEnabled(true);
  await page.goto(pathToFileURL(here("../dist/index.html")).href);
  check((await text(page, "honest")).includes("http.server") && await page.$eval("#honest", place => place.clientHeight > 0), "from a file it says how to open it");
  await page.close();
  const old = await browser.newPage();
  await old.evaluateOnNewDocument(() => { delete globalThis.WebAssembly; });
  await old.goto(address);
  await until(old, "without WebAssembly the parade walks", () => globalThis.parade?.cost?.frames > 5);
  await old.click("#parade button:nth-child(2)");
  await until(old, "and a touch shows one of its robots", () => document.getElementById("parade").hidden && globalThis.onStage().playing && globalThis.onStage().time > 0.5);
  check((await text(old, "honest")).includes("WebAssembly") && !(await old.$("#stopped[open]")), "and the page says why no robot can be designed");
  await old.close();
  const { page: kept } = await open(browser, address + SMALL);
  await kept.evaluate(() => navigator.serviceWorker.ready);
  await wait(500);
  await kept.setOfflineMode(true);
  await kept.reload();
  await ready(kept);
  check(true, "without a network it opens again");
  await kept.close();
}

/** Takes pictures: of the page as it opens, of a robot in another world, and of the details. */
export async function shots(browser, address, folder, schemes) {
  mkdirSync(folder, { recursive: true });
  for (const scheme of schemes) {
    for (const [width, height] of [[400, 800], [1280, 800], [2560, 1300]]) {
      const features = [{ name: "prefers-color-scheme", value: scheme }];
      const { page, faults } = await openPage(browser, address + HELLO.link, { width, height, features });
      const take = async name => {
        await wait(700);
        await page.screenshot({ path: join(folder, `${name}-${width}-${scheme}.png`) });
      };
      await until(page, `pictures at ${width} px, ${scheme}`, () => document.querySelector("#verdict span"));
      await wait(1500);
      await take("robot");
      await page.select("#chip-ground", "steps");
      await until(page, "on steps", () => document.getElementById("status").textContent.startsWith("The same robot"));
      await take("visit");
      await unfold(page);
      for (const [name, part] of [["details", "#play"], ["edit", "#editor"]]) {
        await page.$eval(part, element => element.scrollIntoView({ block: "start" }));
        await take(name);
      }
      check(await page.evaluate(() => document.documentElement.scrollWidth) <= width, "nothing is wider than the window");
      await close(page, faults);
    }
  }
}
