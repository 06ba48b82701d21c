// Connects the controls of the page with what they do.
/* global Stage: of robot.js; Ternary, Curve: of charts.js; decimals, levelAt: of drawing.js */

import { keepAddress, keepRobot, linked } from "./address.js";
import { ENOUGH, Parade, isReal, mayBegin, measuredOfCast, realRobot } from "./cast.js";
import { Chips } from "./chips.js";
import { Client, Refused, Stopped } from "./client.js";
import { Design, nameOf } from "./design.js";
import { Editor } from "./editor.js";
import { Errand } from "./errand.js";
import { filmKind, save } from "./film.js";
import { Gains } from "./gains.js";
import { GroundEditor } from "./ground.js";
import { toBytes, toText } from "./packed.js";
import { Player } from "./player.js";
import { cut, linkOf, namesIn, seedOf } from "./link.js";
import { progressOf } from "./progress.js";
import { Push } from "./push.js";
import { Race, entrantsFrom, outcome } from "./race.js";
import { Refusals } from "./refusal.js";
import { DEFAULT, OWN, REAL, Scene } from "./scene.js";
import { Shop } from "./shop.js";
import { Strip } from "./strip.js";
import { Twin } from "./twin.js";
import { Visit } from "./visit.js";
import { takeFilm, takeLink } from "./take.js";
import { headline, medianOf, metres, sentence, shownAs, showVerdict } from "./words.js";

const $ = id => document.getElementById(id);
/** After this many milliseconds, a computation can be cancelled. */
const LONG = 2000;
/** If the walk of a link costs more than this many walks of the page's own scene, it waits for a click. */
const COSTLY = 30;
/** If nothing of the library arrives for this many milliseconds, its download hangs. */
const HANGS = 10_000;
/** A robot that rises less than this above the ground does not jump, in metres. */
const JUMPS = 0.02;
const TOUCH = "These robots are finished. Touch one to make it yours.";
/** The buttons that cannot be used before there is a robot. */
const LATER = ["design", "challenge", "twin", "takeback", "race", "back", "ahead", "latest", "save-film", "save-design", "save-scene"];
/** `?panic=5` makes the library panic after iteration 5, for tests. */
const panicAfter = new URLSearchParams(location.search).get("panic");

