// The page of a run. All of its drawings show the same time, the same iteration and the same chosen edge.

// Tests look for errors in this attribute of the document.
addEventListener("error", event => { document.body.dataset.error = event.message; });

const data = JSON.parse(document.getElementById("data").textContent);
const part = id => document.getElementById(id);
const { robot, world, gait, energies, forces, history, goals } = data;
const walkers = [...(data.designs ?? []), { iteration: data.iteration, mixtures: robot.mixtures, walk: data.walk }]
  .map(({ iteration, mixtures, walk }) => Object.assign(new Walker(robot, world, mixtures, walk), { iteration }));
const last = walkers.length - 1;
const view = { now: 0, playing: startsPlaying(), seen: false, shown: last, chosen: null, hovered: null, evolving: false };
const percent = share => `${share > 0 ? "+" : ""}${decimals(100 * share, 1)}\u00a0%`;
const newton = force => `${decimals(force, Math.abs(force) < 10 ? 2 : 1)}\u00a0N`;

// Functions that draw: those in `moving` are called for every frame, those in `still` only when the iteration or the
// chosen edge changes.
const moving = [], still = [];
const drawStill = () => still.forEach(draw => draw());
const walker = () => walkers[view.shown];
const highlight = () => view.hovered ?? view.chosen;

function choose(edge) {
  view.chosen = edge;
  drawStill();
}

function hover(edge) {
  if (view.hovered === edge) return;
  view.hovered = edge;
  drawStill();
}

// Marks the edge under the mouse in all drawings. A click or a tap chooses the edge until the next click on it.
function link(canvas, edgeAt, stays = false) {
  canvas.addEventListener("pointermove", event => {
    if (event.pointerType !== "mouse") return;
    const edge = edgeAt(event.clientX, event.clientY);
    canvas.style.cursor = edge === null ? "default" : "pointer";
    hover(edge);
  });
  canvas.addEventListener("pointerleave", () => hover(null));
  canvas.addEventListener("click", event => {
    const edge = edgeAt(event.clientX, event.clientY);
    choose(edge === view.chosen && !stays ? null : edge);
  });
}

function seek(time) {
  view.now = Math.min(time, walker().duration);
}

// Shows another iteration, at the same time if its walk is long enough.
function show(index) {
  view.shown = index;
  if (view.now > walker().duration) view.now = 0;
  drawStill();
}

function player() {
  const stage = new Stage(part("stage"), { ...world, payloads: robot.payloads });
  stage.orbit = new Orbit(viewOf(robot));
  stage.orbit.listen(stage.canvas);
  link(stage.canvas, (x, y) => stage.edgeAt(x, y));
  const [play, time] = ["play", "time"].map(part);
  const toggle = () => {
    view.seen = true;
    view.playing = !view.playing;
    play.textContent = view.playing ? "Pause" : "Play";
  };
  play.textContent = view.playing ? "Pause" : "Play";
  play.onclick = toggle;
  playBySpace(toggle);
  time.oninput = () => seek(Number(time.value));
  part("limit").textContent = `\u00b1${decimals(100 * world.limit, 0)} %`;
  const strongest = forces ? Math.max(0, ...gait.peaks.flatMap(peak => peak.slice(2))) : 0;
  part("strongest").textContent = newton(strongest);
  part("sound").textContent = world.skeleton.map(strain => decimals(100 * strain, 0)).join(" to ");
  part("by").hidden = !forces;
  part("of-goal").hidden = goals.length === 0;
  const byForce = () => Boolean(forces) && view.shown === last && part("colours").value === "force";
  part("colours").onchange = drawStill;
  still.push(() => {
    for (const id of ["of-strain", "of-beyond", "of-skeleton"]) part(id).hidden = byForce();
    part("of-force").hidden = !byForce();
    part("colours").disabled = view.shown !== last;
    time.max = walker().duration;
  });
  moving.push(moment => {
    const colours = byForce() ? {} : null;
    if (colours) gait.bars.forEach((edge, k) => { colours[edge] = stage.shade(Math.max(-1, Math.min(1, forceAt(moment.frame, k) / strongest))); });
    const { iteration } = walker();
    const which = view.shown === last ? "" : `   iteration ${iteration}`;
    const goal = goalAt(view.now);
    const to = goal ? `   goal ${goal.slice(4, robot.axes + 3).map(place => decimals(place, 2)).join(", ")} m` : "";
    const label = `${decimals(view.now, 1)} s   ${decimals(moment.metres, 2)} m${to}${which}`;
    stage.draw({ ...moment, highlight: highlight(), label, colours, goal: goal?.slice(1, 4) });
    time.value = view.now;
    time.setAttribute("aria-valuetext", label);
  });
  return stage;
}

