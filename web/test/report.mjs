// Opens the page of a run and a page of several runs in Chromium, uses every control, and takes screenshots in light
// and dark at three widths.
//   node report.mjs RUN/report.html [COMPARISON.html] [FOLDER FOR SCREENSHOTS]
// Needs puppeteer-core, and Chromium at /usr/bin/chromium or $CHROMIUM.
import assert from "node:assert/strict";
import { mkdir } from "node:fs/promises";
import { resolve } from "node:path";
import puppeteer from "puppeteer-core";

const [report, ...others] = process.argv.slice(2);
assert(report, "expected the page of a run");
const comparison = others.find(name => name.endsWith(".html"));
const folder = others.find(name => !name.endsWith(".html"));
const widths = [400, 1280, 2560];
const schemes = ["light", "dark"];

const browser = await puppeteer.launch({ executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium", args: ["--no-sandbox"] });
const problems = [];
const pause = milliseconds => new Promise(done => setTimeout(done, milliseconds));

// Opens a page, and records every message in the console, every error and every request as a problem.
async function open(file, { width = 1280, height = 900, scheme = "light", motion = "no-preference", prepare = () => {} } = {}) {
  const page = await browser.newPage();
  await page.evaluateOnNewDocument(prepare);
  const url = `file://${resolve(file)}`;
  page.on("console", message => problems.push(`${file}: ${message.text()}`));
  page.on("pageerror", error => problems.push(`${file}: ${error.message}`));
  page.on("request", request => {
    if (request.url() !== url && !request.url().startsWith("data:")) problems.push(`${file} asks for ${request.url()}`);
  });
  await page.setViewport({ width, height });
  await page.emulateMediaFeatures([{ name: "prefers-color-scheme", value: scheme }, { name: "prefers-reduced-motion", value: motion }]);
  await page.goto(url);
  await page.waitForSelector("body[data-ready]");
  return page;
}

const value = (page, id) => page.$eval(`#${id}`, element => element.value);
const text = (page, id) => page.$eval(`#${id}`, element => element.textContent);
const set = (page, id, to) => page.$eval(`#${id}`, (element, to) => {
  element.value = to;
  element.dispatchEvent(new Event("input", { bubbles: true }));
  element.dispatchEvent(new Event("change", { bubbles: true }));
}, to).then(() => pause(80));

// Scrolls a canvas into view and returns its content.
async function picture(page, id) {
  await page.$eval(`#${id}`, canvas => canvas.scrollIntoView({ block: "center" }));
  await pause(150);
  return page.$eval(`#${id}`, canvas => canvas.toDataURL());
}

// Scrolls a place in a canvas into view and returns its point of the window. Long diagrams scroll in a box.
async function pointIn(page, id, [across, down]) {
  await page.$eval(`#${id}`, (canvas, down) => {
    canvas.scrollIntoView({ block: "center" });
    const box = canvas.closest(".heat");
    box?.scrollTo(0, down * canvas.clientHeight - box.clientHeight / 2);
  }, down);
  const { x, y, width, height } = await (await page.$(`#${id}`)).boundingBox();
  return [x + across * width, y + down * height];
}

async function clickIn(page, id, place) {
  await page.mouse.click(...await pointIn(page, id, place));
  await pause(80);
}

async function playing(page) {
  const before = await value(page, "time");
  // A busy machine may need some time for a frame.
  for (let k = 0; k < 8; k++) {
    await pause(100);
    if (await value(page, "time") !== before) return true;
  }
  return false;
}

// Checks that the space bar plays or pauses exactly once, wherever the focus is.
async function space(page, ids) {
  for (const id of ids) {
    await page.focus(`#${id}`);
    const before = await playing(page);
    await page.keyboard.press("Space");
    assert.equal(await playing(page), !before, `the space bar on #${id}`);
  }
}

async function useRun() {
  const page = await open(report);
  assert(await page.$eval(".verdict span", item => /good|doubtful|bad/.test(item.className)), "the verdict has colours");
  for (const summary of await page.$$("summary")) await summary.click();
  assert(await page.$eval("pre", scene => scene.offsetHeight > 100), "the scene unfolds");
  await page.evaluate(() => scrollTo(0, 0));
  assert(await playing(page), "the robot walks at once");
  await page.click("#play");
  assert(!(await playing(page)), "the button pauses");
  await space(page, ["play", "time", "speed", "colours", "evolve", "iteration", "edge", "displacement", "energy"]);
  if (await playing(page)) await page.keyboard.press("Space");

  // Time, colours and speed.
  await set(page, "time", 5);
  const strains = await picture(page, "stage");
  await set(page, "colours", "force");
  assert(await picture(page, "stage") !== strains, "bars are coloured by force");
  await set(page, "colours", "strain");
  assert(await picture(page, "stage") === strains, "and by strain again");
  await set(page, "speed", 4);
  await page.keyboard.press("Space");
  assert(await playing(page));
  await page.keyboard.press("Space");
  await set(page, "speed", 1);

  // Robot, layout, mixtures and curves show the same iteration.
  const pictures = async () => {
    const seen = [];
    for (const id of ["stage", "layout", "ternary", "displacement", "volumes"]) seen.push(await picture(page, id));
    return seen;
  };
  const delivered = await pictures();
  await set(page, "iteration", 0);
  assert.match(await text(page, "which"), /^iteration 1$/);
  (await pictures()).forEach((seen, k) => assert(seen !== delivered[k], `picture ${k} of iteration 1`));
  await page.click("#evolve");
  await pause(3500);
  assert.match(await text(page, "which"), /^iteration 10$/, "one robot after another");
  await page.click("#evolve");
  await clickIn(page, "displacement", [0.5, 0.6]);
  const middle = await text(page, "which");
  assert.match(middle, /^iteration \d+$/);
  await page.focus("#displacement");
  await page.keyboard.press("ArrowRight");
  await pause(80);
  assert.notEqual(await text(page, "which"), middle, "the arrow keys move the curve's cursor");
  await set(page, "iteration", await page.$eval("#iteration", slider => slider.max));
  assert.match(await text(page, "which"), /^delivered, iteration \d+$/);

  // All drawings show the same chosen edge, whether the list, a drawing or a row chose it.
  const chosen = () => value(page, "edge");
  const rows = await page.$$eval("#rows button", buttons => buttons.length);
  await set(page, "edge", "");
  const plain = [await picture(page, "ternary"), await picture(page, "strains"), await picture(page, "forces")];
  await page.focus("#rows button:nth-child(2)");
  await page.keyboard.press("Enter");
  await pause(80);
  const edge = await page.$eval("#rows button:nth-child(2)", button => button.textContent);
  assert.equal(await chosen(), edge, "a row chooses its edge");
  assert.match(await text(page, "told"), /actuator, nodes .* strain .* force /);
  for (const [k, id] of ["ternary", "strains", "forces"].entries()) assert(await picture(page, id) !== plain[k], `the edge in ${id}`);
  await page.keyboard.press("Tab");
  await pause(80);
  assert.notEqual(await chosen(), edge, "the focus chooses the next row");
  for (const [id, place] of [["commands", [0.5, 0.03]], ["strains", [0.9, 0.99]], ["forces", [0.2, 0.5]], ["layout", [0.5, 0.785]]]) {
    await set(page, "edge", "");
    await clickIn(page, id, place);
    assert.notEqual(await chosen(), "", `a click into ${id} chooses an edge`);
  }
  await set(page, "edge", "");
  await page.mouse.move(...await pointIn(page, "strains", [0.1, 1.5 / rows]));
  await pause(80);
  assert.equal(await chosen(), edge, "the mouse over a row points at its edge");
  await page.mouse.move(5, 5);
  await pause(80);
  assert.equal(await chosen(), "");

  // A click into a diagram over time goes to its time.
  for (const id of ["feet", "strains", "energy"]) {
    await set(page, "time", 0);
    await clickIn(page, id, [0.7, 0.5]);
    for (let k = 0; k < 20 && Number(await value(page, "time")) === 0; k++) await pause(100);
    assert(Number(await value(page, "time")) > 0, `a click into ${id} goes to its time`);
  }
  await page.close();
}

// Turns the view by keys, by the mouse and by two fingers, and turns it back.
async function useView() {
  const page = await open(report, { motion: "reduce" });
  await set(page, "time", 1);
  const home = await picture(page, "stage");
  await pause(300);
  assert(await picture(page, "stage") === home, "with reduced motion the view does not sway");
  const turned = async (says, turn) => {
    await turn();
    await pause(100);
    assert(await picture(page, "stage") !== home, `${says} the view`);
    await page.focus("#stage");
    await page.keyboard.press("Home");
    await pause(100);
    assert(await picture(page, "stage") === home, "Home turns it back");
  };
  await turned("arrow keys turn", async () => {
    await page.focus("#stage");
    await page.keyboard.press("ArrowLeft");
    await page.keyboard.press("ArrowUp");
  });
  const edge = await value(page, "edge");
  await turned("a drag turns", async () => {
    const [x, y] = await pointIn(page, "stage", [0.5, 0.7]);
    await page.mouse.move(x, y);
    await page.mouse.down();
    await page.mouse.move(x + 90, y + 30, { steps: 5 });
    await page.mouse.up();
    await page.mouse.move(5, 5);
  });
  assert.equal(await value(page, "edge"), edge, "a drag is not a click");
  await turned("two fingers turn", async () => {
    const [x, y] = await pointIn(page, "stage", [0.4, 0.5]);
    const fingers = [await page.touchscreen.touchStart(x, y), await page.touchscreen.touchStart(x + 60, y)];
    for (const [k, finger] of fingers.entries()) await finger.move(x + 60 * k + 50, y + 20);
    for (const finger of fingers) await finger.end();
  });
  await page.close();
}

// Prints the script time of a frame of a robot with this many bars, seen in three quarters. The time is not checked,
// because it depends on the machine.
async function cost(bars) {
  const page = await open(report, { motion: "reduce" });
  const took = await page.evaluate(bars => {
    /* global stage, walker, THREE_QUARTERS */
    const { edges, ...moment } = walker().at(1);
    const all = walker().edges;
    const many = Array.from({ length: bars }, (_, k) => all[k % all.length].with(3, 1 + k % 2).with(5, 1));
    stage.orbit.home = THREE_QUARTERS;
    const times = Array.from({ length: 200 }, () => {
      const begun = performance.now();
      stage.draw({ ...moment, edges: many });
      return performance.now() - begun;
    });
    return times.sort((a, b) => a - b)[times.length / 2];
  }, bars);
  console.log(`a frame of ${bars} bars takes ${took.toFixed(2)} ms of script (median of 200)`);
  await page.close();
}

// Checks that with reduced motion the robot does not start by itself.
async function useQuietly() {
  const page = await open(report, { motion: "reduce" });
  assert(!(await playing(page)), "it waits");
  assert.equal(await text(page, "play"), "Play");
  await page.keyboard.press("Space");
  assert(await playing(page));
  await page.close();
}

// Checks that the robot is on the first screen and walks at once, that it waits if it is not in view, and that a wide
// window is used.
async function useScreens() {
  const first = await open(report, { height: 800 });
  const { top, bottom } = await first.$eval("#stage", stage => stage.getBoundingClientRect().toJSON());
  assert(top > 0 && bottom < 800, `the robot is on the first screen: from ${top} to ${bottom} px of 800`);
  assert(await playing(first), "it walks at once");
  await first.close();
  const low = await open(report, { height: 160 });
  await pause(600);
  assert.equal(await value(low, "time"), "0", "a robot that is not in view waits");
  await low.setViewport({ width: 1280, height: 900 });
  await low.$eval("#stage", stage => stage.scrollIntoView({ block: "center" }));
  assert(await playing(low), "and starts when it is seen");
  await low.close();
  const wide = await open(report, { width: 2560, height: 1300 });
  const used = await wide.$eval("#stage", stage => stage.clientWidth);
  assert(used > 2200, `${used} px of 2560 are used`);
  await wide.close();
}

// Checks the page on paper. Browsers do not redraw canvases for it, so they are not redrawn here either.
async function usePrint() {
  const prepare = () => { globalThis.ResizeObserver = class { observe() {} }; };
  const page = await open(report, { scheme: "dark", prepare });
  await pause(500);
  const ink = () => page.$eval("#stage", canvas => {
    const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    const dark = data.filter((x, k) => k % 4 === 0 && data[k + 3] > 200 && x + data[k + 1] + data[k + 2] < 200);
    return dark.length;
  });
  await page.evaluate(() => dispatchEvent(new Event("beforeprint")));
  await page.emulateMediaType("print");
  await page.setViewport({ width: 720, height: 1000 });
  await pause(300);
  assert(await ink() > 500, "the skeleton is dark on paper, also for a dark screen");
  const { controls, squeezed, background } = await page.evaluate(() => ({
    controls: [...document.querySelectorAll("button, input, select")].filter(control => !control.closest("#rows") && control.getBoundingClientRect().height > 0).map(({ id }) => id),
    squeezed: [...document.querySelectorAll("canvas:not(#commands, #strains)")]
      .filter(canvas => canvas.clientHeight > 0 && Math.abs(canvas.clientWidth / canvas.clientHeight / (canvas.width / canvas.height) - 1) > 0.02)
      .map(({ id, clientWidth, clientHeight, width, height }) => `${id}: ${width} x ${height} in ${clientWidth} x ${clientHeight}`),
    background: [getComputedStyle(document.body).backgroundColor, getComputedStyle(document.querySelector(".ramp")).printColorAdjust],
  }));
  assert.deepEqual([controls, squeezed], [[], []], "no controls, and nothing is squeezed");
  assert.deepEqual(background, ["rgb(255, 255, 255)", "exact"], "white paper, and the colours of the legend");
  await page.close();
}

async function useComparison() {
  const page = await open(comparison);
  assert(await playing(page));
  await space(page, ["play", "time", "speed"]);
  const lanes = await page.$$("#lanes li");
  await set(page, "time", 1);
  const metres = await page.$$eval("#lanes .number", all => all.map(lane => lane.textContent));
  assert(metres.length === lanes.length && metres.every(lane => / m$/.test(lane)), metres.join());
  await page.close();
}

// Takes screenshots of the whole page. Nothing may be wider than the window.
async function look(file, name) {
  for (const width of widths) {
    for (const scheme of schemes) {
      const page = await open(file, { width, scheme });
      await pause(1500);
      const wide = await page.evaluate(() => document.documentElement.scrollWidth);
      assert(wide <= width, `${file} is ${wide} px wide in ${width}`);
      if (folder) await page.screenshot({ path: `${folder}/${name}-${width}-${scheme}.png`, fullPage: true });
      await page.close();
    }
  }
}

if (folder) await mkdir(folder, { recursive: true });
try {
  await useRun();
  await useView();
  await cost(176);
  await useQuietly();
  await useScreens();
  await usePrint();
  await look(report, "report");
  if (comparison) {
    await useComparison();
    await look(comparison, "comparison");
  }
  assert.deepEqual(problems, []);
  console.log("every control works; no message, no error, no request");
} finally {
  await browser.close();
}
