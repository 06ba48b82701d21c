// Tests every control of the page in real browsers, the files that it saves, and the saved robot in the native program.
//   node test/page.mjs [--shots FOLDER] [--program COSMIC]
// If a browser or the program is missing, its tests are skipped, and the output says so. Exits with 1 if a check fails.
import { execFileSync } from "node:child_process";
import { existsSync, mkdirSync, mkdtempSync, readFileSync, readdirSync, statSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { parseArgs } from "node:util";
import { fileURLToPath, pathToFileURL } from "node:url";
import { Engine } from "../page/engine.js";
import { installed, launch, open as openPage, ready, says, text } from "./browsers.mjs";
import { serve } from "./serve.mjs";

const here = path => fileURLToPath(new URL(path, import.meta.url));
const { values: given } = parseArgs({ options: { shots: { type: "string" }, program: { type: "string", default: here("../../target/release/cosmic") } } });
const linkTo = (scene, settings) => `#scene=${scene}&seed=1&${settings.map(setting => `set=${encodeURIComponent(setting)}`).join("&")}`;
/** The link to a scene whose design takes only a few seconds. */
const SMALL = linkTo("stability", [
  "lattice.columns=3", "lattice.rows=3", "physics.steps=512", "schedule.iterations=120", "schedule.attraction_from=40",
  "schedule.snap_at=80", "schedule.horizon=[128, 256]", "loss.window=64",
]);
/** The settings of a small robot that goes where it is told. */
const TOLD = ["lattice.columns=3", "lattice.rows=3", "controller.hidden=4", "physics.steps=2048", "schedule.iterations=12", "schedule.horizon=[128, 256]", "loss.window=64"];
/** The most milliseconds that the script of a frame should take on average. */
const FRAME = 4;

/** Opens the page without its greeting and without a design of its own, and unfolds the details. */
async function open(browser, address, how) {
  const url = new URL(address);
  if (!url.search.includes("greets")) url.search += `${url.search ? "&" : "?"}wait`;
  const opened = await openPage(browser, url.href, how);
  await unfold(opened.page);
  return opened;
}

const unfold = page => page.evaluate(() => { document.getElementById("details").open = true; });

/** Scrolls an element into view. Returns its box in the window. */
async function boxOf(page, selector) {
  await page.$eval(selector, element => element.scrollIntoView({ block: "center" }));
  return (await page.$(selector)).boundingBox();
}

let failures = 0;
function check(is, says) {
  console.log(`${is ? "ok  " : "FAIL"} ${says}`);
  if (!is) failures += 1;
}

const wait = milliseconds => new Promise(resolve => setTimeout(resolve, milliseconds));
const press = (page, id) => page.$eval(`#${id}`, element => element.click());
const value = (page, id) => page.$eval(`#${id}`, element => element.value);

/** Checks that the function `is` returns true on the page within 20 seconds. */
async function until(page, says, is, ...given) {
  check(await page.waitForFunction(is, { timeout: 20_000 }, ...given).then(() => true, () => false), says);
}

const linkHas = part => decodeURIComponent(location.href.replaceAll("+", " ")).includes(part);

async function set(page, selector, to) {
  await page.$eval(selector, (element, to) => {
    element.value = to;
    element.dispatchEvent(new Event("input", { bubbles: true }));
    element.dispatchEvent(new Event("change", { bubbles: true }));
  }, to);
}

/** Waits until the page has saved a file whose name matches. */
async function saved(folder, matches, timeout = 60_000) {
  for (const end = Date.now() + timeout; Date.now() < end; await wait(100)) {
    const name = readdirSync(folder).find(name => matches.test(name));
    if (name && statSync(join(folder, name)).size > 0) return join(folder, name);
  }
  throw new Error(`nothing was saved that matches ${matches}`);
}

async function designing(page) {
  check(await page.$eval("#stage", canvas => canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data.some(x => x > 0)), "the robot is shown before the design");
  await page.evaluate(() => {
    globalThis.shifted = [];
    const shift = ({ value, sources }) => `${value.toFixed(5)} by ${sources.map(({ node }) => node?.id || node?.nodeName).join(", ")}`;
    new PerformanceObserver(list => globalThis.shifted.push(...list.getEntries().map(shift))).observe({ type: "layout-shift", buffered: true });
  });
  await page.click("#design");
  await page.waitForFunction(() => Number.parseInt(document.getElementById("iteration").textContent, 10) > 3);
  await page.click("#design");
  await says(page, "Resume");
  const paused = await text(page, "iteration");
  await wait(400);
  check(paused === await text(page, "iteration"), `pause holds at ${paused}`);
  await press(page, "back");
  await press(page, "back");
  const number = async () => Number.parseInt(await text(page, "iteration"), 10);
  check(await number() === Number.parseInt(paused, 10) - 2, "two steps back");
  await press(page, "ahead");
  check(await number() === Number.parseInt(paused, 10) - 1, "a step ahead");
  await press(page, "latest");
  check(await text(page, "iteration") === paused, "the latest");
  await boxOf(page, "#curve");
  await wait(300);
  await page.focus("#curve");
  await page.keyboard.press("Home");
  check(await number() === 0, "the curve goes to the beginning by a key");
  const curve = await boxOf(page, "#curve");
  await page.mouse.click(curve.x + 50, curve.y + curve.height / 2);
  check(await number() <= 1, "and by a click");
  await page.click("#design");
  await says(page, "Design another");
  check(/^120 \/ 120$/.test(await text(page, "iteration")), `designed: ${await text(page, "status")}`);
}

async function playing(page) {
  await press(page, "play");
  check(await text(page, "play") === "Play walk", "the walk pauses");
  const clock = await text(page, "clock");
  await wait(300);
  check(clock === await text(page, "clock"), "and its clock stops");
  await page.evaluate(() => document.activeElement.blur());
  await page.keyboard.press("Space");
  check(await text(page, "play") === "Pause walk", "the space bar plays");
  await set(page, "#speed", "4");
  await set(page, "#time", "0.5");
  check(Number.parseFloat(await text(page, "clock")) >= 0.5, "time is set");
  await wait(1500);
  const cost = await page.evaluate(() => globalThis.playerCost);
  const mean = cost.total / cost.frames;
  // The time is not checked, because it depends on the machine.
  console.log(`     a frame takes ${mean.toFixed(2)} ms of script, and should take at most ${FRAME} (mean of ${cost.frames}, longest ${cost.longest.toFixed(1)})`);
}

async function editing(page) {
  await press(page, "play");
  await set(page, "#time", "0");
  await press(page, "next");
  const first = await text(page, "bar");
  await page.click("[name=material][value='1']");
  await page.waitForFunction(() => document.getElementById("bar").textContent.endsWith("skeleton"));
  const status = await text(page, "status");
  check(/^Bar \d+ of 20/.test(first) && /^Changed by you|^Finished/.test(status), `${first}; then skeleton: ${status}`);
  await page.focus("#stage");
  await page.keyboard.press("ArrowRight");
  const before = await text(page, "bar");
  await page.keyboard.press("Enter");
  await page.waitForFunction(before => document.getElementById("bar").textContent !== before, {}, before);
  check(true, `by keys: ${before}; then ${await text(page, "bar")}; ${await text(page, "status")}`);
  // Look for a bar in the middle of the stage.
  const box = await boxOf(page, "#stage");
  const said = await text(page, "bar");
  for (let up = 0.72; up > 0.3 && said === await text(page, "bar"); up -= 0.03) {
    await page.mouse.click(box.x + box.width / 2, box.y + box.height * up);
    await wait(120);
  }
  check(said !== await text(page, "bar"), `by a click: ${await text(page, "bar")}; ${await text(page, "status")}`);
  await press(page, "previous");
  await press(page, "play");
}

async function files(page, folder, program) {
  await press(page, "save-scene");
  await press(page, "save-design");
  const [scene, design] = [await saved(folder, /^scene\.toml$/), await saved(folder, /^design\.json$/)];
  check(JSON.parse(readFileSync(design)).format === "cosmic-design" && readFileSync(scene, "utf8").includes("columns = 3"), "scene.toml and design.json are saved");
  if (existsSync(program)) {
    const { results } = JSON.parse(execFileSync(program, ["evaluate", design], { encoding: "utf8" }));
    const along = Number((await text(page, "along")).replace("\u2212", "-").replace(" m", ""));
    check(Math.abs(results.displacement - along) < 0.006, `the native program moves the edited robot ${results.displacement.toFixed(4)} m, the page ${along} m`);
    execFileSync(program, ["report", design], { encoding: "utf8" });
    check(true, "and writes its report");
  } else {
    console.log(`SKIPPED: no program ${program}: the saved robot is not evaluated natively`);
  }
  await press(page, "undo");
  await page.waitForFunction(() => document.getElementById("status").textContent.startsWith("Finished"));
  check(true, "back to the robot as designed");
  await set(page, "#speed", "1");
  await press(page, "save-film");
  const film = await saved(folder, /^cosmic-stability-1\.(webm|mp4)$/);
  await page.waitForFunction(() => document.getElementById("saved").textContent.includes("is saved"));
  const bytes = readFileSync(film);
  check(bytes.length > 20_000 && (bytes.readUInt32BE(0) === 0x1a45dfa3 || film.endsWith("mp4")), `the animation has ${bytes.length} bytes`);
}

async function scenes(page, address) {
  const along = await text(page, "along");
  await press(page, "link");
  await page.waitForFunction(() => document.getElementById("saved").textContent.includes("link"));
  check(new URL(page.url()).hash.includes("seed=1"), await text(page, "saved"));
  await press(page, "other");
  await says(page, "Pause");
  await says(page, "Design another");
  check(await value(page, "seed") === "2", `another seed: ${along}, then ${await text(page, "along")}`);
  await set(page, "#seed", "3");
  await says(page, "Design another");
  await page.select("#scene", "incline");
  await page.waitForFunction(() => document.querySelector("[name='physics.incline_deg']").value === "15");
  check(new URL(page.url()).hash === "#scene=incline&seed=3", "a built-in scene");
  for (const [key, to] of [["lattice.columns", 4], ["lattice.rows", 3], ["physics.payload_mass", 0.05], ["physics.gravity", 9.81], ["physics.incline_deg", -5], ["physics.contact", "coulomb"], ["physics.friction", 0.8]]) {
    await set(page, `[name="${key}"]`, String(to));
    await until(page, `${key} = ${to}`, linkHas, `set=${key}=${to}`);
  }
  await press(page, "stairs");
  await until(page, "the ground: steps", linkHas, "[0.8, 0], [0.9, 0.02]");
  const stairs = page.url();
  await press(page, "rough");
  await until(page, "the ground: rough", stairs => location.href !== stairs && location.href.includes("ground.points"), stairs);
  await press(page, "level");
  await until(page, "the ground: level", () => !location.href.includes("ground.points"));
  await page.focus("#ground");
  for (const key of ["ArrowRight", "ArrowUp", "PageUp"]) await page.keyboard.press(key);
  await until(page, "the ground by keys", linkHas, "[0.9, 0.025]");
  const box = await boxOf(page, "#ground");
  await page.mouse.move(box.x + box.width * 0.5, box.y + box.height * 0.4);
  await page.mouse.down();
  await page.mouse.move(box.x + box.width * 0.6, box.y + box.height * 0.3, { steps: 5 });
  await page.mouse.up();
  await until(page, "the ground by a pointer", () => decodeURIComponent(location.href).split("[").length > 6);
  const link = page.url();
  await page.goto("about:blank");
  await page.goto(link);
  await unfold(page);
  await until(page, "the link brings all of it back", () => document.querySelector("[name='lattice.columns']")?.value === "4");
  check(await value(page, "scene") === "incline" && page.url() === link, "and stays as it is");
  await press(page, "reset");
  await page.waitForFunction(() => location.hash === "#scene=incline&seed=3");
  check(true, "the scene's own settings");
  await set(page, "[name='lattice.columns']", "1");
  await page.waitForFunction(() => document.getElementById("refusal").textContent.includes("out of range"));
  check(await page.$eval("#design", button => button.disabled), "an error of the library is shown");
  await page.goto("about:blank");
  await page.goto(`${address}?wait${SMALL}`);
  await ready(page);
}

async function stopping(browser, address) {
  const { page, faults } = await open(browser, `${address}?panic=2${SMALL}`);
  await ready(page);
  await page.focus("#design");
  await page.keyboard.press("Enter");
  await page.waitForSelector("#stopped[open]");
  const message = await text(page, "message");
  check(message.includes("a panic for tests"), `a panic is shown: ${message.replaceAll("\n", " ")}`);
  await page.keyboard.press("Enter");
  await page.waitForSelector("#stopped:not([open])");
  await ready(page);
  await page.focus("#design");
  await page.keyboard.press("Enter");
  await says(page, "Design another");
  check(true, "restart works, by keys alone");
  return close(page, faults);
}

async function close(page, faults) {
  check(faults.length === 0, `no errors, no foreign requests${faults.map(fault => `\n       ${fault}`).join("")}`);
  await page.close();
}

async function motionless(browser, address) {
  const { page, faults } = await open(browser, address + SMALL, { width: 400, height: 800, touch: true, features: [{ name: "prefers-reduced-motion", value: "reduce" }] });
  await ready(page);
  await (await page.$("#design")).tap();
  await says(page, "Design another");
  check(await text(page, "play") === "Play walk" && await text(page, "clock") === "1.0 s", "with reduced motion the robot is shown at the end of its walk; the button reacts to a touch");
  const wide = await page.evaluate(() => document.documentElement.scrollWidth);
  check(wide <= 400, `at 400 px nothing is wider: ${wide} px`);
  const box = await boxOf(page, "#stage");
  const said = await text(page, "bar");
  for (let up = 0.74; up > 0.3 && said === await text(page, "bar"); up -= 0.03) {
    await page.touchscreen.tap(box.x + box.width / 2, box.y + box.height * up);
    await wait(120);
  }
  check(said !== await text(page, "bar"), `a touch edits: ${await text(page, "bar")}`);
  return close(page, faults);
}

/** The free space left and right of the robot's bars, as fractions of the stage's width. */
const margins = page => page.$eval("#stage", canvas => {
  const { width, height } = canvas;
  const { data } = canvas.getContext("2d").getImageData(0, 0, width, Math.floor(0.78 * height));
  const columns = [];
  // Only the robot is above the ground's line; the trail and the marks are below it.
  for (let k = 3; k < data.length; k += 4) if (data[k] > 20) columns.push(((k - 3) / 4) % width);
  const [low, high] = columns.reduce(([low, high], x) => [Math.min(low, x), Math.max(high, x)], [width, 0]);
  return [low / width, 1 - high / width];
});

/** An undecided robot is in the middle and fully visible, even on a telephone. */
async function framed(browser, address) {
  for (const width of [400, 1280]) {
    const { page, faults } = await open(browser, `${address}#scene=stability`, { width, height: 800, features: [{ name: "prefers-reduced-motion", value: "reduce" }] });
    await ready(page);
    await set(page, "#time", "0");
    await wait(200);
    const [left, right] = await margins(page);
    // The tolerance is for the disc of the payload, which is on one side.
    check(left > 0.02 && right > 0.02 && Math.abs(left - right) < 0.05, `undecided at ${width} px: ${left.toFixed(3)} of the stage is free to the left, ${right.toFixed(3)} to the right`);
    await close(page, faults);
  }
}

/** The page calls a robot unreliable if its walks from perturbed starts differ much. */
async function unreliable(browser, address) {
  const few = SMALL.replace("seed=1", "seed=11").replace("iterations%3D120", "iterations%3D20").replace("from%3D40", "from%3D4").replace("at%3D80", "at%3D8");
  const { page, faults } = await open(browser, `${address}${few}&set=selection.perturbation%3D0.001`);
  await ready(page);
  await press(page, "design");
  await says(page, "Design another");
  check(/Unreliable: the /.test(await text(page, "status")), await text(page, "status"));
  await close(page, faults);
}

/** Robots of other versions, of other lattices, too short, too long, not text, and scenes with absurd numbers. */
async function hostileLinks(browser, address) {
  const { link } = JSON.parse(readFileSync(here("../page/hello.json")));
  const robot = new URLSearchParams(link.slice(1)).get("robot");
  const creature = (robot, more = "") => `#scene=creature&seed=1${more}&robot=${encodeURIComponent(robot)}`;
  const set = setting => `#scene=creature&set=${encodeURIComponent(setting)}`;
  const hostile = [
    creature(""), creature("AQ"), creature(robot.slice(0, 40)), creature(`${robot}AAAA`), creature(`B${robot.slice(1)}`),
    creature("A".repeat(100_000)), creature("%00%ff"), creature("<img src=x onerror=alert(1)>"), creature("\u{1f916}"), creature(robot, "&set=lattice.columns%3D5"),
    creature(robot, "&set=controller.goals%3D%22given%22"), `#scene=errand&robot=${robot}`, `#scene=large&robot=${robot}`, `AQD${robot.slice(3)}`.replace(/^/, "#scene=creature&robot="),
    "#scene=", "#scene=<script>alert(1)</script>", "#scene=../../etc/passwd", `#scene=${"x".repeat(50_000)}`, "#seed=-1", "#seed=1e400", "#%E0%A4%A",
    set("lattice.columns=1e9"), set("lattice.columns=-3"), set("physics.gravity=nan"), set("physics.steps=0"), set("__proto__.x=1"), set("base=\"earth\""), set(`${"x".repeat(20_000)}=1`),
  ];
  let bad = [];
  for (const link of hostile) {
    const { page, faults } = await open(browser, address + link);
    try {
      await ready(page);
      const isWrong = !/^#seed|%A$|robot=$/.test(link);
      // The reason is written just after the other scene is ready.
      if (isWrong) await page.waitForFunction(() => document.getElementById("refusal").textContent !== "", { timeout: 5000 });
      const [says, scene] = [await text(page, "refusal"), await value(page, "scene")];
      if (faults.length > 0 || scene === "") bad.push(`${link.slice(0, 80)}: ${says} ${faults}`);
    } catch (error) {
      bad.push(`${link.slice(0, 80)}: ${error.message} ${faults}`);
    }
    await page.close();
  }
  check(bad.length === 0, `${hostile.length} hostile links: each shows a robot and, where it is wrong, the reason${bad.map(link => `\n       ${link}`).join("")}`);
}

/** If a link cannot be opened, the page shows the reason and another robot. */
async function refusedLinks(browser, address) {
  await hostileLinks(browser, address);
  for (const [link, reason, shows] of [
    ["#scene=stabilty&seed=1", "\"stabilty\" is not a scene of this page", "creature"],
    ["#scene=incline&set=lattice.columns%3D1", "out of range", "incline"],
  ]) {
    const { page, faults } = await open(browser, address + link, { height: 900 });
    await ready(page);
    const said = await text(page, "refusal");
    const { top, bottom } = await page.$eval("#refusal", element => element.getBoundingClientRect().toJSON());
    check(said.includes(reason) && said.includes(`shows the scene ${shows}`) && await value(page, "scene") === shows, `${link}: ${said.replaceAll("\n", " ")}`);
    check(top > 0 && bottom <= 900, `in sight: from ${Math.round(top)} to ${Math.round(bottom)} px of 900`);
    await close(page, faults);
  }
}

/** A slow computation can be cancelled, before and during a design. Choosing another scene also ends it. */
async function cancelled(browser, address) {
  const huge = "#scene=stability&set=lattice.columns%3D64&set=lattice.rows%3D64";
  const { page, faults } = await open(browser, address + huge);
  await says(page, "Cancel");
  await press(page, "design");
  await says(page, "Design a robot", 1000);
  check(/^Cancelled/.test(await text(page, "status")), `64x64 nodes: ${await text(page, "status")}`);
  await press(page, "design");
  await says(page, "Cancel");
  const chosen = Date.now();
  await page.select("#scene", "five_by_five");
  await page.waitForFunction(() => document.getElementById("status").textContent.startsWith("Here every bar is still undecided"), { timeout: 20_000 });
  check(true, `another scene does not wait for it: ${((Date.now() - chosen) / 1000).toFixed(1)} s`);
  return close(page, faults);
}

/** The positions of all nodes in the frames of a walk, in units. */
function framesOf({ counts }) {
  let at = counts[0].map(() => 0);
  return counts.map(moved => (at = at.map((count, k) => count + moved[k])));
}

/** A robot that is told the same goal again walks on as if nothing had happened: its state and its clock go on. */
function goingOn() {
  const built = readdirSync(here("../dist"), { recursive: true }).find(name => name.endsWith("cosmic.wasm"));
  const engine = new Engine(new WebAssembly.Module(readFileSync(here(`../dist/${built}`))));
  engine.ask({ do: "begin", scene: { scene: "errand", settings: TOLD }, seed: 1 });
  const tell = (along, frame) => framesOf(engine.ask({ do: "tell", along, frame }).robot.walk);
  const apart = (walk, other) => Math.max(...walk.flatMap((frame, k) => frame.map((x, i) => Math.abs(x - other[k][i]))));
  const whole = tell(1, 4).slice(6, 16);
  const again = tell(1, 6).slice(0, 10);
  tell(1, 0);
  const other = tell(-1, 0).slice(0, 10);
  // Positions are rounded to units.
  check(apart(whole, again) <= 1, `a walk that is told the same goal goes on: ${apart(whole, again)} units apart`);
  check(apart(again, other) > 1, `with the goal behind, it does not: ${apart(again, other)} units apart`);
  for (const [request, reason] of [
    [{ do: "tell", along: 1, frame: 9999 }, /`frame` is 9999; the walk has \d+ frames/],
    [{ do: "begin", scene: { scene: "stability", settings: TOLD.slice(0, 2) }, seed: 1 }, null],
    [{ do: "tell", along: 1, frame: 0 }, /only robots with given goals can be told where to go/],
  ]) {
    let refusal = null;
    try {
      engine.ask(request);
    } catch (error) {
      refusal = error.message;
    }
    check(reason === null ? refusal === null : reason.test(refusal), `${JSON.stringify(request.do)}: ${refusal}`);
  }
}

/** The robot goes where one clicks on the ground, and where the slider is moved by keys. */
async function errand(browser, address) {
  const { page, faults } = await open(browser, address + linkTo("errand", TOLD));
  await ready(page);
  check(await page.$eval("#errand", row => row.getBoundingClientRect().height > 0), "a robot with given goals has the controls for its goal");
  const box = await boxOf(page, "#stage");
  const toldTo = async (says, is) => {
    await until(page, says, is => /^Told to go to /.test(document.getElementById("status").textContent) && Number(document.getElementById("goal").value) * is > 0, is);
    console.log(`     ${await text(page, "status")}`);
  };
  await page.mouse.click(box.x + 0.9 * box.width, box.y + 0.9 * box.height);
  await toldTo("a click ahead of the robot", 1);
  await page.mouse.click(box.x + 0.1 * box.width, box.y + 0.9 * box.height);
  await toldTo("a click behind it", -1);
  check(await page.$eval("#stage", canvas => {
    const { width, height } = canvas;
    const { data } = canvas.getContext("2d").getImageData(0, 0, Math.floor(0.25 * width), Math.floor(0.6 * height));
    return data.some((x, k) => k % 4 === 3 && x > 200);
  }), "a flag is there");
  await press(page, "design");
  await says(page, "Pause");
  await page.mouse.click(box.x + 0.9 * box.width, box.y + 0.9 * box.height);
  await says(page, "Resume");
  await toldTo("a click while the robot is designed pauses the design", 1);
  await press(page, "design");
  await says(page, "Design another");
  await page.focus("#goal");
  const before = Number(await value(page, "goal"));
  await page.keyboard.press("ArrowLeft");
  await until(page, "an arrow key moves the goal", before => document.getElementById("status").textContent.startsWith("Told") && Number(document.getElementById("goal").value) < before, before);
  check((await text(page, "status")).includes(await text(page, "place")), await text(page, "status"));
  await set(page, "#speed", "4");
  await until(page, "the walk to the goal stops at its end", () => document.getElementById("play").textContent === "Play walk" && document.getElementById("time").max - document.getElementById("time").value < 1e-6);
  await press(page, "undo");
  await until(page, "the robot as designed walks again", () => document.getElementById("status").textContent.startsWith("Finished"));
  await page.select("#scene", "stability");
  await until(page, "other scenes have no such controls", () => document.getElementById("errand").getBoundingClientRect().height === 0);
  await close(page, faults);
}

/** A stranger opens the page: a finished robot walks at once, and then a design begins by itself. */
async function stranger(browser, address) {
  for (const slower of [1, 4]) {
    const page = await browser.newPage();
    if (slower > 1) await page.emulateCPUThrottling(slower);
    await page.evaluateOnNewDocument(() => {
      const far = () => Number.parseFloat(document.getElementById("along")?.textContent ?? "");
      const first = {};
      globalThis.first = first;
      const look = () => {
        if (first.step === undefined && far() > 0.02) first.step = performance.now();
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
    console.log(`     a processor ${slower} times slower: the finished robot walks after ${seconds(first.step)} s, the first attempt is over after ${seconds(first.attempt)} s, the design walks 0.1 m after ${seconds(first.walk)} s`);
    check(first.step < first.attempt, "the finished robot walks before the library has designed anything");
    await page.waitForFunction(() => document.getElementById("design").textContent === "Design another", { timeout: 240_000 });
    check(/^Finished after 120 attempts/.test(await text(page, "status")), `and the design begins by itself: ${await text(page, "status")}`);
    await page.close();
  }
  const { page, faults } = await openPage(browser, address, { features: [{ name: "prefers-reduced-motion", value: "reduce" }] });
  await ready(page);
  await wait(1500);
  check(await text(page, "design") === "Design a robot" && await text(page, "attempt-title") === "a finished robot", "with reduced motion no design begins by itself, and the finished robot stands");
  await close(page, faults);
}

/** The address holds a finished or edited robot: a refresh shows it again, and Back returns to it. */
async function links(browser, address) {
  const { page, faults } = await open(browser, address + SMALL);
  await ready(page);
  await press(page, "design");
  await says(page, "Design another");
  await until(page, "the address holds the finished robot", () => location.hash.includes("robot="));
  const designed = { url: page.url(), along: Number.parseFloat(await text(page, "along")) };
  await press(page, "next");
  await page.click("[name=material][value='1']");
  await until(page, "and the edited one", url => location.hash.includes("robot=") && location.href !== url, designed.url);
  await page.goto("about:blank");
  await page.goto(designed.url);
  await until(page, "the link opens the robot", () => document.getElementById("status").textContent.startsWith("This robot came with the link"));
  const along = Number.parseFloat(await text(page, "along"));
  console.log(`     designed ${designed.along} m, in the link ${along} m, ${new URL(designed.url).hash.length} characters`);
  check(Number.isFinite(along), "and it walks");
  await unfold(page);
  await page.select("#chip-gravity", "Moon");
  await until(page, "a chip changes the scene", () => location.hash.includes("physics.gravity%3D1.62") && !location.hash.includes("robot="));
  await says(page, "Pause");
  await page.evaluate(() => history.back());
  await until(page, "Back returns to the robot", () => document.getElementById("status").textContent.startsWith("This robot came with the link"));
  await page.reload();
  await until(page, "so does a refresh", () => document.getElementById("status").textContent.startsWith("This robot came with the link"));
  await page.evaluate(() => globalThis.push([1, 1]));
  await until(page, "a push", () => document.getElementById("status").textContent.startsWith("You pushed the robot"));
  const box = await boxOf(page, "#stage");
  await page.mouse.move(box.x + box.width / 2, box.y + 0.75 * box.height);
  await page.mouse.down();
  await page.mouse.move(box.x + box.width / 2 + 90, box.y + 0.6 * box.height, { steps: 4 });
  await page.mouse.up();
  await until(page, "and a push by dragging", () => /^(You pushed|After your push)/.test(document.getElementById("status").textContent));
  await close(page, faults);
}

/** A change of the scene during a design asks. */
async function asks(browser, address) {
  const { page, faults } = await open(browser, address + SMALL);
  await ready(page);
  await press(page, "design");
  await until(page, "a design", () => Number.parseInt(document.getElementById("iteration").textContent, 10) > 3);
  await page.select("#chip-gravity", "Mars");
  await page.waitForSelector("#leave[open]");
  await press(page, "stay");
  await until(page, "the design goes on", () => document.getElementById("chip-gravity").value !== "Mars" && !location.hash.includes("3.7") && document.getElementById("design").textContent === "Pause");
  await page.select("#chip-gravity", "Mars");
  await page.waitForSelector("#leave[open]");
  await press(page, "go");
  await until(page, "or the change is made", () => location.hash.includes("gravity%3D3.7") && document.getElementById("design").textContent === "Pause");
  await says(page, "Design another");
  await press(page, "race");
  await until(page, "a race of seeds", () => document.querySelectorAll("#lanes progress").length > 1);
  await page.waitForFunction(() => document.getElementById("saved").textContent.includes("won the race"), { timeout: 60_000 });
  check(page.url().includes("robot="), await text(page, "saved"));
  await page.evaluate(() => history.back());
  await ready(page);
  await unfold(page);
  await press(page, "other");
  await says(page, "Design another");
  await page.focus("#strip");
  await page.keyboard.press("Home");
  check((await text(page, "iteration")).startsWith("0 /"), "the strip shows the first attempt by a key");
  const box = await boxOf(page, "#strip");
  await page.mouse.click(box.x + box.width / 2, box.y + 20);
  check((await text(page, "iteration")).startsWith("60 /"), `and another by a click: ${await text(page, "iteration")}`);
  await close(page, faults);
}

/** The page says why it cannot work without scripts, without WebAssembly and from a file. It works without a network. */
async function without(browser, address) {
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
  await until(old, "without WebAssembly the finished robot walks", () => Number.parseFloat(document.getElementById("along").textContent) > 0.3);
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

async function shots(browser, address, folder) {
  mkdirSync(folder, { recursive: true });
  for (const scheme of ["light", "dark"]) {
    for (const [width, height] of [[400, 800], [1280, 800], [2560, 1300]]) {
      const features = [{ name: "prefers-color-scheme", value: scheme }];
      const { page, faults } = await open(browser, address + SMALL, { width, height, features });
      await ready(page);
      await press(page, "design");
      await says(page, "Design another");
      await wait(700);
      await page.screenshot({ path: join(folder, `${scheme}-${width}.png`), fullPage: true });
      await close(page, faults);
    }
  }
}

async function inFirefox(address) {
  const browser = await launch("firefox");
  try {
    const { page, faults } = await open(browser, address + SMALL, { sized: false });
    await ready(page);
    await press(page, "design");
    await says(page, "Design another");
    await press(page, "next");
    await press(page, "link");
    check(/m$/.test(await text(page, "along")), `Firefox: ${await text(page, "status")}`);
    await close(page, faults);
  } finally {
    await browser.close();
  }
}

async function inChromium(address) {
  const folder = mkdtempSync(join(tmpdir(), "cosmic-page-"));
  const browser = await launch("chrome", { downloadBehavior: { policy: "allow", downloadPath: folder } });
  try {
    const { page, faults } = await open(browser, address + SMALL);
    await ready(page);
    await designing(page);
    await playing(page);
    await editing(page);
    await files(page, folder, given.program);
    const shifted = await page.evaluate(() => globalThis.shifted);
    check(shifted.length === 0, `nothing shifts${shifted.map(shift => `\n       ${shift}`).join("")}`);
    await scenes(page, address);
    await close(page, faults);
    await stopping(browser, address);
    await motionless(browser, address);
    await framed(browser, address);
    await unreliable(browser, address);
    await refusedLinks(browser, address);
    await cancelled(browser, address);
    await errand(browser, address);
    await stranger(browser, address);
    await links(browser, address);
    await asks(browser, address);
    await without(browser, address);
    if (given.shots) await shots(browser, address, given.shots);
  } finally {
    await browser.close();
  }
}

goingOn();
const server = await serve(here("../dist"));
for (const [browser, test] of [["chrome", inChromium], ["firefox", inFirefox]]) {
  if (installed(browser)) await test(server.address);
  else console.log(`SKIPPED: no ${browser === "chrome" ? "Chromium" : "Firefox"}`);
}
server.close();
console.log(failures === 0 ? "the page: all checks passed" : `the page: ${failures} checks failed`);
process.exitCode = failures === 0 ? 0 : 1;
