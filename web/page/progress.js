// The curve of the distances over the attempts.

const PHASES = { co_design: "co-design", attraction: "attraction", snap: "snap", fine_tuning: "fine-tuning" };

/** What the curve shows of a design, with its cursor at an attempt. */
export function progressOf({ robots, world }, attempt) {
  const points = robots.map(({ walk }, k) => [k, walk.along ?? NaN]);
  return {
    title: "Displacement after each iteration, m",
    series: [{ name: "displacement", colour: "accent", points }],
    x: [0, world.iterations],
    unit: "iterations",
    cursor: attempt,
    phases: phasesOf(robots),
  };
}

/** The phases, each with its range of iterations. */
function phasesOf(robots) {
  const spans = [];
  robots.forEach(({ record }, k) => {
    const name = record && PHASES[record.phase];
    if (name === null) return;
    if (spans.at(-1)?.name === name) spans.at(-1).to = k;
    else spans.push({ name, from: k - 1, to: k });
  });
  return spans;
}
