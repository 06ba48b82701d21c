// Tests of robots of real parts, with the lists for a workshop, and of the race against evolution.
import { readFileSync } from "node:fs";
import { partsFile, driveFile } from "../page/shop.js";
import { open as openPage, ready, says, text } from "./browsers.mjs";
import { CAST, SMALL, boxOf, check, close, library, linkTo, open, press, saved, set, until } from "./helpers.mjs";
import { OWN } from "../page/scene.js";
import { toBytes } from "../page/packed.js";

const rowsOf = csv => csv.trim().split("\n").map(line => line.split(","));

/** Opens a robot of the parade in the library. */
function opened(engine, robot) {
  const link = new URLSearchParams(robot.link.slice(1));
  const scene = { scene: OWN[link.get("scene")]?.toml ?? link.get("scene"), settings: link.getAll("set") };
  return engine.ask({ do: "open", scene, bytes: toBytes(link.get("robot")) }).robot;
}

/** A robot in space that comes from a link can be edited, and goes into a link again. */
export function editingInSpace() {
  const engine = library();
  const robot = CAST.find(({ name }) => name === "three dimensions");
  const { materials, along } = opened(engine, robot);
  const edited = engine.ask({ do: "edit", materials: materials.with(0, (materials[0] + 1) % 3) }).robot.along;
  check(edited !== along, `an edit of a robot in space: ${edited.toFixed(2)} m in place of ${along.toFixed(2)} m`);
  engine.ask({ do: "edit", materials: null });
  check(Buffer.from(engine.ask({ do: "share" }).bytes).equals(Buffer.from(toBytes(new URLSearchParams(robot.link.slice(1)).get("robot")))), "and back to the robot of its link");
}

/** The lists of the library: together the parts weigh what the verdict says, and the set points repeat. */
export function listing() {
  const engine = library();
  const robot = CAST.find(({ name }) => name === "could be built");
  const { measured } = robot;
  opened(engine, robot);
  const lists = engine.ask({ do: "shop" });
  const [head, ...parts] = rowsOf(partsFile(lists));
  check(head.join() === "part,number,length,mass,places", "parts.csv has the columns of `cosmic export`");
  const mass = parts.reduce((sum, [, number, , mass]) => sum + number * mass, 0);
  const said = Number(/([0-9.]+) kg/.exec(JSON.stringify(measured.verdict))[1]);
  check(Math.abs(mass - said) < 0.006, `together the parts weigh ${mass.toFixed(3)} kg, the verdict says ${said} kg`);
  const has = name => parts.filter(([part]) => part === name).reduce((sum, [, number]) => sum + Number(number), 0);
  check(has("joint") === 2 * (has("tube") + has("device")) && has("device") > 0, `${has("tube")} tubes and ${has("device")} cylinders have ${has("joint")} joints`);
  const [times, ...moments] = rowsOf(driveFile(lists));
  check(times.length === has("device") + 1 && moments.length === 101, `drive.csv has ${times.length - 1} columns of lengths`);
  const shift = moments[0].slice(1).map((length, k) => Math.abs(length - moments.at(-1)[k + 1]));
  check(Math.max(...shift) < 1e-8, "and its last row is the first again");
}

/** An evolution repeats its numbers, and its best robot never gets worse. */
export function evolving() {
  const settings = new URLSearchParams(SMALL.slice(1)).getAll("set");
  const run = () => {
    const engine = library();
    engine.ask({ do: "begin", scene: { scene: "stability", settings }, seed: 3 });
    return Array.from({ length: 12 }, () => engine.ask({ do: "evolve", tries: 25 }));
  };
  const answers = run();
  const far = answers.flatMap(({ robot }) => robot === null ? [] : [robot.along]);
  check(answers.at(-1).tries === 300 && far.every((x, k) => k === 0 || x > far[k - 1]), `300 robots of an evolution walk ${far.map(x => x.toFixed(2)).join(", ")} m`);
  check(JSON.stringify(run()) === JSON.stringify(answers), "and the same again with the same seed");
}

