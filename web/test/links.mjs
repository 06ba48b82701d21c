// Tests of links, of Back and refresh, and of the questions before a robot is lost.
import { open as openPage, ready, says, text } from "./browsers.mjs";
import { SMALL, HELLO, open, unfold, goBack, boxOf, check, press, value, until, close } from "./helpers.mjs";
import { linkOf, namesIn, readLink, seedOf } from "../page/link.js";
import { toBytes, toText } from "../page/packed.js";
import { winning } from "./races.mjs";

/** A name is a seed, and links survive what messages do to them. */
export function naming() {
  // The first two are from the page of those who designed the hash.
  for (const [name, seed] of [["a", 0xe40c292c], ["foobar", 0xbf9cf968], ["Anna", 0xc9cce27b], ["anna", 0xc9cce27b], ["Zo\u00eb", seedOf("ZOE\u0308")], ["\u{1f916}", seedOf("\u{1f916}")]]) {
    check(seedOf(name) === seed, `the seed of ${name} is ${seedOf(name)}`);
  }
  const long = "x".repeat(60);
  for (const [hash, ...names] of [
    ["#Anna", "Anna"], ["#Anna+Ben", "Anna", "Ben"], ["#Anna%20Maria + Ben).", "Anna Maria", "Ben"], ["#anna+ANNA", "anna"], [""], ["#"], ["#%20"], ["#+"], ["#%F0%9F%A4%96", "\u{1f916}"],
    ["#Zoe%CC%88", "Zo\u00eb"], [`#${long}`, long.slice(0, 40)], ["#%3Cb%3Ex", "<b>x"], ["#%E0%A4%A", "%E0%A4%A"], ["#a%00%E2%80%AEb", "ab"], ["#1+2+3+4+5", "1", "2", "3", "4"], ["#C%2B%2B", "C++"], ["#Anna=1"], ["#scene%3Dcube"],
  ]) check(JSON.stringify(readLink(hash).names) === JSON.stringify(names), `${hash.slice(0, 30)} has the names ${JSON.stringify(readLink(hash).names)}`);
  for (const typed of ["Anna", " \u00c5sa + C# ", "a=b&c", "100 %", "<img>", "\u{1f469}\u200d\u{1f4bb}"]) {
    const names = namesIn(typed);
    check(JSON.stringify(readLink(linkOf(names)).names) === JSON.stringify(names), `the address ${linkOf(names)}`);
  }
  const robot = new URLSearchParams(HELLO.link.slice(1)).get("robot");
  const others = Array.from(robot, (letter, k) => robot.slice(0, k) + (letter === "A" ? "B" : "A") + robot.slice(k + 1));
  check(toBytes(robot) !== null && others.every(other => toBytes(other) === null), `a robot with any of its ${robot.length} letters changed is refused`);
  for (const hash of ["#scene=cube&amp;seed=3", "#scene=cube&seed=3).", "#SCENE=cube&Seed=3", "#scene%3Dcube%26seed%3D3"]) check(String(readLink(hash).link) === "scene=cube&seed=3", `${hash} is understood`);
}

