// The sentences under the stage, and the headline on it.
/* global decimals: of drawing.js */

/** What a phase of the design does, in words that need no explanation. */
export const DOING = { co_design: "Searching", attraction: "Deciding", snap: "Deciding", fine_tuning: "Practising" };
const HOW = {
  co_design: "every bar may still become bone, muscle or nothing",
  attraction: "each bar becomes bone, muscle or nothing",
  snap: "each bar becomes bone, muscle or nothing",
  fine_tuning: "the body is ready, and the robot learns to use it",
};

export const metres = x => `${decimals(x, 2)} m`;
const range = (low, high) => metres(low) === metres(high) ? metres(low) : `${decimals(low, 2)} to ${metres(high)}`;
const isKnown = distance => distance !== null && [distance.p10, distance.p50, distance.p90].every(Number.isFinite);

/**
 * The headline, the flag and what they mean: { far, title }, where `far` is in metres, or null for a walk that diverged.
 * Of a finished robot it is the median of slightly different walks, otherwise the distance of the walk on the stage.
 * @param walk is the walk on the stage, `looked` the attempt that the user chose to see, or null.
 */
export function headline({ walk, looked, design: { delivered, told } }) {
  const within = `in ${walk.took.toFixed(1)} s`;
  if (looked === null && told === null && delivered?.measured?.distance) return { far: delivered.measured.distance.p50, title: `typical distance ${within}` };
  if (looked === null && told !== null && told.to !== null) return { far: walk.along, title: "place at the end" };
  return { far: walk.along, title: `distance ${within}` };
}

/** What the headline shows. */
export const shownAs = far => far === null ? "diverged" : metres(far);

function working(design) {
  const { record } = design.robots.at(-1);
  if (record === null) return "Searching …";
  const left = (design.world.iterations - design.iteration) * design.seconds / design.iteration;
  return `${DOING[record.phase]}: ${HOW[record.phase]}. About ${Math.max(1, Math.round(left))} s left.`;
}

/** The sentence about an earlier attempt that the user looks at. */
function attempt(design, looked) {
  const { walk, record } = design.robots[looked];
  const far = walk.along === null ? walk.diverged : `it walks ${metres(walk.along)}`;
  const phase = record === null ? "Every bar is still undecided" : `${DOING[record.phase]}: ${HOW[record.phase]}`;
  return `Version ${looked} of ${design.world.iterations}: ${far}. ${phase}.`;
}

/** The median distance of a robot, m; null if it is not measured, and if it sometimes falls apart. */
export function medianOf({ measured }) {
  const median = measured?.distance?.p50;
  return Number.isFinite(median) ? median : null;
}

/** How far a finished robot walks: in slightly different walks, if they are measured. */
function distance({ walk, measured }) {
  const within = `in ${walk.took.toFixed(1)} s`;
  const changes = "with small changes of start, friction and stiffness";
  if (!measured?.distance) return `It walks ${metres(walk.along)} ${within}.`;
  const { p10, p50, p90 } = measured.distance;
  const { verdict, reason } = measured.reliability;
  const doubt = verdict === "unreliable" ? ` Unreliable: ${reason}.` : "";
  const far = isKnown(measured.distance)
    ? `Typically it walks ${metres(p50)} ${within}: ${range(p10, p90)} in eight trials ${changes}.`
    : `It walks ${metres(walk.along)} ${within}, but ${changes} it sometimes falls apart in eight trials.`;
  return `${far}${doubt}`;
}

function finished(design) {
  const { delivered, seconds, iteration } = design;
  const { walk, designed } = delivered;
  const isChanged = walk !== designed.walk;
  const how = isChanged ? "Changed by you" : design.hasAttempts ? `Finished after ${iteration} versions and ${Math.round(seconds)} s` : "This robot is finished";
  if (walk.along === null) return isChanged ? `${how}: ${walk.diverged}.` : `This robot falls apart: ${walk.diverged}.`;
  if (isChanged) {
    const [own, before] = [delivered, designed].map(robot => delivered.measured ? medianOf(robot) ?? robot.walk.along : robot.walk.along);
    return `${how}: ${metres(own)} instead of ${metres(before ?? 0)}. ${distance(delivered)}`;
  }
  return `${how}. ${distance(delivered)} Click a bar, drag the robot, or choose another ground.`;
}

/** The other world in which the robot walks. */
function place({ ground, gravity }) {
  const on = ground && { flat: "on flat ground", steps: "on steps", rough: "on rough ground", uphill: "uphill", downhill: "downhill" }[ground.name];
  return [gravity && `with the gravity of ${gravity.name === "Moon" ? "the Moon" : gravity.name}`, on].filter(Boolean).join(" and ");
}