// The world that is shown before there is a robot.
const stage = new Stage($("stage"), { width: 2, ground: [[-9, 0], [9, 0]], cos: 1, limit: 1 });
const ternary = new Ternary($("ternary"));
const curve = new Curve($("curve"), x => look(Math.round(x)));
const strip = new Strip($("strip"), look);
const player = new Player(stage, tellTime, tellPlay);
player.lengthen = lengthen;
const client = new Client({ onstop: stopped, onmissing: missing, onload: tellLoaded, onwait: isLong => { $("busy").hidden = !isLong; } });
const design = new Design(client, changed, panicAfter === null ? null : Number(panicAfter));
const scene = new Scene(client, $("settings"), mayChange, sceneKnown);
const ground = new GroundEditor($("ground"), points => scene.setGround(points));
const chips = new Chips(
  { ground: $("chip-ground"), gravity: $("chip-gravity"), size: $("chip-size") },
  [...document.querySelectorAll("#worlds button[data-kind]")],
  chooseWorld,
);
const toLatest = () => {
  looked = null;
  race.end();
};
/** Whether the finished robot is on the stage, and not an earlier attempt. */
const isShown = () => design.state === "finished" && looked === null;
/** Before another walk takes the stage. */
const toOther = () => {
  looked = null;
  endRaces();
};
const visit = new Visit({ scene, player, design, onvisit: toOther });
const push = new Push({
  canvas: $("stage"), stage, player, design, isShown, onpush: toOther, onerror: error => refusal.show(error),
});
const editor = new Editor({
  canvas: $("stage"), stage, player, isShown, onedit: toLatest, onerror: error => refusal.show(error),
  parts: {
    fieldset: $("editor"), legend: $("bar"), previous: $("previous"), next: $("next"), undo: $("undo"),
    materials: [...document.getElementsByName("material")],
  },
});
const gains = new Gains({
  canvas: $("stage"), stage, player, design, text: $("gain"), onerror: error => refusal.show(error),
  isShown: () => looked === null && ["working", "paused"].includes(design.state),
});
const errand = new Errand({
  canvas: $("stage"), stage, player, design, ontell: toOther, onerror: error => refusal.show(error),
  parts: { row: $("errand"), slider: $("goal"), place: $("place") },
});
const refusal = new Refusals({ text: $("refusal"), details: $("details"), scene, before: $("status") });
const race = new Race($("lanes"), { player, onchange: raced });
const twin = design.twin = new Twin(tellTwin);
const shop = new Shop({
  design, onerror: error => refusal.show(error),
  parts: {
    section: $("shop"), pieces: $("pieces"), drive: $("drive"), says: $("drive-says"), savePieces: $("save-pieces"),
    saveDrive: $("save-drive"),
  },
});
/** The iteration that the user chose to see; null for the last iteration or the delivered robot. */
let looked = null;
let recording = null;
/** Whether the page began the design in progress by itself. */
let isUnasked = false;
/** How much of the library is loaded, from 0 to 1. */
let loaded = 0;
/** Whether robots can be designed here. Without WebAssembly, honest.js says that they cannot. */
let designs = typeof WebAssembly === "object";
/** The timer that notices a download that hangs. */
let hangs;
/** The timer for the next update of the main button. */
let waiting;
/** What the status says first when the page's own design takes the stage, and until when (milliseconds). */
let farewell = { words: "", until: 0 };
/** The other world that the switches show; null for the robot's own world. */
let elsewhere = null;
/** Is called when the list of scenes is there. Then the address is opened, and a robot of the parade may take its place. */
let tellScenes;
const scenesKnown = new Promise(resolve => { tellScenes = resolve; });
const parade = new Parade($("parade"), { player, onpick: adopt });

/** Lets finished robots walk on the stage until the page's own design walks. */
async function greet() {
  if (linked || new URLSearchParams(location.search).has("wait") || !(await parade.open())) return;
  beginGreeting();
  const next = mayBegin() ? "Meanwhile the page designs one of its own." : "Press “Design a robot” for another one.";
  $("status").textContent = designs ? `${TOUCH} ${next}` : "These robots are finished. Touch one to see it walk.";
}

/** Shows the parade in place of the stage, which keys cannot reach behind it. */
function beginGreeting() {
  $("robot").classList.add("greets");
  $("stage").tabIndex = -1;
}

function endGreeting() {
  const hadFocus = $("parade").contains(document.activeElement);
  parade.close();
  $("stage").tabIndex = 0;
  if (hadFocus) $("stage").focus({ preventScroll: true });
  $("robot").classList.remove("greets", "called");
  $("finished").textContent = "More robots";
}

/** Calls the parade back; a second press leads back to the robot. */
async function callParade() {
  if (parade.isOpen) {
    endGreeting();
    return changed(design.state);
  }
  race.end();
  if (!(await parade.open())) return;
  parade.isCalled = true;
  beginGreeting();
  $("robot").classList.add("called");
  $("finished").textContent = "Back to mine";
  $("status").textContent = TOUCH;
  $("verdict").textContent = "";
  $("parade").scrollIntoView({ block: "nearest" });
}

/** Makes a robot of the parade a finished robot of the page. What follows waits until it is. */
let adopting = null;
async function adopt(robot = parade.robots[0]) {
  if (parade.isOpen && robot) adopting ??= take(robot).finally(() => { adopting = null; });
  await adopting;
}

async function take({ walk, link, time, measured }) {
  if (!(await mayLose())) return;
  endGreeting();
  player.show(walk, { restart: true });
  player.seek(time);
  if (!designs) {
    $("along").textContent = shownAs(measured.distance.p50);
    $("status").textContent = "This robot is finished.";
    return;
  }
  history.pushState(null, "", link);
  scene.read();
  await scenesKnown;
  await scene.check();
  player.seek(time);
}

