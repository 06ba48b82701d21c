// Connects the controls of the page with what they do.
/* global Stage: of robot.js; Ternary, Curve: of charts.js; decimals, levelAt: of drawing.js */

import { keepAddress, keepRobot, linked } from "./address.js";
import { Chips } from "./chips.js";
import { Client, Refused, Stopped } from "./client.js";
import { Design } from "./design.js";
import { Editor } from "./editor.js";
import { Errand } from "./errand.js";
import { filmKind, save } from "./film.js";
import { GroundEditor } from "./ground.js";
import { GREETING, hello, mayBegin } from "./hello.js";
import { toBytes, toText } from "./packed.js";
import { Player } from "./player.js";
import { progressOf } from "./progress.js";
import { Push } from "./push.js";
import { Race } from "./race.js";
import { Refusals } from "./refusal.js";
import { DEFAULT, OWN, Scene } from "./scene.js";
import { Strip } from "./strip.js";
import { Visit } from "./visit.js";
import { takeFilm, takeLink } from "./take.js";
import { headline, sentence, shownAs, showVerdict } from "./words.js";

const $ = id => document.getElementById(id);
/** After this many milliseconds, a computation can be cancelled. */
const LONG = 2000;
/** The distance of the first column of a lattice from the origin of the ground, in metres. */
const ORIGIN = 0.1;
/** The buttons that cannot be used before there is a robot. */
const LATER = ["design", "race", "back", "ahead", "latest", "save-film", "save-design", "save-scene"];
/** `?panic=5` makes the library panic after iteration 5, for tests. */
const panicAfter = new URLSearchParams(location.search).get("panic");

// The world that is shown before there is a robot.
const stage = new Stage($("stage"), { width: 2, ground: [[-9, 0], [9, 0]], cos: 1, limit: 1 });
const ternary = new Ternary($("ternary"));
const curve = new Curve($("curve"), x => look(Math.round(x)));
const strip = new Strip($("strip"), look);
const player = new Player(stage, tellTime, tellPlay);
const client = new Client(stopped);
const design = new Design(client, changed, panicAfter === null ? null : Number(panicAfter));
const scene = new Scene(client, $("settings"), mayChange, sceneKnown);
const ground = new GroundEditor($("ground"), points => scene.setGround(points));
const chips = new Chips(
  { ground: $("chip-ground"), gravity: $("chip-gravity"), size: $("chip-size") },
  chooseWorld,
);
const toLatest = () => { looked = null; };
/** Whether the finished robot is on the stage, and not an earlier attempt. */
const isShown = () => design.state === "finished" && looked === null;
const visit = new Visit({ scene, player, design, onvisit: toLatest });
const push = new Push({
  canvas: $("stage"), stage, player, design, isShown, onpush: toLatest, onerror: error => refusal.show(error),
});
const editor = new Editor({
  canvas: $("stage"), stage, player, isShown, onedit: toLatest, onerror: error => refusal.show(error),
  parts: {
    fieldset: $("editor"), legend: $("bar"), previous: $("previous"), next: $("next"), undo: $("undo"),
    materials: [...document.getElementsByName("material")],
  },
});
const errand = new Errand({
  canvas: $("stage"), stage, player, design, ontell: toLatest, onerror: error => refusal.show(error),
  parts: { row: $("errand"), slider: $("goal"), place: $("place") },
});
const refusal = new Refusals({ text: $("refusal"), details: $("details"), scene, before: $("status") });
const race = new Race($("lanes"));
/** The iteration that the user chose to see; null for the last iteration or the delivered robot. */
let looked = null;
let recording = null;
/** The timer for the next update of the main button. */
let waiting;
/** The walk of the finished robot that is on the stage until the page's own design takes it; null afterwards. */
let greeting = null;
/** That robot in the form that links have. */
let greeter = null;
/** The other world that the chips show; null for the robot's own world. */
let elsewhere = null;
async function greet() {
  if (linked || new URLSearchParams(location.search).has("wait")) return;
  const finished = await hello();
  if (finished === null || design.iteration > 0) return;
  greeting = finished.walk;
  greeter = new URLSearchParams(finished.link.slice(1)).get("robot");
  player.show(greeting, { restart: true });
  tellPlay();
  $("time").max = greeting.duration;
  $("attempt-title").textContent = "a finished robot";
  $("along-title").textContent = "distance so far";
  $("iteration").textContent = "";
  const next = mayBegin() ? "The next one is designed while you watch." : "Press “Design a robot” for another one.";
  $("status").textContent = designs ? `This robot is finished. ${next}` : "This robot is finished.";
  if (mayBegin()) setTimeout(endGreeting, GREETING);
}