/** A name is the whole link: its robot is born, the same one everywhere, and two names race. */
export async function births(browser, address) {
  const { page, faults } = await openPage(browser, address);
  await page.waitForSelector("#parade button:nth-child(6)");
  await until(page, "the page designs a robot", () => document.getElementById("strip").getAttribute("aria-valuenow") > 2);
  await page.keyboard.press("Tab");
  check(await page.evaluate(() => document.activeElement.id) === "name", "the first Tab leads to the name");
  await page.keyboard.type("Anna");
  await page.keyboard.press("Enter");
  const began = Date.now();
  await until(page, "a name gives a robot, without a question", () => /^Anna walks [\d.]+ m so far/.test(document.getElementById("status").textContent) && !document.querySelector("#leave[open]"));
  await page.waitForFunction(() => /^Anna walks [\d.]+ m\. Finished/.test(document.getElementById("status").textContent), { timeout: 120_000 });
  const [said, far] = [/^[^.]*\.\d+ m/.exec(await text(page, "status"))[0], await text(page, "along")];
  check(page.url() === `${address}#Anna` && said === `Anna walks ${far}`, `${page.url()} after ${((Date.now() - began) / 1000).toFixed(1)} s: ${said}`);
  await unfold(page);
  await press(page, "next");
  await page.click("[name=material][value='1']");
  await until(page, "an edited robot has a link of the other kind", () => location.hash.includes("robot="));
  await goBack(page);
  await until(page, "Back returns to the name and its attempts", said => document.getElementById("status").textContent.startsWith(`${said}. Finished after 120 versions`), said);
  await page.goto("about:blank");
  await page.goto(`${address}#anna`);
  await page.waitForFunction(() => /^anna walks [\d.]+ m\. Finished/.test(document.getElementById("status").textContent), { timeout: 120_000 });
  check((await text(page, "status")).startsWith(said.replace("Anna", "anna")), `the link shows it being born: ${said}`);
  await page.goto("about:blank");
  await page.goto(`${address}#Anna+%3Cb%3EBen%20%F0%9F%A4%96`);
  await until(page, "two names race", () => globalThis.race.lanes.length === 2 && globalThis.race.lanes.every(({ walk }) => walk));
  check(await page.$$eval("#lanes > div:not([hidden]) span", all => all.map(name => name.textContent).join()) === "Anna,<b>Ben \u{1f916}", "as text");
  await page.waitForFunction(() => / won the race: | tie: /.test(document.getElementById("saved").textContent), { timeout: 240_000 });
  await until(page, "the winner is on the stage, at the same address", () => location.hash.startsWith("#Anna+") && / walks [\d.]+ m\. This robot is finished/.test(document.getElementById("status").textContent));
  console.log(`     ${await text(page, "saved")}`);
  await close(page, faults);
}

/** Robots of other versions, of other lattices, too short, too long, not text, and scenes with absurd numbers. */
async function hostileLinks(browser, address) {
  const robot = new URLSearchParams(HELLO.link.slice(1)).get("robot");
  const creature = (robot, more = "") => `#scene=creature&seed=1${more}&robot=${encodeURIComponent(robot)}`;
  const set = setting => `#scene=creature&set=${encodeURIComponent(setting)}`;
  const hostile = [
    creature(""), creature("AQ"), creature(robot.slice(0, 40)), creature(`${robot}AAAA`), creature(`B${robot.slice(1)}`),
    ...[bytes => bytes.slice(0, 2), bytes => bytes.slice(0, 40), bytes => [...bytes, 0, 0, 0], bytes => bytes.with(0, 2), bytes => bytes.with(1, 255), bytes => bytes.with(6, 255)].map(change => creature(toText(change(toBytes(robot))))),
    creature("A".repeat(100_000)), creature("%00%ff"), creature("<img src=x onerror=alert(1)>"), creature("\u{1f916}"), creature(robot, "&set=lattice.columns%3D5"),
    creature(robot, "&set=controller.goals%3D%22given%22"), `#scene=errand&robot=${robot}`, `#scene=large&robot=${robot}`,
    "#scene=", "#scene=<script>alert(1)</script>", "#scene=../../etc/passwd", `#scene=${"x".repeat(50_000)}`, "#seed=-1", "#seed=1e400", "#%E0%A4%A",
    set("lattice.columns=1e9"), set("lattice.columns=-3"), set("physics.gravity=nan"), set("physics.steps=0"), set("__proto__.x=1"), set("base=\"earth\""), set(`${"x".repeat(20_000)}=1`),
    `#scene=${encodeURIComponent("x y ".repeat(9000))}`, set("lattice.columns=64") + "&set=lattice.rows%3D64", set("physics.gravity=1\nphysics.steps=64"),
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
      if (faults.length > 0 || scene === "" || says.length > 1000 || /\S{42}/.test(says)) bad.push(`${link.slice(0, 80)}: ${says} ${faults}`);
    } catch (error) {
      bad.push(`${link.slice(0, 80)}: ${error.message} ${faults}`);
    }
    await page.close();
  }
  check(bad.length === 0, `${hostile.length} hostile links: each shows a robot and, where it is wrong, the reason${bad.map(link => `\n       ${link}`).join("")}`);
}