// The goal at a time: [its beginning, the x, y and z of the ground below it, its place along the ground and across].
const goalAt = time => goals.filter(([from]) => from <= time).pop() ?? null;

const forceAt = (frame, bar) => forces.counts[frame][bar] * forces.unit;

function evolution() {
  part("evolution").hidden = last === 0;
  const [slider, which, evolve] = ["iteration", "which", "evolve"].map(part);
  slider.max = last;
  slider.oninput = () => {
    view.evolving = false;
    show(Number(slider.value));
  };
  evolve.onclick = () => {
    view.evolving = !view.evolving;
    if (view.evolving) {
      view.now = 0;
      if (!view.playing) part("play").click();
      show(0);
    }
    drawStill();
  };
  still.push(() => {
    const { iteration, walk } = walker();
    const says = view.shown === last ? `delivered, iteration ${iteration}` : `iteration ${iteration}${walk ? "" : ", no walk kept"}`;
    slider.value = view.shown;
    slider.setAttribute("aria-valuetext", says);
    which.textContent = says;
    evolve.textContent = view.evolving ? "Stop" : "Evolve";
  });
}

// The camera that looks at the robot at rest.
function atRest() {
  const axes = [0, 1, 2].map(axis => robot.start.filter((_, k) => k % 3 === axis));
  const middle = of => (Math.min(...of) + Math.max(...of)) / 2;
  return [middle(axes[0]), middle(axes[1]), Math.min(...axes[2])];
}

function design() {
  const layout = new Stage(part("layout"), { ...world, width: 3.1 * robot.side, payloads: robot.payloads, view: viewOf(robot) });
  const ternary = new Ternary(part("ternary"));
  if (robot.axes === 3) {
    layout.orbit = new Orbit(viewOf(robot));
    layout.orbit.listen(layout.canvas, { onturn: drawStill });
  }
  link(layout.canvas, (x, y) => layout.edgeAt(x, y));
  link(ternary.canvas, (x, y) => ternary.edgeAt(x, y));
  const camera = atRest();
  const paths = robot.materials.map((material, e) => (material === 0 ? null : walkers.map(walker => walker.mixtures[e])));
  const count = material => robot.materials.filter(other => other === material).length;
  part("counts").textContent = robot.undecided
    ? `${robot.edges.length} edges, all undecided; the fainter, the less solid`
    : `${count(1)} skeleton, ${count(2)} actuators, ${count(0)} void, void edges faint`;
  const select = part("edge");
  robot.edges.forEach((_, e) => select.add(new Option(`${e}, ${nameOf(e)}`, e)));
  select.onchange = () => choose(select.value === "" ? null : Number(select.value));
  still.push(() => {
    layout.draw({ positions: robot.start, edges: walker().edges, camera, highlight: highlight(), colours: walker().edges.map(([, , , material]) => layout.colour(MATERIALS[material])) });
    ternary.draw({ mixtures: walker().mixtures, delivered: robot.materials, paths, highlight: highlight() });
    select.value = highlight() ?? "";
  });
  moving.push(moment => { part("told").textContent = told(highlight(), moment); });
}

// The material of an edge.
const nameOf = edge => (robot.undecided ? "undecided" : MATERIALS[robot.materials[edge]]);

// A sentence about an edge: its material, and its strain and force now and at their peaks.
function told(edge, { shape, frame }) {
  if (edge === null) return "Point at a bar, a row or a point, or choose an edge.";
  const [i, j] = robot.edges[edge];
  const words = [`${nameOf(edge)}, nodes ${i}\u2013${j}, ${decimals(1000 * robot.rest[edge], 0)} mm`];
  const bar = gait ? gait.bars.indexOf(edge) : -1;
  if (bar >= 0 && view.shown === last) {
    const [low, high, push, pull] = gait.peaks[bar];
    const strain = distance(shape, i, j) / robot.rest[edge] - 1;
    words.push(`strain ${percent(strain)} (${percent(low)} to ${percent(high)})`);
    words.push(`force ${newton(forceAt(frame, bar))} (${newton(-push)} to ${newton(pull)})`);
  }
  return words.join(" \u00b7 ");
}

// The phase of a number over the last periods, from 0 to 1: the place of its first harmonic.
function phaseOf(values) {
  const { times, period } = gait;
  const turn = time => 2 * Math.PI * time / period;
  const sum = of => values.reduce((sum, value, k) => sum + value * of(turn(times[k])), 0);
  return (Math.atan2(sum(Math.sin), sum(Math.cos)) / (2 * Math.PI) + 1) % 1;
}