/** Makes the robot that greets a finished robot of the page, which can be touched, in place of the page's own design. */
async function adopt() {
  if (greeting === null || !designs || scene.name !== DEFAULT || scene.changed.size > 0) return;
  const { time } = player;
  greeting = null;
  scene.robot = greeter;
  await scene.check();
  player.seek(time);
}

/** Gives the stage to the page's own design. */
function endGreeting() {
  if (greeting === null) return;
  // A lattice that does not walk yet is less to see than the finished robot.
  const walks = design.iteration > 0;
  if (!walks) return setTimeout(endGreeting, 250);
  greeting = null;
  changed(design.state);
  if (design.world !== null) show({ restart: true });
}

async function begin() {
  try {
    const scenes = await client.ask({ do: "scenes" });
    scenes.unshift(...Object.entries(OWN).map(([name, { about }]) => ({ name, about })));
    $("scene").replaceChildren(...scenes.map(({ name, about }) => Object.assign(new Option(name, name), { title: about })));
    await openAddress();
  } catch (error) {
    refusal.show(error);
  }
}

/** Opens what the address names. */
async function openAddress() {
  const names = [...$("scene").options].map(({ value }) => value);
  if (!names.includes(scene.name)) {
    return openInstead(DEFAULT, `${JSON.stringify(scene.name)} is not a scene of this page; expected one of ${names.join(", ")}.`);
  }
  // Something else may be opened in the meantime.
  if (!(await scene.check())) return;
  if (design.state === "empty") await openInstead(scene.name, $("refusal").textContent);
  if (design.state === "ready" && mayBegin()) await work();
}

/** Opens a built-in scene with its own settings, because the link cannot be opened. */
async function openInstead(name, reason) {
  scene.robot = null;
  await scene.choose(name);
  refusal.say(`The link cannot be opened: ${reason.trim()}\nThe page shows the scene ${name} instead.`);
}

/** Opens the address to which Back, a link or the user went. */
async function navigate() {
  if (!(await mayChange())) {
    // Back to the address of the design that goes on.
    history.pushState(null, "", scene.link);
    return;
  }
  greeting = null;
  scene.read();
  try {
    await openAddress();
  } catch (error) {
    refusal.show(error);
  }
}

/** Is called when the library has checked a scene. Prepares the robot, or shows the error. */
async function sceneKnown(error) {
  $("scene").value = scene.name;
  $("seed").value = scene.seed;
  refusal.forget();
  if (error) {
    design.abandon("empty");
    return refuse(error);
  }
  keepAddress(scene);
  const { settings, profile } = scene.checked;
  chips.show(settings);
  errand.open(settings);
  const columns = settings["lattice.columns"] - 1;
  ground.show(profile, ORIGIN + columns * settings["lattice.spacing"]);
  await prepare();
}

/** Asks before a change that would discard a design in progress. */
async function mayChange() {
  const busy = ["working", "paused", "measuring"].includes(design.state) && design.iteration > 0;
  // A computation that hangs can be left without a question.
  if (!busy || client.busyFor >= LONG) return true;
  $("leave").returnValue = "";
  $("leave").showModal();
  await new Promise(resolve => $("leave").addEventListener("close", resolve, { once: true }));
  return $("leave").returnValue === "go";
}

/** Makes a change. If a robot was being designed or finished, the next design begins at once. */
async function changeAndDesign(change) {
  const goesOn = !["empty", "preparing", "ready", "cancelled", "stopped"].includes(design.state);
  const changed = await change();
  if (scene.checked) chips.show(scene.checked.settings);
  if (changed && goesOn && design.state === "ready") await work();
}

/** Prepares the robot of the scene, or opens the robot of the link. */
async function prepare() {
  looked = null;
  recording?.abort();
  race.end();
  editor.open(null);
  try {
    if (scene.robot === null) {
      await design.prepare(scene.asked, scene.seed, scene.key);
    } else {
      if (toBytes(scene.robot) === null) throw new Refused("the robot in this link is not complete; copy the whole link");
      const { visited } = scene;
      await design.open(scene.asked, scene.robot, scene.key);
      await visit.arrive(visited);
      await design.judge();
    }
    return true;
  } catch (error) {
    // If the worker was stopped, the code that stopped it sets the next state.
    if (!(error instanceof Stopped)) design.abandon("empty");
    refuse(error);
    return false;
  }
}

