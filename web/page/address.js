// Keeps the address of the page up to date, so that the link, a refresh and Back show the same robot again.

import { readLink } from "./link.js";
import { DEFAULT } from "./scene.js";

const first = readLink(location.hash);
/** Whether the address named what to show when the page was opened. */
export const linked = first.names.length > 0 || String(first.link) !== "";

/** Writes the link into the address. The page's own scene needs none. Back returns to a finished robot, and to the robot
 * before an edit. */
export function keepAddress(scene) {
  const isOwn = !linked && scene.link === `#scene=${DEFAULT}&seed=1`;
  if (isOwn && location.hash === "") return;
  const { names, link } = readLink(location.hash);
  const isOther = names.length > 0 ? !scene.isNamed : link.has("robot") && scene.robot !== link.get("robot");
  history[isOther ? "pushState" : "replaceState"](null, "", scene.link);
}

/** Writes the finished robot, and the other world in which it walks, into the address. */
export function keepRobot(scene, { delivered, elsewhere }) {
  scene.robot = delivered.link;
  if (scene.names.length > 0) scene.born = delivered.designed.link;
  const changes = Object.entries(elsewhere?.changes ?? {});
  scene.visited = Object.fromEntries(changes.map(([kind, { name }]) => [kind, name]));
  keepAddress(scene);
}