/** Gives the stage to the page's own design once it walks far enough, or is finished. */
function giveWay(state) {
  const far = design.best?.walk.along ?? 0;
  if (!parade.isOpen || parade.isCalled || !(far > ENOUGH || state === "finished")) return;
  if (parade.rest > 0) return setTimeout(() => changed(design.state), parade.rest);
  farewell = { words: `The page’s own design walks ${shownAs(far)} now, so it takes the stage. `, until: performance.now() + 8000 };
  endGreeting();
}

async function begin() {
  try {
    const scenes = await client.ask({ do: "scenes" });
    scenes.unshift(...Object.entries(OWN).map(([name, { about }]) => ({ name, about })));
    $("scene").replaceChildren(...scenes.map(({ name, about }) => Object.assign(new Option(name, name), { title: about })));
    tellScenes();
    await openAddress();
  } catch (error) {
    refusal.show(error);
  }
}

/** Opens what the address names. */
async function openAddress() {
  const names = [...$("scene").options].map(({ value }) => value);
  if (!names.includes(scene.name)) {
    return openInstead(DEFAULT, `${JSON.stringify(cut(scene.name))} is not a scene of this page; expected one of ${names.join(", ")}.`);
  }
  // Something else may be opened in the meantime.
  if (!(await scene.check())) return;
  if (design.state === "empty") await openInstead(scene.name, $("refusal").textContent);
  if (design.state !== "ready" || !mayBegin()) return;
  isUnasked = !linked && location.hash === "";
  await designThis();
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
  endGreeting();
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
  $("real").setAttribute("aria-pressed", scene.name === REAL);
  $("name").value = scene.names.join(" + ");
  refusal.forget();
  if (error) {
    endRaces();
    design.abandon("empty");
    return refuse(error);
  }
  keepAddress(scene);
  const { settings, profile } = scene.checked;
  chips.show(settings);
  errand.open(settings);
  const columns = settings["lattice.columns"] - 1;
  ground.show(profile, columns * settings["lattice.spacing"]);
  if (!scene.isLinked || scene.cost < COSTLY) return void await prepare();
  // A link cannot keep the processor busy without a click.
  toOther();
  design.costs = scene.cost;
  design.abandon("asking");
}

/** Asks before a change that would discard a design in progress. */
async function mayChange() {
  await adopting;
  if (parade.isOpen) {
    endGreeting();
    changed(design.state);
  }
  return mayLose();
}

/** Asks whether a design in progress may be lost. */
async function mayLose() {
  const busy = ["working", "paused", "measuring"].includes(design.state) && design.iteration > 0;
  // A design that nobody asked for, and a computation that hangs, can be left without a question.
  if (!busy || isUnasked || client.busyFor >= LONG) return true;
  $("leave").returnValue = "";
  $("leave").showModal();
  await new Promise(resolve => $("leave").addEventListener("close", resolve, { once: true }));
  return $("leave").returnValue === "go";
}

/** Makes a change. If a robot was being designed or finished, the next design begins at once. */
async function changeAndDesign(change) {
  const goesOn = !["empty", "preparing", "ready", "asking", "cancelled", "stopped"].includes(design.state);
  const changed = await change();
  if (scene.checked) chips.show(scene.checked.settings);
  if (changed && goesOn && design.state === "ready") await work();
}

/** Prepares the robot of the scene, or opens the robot of the link. */
async function prepare() {
  toOther();
  recording?.abort();
  editor.open(null);
  design.owner = scene.owner;
  // A robot that was born on this page is still there.
  if (scene.names.length === 1 && scene.robot === null) scene.robot = scene.born = design.linkOf(scene.key);
  try {
    if (scene.robot === null) {
      await meetRival();
      await design.prepare(scene.asked, scene.seed, scene.key);
    } else {
      if (toBytes(scene.robot) === null) throw new Refused("the robot in this link is damaged; copy the whole link");
      const { visited } = scene;
      await meetRival();
      await design.open(scene.asked, scene.robot, scene.key);
      await visit.arrive(visited);
      design.judge();
    }
    return true;
  } catch (error) {
    // If the worker was stopped, the code that stopped it sets the next state.
    if (!(error instanceof Stopped)) design.abandon("empty");
    refuse(error);
    return false;
  }
}

