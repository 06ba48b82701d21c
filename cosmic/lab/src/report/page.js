"use strict";
// Said in the document, where a test can see it.
addEventListener("error", event => { document.body.dataset.error = event.message; });
// Plays the rollout on the canvas. Positions are in units of `data.unit` metres: x0, y0, x1, y1, … a frame.
const data = JSON.parse(document.getElementById("motion").textContent);
const canvas = document.getElementById("stage");
const slider = document.getElementById("time");
const button = document.getElementById("play");
const speed = document.getElementById("speed");
const clock = document.getElementById("clock");
const pen = canvas.getContext("2d");
const scale = canvas.width / data.width;
// Some two dozen marks along the ground, a power of ten apart.
const decade = Math.round(Math.log10(data.width / 24));
const between = 10 ** decade;
let now = 0, playing = true, last = null;

slider.max = data.duration;

function line(points, colour, width) {
  pen.strokeStyle = colour;
  pen.lineWidth = width;
  pen.beginPath();
  for (const [x, y] of points) pen.lineTo(x, y);
  pen.stroke();
}

function draw() {
  const index = Math.min(data.frames.length - 1, Math.round(now / data.step));
  const frame = data.frames[index];
  const [cameraX, cameraY] = data.camera[index];
  const place = (x, y) => [canvas.width / 2 + (x - cameraX) * scale, canvas.height * 0.8 - (y - cameraY) * scale];
  const node = (frame, i) => place(frame[2 * i] * data.unit, frame[2 * i + 1] * data.unit);
  const ground = x => {
    // The first corner ahead ends the part of the ground that x is on.
    const ahead = Math.max(1, data.ground.findIndex(point => point[0] >= x));
    const [[x0, y0], [x1, y1]] = data.ground.slice(ahead - 1, ahead + 1);
    return y0 + (y1 - y0) * (x - x0) / (x1 - x0);
  };
  pen.clearRect(0, 0, canvas.width, canvas.height);
  pen.lineCap = pen.lineJoin = "round";
  pen.fillStyle = "#656d76";
  pen.textAlign = "center";
  pen.font = "20px system-ui, sans-serif";
  const half = data.width / 2;
  // Along the ground, as displacements are measured.
  const [first, last] = [-half, half].map(x => (cameraX + x) / data.cos / between);
  for (let k = Math.ceil(first); k <= last; k++) {
    const along = data.cos * k * between;
    const [x, y] = place(along, ground(along));
    line([[x, y], [x, y + (k % 5 ? 8 : 16)]], "#9aa3ad", 1.5);
    const metres = (k * between).toFixed(Math.max(0, -decade));
    if (k % 5 === 0) pen.fillText(`${metres} m`.replace("-", "\u2212"), x, y + 40);
  }
  const [left, right] = [cameraX - half, cameraX + half];
  const corners = data.ground.filter(([x]) => left < x && x < right);
  const terrain = [[left, ground(left)], ...corners, [right, ground(right)]];
  line(terrain.map(([x, y]) => place(x, y)), "#1f2328", 2.5);
  line(data.frames.slice(0, index + 1).map(f => node(f, 0)), data.payload, 2);
  for (const [i, j, rest] of data.edges) {
    const length = Math.hypot(frame[2 * i] - frame[2 * j], frame[2 * i + 1] - frame[2 * j + 1]) * data.unit;
    const share = Math.max(-1, Math.min(1, (length / rest - 1) / data.limit));
    const middle = (data.ramp.length - 1) / 2;
    const colour = rest > 0 ? data.ramp[Math.round(middle * (1 + share))] : data.skeleton;
    line([node(frame, i), node(frame, j)], colour, rest > 0 ? 7 : 5);
  }
  pen.fillStyle = data.payload;
  pen.beginPath();
  pen.arc(...node(frame, 0), 10, 0, 2 * Math.PI);
  pen.fill();
  slider.value = now;
  clock.textContent = `${now.toFixed(1)} s`;
}

function tick(stamp) {
  if (playing && last !== null) now += (stamp - last) / 1000 * Number(speed.value);
  if (now > data.duration) now = 0;
  last = stamp;
  draw();
  requestAnimationFrame(tick);
}

button.onclick = () => {
  playing = !playing;
  button.textContent = playing ? "Pause" : "Play";
};
slider.oninput = () => { now = Number(slider.value); };
draw();
document.body.dataset.ready = "true";
requestAnimationFrame(tick);
