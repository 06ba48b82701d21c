// Keeps the address of the page up to date, so that the link, a refresh and Back show the same robot again.

import { DEFAULT } from "./scene.js";

/** Whether the address named what to show when the page was opened. */
export const linked = location.hash.length > 1;

/** Writes the link into the address. The page's own scene needs none. Back returns to a finished robot, and to the robot
 * before an edit. */
export function keepAddress(scene) {
  const isOwn = !linked && scene.link === `#scene=${DEFAULT}&seed=1`;
  if (isOwn && location.hash === "") return;
  const before = new URLSearchParams(location.hash.slice(1));
  const isOther = before.has("robot") && scene.robot !== before.get("robot");
  history[isOther ? "pushState" : "replaceState"](null, "", scene.link);
}

/** Writes the finished robot, and the other world in which it walks, into the address. */
export function keepRobot(scene, { delivered, elsewhere }) {
  scene.robot = delivered.link;
  const changes = Object.entries(elsewhere?.changes ?? {});
  scene.visited = Object.fromEntries(changes.map(([kind, { name }]) => [kind, name]));
  keepAddress(scene);
}
