// The finished robot that walks while the library loads.

import { Walk } from "./design.js";

/** How long the finished robot is shown before the page's own design takes the stage, milliseconds. */
export const GREETING = 4000;

/** Loads the walk of a finished robot; null if it cannot be loaded. `link` opens the robot. */
export async function hello() {
  try {
    const { world, robot, link } = await (await fetch(new URL("hello.json", import.meta.url))).json();
    return { walk: new Walk(world, robot), link };
  } catch {
    return null;
  }
}

/** Whether the page may begin a design by itself. */
export function mayBegin() {
  const still = matchMedia("(prefers-reduced-motion: reduce)").matches;
  const saves = navigator.connection?.saveData === true || matchMedia("(prefers-reduced-data: reduce)").matches;
  return !still && !saves && !new URLSearchParams(location.search).has("wait");
}