/** During the parade the switch for real parts takes the robot of the parade. */
export async function choosing(browser, address) {
  const { page, faults } = await openPage(browser, address);
  await page.waitForSelector("#parade button");
  await press(page, "real");
  await until(page, "the switch takes the robot of real parts from the parade", () => document.getElementById("status").textContent.startsWith("This robot is finished"));
  check(await page.$eval("#real", button => button.getAttribute("aria-pressed")) === "true" && page.url().includes("scene=real_parts"), "and is on");
  await close(page, faults);
}

/** The switch for real parts leads to a robot that could be built, with its lists. */
export async function building(browser, address, folder) {
  const { page, faults } = await open(browser, address);
  await ready(page);
  await press(page, "real");
  await until(page, "a robot of real parts", () => document.querySelector("#verdict span"));
  const isOn = () => page.$eval("#real", button => button.getAttribute("aria-pressed"));
  check(await isOn() === "true", "its switch is on");
  check(await page.$("#verdict .bad") === null, await text(page, "verdict"));
  await until(page, "its parts are listed", () => document.querySelectorAll("#shop:not([hidden]) #pieces tr").length > 4);
  check((await page.$$("#drive tr")).length === 12, "with a period of its muscles");
  if (folder !== null) {
    await press(page, "save-pieces");
    await press(page, "save-drive");
    const [parts, drive] = [await saved(folder, /^parts\.csv$/), await saved(folder, /^drive\.csv$/)].map(path => readFileSync(path, "utf8"));
    check(parts.includes("\ntube,") && drive.startsWith("time,length_"), "both lists are saved");
  }
  await press(page, "real");
  await says(page, "Pause");
  check(await isOn() === "false" && page.url().includes("scene=creature"), "the switch leads back, and a design begins");
  check(await page.$eval("#shop", section => section.hidden), "without lists");
  await close(page, faults);
}

/** An evolution races the design in a lane of its own. */
export async function twins(browser, address) {
  const { page, faults } = await open(browser, address + linkTo("creature", []));
  await ready(page);
  await press(page, "design");
  await page.waitForSelector("#twin:enabled");
  await boxOf(page, "footer");
  await press(page, "twin");
  await until(page, "evolution has a lane", () => /^evolution, \d+ tries: -?\d/.test(globalThis.onStage().lane));
  check(/^Evolution needed \d+ robots and [\d.]+ s to walk/.test(await text(page, "status")), await text(page, "status"));
  await until(page, "it is compared by time, too", () => /; the gradient needed \d+ versions? and [\d.]+ s\. /.test(document.getElementById("status").textContent));
  const { top, bottom } = await page.$eval("#stage", stage => stage.getBoundingClientRect().toJSON());
  check(top > -1 && bottom <= 900, `its lane is in view: from ${Math.round(top)} to ${Math.round(bottom)} px`);
  await says(page, "Design another");
  await until(page, "it goes on beside the finished robot", () => /^evolution, \d+ tries/.test(globalThis.onStage().lane));
  await press(page, "twin");
  await until(page, "it ends", () => globalThis.onStage().lane === null && document.getElementById("twin").textContent === "Race evolution");
  await press(page, "twin");
  await until(page, "it can be begun again", () => globalThis.onStage().lane !== null);
  await press(page, "other");
  await says(page, "Pause");
  check(await text(page, "twin") === "Race evolution", "another seed ends it");
  await says(page, "Design another");
  await press(page, "twin");
  await until(page, "a third one", () => globalThis.onStage().lane !== null);
  await page.evaluate(() => globalThis.push([0.3, 0.5]));
  await until(page, "a push ends it", () => document.getElementById("status").textContent.startsWith("You pushed") && document.getElementById("twin").textContent === "Race evolution");
  await press(page, "twin");
  await until(page, "which leads home first", () => globalThis.onStage().lane !== null && document.getElementById("home").hidden);
  await set(page, "[name='physics.incline_deg']", "95");
  await until(page, "a setting that cannot be used ends it", () => document.getElementById("twin").textContent === "Race evolution" && document.getElementById("twin").disabled);
  await close(page, faults);
}
