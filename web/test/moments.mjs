// Tests of the first minute: the parade, the switches, walks without an end, races against a link, and the gradient.
import { open as openPage, ready, says, text } from "./browsers.mjs";
import { CAST, HELLO, SMALL, check, close, here, library, linkTo, open, press, until, wait } from "./helpers.mjs";
import { sentence } from "../page/words.js";
import { agree } from "./links.mjs";
import { serve } from "./serve.mjs";

/** The gradient is the derivative of the distance: small changes of bars bring what it says. */
export function gaining() {
  const engine = library();
  const settings = new URLSearchParams(SMALL.slice(1)).getAll("set");
  engine.ask({ do: "begin", scene: { scene: "stability", settings: [...settings, 'gradient.precision="f64"'] }, seed: 1 });
  for (let k = 0; k < 12; k++) engine.ask({ do: "iterate", shown: false });
  const { gains, seconds } = engine.ask({ do: "gains", tried: null });
  const share = 1e-4;
  const off = gains.map((gain, bar) => {
    const [up, down] = [share, -share].map(by => engine.ask({ do: "gains", tried: [bar, by] }).farther);
    return Math.abs((up - down) / (2 * share) - gain);
  });
  const most = Math.max(...gains.map(Math.abs));
  check(Math.max(...off) < 1e-3 * most, `the gradient within ${seconds.toFixed(2)} s is the derivative: ${(100 * most).toFixed(2)} cm a bar at most, wrong by ${(100 * Math.max(...off)).toExponential(1)} cm`);
}

/** A touch makes a robot of the parade the user's own, while the page designs another one. */
export async function picking(browser, address) {
  for (const [k, { name }] of CAST.entries()) {
    const { page, faults } = await openPage(browser, address);
    await page.waitForSelector(`#parade button:nth-child(${k + 1})`);
    const far = await page.$eval(`#parade button:nth-child(${k + 1}) b`, far => far.textContent);
    await page.click(`#parade button:nth-child(${k + 1})`);
    await until(page, `a touch takes the robot of the parade: ${name}`, () => document.getElementById("status").textContent.startsWith("This robot is finished"));
    const robot = new URLSearchParams(CAST[k].link.slice(1)).get("robot");
    check(page.url().endsWith(`&robot=${robot}`), `and is in the address: ${page.url().length} characters`);
    check(far === await text(page, "along") && (await text(page, "status")).includes(` ${far} in `), `the parade, the headline and the sentence say ${far} (${await text(page, "along-title")})`);
    await agree(page, name);
    const onMoon = [];
    for (const pause of k === 0 ? [300, 1700] : []) {
      await wait(pause);
      await page.click("#worlds [data-choice=Moon]");
      await page.waitForFunction(() => document.getElementById("status").textContent.startsWith("The same robot"));
      onMoon.push(await text(page, "along"));
      await press(page, "home");
      await page.waitForFunction(() => document.getElementById("status").textContent.startsWith("This robot"));
    }
    if (k === 0) check(onMoon[0] === onMoon[1], `on the Moon it walks ${onMoon.join(" and ")}, at whatever moment`);
    await close(page, faults);
  }
  for (const [what, next, status] of [
    ["the Moon", "[data-choice=Moon]", "The same robot, now with the gravity of the Moon"], ["another design", "#design", "Searching"], ["evolution", "#twin", "Evolution"],
  ]) {
    const { page, faults } = await openPage(browser, address);
    await page.waitForSelector("#parade button:nth-child(6)");
    // The page's own design is under way.
    await until(page, "a design", () => document.getElementById("strip").getAttribute("aria-valuenow") > 2);
    await page.evaluate(next => {
      document.querySelector("#parade button:nth-child(4)").click();
      document.querySelector(next).click();
    }, next);
    await until(page, `a robot of the parade and at once ${what}`, status => document.getElementById("status").textContent.startsWith(status), status);
    check(!(await page.$("#leave[open]")) && await page.evaluate(() => location.hash.includes("columns%3D6")), `with that robot, without a question: ${await page.evaluate(() => location.hash.slice(0, 120))}`);
    await close(page, faults);
  }
  const { page, faults } = await openPage(browser, address);
  await page.waitForSelector("#parade button");
  await page.focus("#parade button:nth-child(2)");
  check(await page.$eval("#stage", stage => stage.tabIndex) === -1, "the stage behind the parade cannot be reached by keys");
  await page.keyboard.press("Enter");
  await until(page, "keys take a robot, too", () => document.getElementById("parade").hidden && document.getElementById("status").textContent.startsWith("This robot is finished"));
  check(await page.evaluate(() => document.activeElement.id === "stage" && document.activeElement.tabIndex === 0), "and the focus is on the stage");
  const [held, nodes] = await page.evaluate(() => [globalThis.onStage().absent, globalThis.onStage().held]);
  check(held.length > 0 && held.flat().every(node => nodes.includes(node)), `${held.length} absent bars are drawn, all between nodes of the robot`);
  await close(page, faults);
}