/** Shows the error of a scene that cannot be used. */
function refuse(error) {
  refusal.show(error);
  if (error instanceof Refused) $("status").textContent = "This setting cannot be used.";
}

function stopped(message) {
  design.abandon("stopped");
  $("message").textContent = message;
  if (!$("stopped").open) $("stopped").showModal();
}

/** Returns the robot that is shown, and the record of its iteration. */
function shown() {
  if (looked !== null) return design.robots[looked];
  return design.told ?? design.delivered ?? design.robots.at(-1);
}

/** Whether the page can only wait for the worker. */
const waits = state => state === "preparing" || state === "measuring" || (state === "paused" && design.iterates);

function tellButton(state) {
  const words = { preparing: "Preparing …", working: "Pause", measuring: "Measuring …", paused: "Resume", finished: design.elsewhere ? "Design for this world" : "Design another" };
  const long = waits(state) && client.busyFor >= LONG;
  $("design").textContent = long ? "Cancel" : words[state] ?? "Design a robot";
  $("design").disabled = !long && ["empty", "stopped", "preparing", "measuring"].includes(state);
  clearTimeout(waiting);
  if (waits(state) && !long) waiting = setTimeout(() => tellButton(design.state), LONG / 4);
}

function changed(state) {
  const busy = state === "working" || state === "measuring";
  tellButton(state);
  $("home").hidden = state !== "finished" || design.told === null;
  $("home").textContent = design.elsewhere ? "Back to its own world" : "Back to its own walk";
  if (design.elsewhere !== elsewhere) {
    elsewhere = design.elsewhere;
    if (scene.checked !== null) chips.show(visit.settings);
  }
  $("save-design").disabled = state !== "finished";
  $("save-scene").disabled = scene.checked === null;
  // The winner of a race is opened from its link.
  $("race").disabled = scene.checked === null || scene.takesGoals;
  $("save-film").disabled = design.world === null || filmKind() === null || recording !== null;
  if (greeting !== null) {
    strip.draw({ robots: design.robots, attempts: design.world?.iterations ?? 1, shown: Math.max(0, design.iteration) });
    return;
  }
  tellStatus(state);
  if (design.world === null || ["stopped", "empty", "preparing", "cancelled"].includes(state)) return;
  if (state === "finished" && !$("stage").classList.contains("editable")) {
    looked = null;
    editor.open(design);
  }
  if (looked === null || !busy) show({ restart: state === "ready" });
  else drawCurve();
  // Another scene or robot may have been chosen that is not prepared yet.
  const isCurrent = design.key === scene.key && !scene.isChecking && !design.isReplacing;
  if (state === "finished" && isCurrent) keepRobot(scene, design);
}

/** Sets the flag: at the goal, or at the distance of the headline; during a design at the best distance so far. The best
 * robot so far is shown as a ghost; after an edit, it is the robot before the edit. */
function flag(far) {
  const { best, delivered, place } = design;
  player.goal = errand.show();
  player.goalLabel = "";
  const designed = delivered?.designed.walk ?? null;
  player.ghost = delivered ? (delivered.walk === designed ? null : designed) : best?.walk ?? null;
  if (player.goal !== null || place === null) return;
  const isBest = looked === null && delivered === null;
  const to = isBest ? best?.walk.along : far;
  if (!(to > 0.05)) return;
  const { origin, cos, ground } = player.walk.world;
  const foot = origin + to * cos;
  player.goal = [foot, 0, levelAt(ground, foot)];
  player.goalLabel = `${isBest ? "best " : ""}${shownAs(to)}`;
}

function show(how = {}) {
  greeting = null;
  const { walk } = shown();
  const isDelivered = looked === null && design.delivered !== null;
  const goesOn = walk === design.told?.walk;
  if (player.walk !== walk) player.show(walk, { ...how, withVoid: isDelivered, goesOn, stops: goesOn && design.told.along !== null });
  const { far, title } = headline({ walk, looked, design });
  flag(far);
  if (!player.playing) player.paint();
  tellPlay();
  $("time").max = walk.duration;
  $("along").textContent = shownAs(far);
  $("along-title").textContent = title;
  const number = looked ?? design.iteration;
  const came = design.delivered !== null && !design.hasAttempts;
  $("strip").classList.toggle("empty", came);
  $("attempt-title").textContent = came ? "a finished robot" : "attempt";
  $("iteration").textContent = came ? "" : `${number} / ${design.world.iterations}`;
  $("back").disabled = number === 0;
  $("ahead").disabled = $("latest").disabled = looked === null;
  $("stage").classList.toggle("earlier", looked !== null);
  ternary.draw({ mixtures: walk.mixtures, delivered: walk.materials, highlight: player.highlight });
  drawCurve();
  describe(walk);
  tellStatus(design.state);
}