/** If a link cannot be opened, the page shows the reason and another robot. */
export async function refusedLinks(browser, address) {
  await hostileLinks(browser, address);
  for (const [link, reason, shows] of [
    ["#scene=stabilty&seed=1", "\"stabilty\" is not a scene of this page", "creature"],
    ["#scene=incline&set=lattice.columns%3D1", "`lattice.columns` is out of range: 1; allowed: a whole number from 2 to 64", "incline"],
    ["#scene=incline&set=lattice.colums%3D3", "did you mean `columns`?", "incline"],
    ["#scene=creature&robot=AQ", "the robot in this link is damaged; copy the whole link", "creature"],
    [`#scene=creature&robot=${toText([2, 16])}`, "the robot in this link has an unknown format", "creature"],
    ["#scene=creature&set=lattice.columns%3D64&set=lattice.rows%3D64", "make 4096 nodes; the memory of a browser is enough for 1024", "creature"],
    ["#scene=creature&set=physics.gravity%3D1%0Aphysics.steps%3D64", "a setting sets one key, and this one sets 2", "creature"],
  ]) {
    const { page, faults } = await open(browser, address + link, { height: 900 });
    await ready(page);
    await page.waitForFunction(() => document.getElementById("refusal").textContent !== "", { timeout: 5000 });
    const said = await text(page, "refusal");
    const { top, bottom } = await page.$eval("#refusal", element => element.getBoundingClientRect().toJSON());
    check(!/--set|\^/.test(said), "without an option of the command line and without a caret");
    check(said.includes(reason) && said.includes(`shows the scene ${shows}`) && await value(page, "scene") === shows, `${link}: ${said.replaceAll("\n", " ")}`);
    check(top > 0 && bottom <= 900, `in sight: from ${Math.round(top)} to ${Math.round(bottom)} px of 900`);
    await close(page, faults);
  }
}

/** What the page says about the robot: the headline, the sentence without the attempts, and the verdict. */
async function said(page) {
  await page.waitForFunction(() => document.getElementById("along-title").textContent.startsWith("typical distance"), { timeout: 20_000 });
  const [status] = /Typically .* stiffness\.|It walks .* trials\./.exec(await text(page, "status")) ?? [];
  return JSON.stringify([await text(page, "along"), status, await text(page, "verdict")]);
}