/** When the page's own design takes the stage from the parade, so does the focus. */
export async function focusing(browser, address) {
  const { page, faults } = await openPage(browser, address);
  await page.waitForSelector("#parade button");
  await page.focus("#parade button:nth-child(3)");
  await until(page, "the page's own design takes the stage", () => document.getElementById("parade").hidden);
  check(await page.evaluate(() => document.activeElement.id) === "stage", "with the focus");
  await close(page, faults);
}

/** The parade comes back beside a finished robot and beside a design, and the page says whose it is. */
export async function recalling(browser, address) {
  const { page, faults } = await open(browser, address + HELLO.link);
  await until(page, "a finished robot", () => document.querySelector("#verdict span"));
  const url = page.url();
  await press(page, "finished");
  await until(page, "the parade is called", () => globalThis.parade.isOpen && document.querySelectorAll("#parade button").length === 6);
  await press(page, "finished");
  check(await page.evaluate(() => !globalThis.parade.isOpen && document.getElementById("status").textContent.startsWith("This robot is finished")) && page.url() === url, "and goes");
  await press(page, "finished");
  await page.waitForSelector("#parade button");
  await page.click("#worlds [data-choice=Moon]");
  await until(page, "a switch moves the robot that was on the stage", () => document.getElementById("status").textContent.startsWith("The same robot, now") && !globalThis.parade.isOpen);
  await press(page, "design");
  await until(page, "a design", () => Number.parseInt(document.getElementById("iteration").textContent, 10) > 3);
  await press(page, "finished");
  await page.waitForSelector("#parade button:nth-child(4)");
  await page.click("#parade button:nth-child(4)");
  await page.waitForSelector("#leave[open]");
  await press(page, "stay");
  check(await page.evaluate(() => globalThis.parade.isOpen), "a design in progress is not lost without a question");
  await page.click("#parade button:nth-child(4)");
  await page.waitForSelector("#leave[open]");
  await press(page, "go");
  await until(page, "another robot is chosen", () => document.getElementById("status").textContent.startsWith("This robot is finished") && location.hash.includes("columns%3D6"));
  const says = await page.$eval("footer", footer => footer.innerText);
  check(/cosmic.*source.*Guo and L\. Wang, COSMIC: Concurrent/s.test(says), says.replaceAll("\n", " "));
  await close(page, faults);
}