// Sorts the actuators by the phase of their target strains, and returns groups of them. Actuators with a similar phase
// are in one group; the first group follows the largest gap between phases.
function groups() {
  const rows = gait.actuators.map((_, k) => ({ k, phase: phaseOf(gait.commands[k]) })).sort((a, b) => a.phase - b.phase);
  const gap = at => (rows[at].phase - rows[(at + rows.length - 1) % rows.length].phase + 1) % 1;
  const first = rows.length > 1 ? rows.reduce((best, _, at) => (gap(at) > gap(best) ? at : best), 0) : 0;
  const sorted = rows.map((_, at) => rows[(first + at) % rows.length]);
  const from = sorted[0].phase;
  const groups = [];
  for (const { k, phase } of sorted) {
    const quarter = Math.min(3, Math.floor(4 * ((phase - from + 1) % 1)));
    if (groups.at(-1)?.quarter !== quarter) groups.push({ quarter, rows: [], phases: [] });
    groups.at(-1).rows.push(k);
    groups.at(-1).phases.push(phase);
  }
  const order = groups.flatMap(group => group.rows);
  for (const key of ["actuators", "commands", "strains"]) gait[key] = order.map(k => gait[key][k]);
  let row = 0;
  return groups.map(({ rows: { length }, phases }) => {
    row += length;
    return { first: row - length, actuators: gait.actuators.slice(row - length, row), phases };
  });
}

// A small robot for each group of actuators, in which their bars are coloured.
function drawGroups(groups) {
  const camera = atRest();
  groups.forEach(({ actuators, phases }, k) => {
    const figure = document.createElement("figure");
    const canvas = document.createElement("canvas");
    const caption = document.createElement("figcaption");
    const ends = [phases[0], phases[phases.length - 1]].map(phase => decimals(100 * phase, 0));
    caption.textContent = `${"ABCD"[k]}: phase ${ends[0] === ends[1] ? ends[0] : ends.join(" to ")} %, ${actuators.length} ${actuators.length > 1 ? "actuators" : "actuator"}`;
    canvas.setAttribute("role", "img");
    canvas.setAttribute("aria-label", `The actuators of group ${"ABCD"[k]}: edges ${actuators.join(", ")}`);
    figure.append(canvas, caption);
    part("groups").append(figure);
    const small = new Stage(canvas, { ...world, width: 3.1 * robot.side, payloads: robot.payloads, view: viewOf(robot) });
    const chosen = new Set(actuators);
    const bars = walkers[last].bars;
    const draw = () => small.draw({ positions: robot.start, edges: bars, camera, highlight: highlight(), colours: robot.edges.map((_, edge) => small.colour(chosen.has(edge) ? "actuator" : "void")) });
    link(canvas, (x, y) => small.edgeAt(x, y), true);
    still.push(draw);
  });
}

function actuators(stage) {
  const phases = groups();
  drawGroups(phases);
  const breaks = phases.slice(1).map(({ first }) => first);
  const letterOf = row => "ABCD"[breaks.filter(first => first <= row).length];
  const rows = gait.actuators.map(edge => gait.bars.indexOf(edge));
  const buttons = gait.actuators.map(edge => {
    const button = Object.assign(document.createElement("button"), { type: "button", textContent: edge, onclick: () => choose(edge) });
    button.setAttribute("aria-label", `actuator of edge ${edge}, group ${letterOf(gait.actuators.indexOf(edge))}`);
    button.title = `group ${letterOf(gait.actuators.indexOf(edge))}`;
    if (breaks.includes(gait.actuators.indexOf(edge))) button.classList.add("break");
    button.onfocus = () => { if (button.matches(":focus-visible")) choose(edge); };
    button.onpointerenter = () => hover(edge);
    button.onpointerleave = () => hover(null);
    return button;
  });
  part("rows").append(...buttons);
  part("peaks").append(...rows.map(bar => {
    const line = document.createElement("span");
    const ends = gait.peaks[bar].slice(0, 2).map(strain => {
      const beyond = Math.abs(strain) > world.limit;
      return Object.assign(document.createElement("b"), { textContent: percent(strain), className: beyond ? "beyond" : "", style: beyond ? "" : "font-weight: 400" });
    });
    line.append(ends[0], "\u2002", ends[1]);
    return line;
  }));
  const edgeOf = row => gait.actuators[row] ?? null;
  for (const id of ["commands", "strains"]) {
    part(id).style.height = `${24 * rows.length}px`;
    const heat = new Heat(part(id));
    link(heat.canvas, (_, y) => edgeOf(heat.rowAt(y)), true);
    heat.canvas.addEventListener("click", event => goTo(heat.timeAt(event.clientX)));
    moving.push(() => heat.draw({ ...gait, rows: gait[id], breaks, cursor: cursor(), chosen: gait.actuators.indexOf(highlight()), colour: strain => stage.strainColour(strain) }));
  }
  still.push(() => buttons.forEach((button, k) => button.setAttribute("aria-pressed", gait.actuators[k] === highlight())));
}

