"use strict";
// What all drawings on canvases share: for reports, comparisons and the page in the folder `web`.

const FONT = 'system-ui, "Segoe UI", Helvetica, Arial, sans-serif';
const MATERIALS = ["void", "skeleton", "actuator"];

// The width of a page of paper, in pixels. Drawings are as wide on paper, so that their words are as large as the text.
const PAPER_WIDTH = 700;

// What is folded is printed, too. This comes before the drawings, so that those that were folded have a size.
addEventListener("beforeprint", () => {
  for (const fold of document.querySelectorAll("details:not([open])")) {
    fold.dataset.folded = "true";
    fold.open = true;
  }
});
addEventListener("afterprint", () => {
  for (const fold of document.querySelectorAll("details[data-folded]")) {
    delete fold.dataset.folded;
    fold.open = false;
  }
});

// A canvas that has the resolution of the screen and the size of its element.
class Drawing {
  // The colours of the page, which are the same on all canvases.
  static #colours = new Map();
  #scene = null;
  #size;
  #inView = true;
  #isPrinted = false;

  constructor(canvas) {
    this.canvas = canvas;
    this.pen = canvas.getContext("2d");
    this.#size = [canvas.clientWidth, canvas.clientHeight];
    new ResizeObserver(() => {
      this.#size = [canvas.clientWidth, canvas.clientHeight];
      this.#again();
    }).observe(canvas);
    new IntersectionObserver(entries => {
      const wasInView = this.#inView;
      this.#inView = entries[entries.length - 1].isIntersecting;
      if (!wasInView) this.#again();
    }).observe(canvas);
    const recolour = () => {
      Drawing.#colours.clear();
      this.#again();
    };
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", recolour);
    // Paper is white, also for readers whose screen is dark. Drawings out of view are drawn for paper, too.
    for (const [moment, isPrinted] of [["beforeprint", true], ["afterprint", false]]) {
      addEventListener(moment, () => {
        this.#isPrinted = isPrinted;
        this.#size = [canvas.clientWidth, canvas.clientHeight];
        document.documentElement.classList.toggle("printed", isPrinted);
        recolour();
      });
    }
  }

  // Draws `scene`, the data of what is shown, with the method `paint` of each kind of drawing. The scene is drawn again
  // when the canvas comes into view, and when size or colours change.
  draw(scene) {
    this.#scene = scene;
    const [wide, height] = this.#size;
    const page = (document.querySelector("main") ?? document.body).clientWidth;
    const width = this.#isPrinted ? wide * Math.min(1, PAPER_WIDTH / page) : wide;
    if (!(this.#inView || this.#isPrinted) || width === 0 || height === 0) return;
    const sharp = devicePixelRatio || 1;
    const [across, down] = [Math.round(width * sharp), Math.round(height * sharp)];
    if (this.canvas.width !== across || this.canvas.height !== down) {
      this.canvas.width = across;
      this.canvas.height = down;
    }
    this.pen.setTransform(across / width, 0, 0, down / height, 0, 0);
    this.pen.clearRect(0, 0, width, height);
    this.pen.lineCap = this.pen.lineJoin = "round";
    this.paint(scene, width, height);
  }

  #again() {
    if (this.#scene !== null) this.draw(this.#scene);
  }

  // The colour of `theme.css` with this name.
  colour(name) {
    return this.#kept(name, () => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim());
  }

  #kept(name, compute) {
    const colours = Drawing.#colours;
    if (!colours.has(name)) colours.set(name, compute());
    return colours.get(name);
  }

  // The colour for a number from 0 to 1, in 9 shades: `--skeleton` at 0, `--beyond` at 1.
  strained(share) {
    const k = Math.round(8 * Math.min(1, Math.max(0, share)));
    return this.#kept(`strained ${k}`, () => {
      const rgb = name => [1, 3, 5].map(i => parseInt(this.colour(name).slice(i, i + 2), 16));
      const end = rgb("beyond");
      return `rgb(${rgb("skeleton").map((from, i) => Math.round(from + k / 8 * (end[i] - from)))})`;
    });
  }

  // The colour for a number from -1 to 1, in 33 shades: `--shorter` at -1, `--rest` at 0, `--longer` at 1.
  shade(share) {
    const k = Math.round(16 * share);
    return this.#kept(k, () => {
      const rgb = name => [1, 3, 5].map(i => parseInt(this.colour(name).slice(i, i + 2), 16));
      const end = rgb(k < 0 ? "shorter" : "longer");
      return `rgb(${rgb("rest").map((from, i) => Math.round(from + Math.abs(k) / 16 * (end[i] - from)))})`;
    });
  }

  line(points, colour, width) {
    const pen = this.pen;
    pen.strokeStyle = colour;
    pen.lineWidth = width;
    pen.beginPath();
    for (const point of points) pen.lineTo(point[0], point[1]);
    pen.stroke();
  }

  fill(points, colour) {
    const pen = this.pen;
    pen.beginPath();
    for (const point of points) pen.lineTo(point[0], point[1]);
    pen.fillStyle = colour;
    pen.fill();
  }

  disc(x, y, radius, fill, edge) {
    const pen = this.pen;
    pen.beginPath();
    pen.arc(x, y, radius, 0, 2 * Math.PI);
    pen.fillStyle = fill;
    pen.fill();
    if (edge) {
      pen.strokeStyle = edge;
      pen.lineWidth = 1.5;
      pen.stroke();
    }
  }

  text(text, x, y, colour = "muted", align = "left", font = "12px") {
    const pen = this.pen;
    pen.font = `${font} ${FONT}`;
    pen.fillStyle = this.colour(colour);
    pen.textAlign = align;
    pen.fillText(text, x, y);
  }

  // The width of a text in the font of 12 pixels.
  measure(text) {
    this.pen.font = `12px ${FONT}`;
    return this.pen.measureText(text).width;
  }

  // The edge that is nearest to a point of the window and at most 12 pixels away, or null. `marks` is a list of
  // [edge, distance], where `distance` is a function of a place on the canvas.
  nearest(clientX, clientY, marks) {
    const box = this.canvas.getBoundingClientRect();
    let [least, nearest] = [12, null];
    for (const [edge, distance] of marks) {
      const off = distance(clientX - box.left, clientY - box.top);
      if (off < least) [least, nearest] = [off, edge];
    }
    return nearest;
  }
}