/** The switches move the robot, walks go on, and the height of jumps is shown. */
export async function switches(browser, address) {
  const { page, faults } = await open(browser, address + HELLO.link);
  await until(page, "a finished robot", () => document.querySelector("#verdict span"));
  const isOn = () => page.$$eval("#worlds button", buttons => buttons.filter(button => button.getAttribute("aria-pressed") === "true").map(button => button.dataset.choice).join());
  check(await isOn() === "Earth", "the switch of the Earth is on");
  await page.click("#worlds [data-choice=Moon]");
  await until(page, "a switch leads to the Moon", () => document.getElementById("status").textContent.startsWith("The same robot, now with the gravity of the Moon"));
  check(await isOn() === "Moon", "and is on");
  check(/^0\.\d\d m$/.test(await text(page, "jump")) && await page.$eval("#jumps", figure => !figure.hidden), `there it jumps ${await text(page, "jump")}`);
  await page.select("#speed", "4");
  const far = () => page.evaluate(() => globalThis.onStage().metres);
  await until(page, "the walk goes on for four times as long as a walk", () => globalThis.onStage().time > 4 * 8);
  const before = await far();
  await until(page, "and gets farther", before => globalThis.onStage().metres > before + 0.2, before);
  const frames = await page.evaluate(() => globalThis.onStage().frames);
  check(frames < 400, `its past is forgotten: ${frames} frames are kept`);
  await page.click("#worlds [data-choice=steps]");
  await until(page, "a second switch: stairs on the Moon", () => document.getElementById("status").textContent.startsWith("The same robot, now with the gravity of the Moon and on steps"));
  check(await isOn() === "Moon,steps" && page.url().endsWith("&gravity=Moon&ground=steps"), "the link holds what one sees");
  await page.click("#worlds [data-choice=steps]");
  await until(page, "and off again", () => !location.hash.includes("ground="));
  await page.evaluate(() => globalThis.push([0.5, 1]));
  await until(page, "a push of a robot that has walked on", () => document.getElementById("status").textContent.startsWith("You pushed the robot"));
  await press(page, "home");
  await until(page, "and home", () => document.getElementById("status").textContent.startsWith("This robot is finished") && !location.hash.includes("gravity="));
  check(await isOn() === "Earth", "where the switch of the Earth is on again");
  await close(page, faults);
}

/** An edit by a touch can be taken back beside the button Share. */
export async function takingBack(browser, address) {
  const { page, faults } = await openPage(browser, address + HELLO.link, { width: 400, height: 800, touch: true });
  await until(page, "a finished robot on a telephone", () => document.querySelector("#verdict span"));
  check(await page.$eval("#takeback", button => button.disabled), "nothing to take back");
  const url = page.url();
  const tap = async () => {
    const before = page.url();
    const box = await (await page.$("#stage")).boundingBox();
    const robot = await page.evaluate(() => globalThis.onStage().box);
    for (let part = 0.1; part < 1 && page.url() === before; part += 0.06) {
      await page.touchscreen.tap(box.x + robot[0] + part * (robot[2] - robot[0]), box.y + (robot[1] + robot[3]) / 2);
      await wait(700);
    }
    check(page.url() !== before, "a touch edits");
    return page.url();
  };
  await page.evaluate(() => document.getElementById("play").click());
  await tap();
  await page.waitForSelector("#takeback:enabled");
  const [back, link] = await page.evaluate(() => ["takeback", "link"].map(id => document.getElementById(id).getBoundingClientRect().toJSON()));
  check(Math.abs(back.y - link.y) < 60, `the button is beside Share: ${Math.round(back.y - link.y)} px below it`);
  for (let k = 0; k < 20 && !(await page.$eval("#takeback", button => button.disabled)); k++) {
    await (await page.$("#takeback")).tap();
    await wait(700);
  }
  await until(page, "and takes the edits back", url => location.href === url && document.getElementById("takeback").disabled, url);
  await close(page, faults);
}

/** Before the library has loaded, the page says how much of it is there. */
export async function loading(browser) {
  const server = await serve(here("../dist"), 0, 100);
  const page = await browser.newPage();
  await page.goto(`${server.address}?wait`);
  const words = new Set();
  for (const end = Date.now() + 30_000; Date.now() < end; await wait(50)) {
    const [button, status] = [await text(page, "design"), await text(page, "status")];
    if (/^Loading, \d+ %$/.test(button) && /\d+ %$/.test(status)) words.add(status);
    if (button === "Design a robot" && status.startsWith("Here")) break;
  }
  check(words.size > 2, `words of progress: ${[...words].slice(0, 3).join("; ")} …`);
  await page.close();
  server.close();
}