function look(iteration) {
  if (design.world === null) return;
  const within = Math.min(design.iteration, Math.max(0, iteration));
  looked = within === design.iteration && design.state !== "finished" ? null : within;
  show();
}

function step(by) {
  const at = looked ?? (design.delivered ? design.iteration + 1 : design.iteration);
  if (at + by > design.iteration) looked = null;
  else looked = Math.max(0, at + by);
  show();
}

function drawCurve() {
  const attempt = looked ?? design.iteration;
  strip.draw({ robots: design.robots, attempts: design.world.iterations, shown: attempt });
  curve.draw(progressOf(design, attempt));
}

function describe(walk) {
  const far = walk.along === null ? "its walk diverges" : `it walks ${shownAs(walk.along)}`;
  $("stage").setAttribute("aria-label", `Robot of ${walk.count(1)} bones and ${walk.count(2)} muscles; ${far} in ${walk.duration.toFixed(1)} s. Shift with arrow keys turns the view, Home resets it`);
  const solid = walk.materials.length - walk.count(0);
  $("ternary").setAttribute("aria-label", `Mixtures of ${walk.materials.length} bars: ${solid} are mostly solid, ${walk.count(2)} of them actuators`);
}

function tellStatus(state) {
  // Screen readers do not read texts that change with every iteration.
  $("status").setAttribute("aria-live", state === "working" ? "off" : "polite");
  $("status").textContent = sentence(state, design, looked);
  showVerdict($("verdict"), (isShown() && design.told === null && design.delivered.measured?.verdict) || []);
}

function tellTime(time) {
  $("time").value = time;
  $("clock").textContent = `${time.toFixed(1)} s`;
  if (greeting !== null) $("along").textContent = shownAs(greeting.at(time).metres);
}

// Controls.

function tellPlay() {
  $("play").textContent = player.playing ? "Pause walk" : "Play walk";
}

function togglePlay() {
  player.toggle();
  tellPlay();
}

async function pressDesign() {
  if ($("design").textContent === "Cancel") return cancel();
  greeting = null;
  if (design.state === "working") return design.pause();
  if (design.elsewhere) return changeAndDesign(() => scene.set(...Object.entries(design.elsewhere.settings)));
  if (design.state === "finished") return newSeed(scene.seed + 1);
  if (design.state === "cancelled" && !(await prepare())) return;
  await work();
}

async function work() {
  toLatest();
  try {
    await design.work();
  } catch (error) {
    refusal.show(error);
  }
}

/** Ends a computation that takes too long. The worker loses its robot. */
function cancel() {
  client.start();
  design.abandon("cancelled");
}

/** Lets the finished robot walk on in another world, with the same body. Otherwise changes the scene. */
async function chooseWorld(kind, name, settings) {
  if (kind !== "size") await adopt();
  if (kind === "size" || design.state !== "finished") return changeAndDesign(() => scene.set(...Object.entries(settings)));
  try {
    await visit.move(kind, name, settings);
  } catch (error) {
    chips.show(visit.settings);
    refusal.show(error);
  }
}

/** Brings the finished robot back to its own world and to the start of its walk. */
async function goHome() {
  toLatest();
  refusal.forget();
  try {
    await design.home();
  } catch (error) {
    refusal.show(error);
  }
}

/** Sets the seed. If a robot is being designed or is finished, a design with the new seed begins at once. */
const newSeed = seed => changeAndDesign(() => scene.setSeed(seed));

/** Lets several seeds race, and opens the best robot. A second press ends the race. */
async function startRace() {
  if (race.runs) return race.end();
  if (!(await mayChange())) return;
  if (design.state === "working") design.pause();
  $("race").textContent = "End the race";
  try {
    const best = await race.run(scene.asked, scene.seed);
    if (best === null) return;
    scene.robot = toText(best.bytes);
    scene.seed = best.seed;
    history.pushState(null, "", scene.link);
    await scene.check();
    $("saved").textContent = `Seed ${best.seed} won the race: ${shownAs(best.far)}.`;
  } catch (error) {
    refusal.show(error);
  } finally {
    $("race").textContent = "Race of seeds";
  }
}