// The height at `x` of ground with the corners [[x, y], …]. It is level before the first corner and after the last.
function levelAt(ground, x) {
  let ahead = 0;
  while (ahead < ground.length && !(ground[ahead][0] > x)) ahead += 1;
  if (ahead === 0 || ahead === ground.length) return ground[Math.max(0, ahead - 1)]?.[1] ?? 0;
  const [from, to] = [ground[ahead - 1], ground[ahead]];
  return from[1] + (to[1] - from[1]) * (x - from[0]) / (to[0] - from[0]);
}

// The mean height of ground over `width` around `x`. A camera that follows it does not jump where the ground has a
// step.
function levelAround(ground, x, width) {
  let sum = 0;
  for (let k = 0; k <= 16; k++) sum += levelAt(ground, x + width * (k / 16 - 0.5));
  return sum / 17;
}

// Calls `tick(seconds)` now and for every frame of the screen. `seconds` is the time since the last frame.
function everyFrame(tick) {
  tick(0);
  let last = null;
  const frame = stamp => {
    // Limited, so that a page that was hidden does not jump ahead.
    tick(last === null ? 0 : Math.min(0.1, (stamp - last) / 1000));
    last = stamp;
    requestAnimationFrame(frame);
  };
  requestAnimationFrame(frame);
}

// Calls `toggle` when the space bar is pressed, unless the focus is in a text field. The bar then has no other effect.
function playBySpace(toggle) {
  for (const kind of ["keydown", "keyup"]) {
    addEventListener(kind, event => {
      const field = event.target.closest?.("input:not([type=range]), textarea, [contenteditable]");
      if (event.key !== " " || field || event.ctrlKey || event.metaKey || event.altKey) return;
      event.preventDefault();
      if (kind === "keydown" && !event.repeat) toggle();
    }, true);
  }
}

// Calls `does` once, as soon as half of an element is in view.
function whenSeen(element, does) {
  const observer = new IntersectionObserver(entries => {
    if (!entries.some(entry => entry.isIntersecting)) return;
    observer.disconnect();
    does();
  }, { threshold: 0.5 });
  observer.observe(element);
}

const startsPlaying = () => !matchMedia("(prefers-reduced-motion: reduce)").matches;

// A number with `digits` decimals. Its minus sign is that of the keyboard, so that people can paste the number.
const decimals = (x, digits) => x.toFixed(digits);

// The smallest of 1, 2 and 5 times a power of ten that is at least `least`.
function roundStep(least) {
  const decade = 10 ** Math.floor(Math.log10(least));
  return [1, 2, 5, 10].find(k => k * decade >= least * (1 - 1e-9)) * decade;
}

// The number of decimals that multiples of a step need.
const digitsOf = step => Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