/** If the library is cut, missing or another file, or its download hangs, the page says so, robots walk, and a button helps. */
export async function missing(browser) {
  const type = { "content-type": "application/wasm" };
  for (const [how, spoil, words] of [
    ["is cut", (response, bytes) => response.writeHead(200, type).end(bytes.subarray(0, 100_000)), "did not arrive"],
    ["is missing", response => response.writeHead(404).end(), "answers with 404"],
    ["is another file", response => response.writeHead(200, type).end("<!DOCTYPE html>"), "did not arrive"],
    ["is another program", response => response.writeHead(200, type).end(Buffer.from([0, 97, 115, 109, 1, 0, 0, 0])), "did not arrive"],
    ["hangs", (response, bytes) => response.writeHead(200, type).write(bytes.subarray(0, 1_000_000)), "has stopped arriving"],
  ]) {
    for (const link of how === "hangs" ? [""] : ["", HELLO.link]) {
      let isSpoilt = true;
      const server = await serve(here("../dist"), 0, 0, (...given) => isSpoilt && (spoil(...given), true));
      const { page } = await openPage(browser, server.address + link);
      await until(page, `the library ${how}${link && ", with a link"}`, words => document.getElementById("missing").textContent.includes(words), words);
      const before = await page.evaluate(() => globalThis.parade.cost.frames);
      await until(page, "robots walk", before => globalThis.parade.cost.frames > before + 5, before);
      check(!(await page.$("#stopped[open]")), await text(page, "missing"));
      isSpoilt = false;
      await page.click("#again");
      await ready(page);
      check(await page.$eval("#missing", words => words.hidden), "the button loads it");
      await page.close();
      server.close();
    }
  }
}

/** A link asks to beat a robot: a new design races it in lanes, and the link of the result holds both. */
export async function beating(browser, address) {
  const [scene, rest] = SMALL.split("&seed=1");
  const { page, faults } = await open(browser, address + SMALL);
  await ready(page);
  await press(page, "design");
  await says(page, "Design another");
  await until(page, "a robot to beat", () => location.hash.includes("robot=") && document.getElementById("along-title").textContent.startsWith("typical distance"));
  const far = await text(page, "along");
  await page.evaluate(() => { navigator.clipboard.writeText = async text => { globalThis.copied = text; }; });
  await press(page, "challenge");
  const link = await (await page.waitForFunction(() => globalThis.copied)).jsonValue();
  const asked = new URLSearchParams(new URL(link).hash.slice(1));
  check(asked.get("beat") === far.replace(" m", "") && asked.get("seed") === "2" && !asked.has("robot"), `${await text(page, "saved")}`);
  const claims = link.replace(/beat=[\d.]+/, "beat=99.00");
  for (const url of [link, claims]) {
    await page.goto("about:blank");
    await page.goto(url);
    await until(page, "the link opens with the robot to beat", () => document.getElementById("status").textContent.startsWith("To beat: ") && globalThis.onStage().lane !== null);
    check((await text(page, "status")).includes("the link says 99.00 m") === (url === claims), await text(page, "status"));
  }
  await press(page, "design");
  await until(page, "a new design races it", () => Number.parseInt(document.getElementById("iteration").textContent, 10) > 3 && globalThis.onStage().lane?.startsWith("to beat: "));
  await says(page, "Design another");
  await until(page, "and is compared with it", () => /^(You beat it|Not beaten yet): -?[\d.]+ m against/.test(document.getElementById("status").textContent) && location.hash.includes("robot="));
  console.log(`     ${await text(page, "status")}`);
  const both = page.url();
  check(new URL(both).hash.includes(`rival=${asked.get("rival")}`) && new URL(both).hash.includes("robot="), `the link holds both robots in ${both.length} characters`);
  const said = (await text(page, "status")).split(". ")[0];
  await page.goto("about:blank");
  await page.goto(both);
  await until(page, "and opens with both", said => document.getElementById("status").textContent.startsWith(said) && globalThis.onStage().lane !== null, said.slice(0, 12));
  await page.select("#scene", "creature");
  await until(page, "another scene has no robot to beat", () => !location.hash.includes("rival=") && globalThis.onStage().lane === null);
  check(scene.length > 0 && rest.length > 0, "the scene is that of the robot to beat");
  await close(page, faults);
}

