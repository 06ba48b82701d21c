// Tests of links, of Back and refresh, and of the questions before a robot is lost.
import { ready, says, text } from "./browsers.mjs";
import { SMALL, HELLO, open, unfold, goBack, boxOf, check, press, value, until, close } from "./helpers.mjs";

/** Robots of other versions, of other lattices, too short, too long, not text, and scenes with absurd numbers. */
async function hostileLinks(browser, address) {
  const robot = new URLSearchParams(HELLO.link.slice(1)).get("robot");
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
export async function refusedLinks(browser, address) {
  await hostileLinks(browser, address);
  for (const [link, reason, shows] of [
    ["#scene=stabilty&seed=1", "\"stabilty\" is not a scene of this page", "creature"],
    ["#scene=incline&set=lattice.columns%3D1", "out of range", "incline"],
  ]) {
    const { page, faults } = await open(browser, address + link, { height: 900 });
    await ready(page);
    await page.waitForFunction(() => document.getElementById("refusal").textContent !== "", { timeout: 5000 });
    const said = await text(page, "refusal");
    const { top, bottom } = await page.$eval("#refusal", element => element.getBoundingClientRect().toJSON());
    check(said.includes(reason) && said.includes(`shows the scene ${shows}`) && await value(page, "scene") === shows, `${link}: ${said.replaceAll("\n", " ")}`);
    check(top > 0 && bottom <= 900, `in sight: from ${Math.round(top)} to ${Math.round(bottom)} px of 900`);
    await close(page, faults);
  }
}

/** The address holds a finished or edited robot: a refresh shows it again, and Back returns to it. */
export async function links(browser, address) {
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
  await until(page, "the link opens the robot", () => document.getElementById("status").textContent.startsWith("This robot is finished. It walks"));
  const along = Number.parseFloat(await text(page, "along"));
  console.log(`     designed ${designed.along} m, in the link ${along} m, ${new URL(designed.url).hash.length} characters`);
  check(Number.isFinite(along), "and it walks");
  await unfold(page);
  await page.select("#chip-size", "small");
  await until(page, "another size begins another design", () => location.hash.includes("lattice.columns%3D4") && !location.hash.includes("robot="));
  await says(page, "Pause");
  await goBack(page);
  await until(page, "Back returns to the robot", () => document.getElementById("status").textContent.startsWith("This robot is finished. It walks"));
  await page.reload();
  await until(page, "so does a refresh", () => document.getElementById("status").textContent.startsWith("This robot is finished. It walks"));
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
  await press(page, "race");
  await until(page, "a race of seeds", () => document.querySelectorAll("#lanes progress").length > 1);
  await page.waitForFunction(() => document.getElementById("saved").textContent.includes("won the race"), { timeout: 60_000 });
  check(page.url().includes("robot="), await text(page, "saved"));
  await goBack(page);
  const isEarly = () => document.getElementById("status").textContent === "Loading …" && !document.getElementById("design").disabled;
  check(!(await page.evaluate(isEarly)), "nothing can be designed before the page has loaded");
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