/** The address holds a finished or edited robot: a refresh shows the same robot again, and Back returns to it. */
export async function links(browser, address) {
  const { page, faults } = await open(browser, address + SMALL);
  await ready(page);
  await press(page, "design");
  await says(page, "Design another");
  await until(page, "the address holds the finished robot", () => location.hash.includes("robot="));
  const designed = { url: page.url(), said: await said(page) };
  await press(page, "next");
  await page.click("[name=material][value='1']");
  await until(page, "and the edited one", url => location.hash.includes("robot=") && location.href !== url, designed.url);
  const edited = { url: page.url(), said: await said(page) };
  await goBack(page);
  await until(page, "Back undoes the edit, and keeps the attempts", () => document.getElementById("status").textContent.startsWith("Finished after 120 versions"));
  check(await said(page) === designed.said && await isStripped(page), "as they were");
  await lookAt(page, 36);
  await page.evaluate(robot => { location.hash = robot; }, HELLO.link);
  await until(page, "another link in the address opens another robot", () => document.getElementById("status").textContent.startsWith("This robot is finished"));
  check(!(await isStripped(page)), "which has no attempts");
  await goBack(page);
  await until(page, "Back returns to the robot and its attempts", () => document.getElementById("status").textContent.startsWith("Finished after 120 versions"));
  check(await said(page) === designed.said && await isStripped(page), "as they were");
  await lookAt(page, 36);
  for (const { url, said: before } of [designed, edited]) {
    await page.goto("about:blank");
    await page.goto(url);
    await until(page, "the link opens the robot", () => document.getElementById("status").textContent.startsWith("This robot is finished"));
    const after = await said(page);
    check(after === before, `the same robot: ${after}${after === before ? "" : `, not ${before}`}`);
  }
  await unfold(page);
  await page.select("#chip-size", "small");
  await until(page, "another size begins another design", () => location.hash.includes("lattice.columns%3D4") && !location.hash.includes("robot="));
  await until(page, "a design", () => Number.parseInt(document.getElementById("iteration").textContent, 10) > 0);
  await goBack(page);
  await page.waitForSelector("#leave[open]");
  await press(page, "go");
  await until(page, "Back returns to the robot, but asks before a design is lost", () => document.getElementById("status").textContent.startsWith("This robot is finished"));
  await page.reload();
  await until(page, "so does a refresh", () => document.getElementById("status").textContent.startsWith("This robot is finished"));
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

const isStripped = page => page.$eval("#strip", strip => strip.clientHeight > 0 && strip.getAttribute("aria-valuemax") === "120");

/** Looks at an attempt. The words, the headline and the flag are about this attempt. */
async function lookAt(page, attempt) {
  await page.focus("#strip");
  await page.keyboard.press("Home");
  for (let k = 0; k < attempt; k++) await page.keyboard.press("ArrowRight");
  const status = await text(page, "status");
  const far = await text(page, "along");
  check(status.startsWith(`Version ${attempt} of 120: it walks ${far}.`) && await text(page, "iteration") === `${attempt} / 120` && await text(page, "verdict") === "", `the words describe the attempt: ${status}`);
  await agree(page, `attempt ${attempt}`);
  const before = page.url();
  await page.$eval("#stage", stage => stage.click());
  await page.focus("#strip");
  await page.keyboard.press("End");
  check(page.url() === before, "the finished robot is not edited by a click on an attempt");
}

/** The headline, the flag's label and the flag's place on the axis are the same distance. */
export async function agree(page, what) {
  const headline = await text(page, "along");
  const { goal, goalLabel, origin, cos } = await page.evaluate(() => globalThis.onStage());
  const far = Number.parseFloat(headline);
  // Short distances have no flag.
  if (far < 0.06) return check(goal === null || goalLabel === headline, `${what}: ${headline}, no flag`);
  const at = (goal?.[0] - origin) / cos;
  check(goalLabel === headline && Math.abs(at - far) < 0.006, `${what}: the headline says ${headline} (${await text(page, "along-title")}), the flag ${goalLabel}, the axis ${at.toFixed(3)} m`);
}

/** The headline is the distance to quote: it is within the range that the page states. */
export async function headlines(browser, address) {
  const { page, faults } = await open(browser, address + HELLO.link);
  await said(page);
  const [median, low, high] = /walks ([\d.]+) m in [\d.]+ s: ([\d.]+) (?:to ([\d.]+) )?m in/.exec(await text(page, "status")).slice(1).map(Number);
  check(Number.parseFloat(await text(page, "along")) === median && low <= median && median <= (high || low), `the headline is the median: ${await text(page, "status")}`);
  await agree(page, "a finished robot");
  await page.evaluate(() => globalThis.push([1, 0.5]));
  await until(page, "a push", () => document.getElementById("status").textContent.startsWith("You pushed the robot"));
  await agree(page, "after a push");
  await page.select("#chip-gravity", "Moon");
  await until(page, "on the Moon", () => document.getElementById("status").textContent.startsWith("The same robot"));
  await agree(page, "on the Moon");
  await page.select("#chip-ground", "uphill");
  await until(page, "and uphill", () => document.getElementById("status").textContent.includes("uphill"));
  await agree(page, "uphill on the Moon");
  await close(page, faults);
}

/** A change of the scene during a design asks. */
export async function asks(browser, address) {
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
  const before = page.url();
  await winning(page);
  if (page.url() !== before) await goBack(page);
  check(page.url() === before, "Back leads to the robot before the race, if another one has won");
  const isEarly = () => document.getElementById("status").textContent === "Loading …" && !document.getElementById("design").disabled;
  check(!(await page.evaluate(isEarly)), "nothing can be designed before the page has loaded");
  await ready(page);
  await unfold(page);
  await press(page, "other");
  // The robot to which Back returned is finished, too.
  await says(page, "Pause");
  await says(page, "Design another");
  await page.focus("#strip");
  await page.keyboard.press("Home");
  check((await text(page, "iteration")).startsWith("0 /"), "the strip shows the first attempt by a key");
  const box = await boxOf(page, "#strip");
  await page.mouse.click(box.x + box.width / 2, box.y + 20);
  check((await text(page, "iteration")).startsWith("60 /"), `and another by a click: ${await text(page, "iteration")}`);
  await close(page, faults);
}