/** While a robot is designed, its bars have tints, and a touch or a key says what a change would bring. */
export async function tinting(browser, address) {
  const { page, faults } = await open(browser, address + linkTo("creature", []));
  await ready(page);
  await press(page, "design");
  await until(page, "the bars have tints", () => document.getElementById("robot").classList.contains("tinted"));
  const tints = await page.evaluate(() => globalThis.onStage().tints);
  check(Math.max(...tints.map(Math.abs)) === 1 && new Set(tints).size > 10, `${tints.length} bars, from ${Math.min(...tints).toFixed(2)} to ${Math.max(...tints).toFixed(2)}`);
  await press(page, "design");
  await says(page, "Resume");
  await page.focus("#stage");
  await page.keyboard.press("Enter");
  await until(page, "a key says what a change would bring", () => /^(Thicker|Thinner) here: \+[\d.]+ cm in [\d.]+ s\. Tried: [+-][\d.]+ cm\.$/.test(document.getElementById("gain").textContent));
  console.log(`     ${await text(page, "gain")}`);
  const first = await text(page, "gain");
  const box = await (await page.$("#stage")).boundingBox();
  const robot = await page.evaluate(() => globalThis.onStage().box);
  for (let part = 0.1; part < 1 && first === await text(page, "gain"); part += 0.05) {
    await page.mouse.click(box.x + robot[0] + part * (robot[2] - robot[0]), box.y + robot[1] + 0.4 * (robot[3] - robot[1]));
    await wait(150);
  }
  check(first !== await text(page, "gain"), `and a touch: ${await text(page, "gain")}`);
  await press(page, "design");
  await says(page, "Design another", 240_000);
  check(await page.$eval("#gain", words => words.hidden) && await page.evaluate(() => globalThis.onStage().tints === null), "a finished robot has none");
  await close(page, faults);
}

/** A robot of real parts is measured aside, which takes a minute: the page says so, and a switch moves the robot meanwhile. */
export async function measuring(browser, address) {
  const { link } = CAST.find(({ name }) => name === "could be built");
  const { page, faults } = await openPage(browser, address + link);
  const isHome = () => document.getElementById("status").textContent.startsWith("This robot is finished");
  await until(page, "a robot of real parts", isHome);
  check(/\d m\/s/.test(await text(page, "verdict")), "the verdict of a robot of the parade is known");
  // With another payload nothing is known of it.
  await page.evaluate(link => { location.hash = `${link}&set=physics.payload_mass=0.051`; }, link);
  await until(page, "an unknown robot is measured", () => document.getElementById("verdict").textContent.startsWith("Measuring"));
  const slow = await page.createCDPSession();
  await slow.send("Emulation.setCPUThrottlingRate", { rate: 4 });
  await wait(1000);
  const asked = Date.now();
  await page.click("#worlds [data-choice=Moon]");
  await page.waitForFunction(() => !document.getElementById("busy").hidden || document.getElementById("status").textContent.startsWith("The same robot"), { timeout: 60_000 });
  check(Date.now() - asked < 2000, `a switch is answered after ${Date.now() - asked} ms`);
  await page.waitForFunction(() => document.getElementById("status").textContent.startsWith("The same robot"), { timeout: 60_000 });
  check(Date.now() - asked < 20_000, `and the robot walks there after ${Date.now() - asked} ms`);
  await close(page, faults);
}

/** Two robots are compared by their medians, not by a lucky walk, and a tie is a tie. */
export function comparing() {
  globalThis.decimals = (x, digits) => x.toFixed(digits);
  const robot = (along, p50) => ({ walk: { along, took: 6, count: () => 1 }, measured: { distance: { p10: p50, p50, p90: p50 }, reliability: {} } });
  const says = (own, rival) => {
    const delivered = robot(...own);
    delivered.designed = delivered;
    const design = { rival: { ...robot(...rival), claimed: null }, delivered, twin: { walk: null }, robots: [], told: null, hasAttempts: true };
    return sentence("finished", design, null).split(". ")[0];
  };
  for (const [own, rival, begins] of [
    [[3.82, 3.2], [3.1, 3.37], "Not beaten yet: 3.20 m against 3.37 m"], [[2.9, 3.4], [3.8, 3.37], "You beat it: 3.40 m against 3.37 m"],
    [[3.9, 3.371], [3.1, 3.369], "A tie: 3.37 m against 3.37 m"], [[3.9, NaN], [3.1, 3.369], "To beat: 3.37 m"],
  ]) check(says(own, rival) === begins, `${own} against ${rival}: ${says(own, rival)}`);
}
