// Tests of robots that walk on: to a goal, after a push, in another world.
import { toBytes } from "../page/packed.js";
import { OWN } from "../page/scene.js";
import { ready, says, text } from "./browsers.mjs";
import { SMALL, library, linkHas, linkTo, TOLD, HELLO, open, unfold, goBack, boxOf, check, press, value, until, set, wait, close } from "./helpers.mjs";

/** The positions of all nodes in the frames of a walk, in units. */
function framesOf({ counts }) {
  let at = counts[0].map(() => 0);
  return counts.map(moved => (at = at.map((count, k) => count + moved[k])));
}

/** A robot that is told the same goal again walks on as if nothing had happened: its state and its clock go on. */
export function goingOn() {
  const engine = library();
  engine.ask({ do: "begin", scene: { scene: "errand", settings: TOLD }, seed: 1 });
  const tell = (along, frame) => framesOf(engine.ask({ do: "tell", to: [along, 0], frame }).robot.walk);
  const apart = (walk, other) => Math.max(...walk.flatMap((frame, k) => frame.map((x, i) => Math.abs(x - other[k][i]))));
  const whole = tell(1, 4).slice(6, 16);
  const again = tell(1, 6).slice(0, 10);
  tell(1, 0);
  const other = tell(-1, 0).slice(0, 10);
  // Positions are rounded to units.
  check(apart(whole, again) <= 1, `a walk that is told the same goal goes on: ${apart(whole, again)} units apart`);
  check(apart(again, other) > 1, `with the goal behind, it does not: ${apart(again, other)} units apart`);
  for (const [request, reason] of [
    [{ do: "tell", to: [1, 0], frame: 9999 }, /`frame` is 9999; the walk has \d+ frames/],
    [{ do: "begin", scene: { scene: "stability", settings: TOLD.slice(0, 2) }, seed: 1 }, null],
    [{ do: "tell", to: [1, 0], frame: 0 }, /only robots with given goals can be told where to go/],
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

/** A robot walks in another world from its start, whatever it did before. */
export function visiting() {
  const engine = library();
  const bytes = toBytes(new URLSearchParams(HELLO.link.slice(1)).get("robot"));
  const home = () => engine.ask({ do: "open", scene: { scene: OWN.creature.toml, settings: [] }, bytes });
  const { world, robot } = home();
  const visit = (...settings) => engine.ask({ do: "visit", settings });
  const apart = (walk, other) => Math.max(...walk.flatMap((frame, k) => frame.map((x, i) => Math.abs(x - other[k][i]))));
  const own = framesOf(robot.walk);
  check(apart(framesOf(visit().robot.walk), own) === 0, "in a world without a difference a robot walks as in its own");
  const first = visit("physics.gravity=1.62");
  engine.ask({ do: "push", velocity: [1, 0, 0.5], frame: 30 });
  check(JSON.stringify(visit("physics.gravity=1.62")) === JSON.stringify(first), `on the Moon it walks ${first.robot.along.toFixed(2)} m, also after a push`);
  for (const setting of ["physics.gravity=1.62", "physics.incline_deg=8", "physics.incline_deg=-8"]) {
    home();
    const there = visit(setting);
    const solid = new Set(world.robot.edges.filter((_, e) => robot.materials[e] > 0).flat());
    const level = ([[x0, y0], [x1, y1]], x) => y0 + (x - x0) * (y1 - y0) / (x1 - x0);
    const lowest = (frame, { ground }) => Math.min(...[...solid].map(i => frame[2 * i + 1] * robot.walk.unit - level(ground, frame[2 * i] * robot.walk.unit)));
    const [before, after] = [lowest(own[0], world.world), lowest(framesOf(there.robot.walk)[0], there.world.world)];
    // Two positions are rounded to units.
    check(Math.abs(before - after) <= 2 * robot.walk.unit, `${setting}: its lowest foot is ${(1000 * before).toFixed(1)} mm above the ground before, ${(1000 * after).toFixed(1)} mm after`);
    check(there.robot.walk === null || apart(framesOf(there.robot.walk), own) > 1, "and it walks another way");
  }
  const { measured: { verdict } } = engine.judge();
  check(verdict[0][1][0].text.endsWith("m/s") && verdict.flatMap(([, items]) => items).every(({ level }) => /^(remark|good|doubtful|bad)$/.test(level)), `its verdict: ${verdict.map(([words, items]) => words + items.map(({ text }) => text).join(", ")).join(". ")}`);
}

/** The robot of a link is the robot of the page, bit for bit: its walk, its measurements and its verdict, also after
 * edits. */
export function judging() {
  const engine = library();
  const settings = new URLSearchParams(SMALL.slice(1)).getAll("set");
  engine.ask({ do: "begin", scene: { scene: "stability", settings }, seed: 1 });
  while (!engine.ask({ do: "iterate", shown: false }).done);
  const same = (a, b) => JSON.stringify(a) === JSON.stringify(b);
  const { robot, measured } = engine.ask({ do: "deliver", packed: true });
  const { bytes } = engine.ask({ do: "share" });
  const linked = library();
  const opened = linked.ask({ do: "open", scene: { scene: "stability", settings }, bytes });
  check(same(opened.robot, robot) && same(linked.judge().measured, measured), `the link is the robot: ${robot.along} m, ${measured.distance.p50} m`);
  check(same(engine.judge().measured, measured), "a delivery is judged like an edit");
  const other = robot.materials.with(robot.materials.indexOf(0), 2);
  for (const [from, first] of [["designed", engine], ["opened", linked]]) {
    const edited = first.ask({ do: "edit", materials: other });
    const judged = first.judge();
    const again = library();
    const link = first.ask({ do: "share" });
    const reopened = again.ask({ do: "open", scene: { scene: "stability", settings }, bytes: link.bytes });
    check(same(reopened.robot, edited.robot) && same(again.judge(), judged), `a muscle added to a robot that was ${from}: ${edited.robot.along} m, ${judged.measured.distance.p50} m`);
    first.ask({ do: "edit", materials: robot.materials });
    check(same(first.ask({ do: "share" }).bytes, bytes), "and taken away");
    check(same(first.ask({ do: "restore", bytes: link.bytes }).robot, edited.robot), "and restored by its link");
  }
}

/** The finished robot walks on in other worlds, and comes back with a click. */
export async function worlds(browser, address) {
  const { page, faults } = await open(browser, address + HELLO.link);
  await until(page, "a finished robot", () => document.getElementById("status").textContent.startsWith("This robot is finished"));
  await until(page, "it has a verdict", () => document.querySelector("#verdict span"));
  await until(page, "it walks in its own world", () => document.getElementById("along-title").textContent.startsWith("typical distance"));
  const [url, own] = [page.url(), await text(page, "along")];
  const says = (what, part) => until(page, what, part => document.getElementById("status").textContent.startsWith(`The same robot, now ${part}`), part);
  await page.select("#chip-gravity", "Moon");
  await says("on the Moon", "with the gravity of the Moon:");
  console.log(`     ${await text(page, "status")}`);
  await page.select("#chip-ground", "uphill");
  await says("uphill on the Moon", "with the gravity of the Moon and uphill:");
  await page.evaluate(() => globalThis.push([1, 1]));
  await until(page, "a push there", () => document.getElementById("status").textContent.startsWith("You pushed the robot"));
  await page.select("#chip-gravity", "Earth");
  await says("with its own gravity", "uphill:");
  check(await page.evaluate(linkHas, "&ground=uphill"), `the address holds the world, too: ${page.url().slice(-20)}`);
  await press(page, "home");
  await until(page, "a click brings it back", own => document.getElementById("along").textContent === own && document.getElementById("home").hidden && document.getElementById("chip-ground").value === "flat" && !location.hash.includes("ground="), own);
  await page.select("#chip-gravity", "Jupiter");
  await until(page, "on Jupiter", () => document.getElementById("status").textContent.startsWith("The same robot"));
  check(await text(page, "design") === "Design for this world", `the main button: ${await text(page, "design")}`);
  await press(page, "design");
  await until(page, "designs a robot for that world", () => location.hash.includes("gravity%3D24.8") && !location.hash.includes("robot=") && document.getElementById("design").textContent === "Pause");
  await goBack(page);
  if (await page.$("#leave[open]")) await press(page, "go");
  await until(page, "Back returns to the robot on Jupiter", () => document.getElementById("status").textContent.startsWith("The same robot, now with the gravity of Jupiter"));
  await press(page, "home");
  await until(page, "and home", url => location.href === url, url);
  await unfold(page);
  await press(page, "next");
  await page.click("[name=material][value='1']");
  await until(page, "an edit is in the address", url => location.href !== url, url);
  await goBack(page);
  await until(page, "Back undoes it", (url, own) => location.href === url && document.getElementById("along").textContent === own, url, own);
  await close(page, faults);
}

/** On the Moon the camera rises with the robot, no walk ends in mid-air, and a link brings others to the Moon. */
export async function moon(browser, address) {
  const { page, faults } = await open(browser, address + HELLO.link);
  await until(page, "a finished robot", () => document.querySelector("#verdict span"));
  await page.select("#chip-gravity", "Moon");
  await until(page, "on the Moon", () => document.getElementById("status").textContent.startsWith("The same robot"));
  await press(page, "link");
  await until(page, "its link", () => document.getElementById("saved").textContent.includes("link"));
  check(/[#&]gravity=Moon/.test(page.url()), await text(page, "saved"));
  for (const velocity of [[0, 1.5], [0.5, 1], [-0.5, 1.5]]) {
    await page.evaluate(velocity => globalThis.push(velocity), velocity);
    await until(page, `a push of ${velocity} m/s`, () => document.getElementById("status").textContent.startsWith("You pushed"));
    const { foot, playing } = await page.evaluate(() => globalThis.onStage());
    check(playing && Math.abs(foot) < 0.004, `its walk ends on the ground: ${(1000 * foot).toFixed(1)} mm above it`);
    if ((await text(page, "play")).startsWith("Pause")) await press(page, "play");
    const highest = await page.evaluate(() => {
      const time = document.getElementById("time");
      const tops = [];
      for (let at = 0; at < time.max; at += 0.1) {
        time.value = at;
        time.dispatchEvent(new Event("input"));
        tops.push(globalThis.onStage().box[1]);
      }
      return Math.min(...tops);
    });
    check(highest > 10, `the camera rises with it: it comes to ${highest.toFixed(0)} px below the upper edge`);
    await press(page, "play");
  }
  const end = Number(await page.$eval("#time", time => time.max));
  await set(page, "#time", String(end - 0.05));
  await until(page, "and goes on", end => globalThis.onStage().playing && globalThis.onStage().time > end + 0.5, end);
  const url = page.url();
  await page.goto("about:blank");
  await page.goto(url);
  await until(page, "the link leads to the Moon", () => document.getElementById("status").textContent.startsWith("The same robot, now with the gravity of the Moon"));
  check(await value(page, "chip-gravity") === "Moon" && page.url() === url, `and stays there: ${await text(page, "status")}`);
  await unfold(page);
  await press(page, "home");
  await until(page, "and back", () => document.getElementById("status").textContent.startsWith("This robot is finished") && !location.hash.includes("gravity="));
  // Two choices at once: the second must not leave the robot standing in mid-air.
  await page.evaluate(() => {
    for (const [id, choice] of [["chip-gravity", "Moon"], ["chip-size", "tall"]]) {
      document.getElementById(id).value = choice;
      document.getElementById(id).dispatchEvent(new Event("change"));
    }
  });
  await until(page, "a choice during another one", () => document.getElementById("design").textContent === "Pause" && globalThis.onStage().playing);
  await close(page, faults);
}

/** The robot goes where one clicks on the ground, and where the slider is moved by keys. */
export async function errand(browser, address) {
  const { page, faults } = await open(browser, address + linkTo("errand", TOLD));
  await ready(page);
  check(await page.$eval("#errand", row => row.getBoundingClientRect().height > 0), "a robot with given goals has the controls for its goal");
  check(await page.$eval("#race", button => button.disabled), "no race of robots that do not fit into a link");
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

/** A robot in space is seen in three quarters. Keys and a drag on the ground turn the view, and a drag on the robot pushes it. */
export async function space(browser, address) {
  const cubes = ["lattice.kind=\"cubic\"", "lattice.depth=2"].map(setting => `&set=${encodeURIComponent(setting)}`).join("");
  const features = [{ name: "prefers-reduced-motion", value: "reduce" }];
  const { page, faults } = await open(browser, address + SMALL + cubes, { features });
  await ready(page);
  const view = () => page.evaluate(() => globalThis.onStage().view.map(Math.round));
  const isAt = async (...angles) => String(await view()) === String(angles);
  check(await isAt(-40, 18), `a robot in space is seen in three quarters: ${await view()}`);
  await press(page, "design");
  await says(page, "Design another");
  await page.focus("#stage");
  await page.keyboard.press("ArrowRight");
  await page.keyboard.press("ArrowUp");
  check(await isAt(-35, 23), `arrow keys turn the view: ${await view()}`);
  await page.keyboard.press("Home");
  check(await isAt(-40, 18), "Home turns it back");
  const drag = async ([x, y], [dx, dy]) => {
    await page.mouse.move(x, y);
    await page.mouse.down();
    await page.mouse.move(x + dx, y + dy, { steps: 4 });
    await page.mouse.up();
  };
  const { x, y, width, height } = await boxOf(page, "#stage");
  const before = await text(page, "status");
  await drag([x + 0.06 * width, y + 0.9 * height], [50, -20]);
  check(await isAt(-20, 10) && before === await text(page, "status"), `a drag on the ground turns the view: ${await view()}`);
  const robot = await page.evaluate(() => globalThis.onStage().box);
  await drag([x + (robot[0] + robot[2]) / 2, y + (robot[1] + robot[3]) / 2], [60, -60]);
  await until(page, "a drag on the robot pushes it", () => /^(You pushed|After your push)/.test(document.getElementById("status").textContent));
  check(await isAt(-20, 10), "and does not turn the view");
  await close(page, faults);
}

/** A robot in space goes to a click on any side of it. */
export async function aside(browser, address) {
  const { page, faults } = await open(browser, address + linkTo("scout", [...TOLD, "lattice.rows=2"]));
  await ready(page);
  const box = await boxOf(page, "#stage");
  for (const [right, down, side] of [[0.75, 0.5, "left"], [0.4, 0.95, "right"]]) {
    await page.mouse.click(box.x + right * box.width, box.y + down * box.height);
    await until(page, `a click to its ${side}`, side => RegExp(`^Told to go to .* m to the ${side}[.:]`).test(document.getElementById("status").textContent), side);
    console.log(`     ${await text(page, "status")}`);
  }
  await close(page, faults);
}