// The current time if the delivered robot is shown, otherwise a time outside all diagrams.
const cursor = () => (view.shown === last ? view.now : -1);

function goTo(time) {
  if (view.shown !== last) show(last);
  seek(time);
}

function feet() {
  const feet = new Feet(part("feet"));
  part("feet").style.height = `${24 * Math.max(1, gait.feet.length) + 24}px`;
  feet.canvas.addEventListener("click", event => goTo(feet.timeAt(event.clientX)));
  moving.push(() => feet.draw({ ...gait, cursor: cursor() }));
  const { times, period } = gait;
  const shown = Math.min(3, Math.round((times[times.length - 1] - times[0]) / period));
  part("periods").textContent = shown > 1 ? `The last ${shown} periods of the clock, ${decimals(period, 2)} s each` : `${decimals(period, 2)} s at the end`;
}

function bars() {
  const peaks = new Peaks(part("forces"));
  link(peaks.canvas, x => peaks.edgeAt(x));
  const order = gait.bars.map((_, bar) => bar).sort((a, b) => Math.max(...gait.peaks[b].slice(2)) - Math.max(...gait.peaks[a].slice(2)));
  moving.push(({ frame }) => {
    const now = bar => (view.shown === last ? forceAt(frame, bar) : null);
    peaks.draw({ bars: order.map(bar => ({ edge: gait.bars[bar], push: gait.peaks[bar][2], pull: gait.peaks[bar][3], now: now(bar) })), highlight: highlight() });
  });
}

function energy() {
  const curve = new Curve(part("energy"), goTo, 0.1);
  const line = (name, colour, key) => ({ name, colour, points: energies.times.map((time, k) => [time, energies[key][k]]) });
  const series = [line("kinetic", "accent", "kinetic"), line("in springs", "third", "elastic"), line("of height", "second", "height")];
  const x = [0, energies.times[energies.times.length - 1]];
  moving.push(() => curve.draw({ title: "Energy, J", series, x, unit: "s", cursor: view.shown === last ? view.now : 0, digits: 3 }));
}

function convergence() {
  const { charts, phases, first } = history;
  const count = charts[0].series[0].numbers.length;
  const x = [first - 1, first - 1 + count];
  const colours = ["accent", "second", "third", "fourth"];
  const line = ({ name, colour, numbers }) => ({ name, colour: colours[colour], points: numbers.flatMap((y, k) => (y === null ? [] : [[first + k, y]])) });
  // Shows the recorded design whose iteration is nearest.
  const toIteration = iteration => {
    view.evolving = false;
    if (last > 0) show(walkers.reduce((best, { iteration: at }, k) => (Math.abs(at - iteration) <= Math.abs(walkers[best].iteration - iteration) && k < last ? k : best), 0));
  };
  for (const { id, title, series, levels, log } of charts) {
    const curve = new Curve(part(id), toIteration, 10);
    still.push(() => curve.draw({ title, series: series.map(line), x, unit: "iterations", phases, cursor: Math.min(x[1], walker().iteration), levels, log, robust: true }));
  }
  const names = phases.map(({ name, from, to }) => `${name.replace("_", "-")} ${from + 1 < to ? `${from + 1}\u2013` : ""}${to}`);
  part("phases").textContent = `Phases: ${names.join(", ")}. Dashed: the median of the final robot, and the bounds before they widen.`;
}

const stage = part("stage") ? player() : null;
if (part("evolution")) evolution();
if (part("layout")) design();
if (gait && part("feet")) {
  feet();
  energy();
  if (gait.bars.length > 0) {
    actuators(stage);
    bars();
  } else part("of-bars").remove();
}
if (!history?.charts.some(({ id }) => id === "objective")) part("objective")?.remove();
if (history && part("volumes")) convergence();
else for (const id of ["objective", "displacement"]) part(id)?.remove();
drawStill();
// Paper has other colours than the screen.
for (const moment of ["beforeprint", "afterprint"]) addEventListener(moment, drawStill);
// The robot starts when it is seen.
if (stage) whenSeen(stage.canvas, () => { view.seen = true; });
everyFrame(seconds => {
  if (view.playing && view.seen) view.now += seconds * Number(part("speed")?.value ?? 1);
  const ends = view.evolving && view.shown < last ? Math.min(2.5, walker().duration) : walker().duration;
  if (view.now > ends) {
    view.now = 0;
    if (view.shown === last) view.evolving = false;
    show(view.evolving ? view.shown + 1 : view.shown);
  }
  if (view.playing && view.seen) stage?.orbit.sway(seconds);
  const moment = walker().at(view.now);
  moving.forEach(draw => draw(moment));
});
document.body.dataset.ready = "true";
