// Connects the controls of the page with what they do.
/* global Stage, Ternary, Curve, decimals: of drawing.js */

import { Client, Refused, Stopped } from "./client.js";
import { Design } from "./design.js";
import { Editor } from "./editor.js";
import { Errand } from "./errand.js";
import { film, filmKind, save } from "./film.js";
import { GroundEditor } from "./ground.js";
import { Player } from "./player.js";
import { DEFAULT, Scene } from "./scene.js";

const $ = id => document.getElementById(id);
/** After this many milliseconds, a computation can be cancelled. */
const LONG = 2000;
const PHASES = { co_design: "co-design", attraction: "attraction", snap: "snap", fine_tuning: "fine-tuning" };
/** `?panic=5` makes the library panic after iteration 5, for tests. */
const panicAfter = new URLSearchParams(location.search).get("panic");

// The world that is shown before there is a robot.
const stage = new Stage($("stage"), { width: 2, ground: [[-9, 0], [9, 0]], cos: 1, limit: 1 });
const ternary = new Ternary($("ternary"));
const curve = new Curve($("curve"), x => look(Math.round(x)));
const player = new Player(stage, tellTime, tellPlay);
const client = new Client(stopped);
const design = new Design(client, changed, panicAfter === null ? null : Number(panicAfter));
const scene = new Scene(client, $("settings"), sceneKnown);
const ground = new GroundEditor($("ground"), points => scene.setGround(points));
const editor = new Editor({
  canvas: $("stage"), stage, player, onerror: fail,
  parts: {
    fieldset: $("editor"), legend: $("bar"), previous: $("previous"), next: $("next"), undo: $("undo"),
    materials: [...document.getElementsByName("material")],
  },
});
const errand = new Errand({
  canvas: $("stage"), stage, player, design, ontell: () => { looked = null; }, onerror: fail,
  parts: { row: $("errand"), slider: $("goal"), place: $("place") },
});
/** The iteration that the user chose to see; null for the last iteration or the delivered robot. */
let looked = null;
let recording = null;
/** The timer for the next update of the main button. */
let waiting;

async function begin() {
  try {
    const scenes = await client.ask({ do: "scenes" });
    $("scene").replaceChildren(...scenes.map(({ name, about }) => Object.assign(new Option(name, name), { title: about })));
    const names = scenes.map(({ name }) => name);
    if (!names.includes(scene.name)) {
      return openInstead(DEFAULT, `${JSON.stringify(scene.name)} is not a scene of this page; expected one of ${names.join(", ")}.`);
    }
    await scene.check();
    if (design.state === "empty") await openInstead(scene.name, $("refusal").textContent);
  } catch (error) {
    fail(error);
  }
}

/** Opens a built-in scene with its own settings, because the link cannot be opened. */
async function openInstead(name, reason) {
  await scene.choose(name);
  $("refusal").textContent = `The link cannot be opened. ${reason.trim()}\nThe page shows the scene ${name} instead.`;
}

/** Is called when the library has checked a scene. Prepares the robot, or shows the error. */
async function sceneKnown(error) {
  $("scene").value = scene.name;
  $("seed").value = scene.seed;
  $("refusal").textContent = "";
  if (error) {
    design.abandon("empty");
    return fail(error);
  }
  history.replaceState(null, "", scene.link);
  const { settings, profile } = scene.checked;
  errand.open(settings);
  const columns = settings["lattice.columns"] - 1;
  ground.show(profile, settings["lattice.origin_x"] + columns * settings["lattice.spacing"]);
  await prepare();
}

async function prepare() {
  looked = null;
  recording?.abort();
  editor.open(null);
  try {
    await design.prepare(scene.asked, scene.seed);
    return true;
  } catch (error) {
    // If the worker was stopped, the code that stopped it sets the next state.
    if (!(error instanceof Stopped)) design.abandon("empty");
    fail(error);
    return false;
  }
}

/** Shows an error of the library in the section that has the focus. A stopped worker is shown in a dialog instead. */
function fail(error) {
  if (error instanceof Stopped) return;
  if (!(error instanceof Refused)) throw error;
  (document.activeElement?.closest("section") ?? $("robot")).append($("refusal"));
  $("refusal").textContent = error.message;
  $("status").textContent = "The scene has an error.";
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
  const words = { preparing: "Preparing …", working: "Pause", measuring: "Measuring …", paused: "Resume", finished: "Design again" };
  const long = waits(state) && client.busyFor >= LONG;
  $("design").textContent = long ? "Cancel" : words[state] ?? "Design";
  $("design").disabled = !long && ["empty", "stopped", "preparing", "measuring"].includes(state);
  clearTimeout(waiting);
  if (waits(state) && !long) waiting = setTimeout(() => tellButton(design.state), LONG / 4);
}

