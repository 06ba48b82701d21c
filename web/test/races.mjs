// Tests of the race of seeds: its lanes, what they say, and what is left when it ends.
import { ready, text } from "./browsers.mjs";
import { SMALL, check, close, goBack, library, open, press, until } from "./helpers.mjs";

/** A lane shows the latest robot after every attempt whose number is a multiple of this. */
const SHOWN = 5;
/** A scene whose race takes longer than the tests. */
const LONG = SMALL.replace("iterations%3D120", "iterations%3D2000");

/** Runs on a page: gives it processors for three lanes, and counts the workers that it starts from now on. */
const count = () => {
  Object.defineProperty(navigator, "hardwareConcurrency", { value: 4 });
  globalThis.workers = 0;
  globalThis.Worker = class extends Worker {
    constructor(...given) {
      super(...given);
      globalThis.workers += 1;
    }

    terminate() {
      super.terminate();
      globalThis.workers -= 1;
    }
  };
};

/** Whether all lanes have a robot after so many attempts. */
const areAt = attempts => globalThis.race.lanes.length > 1 && globalThis.race.lanes.every(({ attempt }) => Number.parseInt(attempt.textContent.slice(8), 10) >= attempts);

/**
 * What the lanes show: whether a robot is above the ground, the distance that it walks as text, and whether the payload is
 * drawn at this distance.
 */
const lanes = () => {
  const { lanes } = globalThis.race;
  const place = document.getElementById("lanes");
  const [start, best] = ["--start", "--best"].map(name => Number.parseFloat(place.style.getPropertyValue(name)));
  const far = Number.parseFloat(place.querySelector(".best").textContent.slice(5));
  const orange = [0xd9, 0x7a, 0x00];
  return lanes.map(({ seed, walk, attempt, distance, canvas, stage }) => {
    const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    const { left } = canvas.getBoundingClientRect();
    const lines = [start, best].map(at => stage.groundAt(left + at, 0)[0] - walk.world.origin);
    const walked = walk.at(walk.duration).metres;
    const x = Math.round((start + (best - start) * (walked - lines[0]) / (lines[1] - lines[0])) * canvas.width / canvas.clientWidth);
    const isOrange = pixel => orange.every((part, c) => Math.abs(data[4 * pixel + c] - part) < 12);
    const rows = Array.from({ length: canvas.height }, (_, row) => row * canvas.width + x);
    return {
      seed, attempt: Number.parseInt(attempt.textContent.slice(8), 10), text: distance.textContent,
      isDrawn: data.subarray(0, 4 * canvas.width * Math.floor(0.6 * canvas.height)).some((part, k) => k % 4 === 3 && part > 100),
      isThere: rows.some(pixel => [-1, 0, 1].some(aside => isOrange(pixel + aside))),
      walked, lines, far, box: stage.box.join(),
    };
  });
};

/** Whether the lines are at the start and at the best distance of a lane, on flat ground. */
const sameScale = ({ lines: [start, best], far }) => Math.abs(start) < 0.002 && Math.abs(best - far) < 0.007;

const runs = page => page.evaluate(() => [globalThis.workers, !document.getElementById("lanes").hidden, globalThis.race.runs]);
const isOver = page => runs(page).then(state => String(state) === "0,false,false");

/** Starts a race, and waits until all lanes have walks. */
async function start(page, attempts = SHOWN) {
  await press(page, "race");
  await until(page, "a race of three seeds", areAt, attempts);
}

