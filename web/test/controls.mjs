// Tests of the controls: designing, playing, editing, the files, the scene, and what goes wrong.
import { execFileSync } from "node:child_process";
import { existsSync, readFileSync } from "node:fs";
import { ready, says, text } from "./browsers.mjs";
import { SMALL, library, open, unfold, boxOf, check, wait, press, value, until, linkHas, set, saved, watchShifts, checkShifts, close } from "./helpers.mjs";

/** The most milliseconds that the script of a frame should take on average. */
const FRAME = 4;

export async function designing(page) {
  check(await page.$eval("#stage", canvas => canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data.some(x => x > 0)), "the robot is shown before the design");
  await page.evaluate(watchShifts);
  await page.click("#design");
  await page.waitForFunction(() => Number.parseInt(document.getElementById("iteration").textContent, 10) > 3);
  await page.click("#design");
  await says(page, "Resume");
  // An attempt that is under way still ends.
  await wait(1000);
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

export async function playing(page) {
  await press(page, "play");
  check(await text(page, "play") === "Play walk", "the walk pauses");
  const clock = await text(page, "clock");
  await wait(300);
  check(clock === await text(page, "clock"), "and its clock stops");
  await page.evaluate(() => document.activeElement.blur());
  await page.keyboard.press(" ");
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

export async function editing(page) {
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
  await until(page, "the edited robot gets a verdict", () => document.querySelector("#verdict span"));
  console.log(`     ${await text(page, "verdict")}`);
  await press(page, "previous");
  await press(page, "play");
}

export async function files(page, folder, program) {
  await press(page, "save-scene");
  await press(page, "save-design");
  const [scene, design] = [await saved(folder, /^scene\.toml$/), await saved(folder, /^design\.json$/)];
  check(JSON.parse(readFileSync(design)).format === "cosmic-design" && readFileSync(scene, "utf8").includes("columns = 3"), "scene.toml and design.json are saved");
  if (existsSync(program)) {
    const { results } = JSON.parse(execFileSync(program, ["evaluate", design], { encoding: "utf8" }));
    const { along } = await page.evaluate(() => globalThis.onStage());
    check(Math.abs(results.displacement - along) < 0.006, `the native program moves the edited robot ${results.displacement.toFixed(4)} m, the page ${along.toFixed(4)} m`);
    execFileSync(program, ["report", design], { encoding: "utf8" });
    check(true, "and writes its report");
  } else {
    console.log(`SKIPPED: no program ${program}: the saved robot is not evaluated natively`);
  }
  await press(page, "undo");
  await page.waitForFunction(() => document.getElementById("status").textContent.startsWith("Finished"));
  check((await text(page, "verdict")).length > 0, `back to the robot as designed: ${await text(page, "verdict")}`);
  await set(page, "#speed", "1");
  await press(page, "save-film");
  const film = await saved(folder, /^cosmic-stability-1\.(webm|mp4)$/);
  await page.waitForFunction(() => document.getElementById("saved").textContent.includes("is saved"));
  const bytes = readFileSync(film);
  check(bytes.length > 20_000 && (bytes.readUInt32BE(0) === 0x1a45dfa3 || film.endsWith("mp4")), `the animation has ${bytes.length} bytes`);
}

export async function scenes(page, address) {
  const along = await text(page, "along");
  await press(page, "link");
  await page.waitForFunction(() => document.getElementById("saved").textContent.includes("link"));
  check(new URL(page.url()).hash.includes("seed=1"), await text(page, "saved"));
  await press(page, "other");
  await says(page, "Pause");
  await says(page, "Design another");
  check(await value(page, "seed") === "2", `another seed: ${along}, then ${await text(page, "along")}`);
  await set(page, "#seed", "3");
  await says(page, "Pause");
  await says(page, "Design another");
  await page.select("#scene", "incline");
  await page.waitForFunction(() => document.querySelector("[name='physics.incline_deg']").value === "15");
  check(new URL(page.url()).hash === "#scene=incline&seed=3", "a built-in scene");
  for (const [key, to] of [["lattice.columns", 4], ["lattice.rows", 3], ["physics.payload_mass", 0.05], ["physics.gravity", 9.81], ["physics.incline_deg", -5], ["physics.contact", "coulomb"], ["physics.friction", 0.8]]) {
    await set(page, `[name="${key}"]`, String(to));
    await until(page, `${key} = ${to}`, linkHas, `set=${key}=${to}`);
  }
  await press(page, "stairs");
  await until(page, "the ground: steps", linkHas, "[0.7, 0], [0.8, 0.02]");
  const stairs = page.url();
  await press(page, "rough");
  await until(page, "the ground: rough", stairs => location.href !== stairs && location.href.includes("ground.points"), stairs);
  await press(page, "level");
  await until(page, "the ground: level", () => !location.href.includes("ground.points"));
  await page.focus("#ground");
  for (const key of ["ArrowRight", "ArrowUp", "PageUp"]) await page.keyboard.press(key);
  await until(page, "the ground by keys", linkHas, "[0.8, 0.025]");
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

export async function stopping(browser, address) {
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

export async function motionless(browser, address) {
  const { page, faults } = await open(browser, address + SMALL, { width: 400, height: 800, touch: true, features: [{ name: "prefers-reduced-motion", value: "reduce" }] });
  await ready(page);
  await page.evaluate(watchShifts);
  await (await page.$("#design")).tap();
  await says(page, "Design another");
  const { foot } = await page.evaluate(() => globalThis.onStage());
  check(await text(page, "play") === "Play walk" && Number.parseFloat(await text(page, "clock")) > 0.5 && foot < 0.003, `with reduced motion the robot is shown at the end of its walk, ${(1000 * foot).toFixed(1)} mm above the ground; the button reacts to a touch`);
  const wide = await page.evaluate(() => document.documentElement.scrollWidth);
  check(wide <= 400, `at 400 px nothing is wider: ${wide} px`);
  const box = await boxOf(page, "#stage");
  const said = await text(page, "bar");
  for (let up = 0.74; up > 0.3 && said === await text(page, "bar"); up -= 0.03) {
    await page.touchscreen.tap(box.x + box.width / 2, box.y + box.height * up);
    await wait(120);
  }
  check(said !== await text(page, "bar"), `a touch edits: ${await text(page, "bar")}`);
  await checkShifts(page);
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
export async function framed(browser, address) {
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

/** A seed whose robot the library calls unreliable. Which one it is changes with every change of the physics. */
function unreliableSeed(link) {
  const engine = library();
  const settings = new URLSearchParams(link.slice(1)).getAll("set");
  for (let seed = 1; seed <= 40; seed++) {
    engine.ask({ do: "begin", scene: { scene: "stability", settings }, seed });
    while (!engine.ask({ do: "iterate", shown: false }).done);
    if (engine.ask({ do: "deliver", packed: true }).measured.reliability.verdict === "unreliable") return seed;
  }
  return null;
}

/** The page calls a robot unreliable if robots that vary a little walk much less far. */
export async function unreliable(browser, address) {
  let few = SMALL.replace("iterations%3D120", "iterations%3D20").replace("from%3D40", "from%3D4").replace("at%3D80", "at%3D8");
  const seed = unreliableSeed(few);
  check(seed !== null, `seed ${seed} is unreliable`);
  few = few.replace("seed=1", `seed=${seed}`);
  const { page, faults } = await open(browser, address + few);
  await ready(page);
  await press(page, "design");
  await says(page, "Design another");
  check(/Unreliable: the /.test(await text(page, "status")), await text(page, "status"));
  await close(page, faults);
}

/** A slow computation can be cancelled, before and during a design. Choosing another scene also ends it. */
export async function cancelled(browser, address) {
  const huge = "#scene=stability&set=lattice.columns%3D32&set=lattice.rows%3D32";
  const { page, faults } = await open(browser, address + huge);
  await says(page, "Open it");
  check(/^A walk of this link costs about 171 times as much/.test(await text(page, "status")), `a link that costs much waits for a click: ${await text(page, "status")}`);
  await press(page, "design");
  await says(page, "Cancel");
  await press(page, "design");
  await says(page, "Design a robot", 1000);
  check(/^Cancelled/.test(await text(page, "status")), `32x32 nodes: ${await text(page, "status")}`);
  await press(page, "design");
  await says(page, "Cancel");
  const chosen = Date.now();
  await page.select("#scene", "five_by_five");
  await page.waitForFunction(() => document.getElementById("status").textContent.startsWith("Here every bar is still undecided"), { timeout: 20_000 });
  check(true, `another scene does not wait for it: ${((Date.now() - chosen) / 1000).toFixed(1)} s`);
  return close(page, faults);
}