function changed(state) {
  const busy = state === "working" || state === "measuring";
  tellButton(state);
  $("save-design").disabled = state !== "finished";
  $("save-scene").disabled = scene.checked === null;
  $("save-film").disabled = design.world === null || filmKind() === null || recording !== null;
  tellStatus(state);
  player.goal = errand.show();
  if (design.world === null || ["stopped", "empty", "preparing", "cancelled"].includes(state)) return;
  if (state === "finished" && !$("stage").classList.contains("editable")) {
    looked = null;
    editor.open(design);
  }
  if (looked === null || !busy) show({ restart: state === "ready" });
  else drawCurve();
}

function show(how = {}) {
  const { walk } = shown();
  const isDelivered = looked === null && design.delivered !== null;
  const goesOn = walk === design.told?.walk;
  if (player.walk !== walk) player.show(walk, { ...how, withVoid: isDelivered, goesOn });
  tellPlay();
  $("time").max = walk.duration;
  $("along").textContent = walk.along === null ? "diverged" : `${decimals(walk.along, 2)} m`;
  const number = looked ?? design.iteration;
  $("iteration").textContent = `${number} / ${design.world.iterations}`;
  $("back").disabled = number === 0;
  $("ahead").disabled = $("latest").disabled = looked === null;
  drawTernary(walk);
  drawCurve();
  describe(walk);
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

function drawTernary(walk) {
  ternary.draw({ mixtures: walk.mixtures, delivered: walk.materials, highlight: player.highlight });
}

function drawCurve() {
  const points = design.robots.map(({ walk }, k) => [k, walk.along ?? NaN]);
  curve.draw({
    title: "Displacement after each iteration, m",
    series: [{ name: "displacement", colour: "accent", points }],
    x: [0, design.world.iterations],
    unit: "iterations",
    cursor: looked ?? design.iteration,
    phases: phases(),
  });
}

/** The phases, each with its range of iterations. */
function phases() {
  const spans = [];
  design.robots.forEach(({ record }, k) => {
    const name = record && PHASES[record.phase];
    if (name === null) return;
    if (spans.at(-1)?.name === name) spans.at(-1).to = k;
    else spans.push({ name, from: k - 1, to: k });
  });
  return spans;
}

function describe(walk) {
  const far = walk.along === null ? "its walk diverges" : `it walks ${decimals(walk.along, 2)} m`;
  $("stage").setAttribute("aria-label", `Robot of ${walk.count(1)} bars of skeleton and ${walk.count(2)} actuators; ${far} in ${walk.duration.toFixed(1)} s`);
  const solid = walk.materials.length - walk.count(0);
  $("ternary").setAttribute("aria-label", `Mixtures of ${walk.materials.length} bars: ${solid} are mostly solid, ${walk.count(2)} of them actuators`);
}

function tellStatus(state) {
  const about = {
    empty: "",
    preparing: "Preparing the robot …",
    cancelled: "Cancelled. Press Design to start again.",
    ready: "The bars are undecided. Press Design.",
    paused: `Paused after iteration ${design.iteration}.`,
    measuring: "Measuring the robot from other starts …",
    stopped: "The computation stopped.",
  };
  if (design.told !== null && ["ready", "paused", "finished"].includes(state)) about[state] = told();
  // Screen readers do not read texts that change with every iteration.
  $("status").setAttribute("aria-live", state === "working" ? "off" : "polite");
  $("status").textContent = about[state] ?? (state === "finished" ? finished() : working());
}

function working() {
  const { record } = design.robots.at(-1);
  if (record === null) return "Designing …";
  const left = (design.world.iterations - design.iteration) * design.seconds / design.iteration;
  return `Designing: ${PHASES[record.phase]}. About ${Math.max(1, Math.round(left))} s left.`;
}

function finished() {
  const { walk, asDesigned, measured } = design.delivered;
  const { p10, p50, p90 } = measured.spread;
  const { verdict, reason } = measured.reliability;
  const far = [p50, p10, p90].every(Number.isFinite)
    ? `${decimals(p50, 2)} m from perturbed starts (10 to 90 %: ${decimals(p10, 2)} to ${decimals(p90, 2)} m)`
    : "some perturbed starts diverge";
  const doubt = verdict === "unreliable" ? ` Unreliable: ${reason}.` : "";
  if (walk === asDesigned) return `Designed in ${Math.round(design.seconds)} s: ${far}.${doubt}`;
  if (walk.along === null) return `Edited: ${walk.diverged}.`;
  return `Edited: ${decimals(walk.along, 2)} m; as designed ${decimals(asDesigned.along, 2)} m.`;
}

function told() {
  const { walk, along, left } = design.told;
  if (left === null) return `Told to go to ${decimals(along, 2)} m: ${walk.diverged}.`;
  return `Told to go to ${decimals(along, 2)} m. After ${walk.duration.toFixed(1)} s the robot is ${decimals(left, 2)} m away from it.`;
}

function tellTime(time) {
  $("time").value = time;
  $("clock").textContent = `${time.toFixed(1)} s`;
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
  if (design.state === "working") return design.pause();
  if (["finished", "cancelled"].includes(design.state) && !(await prepare())) return;
  looked = null;
  try {
    await design.work();
  } catch (error) {
    fail(error);
  }
}

/** Ends a computation that takes too long. The worker loses its robot. */
function cancel() {
  client.start();
  design.abandon("cancelled");
}

/** Sets the seed. If a robot is being designed or is finished, a design with the new seed begins at once. */
async function newSeed(seed) {
  const goesOn = !["empty", "preparing", "ready", "cancelled", "stopped"].includes(design.state);
  scene.seed = seed;
  design.abandon("empty");
  await scene.check();
  if (goesOn && design.state === "ready") await pressDesign();
}

async function saveFilm() {
  const style = getComputedStyle(document.documentElement);
  const colour = name => style.getPropertyValue(`--${name}`).trim();
  recording = new AbortController();
  $("save-film").disabled = true;
  const { walk } = player;
  try {
    const { blob, ending } = await film({
      canvas: $("stage"), player, signal: recording.signal,
      label: time => `${time.toFixed(1)} s   ${decimals(walk.at(time).metres, 2)} m`,
      colours: { paper: colour("panel"), ink: colour("ink") },
      onprogress: share => { $("saved").textContent = `Recording the walk: ${Math.round(100 * share)} %`; },
    });
    save(`cosmic-${scene.name}-${scene.seed}.${ending}`, blob);
    $("saved").textContent = "The animation is saved.";
  } catch (error) {
    if (error.name !== "AbortError") throw error;
    $("saved").textContent = "No animation was saved, because another robot replaced this one.";
  } finally {
    recording = null;
    $("save-film").disabled = filmKind() === null;
    tellPlay();
  }
}

async function copyLink() {
  history.replaceState(null, "", scene.link);
  try {
    await navigator.clipboard.writeText(location.href);
    $("saved").textContent = "The link is copied.";
  } catch {
    $("saved").textContent = "The browser does not allow the page to copy. The link is in the address bar.";
  }
}

function connect() {
  const on = (id, does, event = "click") => $(id).addEventListener(event, does);
  on("design", pressDesign);
  on("play", togglePlay);
  on("time", () => player.seek(Number($("time").value)), "input");
  on("speed", () => { player.speed = Number($("speed").value); }, "change");
  on("scene", () => scene.choose($("scene").value), "change");
  on("seed", () => newSeed(Math.max(0, Math.floor(Number($("seed").value)) || 0)), "change");
  on("other", () => newSeed(scene.seed + 1));
  on("back", () => step(-1));
  on("ahead", () => step(1));
  on("latest", () => { looked = null; show(); });
  on("level", () => ground.level());
  on("stairs", () => ground.stairs());
  on("rough", () => ground.rough());
  on("reset", () => scene.choose(scene.name));
  on("save-design", async () => save("design.json", new Blob([await design.file()], { type: "application/json" })));
  on("save-scene", () => save("scene.toml", new Blob([scene.checked.toml], { type: "text/plain" })));
  on("save-film", saveFilm);
  on("link", copyLink);
  on("restart", () => {
    $("stopped").close();
    client.start();
    begin();
  });
  on("ternary", () => { player.highlight = null; }, "pointerleave");
  on("ternary", event => { if (design.state === "finished") player.highlight = ternary.edgeAt(event.clientX, event.clientY); }, "pointermove");
  // The space bar plays or pauses the walk, unless the focus is on a control that uses the space bar.
  addEventListener("keydown", event => {
    if (event.key !== " " || event.target.closest("button, select, input:not([type=range]), dialog")) return;
    event.preventDefault();
    togglePlay();
  });
  $("stopped").addEventListener("cancel", event => event.preventDefault());
  addEventListener("hashchange", () => location.reload());
}

connect();
tellPlay();
if (filmKind() === null) $("saved").textContent = "This browser cannot record animations.";
begin();
/** How long the scripts of frames take, for tests. */
globalThis.playerCost = player.cost;
