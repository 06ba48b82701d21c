"use strict";
// What all drawings share: a canvas as sharp as the screen and as large as its element, and the page's colours.

const FONT = 'system-ui, "Segoe UI", Helvetica, Arial, sans-serif';

class Drawing {
  #scene = null;
  #colours = new Map();
  #size;
  #inView = true;

  constructor(canvas) {
    this.canvas = canvas;
    this.pen = canvas.getContext("2d");
    this.#size = [canvas.clientWidth, canvas.clientHeight];
    new ResizeObserver(() => {
      this.#size = [canvas.clientWidth, canvas.clientHeight];
      this.#again();
    }).observe(canvas);
    new IntersectionObserver(entries => {
      this.#inView = entries[entries.length - 1].isIntersecting;
      this.#again();
    }).observe(canvas);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
      this.#colours.clear();
      this.recoloured();
      this.#again();
    });
  }

  // Draws a scene, once its element is in view; it is kept and drawn again when size or colours change.
  draw(scene) {
    this.#scene = scene;
    const [width, height] = this.#size;
    if (!this.#inView || width === 0 || height === 0) return;
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

  // What depends on colours, and is kept, is made anew by those that override this.
  recoloured() {}

  // A colour of the page by its name, as in `theme.css`.
  colour(name) {
    if (!this.#colours.has(name)) {
      const style = getComputedStyle(document.documentElement);
      this.#colours.set(name, style.getPropertyValue(`--${name}`).trim());
    }
    return this.#colours.get(name);
  }

  // Colours from `--shorter` over `--rest` to `--longer`, an odd number of them.
  ramp(count) {
    const rgb = name => [1, 3, 5].map(k => parseInt(this.colour(name).slice(k, k + 2), 16));
    const [rest, ends] = [rgb("rest"), [rgb("shorter"), rgb("longer")]];
    const middle = (count - 1) / 2;
    return Array.from({ length: count }, (_, k) => {
      const share = Math.abs(k - middle) / middle;
      const end = ends[k < middle ? 0 : 1];
      return `rgb(${rest.map((from, i) => Math.round(from + share * (end[i] - from)))})`;
    });
  }

  line(points, colour, width) {
    const pen = this.pen;
    pen.strokeStyle = colour;
    pen.lineWidth = width;
    pen.beginPath();
    for (const [x, y] of points) pen.lineTo(x, y);
    pen.stroke();
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

  // The width of a small text.
  measure(text) {
    this.pen.font = `12px ${FONT}`;
    return this.pen.measureText(text).width;
  }
}

// The height of a ground of corners [[x, y], …] at an x.
function levelAt(ground, x) {
  // The first corner ahead ends the part of the ground that x is on.
  const found = ground.findIndex(point => point[0] >= x);
  const ahead = found < 0 ? ground.length - 1 : Math.max(1, found);
  const [[x0, y0], [x1, y1]] = ground.slice(ahead - 1, ahead + 1);
  return y0 + (y1 - y0) * (x - x0) / (x1 - x0);
}

// The mean height of a ground over a width around an x, for a camera that does not jump with every step.
function levelAround(ground, x, width) {
  const levels = Array.from({ length: 17 }, (_, k) => levelAt(ground, x + width * (k / 16 - 0.5)));
  return levels.reduce((sum, level) => sum + level, 0) / levels.length;
}

// A bar with a smaller share of solid material does not connect its nodes.
const HOLDS = 0.3;

// The payloads, and the nodes that edges [i, j, …] connect to them. `solid(e)` is the share of solid material of
// edge e, so that an undecided robot has a body too.
function bodyOf(payloads, edges, solid) {
  const body = new Set(payloads);
  const bars = edges.filter((_, e) => solid(e) > HOLDS);
  for (let before = -1; before !== body.size;) {
    before = body.size;
    for (const [i, j] of bars) if (body.has(i) || body.has(j)) body.add(i).add(j);
  }
  return body;
}

// Calls `tick(seconds)` for every frame of the screen, with the time since the one before.
function everyFrame(tick) {
  let last = null;
  const frame = stamp => {
    // A page that was out of sight does not jump.
    tick(last === null ? 0 : Math.min(0.1, (stamp - last) / 1000));
    last = stamp;
    requestAnimationFrame(frame);
  };
  requestAnimationFrame(frame);
}

// A number with a minus sign that is as wide as a plus sign.
const decimals = (x, digits) => x.toFixed(digits).replace("-", "\u2212");

// The least of 1, 2 and 5 times a power of ten that is not below a number.
function roundStep(least) {
  const decade = 10 ** Math.floor(Math.log10(least));
  return [1, 2, 5, 10].find(k => k * decade >= least * (1 - 1e-9)) * decade;
}