/** Before a robot of a link is opened, what is measured of the cast is known. */
let castKnown = null;
function knowCast() {
  if (scene.robot === null && scene.rival === null) return null;
  return castKnown ??= measuredOfCast().then(measured => measured.forEach((one, name) => design.known.set(name, one)));
}

/** Opens the robot to beat, if there is one. */
async function meetRival() {
  if (scene.rival !== null && toBytes(scene.rival) === null) throw new Refused("the robot to beat in this link is damaged; copy the whole link");
  await knowCast();
  await design.meet(scene.asked, scene.rival, scene.key);
  if (design.rival !== null) design.rival.claimed = scene.claimed;
}

/** Shows the error of a scene that cannot be used. */
function refuse(error) {
  refusal.show(error);
  if (error instanceof Refused) $("status").textContent = "This setting cannot be used.";
}

function endRaces() {
  race.end();
  twin.end();
}

function stopped(message) {
  endRaces();
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
  const words = { asking: "Open it", preparing: "Preparing …", working: "Pause", measuring: "Measuring …", paused: "Resume", finished: design.elsewhere ? "Design for this world" : "Design another" };
  if (state === "empty" && loaded < 1) words.empty = `Loading, ${Math.round(100 * loaded)} %`;
  const long = !race.runs && waits(state) && client.busyFor >= LONG;
  $("design").textContent = race.runs ? "End the race" : long ? "Cancel" : words[state] ?? "Design a robot";
  $("design").disabled = !race.runs && !long && ["empty", "stopped", "preparing", "measuring"].includes(state);
  clearTimeout(waiting);
  if (waits(state) && !long) waiting = setTimeout(() => tellButton(design.state), LONG / 4);
}

/** Says how much of the library is loaded. */
function tellLoaded(share) {
  loaded = share;
  $("missing").hidden = true;
  tellButton(design.state);
  const percent = `${Math.round(100 * share)} %`;
  clearTimeout(hangs);
  if (share === 1) return;
  hangs = setTimeout(() => sayMissing(`At ${percent} the program that designs robots has stopped arriving.`), HANGS);
  if ($("status").textContent.startsWith("Loading")) $("status").textContent = `Loading the program that designs robots: ${percent}`;
}

/** Says that the library did not arrive. Finished robots walk without it. */
async function missing(message) {
  clearTimeout(hangs);
  designs = false;
  endRaces();
  design.abandon("empty");
  sayMissing(`The program that designs robots did not arrive: ${message}.`);
  if (design.world === null && !parade.isOpen) await parade.open();
  if (parade.isOpen) beginGreeting();
  $("status").textContent = "Finished robots walk without it. Touch one to see it walk.";
}

function sayMissing(words) {
  $("missing").firstElementChild.textContent = words;
  $("missing").hidden = false;
}

