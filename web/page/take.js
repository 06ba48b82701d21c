// What a visitor takes along: a film of the walk, and the link. `tell` shows what happens.
/* global decimals: of drawing.js */

import { film, save } from "./film.js";

/** Records the walk on the stage and saves it under a name. */
export async function takeFilm({ canvas, player, signal, name, tell }) {
  const style = getComputedStyle(document.documentElement);
  const colour = name => style.getPropertyValue(`--${name}`).trim();
  const { walk } = player;
  try {
    const { blob, ending } = await film({
      canvas, player, signal,
      label: time => `${time.toFixed(1)} s   ${decimals(walk.at(time).metres, 2)} m`,
      title: [document.title, `${location.host}${location.pathname}`],
      colours: { paper: colour("panel"), ink: colour("ink") },
      onprogress: share => tell(`Recording the walk: ${Math.round(100 * share)} %`),
    });
    save(`${name}.${ending}`, blob);
    tell("The animation is saved.");
  } catch (error) {
    if (error.name !== "AbortError") throw error;
    tell("No animation was saved, because another robot replaced this one.");
  }
}

/** Shares the address of the page: with the system's dialog on telephones, otherwise by copying it. `holds` says what the
 * link holds; null if it holds no robot. */
export async function takeLink({ url = location, holds, tell }) {
  const what = holds ? `The link has ${url.href.length} characters and holds ${holds}.` : "The link designs this robot again.";
  try {
    if (navigator.share && matchMedia("(pointer: coarse)").matches) {
      await navigator.share({ title: document.title, url: url.href });
    } else {
      await navigator.clipboard.writeText(url.href);
      tell(`The link is copied. ${what}`);
    }
  } catch (error) {
    if (error.name === "AbortError") return;
    const isHere = url === location;
    tell(`The browser does not allow the page to copy. ${isHere ? "The link is in the address bar." : `The link is ${url.href}`}`);
  }
}
