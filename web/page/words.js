// The sentences under the stage.
/* global decimals: of drawing.js */

/** What a phase of the design does, in words that need no explanation. */
export const DOING = { co_design: "Searching", attraction: "Deciding", snap: "Deciding", fine_tuning: "Practising" };
const HOW = {
  co_design: "every bar may still become bone, muscle or nothing",
  attraction: "each bar becomes bone, muscle or nothing",
  snap: "each bar becomes bone, muscle or nothing",
  fine_tuning: "the body is ready, and the robot learns to use it",
};

const range = (low, high) => metres(low) === metres(high) ? metres(low) : `${decimals(low, 2)} to ${metres(high)}`;
const metres = x => `${decimals(x, 2)} m`;

export function working(design) {
  const { record } = design.robots.at(-1);
  if (record === null) return "Searching …";
  const left = (design.world.iterations - design.iteration) * design.seconds / design.iteration;
  return `${DOING[record.phase]}: ${HOW[record.phase]}. About ${Math.max(1, Math.round(left))} s left.`;
}

export function finished({ delivered, seconds, iteration }) {
  const { walk, asDesigned, measured } = delivered;
  if (walk.along === null) return walk === asDesigned ? `This robot falls apart: ${walk.diverged}.` : `Changed by you: ${walk.diverged}.`;
  if (walk !== asDesigned) return `Changed by you: it walks ${metres(walk.along)}; before, it was ${metres(asDesigned.along ?? 0)}. Click a bar to change it again.`;
  const touch = "Click a bar, drag the robot, or choose another ground.";
  if (measured === null) return `This robot is finished. It walks ${metres(walk.along)} in ${walk.duration.toFixed(1)} s. ${touch}`;
  const { p10, p50, p90 } = measured.spread;
  const { verdict, reason } = measured.reliability;
  const far = [p50, p10, p90].every(Number.isFinite)
    ? `from slightly different starts it walks ${range(p10, p90)}`
    : "from some slightly different starts it falls apart";
  const doubt = verdict === "unreliable" ? ` Unreliable: ${reason}.` : "";
  return `Finished after ${iteration} attempts and ${Math.round(seconds)} s: ${far}.${doubt} ${touch}`;
}

/** The other world in which the robot walks. */
function place({ ground, gravity }) {
  const on = ground && { flat: "on flat ground", steps: "on steps", rough: "on rough ground", uphill: "uphill", downhill: "downhill" }[ground.name];
  return [gravity && `with the gravity of ${gravity.name === "Moon" ? "the Moon" : gravity.name}`, on].filter(Boolean).join(" and ");
}

function visits({ walk }, { elsewhere, delivered }) {
  const here = place(elsewhere.changes);
  if (walk.along === null) return `The same robot ${here}: ${walk.diverged}.`;
  const [far, home] = [walk, delivered.walk].map(({ along }) => metres(along ?? 0));
  return `The same robot, now ${here}: it walks ${far} in ${walk.duration.toFixed(1)} s. In its own world it walks ${home}.`;
}

function told({ walk, along, left }) {
  if (along === null) return walk.along === null ? `After your push: ${walk.diverged}.` : "You pushed the robot. It walks on from there.";
  if (left === null) return `Told to go to ${metres(along)}: ${walk.diverged}.`;
  return `Told to go to ${metres(along)}. After ${walk.duration.toFixed(1)} s the robot is ${metres(left)} away from it.`;
}

/** The sentence for a state of the design. */
export function sentence(state, design) {
  if (design.told !== null && ["ready", "paused", "finished"].includes(state)) {
    return design.told.visits ? visits(design.told, design) : told(design.told);
  }
  return {
    empty: "",
    preparing: "Preparing the robot …",
    cancelled: "Cancelled. Press “Design a robot” to start again.",
    ready: "Here every bar is still undecided. Press “Design a robot”.",
    paused: `Paused after attempt ${design.iteration}.`,
    measuring: "Trying the robot from slightly different starts …",
    stopped: "The computation stopped.",
  }[state] ?? (state === "finished" ? finished(design) : working(design));
}

/** Shows a verdict: a list of clauses [words, items]. An item is { text, level }; its level ("good", "doubtful" or "bad")
 * is its colour. */
export function showVerdict(line, clauses) {
  const item = ({ text, level }) => Object.assign(document.createElement("span"), { textContent: text, className: level });
  const clause = ([words, items]) => [words, ...items.flatMap((it, k) => (k > 0 ? [", ", item(it)] : [item(it)])), ". "];
  line.replaceChildren(...clauses.flatMap(clause));
}