const tell = text => { $("saved").textContent = text; };

async function saveFilm() {
  recording = new AbortController();
  $("save-film").disabled = true;
  try {
    await takeFilm({ canvas: $("stage"), player, signal: recording.signal, name: `cosmic-${scene.name}-${scene.seed}`, tell });
  } finally {
    recording = null;
    $("save-film").disabled = false;
    tellPlay();
  }
}

async function share() {
  // The robot that greets is the one to share.
  await adopt();
  keepAddress(scene);
  if (location.hash === "") history.replaceState(null, "", scene.link);
  const world = Object.keys(scene.visited).length > 0 ? " and the world in which it walks" : "";
  const robot = looked === null ? "this robot" : "the finished robot";
  await takeLink({ holds: scene.robot === null ? null : `${robot}${world}`, tell });
}

function connect() {
  // When a page is loaded again, Firefox enables the buttons that were enabled before.
  for (const id of LATER) $(id).disabled = true;
  const on = (id, does, event = "click") => $(id).addEventListener(event, does);
  on("design", pressDesign);
  on("play", togglePlay);
  on("time", () => player.seek(Number($("time").value)), "input");
  on("speed", () => { player.speed = Number($("speed").value); }, "change");
  on("scene", async () => {
    await scene.choose($("scene").value);
    $("scene").value = scene.name;
  }, "change");
  on("seed", async () => {
    await newSeed(Math.max(0, Math.floor(Number($("seed").value)) || 0));
    $("seed").value = scene.seed;
  }, "change");
  on("other", () => newSeed(scene.seed + 1));
  on("race", startRace);
  on("back", () => step(-1));
  on("ahead", () => step(1));
  on("latest", () => {
    toLatest();
    show();
  });
  on("level", () => ground.level());
  on("stairs", () => ground.stairs());
  on("rough", () => ground.rough());
  on("reset", () => scene.choose(scene.name));
  on("save-design", async () => save("design.json", new Blob([(await design.files()).design], { type: "application/json" })));
  on("save-scene", async () => {
    // The scene of a finished robot is in open loop if the robot is.
    const text = design.state === "finished" ? (await design.files()).scene : scene.checked.toml;
    save("scene.toml", new Blob([text], { type: "text/plain" }));
  });
  on("save-film", saveFilm);
  on("link", share);
  on("stage", adopt, "pointerdown");
  on("home", goHome);
  on("stay", () => $("leave").close("stay"));
  on("go", () => $("leave").close("go"));
  on("restart", () => {
    $("stopped").close();
    client.start();
    begin();
  });
  on("ternary", () => { player.highlight = null; }, "pointerleave");
  on("ternary", event => { if (design.state === "finished") player.highlight = ternary.edgeAt(event.clientX, event.clientY); }, "pointermove");
  // The space bar plays or pauses the walk, unless the focus is on a control that uses the space bar.
  addEventListener("keydown", event => {
    if (event.key !== " " || event.target.closest("button, select, summary, input:not([type=range]), dialog")) return;
    event.preventDefault();
    togglePlay();
  });
  $("stopped").addEventListener("cancel", event => event.preventDefault());
  addEventListener("hashchange", navigate);
}

connect();
tellPlay();
$("strip").classList.toggle("empty", scene.robot !== null);
greet();
// honest.js says that nothing can be designed.
const designs = typeof WebAssembly === "object";
if (filmKind() === null) $("saved").textContent = "This browser cannot record animations.";
if (designs) begin();
/** How long the scripts of frames take, for tests. */
globalThis.playerCost = player.cost;
/** Pushes the robot, and says what the stage shows, for tests. */
globalThis.push = ([along, above]) => push.push([along, 0, above]);
globalThis.onStage = () => {
  const { walk, goal, goalLabel, playing, time } = player;
  const { world, body, duration } = walk;
  const foot = ({ positions }) => Math.min(...[...body].map(i => positions[3 * i + 2] - levelAt(world.ground, positions[3 * i])));
  return { view: stage.orbit.view, box: stage.box, goal, goalLabel, playing, time, along: walk.along, origin: world.origin, cos: world.cos, foot: foot(walk.at(player.still.matches ? time : duration)) };
};
if ("serviceWorker" in navigator && isSecureContext) navigator.serviceWorker.register("sw.js").catch(() => {});