/** Loads the library once more, and not from where a wrong one may be kept. */
async function loadAgain() {
  designs = true;
  await globalThis.caches?.keys().then(names => Promise.all(names.filter(name => name.startsWith("cosmic-")).map(name => caches.delete(name))));
  client.start("worker.js?again");
  tellLoaded(0);
  begin();
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
  $("challenge").disabled = $("takeback").disabled = true;
  $("save-scene").disabled = scene.checked === null;
  // The winner of a race is opened from its link.
  $("race").disabled = scene.checked === null || scene.takesGoals;
  $("twin").disabled = scene.checked === null || scene.takesGoals || !["working", "paused", "finished"].includes(state);
  shop.show();
  $("save-film").disabled = design.world === null || filmKind() === null || recording !== null;
  giveWay(state);
  if (parade.isOpen) {
    strip.draw({ robots: design.robots, attempts: design.world?.iterations ?? 1, shown: Math.max(0, design.iteration) });
    return;
  }
  tellStatus(state);
  if (design.world === null || ["stopped", "empty", "preparing", "asking", "cancelled"].includes(state)) return;
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

/** The robot in the second lane: the best one of the evolution, or the robot to beat. Null without such a robot, and while the
 * robot on the stage is not on its own walk. */
function inLane() {
  if (design.told !== null) return null;
  if (twin.walk) return { walk: twin.walk, says: `evolution, ${twin.tries} tries: ${shownAs(twin.walk.along)}` };
  return design.rival && { walk: design.rival.walk, says: `to beat: ${design.rival.measured ? shownAs(medianOf(design.rival)) : "measuring …"}` };
}

/** Sets the flag: at the goal, or at the distance of the headline; during a design at the best distance so far. The best
 * robot so far is shown as a ghost; after an edit, it is the robot before the edit. */
function flag(far) {
  const { best, delivered, place } = design;
  player.goal = errand.show();
  player.goalLabel = "";
  const designed = delivered?.designed.walk ?? null;
  const other = inLane();
  player.lane = other?.says ?? null;
  player.ghost = other ? other.walk : delivered ? (delivered.walk === designed ? null : designed) : best?.walk ?? null;
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
  endGreeting();
  const { walk } = shown();
  const isDelivered = looked === null && design.delivered !== null;
  const goesOn = walk === design.told?.walk;
  if (player.walk !== walk) player.show(walk, { ...how, withVoid: isDelivered, goesOn, stops: goesOn && design.told.to !== null });
  const { far, title } = headline({ walk, looked, design });
  flag(far);
  if (!player.playing) player.paint();
  tellPlay();
  $("along").textContent = shownAs(far);
  $("along-title").textContent = title;
  const number = looked ?? design.iteration;
  const came = design.delivered !== null && !design.hasAttempts;
  $("strip").classList.toggle("empty", came);
  $("attempt-title").textContent = came ? "a finished robot" : "version";
  $("iteration").textContent = came ? "" : `${number} / ${design.world.iterations}`;
  tellJump(walk);
  $("back").disabled = number === 0;
  $("ahead").disabled = $("latest").disabled = looked === null;
  $("takeback").disabled = !isShown() || design.delivered.walk === design.delivered.designed.walk;
  $("challenge").disabled = !isShown() || design.told !== null || design.delivered.link === null || medianOf(design.delivered) === null;
  $("robot").classList.toggle("tinted", gains.show());
  $("stage").classList.toggle("earlier", looked !== null);
  ternary.draw({ mixtures: walk.mixtures, delivered: walk.materials, highlight: player.highlight });
  drawCurve();
  describe(walk);
  tellStatus(design.state);
}

/** Shows how high a finished robot jumps. */
function tellJump(walk) {
  const jumps = isShown() && walk.along !== null && walk.jump >= JUMPS;
  $("jumps").hidden = !jumps;
  if (jumps) $("jump").textContent = metres(walk.jump);
}

function look(iteration) {
  if (design.world === null) return;
  race.end();
  const within = Math.min(design.iteration, Math.max(0, iteration));
  looked = within === design.iteration && design.state !== "finished" ? null : within;
  show();
}

function step(by) {
  race.end();
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
  $("stage").setAttribute("aria-label", `Robot of ${walk.count(1)} bones and ${walk.count(2)} muscles; ${far} in ${walk.took.toFixed(1)} s. Shift with arrow keys turns the view, Home resets it`);
  const solid = walk.materials.length - walk.count(0);
  $("ternary").setAttribute("aria-label", `Mixtures of ${walk.materials.length} bars: ${solid} are mostly solid, ${walk.count(2)} of them actuators`);
}

function tellStatus(state) {
  // Screen readers do not read texts that change with every iteration.
  $("status").setAttribute("aria-live", state === "working" ? "off" : "polite");
  const first = performance.now() < farewell.until && looked === null ? farewell.words : "";
  $("status").textContent = race.runs ? race.words : first + sentence(state, design, looked);
  const delivered = isShown() && design.told === null ? design.delivered : null;
  showVerdict($("verdict"), delivered?.measured?.verdict ?? []);
  if (delivered?.isMeasuring) $("verdict").textContent = "Measuring how reliably it walks …";
}

function tellTime(time) {
  const { began, duration } = player.walk;
  // The slider has no times that the walk has forgotten.
  if (Number($("time").max) !== began + duration) Object.assign($("time"), { min: began, max: began + duration });
  $("time").value = began + time;
  $("clock").textContent = `${(began + time).toFixed(1)} s`;
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
  if (race.runs) return race.end();
  await adopting;
  isUnasked = false;
  if ($("design").textContent === "Cancel") return cancel();
  if (parade.isOpen) endGreeting();
  if (design.state === "working") return design.pause();
  if (design.elsewhere) return changeAndDesign(() => scene.set(...Object.entries(design.elsewhere.settings)));
  if (design.state === "finished") return newSeed(scene.seed + 1);
  if (["asking", "cancelled"].includes(design.state) && !(await prepare())) return;
  if (design.state !== "finished") await designThis();
}

/** Designs the robot of the scene, or lets the robots of several names race. */
const designThis = () => scene.names.length > 1 && scene.robot === null ? startRace() : work();

async function work() {
  toLatest();
  try {
    await design.work();
  } catch (error) {
    refusal.show(error);
  }
}

/** Lets the finished robot walk on beyond the end of its walk, as long as somebody looks. Films end with the walk. */
async function lengthen(walk) {
  if (!isShown() || recording !== null || walk !== shown().walk || walk.along === null || design.isReplacing) return undefined;
  try {
    const dropped = await design.lengthen(walk);
    tellJump(walk);
    return dropped;
  } catch (error) {
    refusal.show(error);
    return null;
  }
}

/** Ends a computation that takes too long. The worker loses its robot. */
function cancel() {
  endRaces();
  client.start();
  design.abandon("cancelled");
}

/** Lets the finished robot walk on in another world, with the same body. Otherwise changes the scene. */
async function chooseWorld(kind, name, settings) {
  if (parade.isCalled) callParade();
  if (kind !== "size") await adopt();
  if (!designs) return;
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

/** Opens the link of the name that a visitor typed. */
function openName(event) {
  event.preventDefault();
  const names = namesIn($("name").value);
  if (names.length === 0) return $("name").focus();
  const hash = linkOf(names);
  if (location.hash === hash) navigate();
  else location.hash = hash;
}

/** Lets several seeds race, and opens the best robot. A second press ends the race. */
async function startRace() {
  if (race.runs) return race.end();
  if (!(await mayChange())) return;
  if (design.state === "working") design.pause();
  recording?.abort();
  twin.end();
  tell("");
  try {
    let ranking = null;
    // The robot on the stage stands still behind the lanes.
    const entrants = scene.names.length > 1 ? scene.names.map(name => ({ name, seed: seedOf(name) })) : entrantsFrom(scene.seed);
    await player.goOn(async () => { ranking = await race.run(scene.asked, entrants); });
    if (ranking === null) return;
    tell(outcome(ranking));
    const [{ seed, far, measured, bytes }] = ranking;
    if (far === null) return;
    [scene.robot, scene.seed] = [toText(bytes), seed];
    if (scene.names.length < 2) scene.names = [];
    else scene.born = scene.robot;
    design.known.set(nameOf(scene.key, scene.robot), measured);
    // The robot before may have won.
    if (scene.link !== location.hash) history.pushState(null, "", scene.link);
    await scene.check();
  } catch (error) {
    refusal.show(error);
  }
}

/** Lets an evolution without gradients race the design. A second press ends it. */
async function raceTwin() {
  if (twin.runs) return twin.end();
  await adopting;
  if (parade.isOpen) {
    endGreeting();
    changed(design.state);
  }
  // Both walks begin together.
  if (design.state === "finished") await goHome();
  toLatest();
  $("stage").scrollIntoView({ block: "nearest" });
  try {
    const run = twin.run(scene.asked, scene.seed);
    tellTwin();
    await run;
  } catch (error) {
    refusal.show(error);
  }
}

/** Shows the latest of the evolution. */
function tellTwin() {
  $("twin").textContent = twin.runs ? "End evolution" : "Race evolution";
  if (design.world === null || parade.isOpen || ["stopped", "empty", "preparing", "asking", "cancelled"].includes(design.state)) return;
  flag(headline({ walk: shown().walk, looked, design }).far);
  if (!player.playing) player.paint();
  tellStatus(design.state);
}

/** Shows a robot of real parts, or goes back to the page's own scene. */
async function chooseReal() {
  if (parade.isOpen) return adopt(parade.robots.find(isReal));
  if (!designs) return;
  await scenesKnown;
  if (scene.name === REAL) return changeAndDesign(() => scene.choose(DEFAULT));
  location.hash = (await realRobot()).link;
}

/** Shows or hides the lanes of a race. */
function raced() {
  $("robot").classList.toggle("races", race.runs);
  $("race").textContent = race.runs ? "End the race" : "Race of seeds";
  tellButton(design.state);
  tellStatus(design.state);
}

const tell = text => { $("saved").textContent = text; };

async function saveFilm() {
  race.end();
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

/** Gives out a link that asks others to beat the finished robot. */
async function challenge() {
  await adopting;
  const { delivered } = design;
  const far = medianOf(delivered);
  const url = new URL(scene.challenge(delivered.link, far), location.href);
  await takeLink({ url, holds: `this robot and its distance, ${shownAs(far)}. It opens with a race against it`, tell });
}

async function share() {
  if (parade.isOpen && !parade.isCalled) return takeLink({ holds: "this parade of finished robots", tell });
  keepAddress(scene);
  if (location.hash === "") history.replaceState(null, "", scene.link);
  const world = Object.keys(scene.visited).length > 0 ? " and the world in which it walks" : "";
  const robot = looked === null ? "this robot" : "the finished robot";
  await takeLink({ holds: scene.robot === null || scene.isNamed ? null : `${robot}${world}`, tell });
}

function connect() {
  // When a page is loaded again, Firefox enables the buttons that were enabled before.
  for (const id of LATER) $(id).disabled = true;
  const on = (id, does, event = "click") => $(id).addEventListener(event, does);
  on("design", pressDesign);
  on("play", togglePlay);
  on("time", () => player.seek(Number($("time").value) - player.walk.began), "input");
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
  on("naming", openName, "submit");
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
  on("challenge", challenge);
  on("twin", raceTwin);
  on("finished", callParade);
  on("real", chooseReal);
  on("takeback", () => editor.takeBack());
  on("home", goHome);
  on("stay", () => $("leave").close("stay"));
  on("go", () => $("leave").close("go"));
  on("again", loadAgain);
  on("restart", () => {
    $("stopped").close();
    loadAgain();
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
if (filmKind() === null) $("saved").textContent = "This browser cannot record animations.";
if (designs) {
  tellLoaded(0);
  begin();
}
/** How long the scripts of frames take, for tests. */
globalThis.playerCost = player.cost;
globalThis.parade = parade;
globalThis.race = race;
/** Pushes the robot, and says what the stage shows, for tests. */
globalThis.push = ([along, above]) => push.push([along, 0, above]);
globalThis.onStage = () => {
  const { walk, goal, goalLabel, playing, time } = player;
  if (walk === null) return {};
  const { world, body, duration } = walk;
  const foot = ({ positions }) => Math.min(...[...body].map(i => positions[3 * i + 2] - levelAt(world.ground, positions[3 * i])));
  const { metres } = walk.at(time);
  return { absent: player.absent.map(([i, j]) => [i, j]), held: [...body], metres, frames: walk.walk?.counts.length, lane: player.lane, tints: player.tints, view: stage.orbit.view, box: stage.box, goal, goalLabel, playing, time: walk.began + time, along: walk.along, origin: world.origin, cos: world.cos, foot: foot(walk.at(player.still.matches ? time : duration)) };
};
if ("serviceWorker" in navigator && isSecureContext) navigator.serviceWorker.register("sw.js").catch(() => {});