/** Seeds race in lanes. A race that ends early leaves no workers, and the page as it was. */
export async function racing(browser, address) {
  const { page, faults } = await open(browser, address + LONG);
  await ready(page);
  await page.evaluate(count);
  const before = [page.url(), await text(page, "status")];
  await start(page, 2 * SHOWN);
  const first = await page.evaluate(lanes);
  check(String(await runs(page)) === "3,true,true" && first.every(({ isDrawn }) => isDrawn), "a robot is in each of three lanes");
  check(first.every(sameScale), `all lanes have the same scale, with a line at the start and at the best distance, ${first[0].far} m`);
  const engine = library();
  const [, settings] = LONG.match(/&(set=.*)/);
  const scene = { scene: "stability", settings: new URLSearchParams(settings).getAll("set") };
  const walks = first.map(({ seed, attempt }) => {
    engine.ask({ do: "begin", scene, seed });
    let far;
    for (let k = 1; k <= attempt - attempt % SHOWN; k++) far = engine.ask({ do: "iterate", shown: k % SHOWN === 0 }).robot?.along;
    return far;
  });
  const said = first.map(({ seed, attempt, text }) => `seed ${seed}: ${text} after ${attempt} attempts`).join(", ");
  check(first.every(({ text, walked }, k) => text === `${walks[k].toFixed(2)} m` && Math.abs(walked - walks[k]) < 0.01), `the distances are those of the walks: ${said}`);
  const ahead = await page.$$eval("#lanes > div", all => all.map(lane => lane.classList.contains("leads")));
  check(ahead.filter(Boolean).length === 1, "one robot leads");
  await until(page, "the robots walk", before => globalThis.race.lanes.every(({ stage }, k) => stage.box.join() !== before[k]), first.map(({ box }) => box));
  const labels = await page.$$eval("#lanes > :not([hidden])[role], #lanes > :not([hidden]) [role]", parts => parts.map(part => part.getAttribute("aria-label")));
  check(labels.length === 6 && labels[0] === "Seed 1" && await page.$eval("#lanes", place => place.closest("[aria-live], [role=status]") === null && !place.querySelector("[aria-live], [role=status]")), `labels for screen readers, which do not read every attempt: ${labels.slice(0, 2).join(", ")}`);
  console.log(`     a frame of three lanes takes ${(await page.evaluate(() => globalThis.race.cost.total / globalThis.race.cost.frames)).toFixed(2)} ms of script`);
  await press(page, "race");
  check(await isOver(page) && page.url() === before[0] && await text(page, "status") === before[1] && await text(page, "race") === "Race of seeds", "a second press ends it, without workers, and leaves the page as it was");
  await start(page);
  await press(page, "design");
  check(await isOver(page) && await text(page, "design") === "Design a robot", "the main button ends it");
  await start(page);
  await page.select("#chip-gravity", "Mars");
  await until(page, "another scene ends it", () => globalThis.workers === 0 && document.getElementById("lanes").hidden && location.hash.includes("3.7"));
  await page.evaluate(() => { location.hash = location.hash.replace("seed=1", "seed=5"); });
  await until(page, "another link", () => document.getElementById("seed").value === "5" && !document.getElementById("design").disabled);
  await start(page);
  check(await page.evaluate(() => globalThis.race.lanes[0].seed) === 5, "a race begins with the seed of the page");
  await goBack(page);
  await until(page, "Back ends it", () => globalThis.workers === 0 && document.getElementById("lanes").hidden && document.getElementById("seed").value === "1");
  await close(page, faults);
}

/** With reduced motion, the robots stand at the end of their walk. Robots in space race, too. */
export async function standing(browser, address) {
  const features = [{ name: "prefers-reduced-motion", value: "reduce" }, { name: "prefers-color-scheme", value: "light" }];
  const cubes = ["lattice.kind=\"cubic\"", "lattice.depth=2"].map(setting => `&set=${encodeURIComponent(setting)}`).join("");
  for (const [more, says] of [["", "with reduced motion"], [cubes, "and in space"]]) {
    const { page, faults } = await open(browser, address + SMALL + more, { features });
    await ready(page);
    await page.evaluate(count);
    await start(page, 50);
    const all = await page.evaluate(lanes);
    const distances = all.map(({ text }) => text).join(", ");
    check(await page.evaluate(() => globalThis.race.cost.frames) === 0 && all.every(({ isDrawn, isThere }) => isDrawn && isThere), `${says} the robots stand at the end of their walk: ${distances}`);
    check(all.every(sameScale), "all lanes have the same scale");
    await press(page, "race");
    await close(page, faults);
  }
}

/** A race comes to its end on a page with a finished robot: the winner is opened. */
export async function winning(page) {
  await press(page, "race");
  await until(page, "a race of seeds", () => document.querySelectorAll("#lanes canvas").length > 1 && !document.getElementById("lanes").hidden);
  await page.waitForFunction(() => document.getElementById("saved").textContent.includes("won the race"), { timeout: 240_000 });
  const said = await text(page, "saved");
  const fars = await page.evaluate(() => globalThis.race.lanes.map(({ seed, far }) => [far, seed]));
  const [[most, winner], ...others] = fars.sort(([a], [b]) => b - a);
  check(said.startsWith(`Seed ${winner} won the race: ${most.toFixed(2)} m against `) && others.every(([far, seed]) => said.includes(`${far.toFixed(2)} m (seed ${seed})`)), said);
  await until(page, "the winner is on the stage with its distance", far => document.getElementById("along").textContent === far && document.getElementById("along-title").textContent.startsWith("typical distance") && location.hash.includes("robot="), `${most.toFixed(2)} m`);
}
