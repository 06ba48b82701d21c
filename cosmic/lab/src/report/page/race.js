// Robots of several runs in lanes, one above the other, all on the same ground, at the same time and to the same scale.

addEventListener("error", event => { document.body.dataset.error = event.message; });

const part = id => document.getElementById(id);
const lanes = JSON.parse(part("data").textContent).map(({ name, robot, world, walk }) => {
  const lane = document.createElement("li");
  const metres = document.createElement("span");
  const canvas = document.createElement("canvas");
  metres.className = "number";
  canvas.setAttribute("aria-label", `The robot of ${name} on its ground; arrow keys turn the view, Home turns it back`);
  lane.append(Object.assign(document.createElement("b"), { textContent: name }), metres, canvas);
  part("lanes").append(lane);
  const walker = new Walker(robot, world, robot.mixtures, walk);
  return { walker, metres, canvas, stage: new Stage(canvas, { ...world, payloads: robot.payloads }) };
});
// All lanes have one view, so that distances compare. Robots in space are seen from the side and a little from above.
const orbit = new Orbit(lanes.some(({ walker }) => walker.robot.axes === 3) ? [-20, 12] : SIDE);
for (const { stage } of lanes) {
  stage.orbit = orbit;
  orbit.listen(stage.canvas);
}
const duration = Math.max(...lanes.map(({ walker }) => walker.duration));
const tallest = Math.max(...lanes.map(({ walker }) => walker.robot.side));
// The finish line is a round number of metres before the place where the best robot ends.
const best = Math.max(...lanes.map(({ walker }) => walker.at(walker.duration).metres));
const finish = best > 0 ? Math.floor(0.9 * best / roundStep(best / 20) + 1e-9) * roundStep(best / 20) : null;
// The time at which each robot first reaches the finish line; null if it does not.
for (const lane of lanes) {
  const { walk, duration } = lane.walker;
  const times = walk ? walk.counts.map((_, k) => Math.min(duration, k * walk.every)) : [];
  lane.finished = finish === null ? null : times.find(time => lane.walker.at(time).metres >= finish) ?? null;
}
const race = { now: 0, playing: startsPlaying(), seen: false };
const [play, time] = ["play", "time"].map(part);

function toggle() {
  race.seen = true;
  race.playing = !race.playing;
  play.textContent = race.playing ? "Pause" : "Play";
}

play.textContent = race.playing ? "Pause" : "Play";
play.onclick = toggle;
playBySpace(toggle);
time.max = duration;
time.oninput = () => { race.now = Number(time.value); };

whenSeen(lanes[0].canvas, () => { race.seen = true; });
everyFrame(seconds => {
  if (race.playing && race.seen) {
    race.now += seconds * Number(part("speed").value);
    orbit.sway(seconds);
  }
  if (race.now > duration) race.now = 0;
  const moments = lanes.map(({ walker }) => walker.at(Math.min(race.now, walker.duration)));
  // Choose the scale such that all robots are in view and none is higher than its lane.
  const places = moments.map(({ camera }) => camera[0]);
  const [last, first] = [Math.min(...places), Math.max(...places)];
  const { clientWidth: width, clientHeight: height } = lanes[0].canvas;
  const scale = Math.min(0.62 * height / tallest, width / (first - last + 2.5 * tallest));
  lanes.forEach(({ walker, metres, stage }, k) => {
    stage.world = { ...walker.world, payloads: walker.robot.payloads, width: Math.min(2.4 * height, 2 * width) / scale, finish: finish ?? undefined };
    const level = moments[k].camera;
    stage.draw({ ...moments[k], camera: [(first + last) / 2, 0, level[2]], level });
    const { finished } = lanes[k];
    const at = finished !== null && race.now >= finished ? `finish ${decimals(finish, digitsOf(roundStep(best / 20)))} m after ${decimals(finished, 1)} s \u00b7 ` : "";
    metres.textContent = `${at}${decimals(moments[k].metres, 2)} m`;
  });
  time.value = race.now;
  part("clock").textContent = `${decimals(race.now, 1)} s`;
  time.setAttribute("aria-valuetext", `${decimals(race.now, 1)} s`);
});
document.body.dataset.ready = "true";