function visits({ walk }, { elsewhere, delivered }) {
  const here = place(elsewhere.changes);
  if (walk.along === null) return `The same robot ${here}: ${walk.diverged}.`;
  const median = medianOf(delivered);
  return `The same robot, now ${here}: it walks ${metres(walk.along)} in ${walk.took.toFixed(1)} s. In its own world it walks ${metres(median ?? delivered.walk.along ?? 0)}.`;
}

function told({ walk, to, left }) {
  if (to === null) {
    if (walk.along === null) return `After your push: ${walk.diverged}.`;
    return `You pushed the robot. It walks on from there: ${metres(walk.along)} in ${walk.took.toFixed(1)} s.`;
  }
  const [along, across] = to;
  const aside = Math.abs(across) < 0.005 ? "" : `, ${metres(Math.abs(across))} to the ${across > 0 ? "left" : "right"}`;
  if (left === null) return `Told to go to ${metres(along)}${aside}: ${walk.diverged}.`;
  return `Told to go to ${metres(along)}${aside}. After ${walk.took.toFixed(1)} s the robot is ${metres(left)} away from it.`;
}

/** How far the robot of a name walks. */
function named({ owner, delivered, best }, state) {
  if (owner === undefined || !["working", "paused", "measuring", "finished"].includes(state)) return "";
  if (delivered && delivered.walk !== delivered.designed.walk) return "";
  const far = state === "finished" ? medianOf(delivered) : best?.walk.along ?? null;
  return far === null ? "" : `${owner} walks ${metres(far)}${state === "finished" ? "" : " so far"}. `;
}

/** What the race against the robot to beat has come to. Only medians are compared: one walk may be a lucky one. */
function race({ rival, delivered }, state) {
  if (rival === null) return "";
  if (rival.measured === null) return "Measuring the robot to beat … ";
  const [far, own] = [medianOf(rival), state === "finished" ? medianOf(delivered) : null];
  if (far === null) return "The robot to beat sometimes falls apart. ";
  const { claimed } = rival;
  const claims = claimed !== null && Math.abs(claimed - far) > 0.01 ? ` (the link says ${metres(claimed)}, but this is what it walks)` : "";
  if (own === null) return `To beat: ${metres(far)}${claims}. `;
  const both = `${metres(own)} against ${metres(far)}${claims}`;
  if (metres(own) === metres(far)) return `A tie: ${both}. “Design another” tries again. `;
  return own > far ? `You beat it: ${both}. Share the link. ` : `Not beaten yet: ${both}. “Design another” tries again. `;
}

const timed = seconds => `${decimals(seconds, seconds < 9.95 ? 1 : 0)} s`;

/** What the race against evolution has come to: how many robots, and how much time, both needed for the same distance. */
function evolution({ twin, robots }, state) {
  if (!twin.walk) return twin.runs ? "Evolution begins with robots at random. " : "";
  const far = twin.walk.along;
  const as = robots.findIndex(({ walk }) => walk.along >= far);
  const here = as > 0 ? `; the gradient needed ${as} ${as === 1 ? "version" : "versions"} and ${timed(robots[as].seconds)}` : as < 0 && robots.length > 1 ? `; the gradient ${state === "finished" ? "did not get" : "has not got"} that far` : "";
  return `Evolution needed ${twin.found} robots and ${timed(twin.seconds)} to walk ${metres(far)}${here}. `;
}

/** The sentence for a state of the design. `looked` is the attempt that the user looks at, or null. */
export function sentence(state, design, looked) {
  if (looked !== null && ["working", "paused", "measuring", "finished"].includes(state)) return attempt(design, looked);
  if (design.told !== null && ["ready", "paused", "finished"].includes(state)) {
    return design.told.visits ? visits(design.told, design) : told(design.told);
  }
  return named(design, state) + evolution(design, state) + race(design, state) + {
    empty: "",
    preparing: "Preparing the robot …",
    asking: `A walk of this link costs about ${Math.round(design.costs)} times as much as one of the page’s own. Press “Open it” to go on.`,
    cancelled: "Cancelled. Press “Design a robot” to start again.",
    ready: "Here every bar is still undecided. Press “Design a robot”.",
    paused: `Paused after version ${design.iteration}.`,
    measuring: "Trying the robot from slightly different starts …",
    stopped: "The computation stopped.",
    finished: state === "finished" && finished(design),
    working: state === "working" && working(design),
  }[state];
}

/** Shows a verdict: a list of clauses [words, items]. An item is { text, level }; its level ("good", "doubtful" or "bad")
 * is its colour. */
export function showVerdict(line, clauses) {
  const item = ({ text, level }) => Object.assign(document.createElement("span"), { textContent: text, className: level });
  const clause = ([words, items]) => [words, ...items.flatMap((it, k) => (k > 0 ? [", ", item(it)] : [item(it)])), ". "];
  line.replaceChildren(...clauses.flatMap(clause));
}
