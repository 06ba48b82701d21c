// Lists for those who build the finished robot: its parts, and the lengths of its actuators over a period. Both can be saved, as
// the tables that `cosmic export` writes.
/* global decimals: of drawing.js */

import { save } from "./film.js";

/** The page shows this many moments of a period. */
const SHOWN = 10;
/** The numbers of the files are rounded to this many decimals, as in `cosmic export`. */
const DECIMALS = 9;

/** What the page calls some parts. */
const NAMES = { device: "cylinder", actuator: "muscle", skeleton: "bone", payload: "cargo" };

const number = x => x === null ? "" : String(Number(x.toFixed(DECIMALS)));
const csv = rows => rows.map(row => `${row.join(",")}\n`).join("");
const places = ({ places }) => [...new Set(places)].join(" ");

/** `parts.csv` of an answer of the library. */
export function partsFile({ pieces }) {
  const rows = pieces.map(piece => [piece.part, piece.places.length, number(piece.length), number(piece.mass), places(piece)]);
  return csv([["part", "number", "length", "mass", "places"], ...rows]);
}

/** `drive.csv` of an answer of the library that has a drive. */
export function driveFile({ drive: { every, lengths } }) {
  const rows = lengths[0][1].map((_, k) => [number(k * every), ...lengths.map(([, all]) => number(all[k]))]);
  return csv([["time", ...lengths.map(([edge]) => `length_${edge}`)], ...rows]);
}

/** Fills a table with rows of texts. The first row is its head. */
function fill(table, rows) {
  table.replaceChildren();
  rows.forEach((texts, k) => {
    const [name, given] = k === 0 ? ["th", { scope: "col" }] : ["td", {}];
    const cells = texts.map(textContent => Object.assign(document.createElement(name), given, { textContent }));
    table.insertRow().append(...cells);
  });
}

export class Shop {
  #parts;
  #design;
  /** The robot that is listed, and its lists. */
  #delivered = null;
  #lists = null;

  /** @param parts are the elements `section`, `pieces`, `drive`, `says`, `savePieces` and `saveDrive`. */
  constructor({ design, parts, onerror }) {
    [this.#design, this.#parts] = [design, parts];
    this.onerror = onerror;
    const give = (name, text) => save(name, new Blob([text], { type: "text/csv" }));
    parts.savePieces.addEventListener("click", () => give("parts.csv", partsFile(this.#lists)));
    parts.saveDrive.addEventListener("click", () => give("drive.csv", driveFile(this.#lists)));
  }

  /** Lists the finished robot with its edits. Without one there are no lists. */
  async show() {
    const { state, delivered } = this.#design;
    const now = state === "finished" ? delivered : null;
    if (now === this.#delivered) return;
    this.#delivered = now;
    if (now === null) {
      this.#parts.section.hidden = true;
      return;
    }
    try {
      const lists = await this.#design.lists();
      if (this.#delivered === now) this.#list(lists);
    } catch (error) {
      this.onerror(error);
    }
  }

  #list(lists) {
    this.#lists = lists;
    const { section, pieces, drive, says, saveDrive } = this.#parts;
    const hasMuscles = this.#delivered.walk.count(2) > 0;
    const total = lists.pieces.reduce((sum, { mass, places }) => sum + places.length * mass, 0);
    const length = ({ length }) => length === null ? "" : `${decimals(1000 * length, 0)} mm`;
    const grams = mass => `${decimals(1000 * mass, 1)} g`;
    const rows = lists.pieces.map(piece => [NAMES[piece.part] ?? piece.part, `${piece.places.length}`, length(piece), grams(piece.mass), places(piece)]);
    fill(pieces, [["part", "number", "length", "mass of one", "bars or nodes"], ...rows, ["together", "", "", grams(total), ""]]);
    saveDrive.disabled = lists.drive === null;
    drive.hidden = lists.drive === null;
    says.textContent = !hasMuscles ? "It has no muscles." : lists.drive === null ? "Its muscles have no fixed course: they follow what the robot sees."
      : "The lengths of its muscles over a period, in mm";
    if (lists.drive !== null) fill(drive, Shop.#moments(lists.drive));
    section.hidden = false;
  }

  static #moments({ every, lengths }) {
    const last = lengths[0][1].length - 1;
    const moments = Array.from({ length: SHOWN + 1 }, (_, k) => Math.round(k * last / SHOWN));
    const row = k => [`${decimals(k * every, 2)} s`, ...lengths.map(([, all]) => decimals(1000 * all[k], 1))];
    return [["time", ...lengths.map(([edge]) => `bar ${edge}`)], ...moments.map(row)];
  }
}
