// Diagrams of a gait: feet on the ground, target strains and strains of actuators, peaks of the forces in bars.

// A diagram over time. Lines mark the periods of the clock and the current time.
class OverTime extends Drawing {
  // Returns the width of a sample's column, and the function from a time to its place between `left` and `right`.
  along(times, left, right) {
    const step = times.length > 1 ? (times[times.length - 1] - times[0]) / (times.length - 1) : 1;
    const [from, to] = [times[0], times[times.length - 1] + step];
    this.span = { left, right, from, to };
    return { wide: (right - left) / times.length, place: time => left + (right - left) * (time - from) / (to - from) };
  }

  lines({ times, period, cursor }, place, top, bottom) {
    const last = times[times.length - 1];
    for (let time = last - period; time > times[0]; time -= period) {
      this.line([[place(time), top], [place(time), bottom]], this.colour("paper"), 2);
    }
    if (cursor >= times[0] && cursor <= last) this.line([[place(cursor), top], [place(cursor), bottom]], this.colour("ink"), 1.5);
  }

  // The time at a point of the window.
  timeAt(clientX) {
    const { left, right, from, to } = this.span;
    const share = (clientX - this.canvas.getBoundingClientRect().left - left) / (right - left);
    return from + (to - from) * Math.min(1, Math.max(0, share));
  }
}

// A row for each foot, filled while the foot is on the ground.
class Feet extends OverTime {
  paint(scene, width, height) {
    const { feet, times } = scene;
    const { wide, place } = this.along(times, 56, width);
    const row = (height - 24) / Math.max(1, feet.length);
    feet.forEach(([node, stands], k) => {
      this.pen.fillStyle = this.colour("earth");
      this.pen.fillRect(56, k * row + 2, width - 56, row - 4);
      this.text(`node ${node}`, 0, (k + 0.5) * row + 4);
      this.pen.fillStyle = this.colour("accent");
      for (const { 0: run, index } of stands.matchAll(/1+/g)) {
        this.pen.fillRect(place(times[index]), k * row + 2, run.length * wide, row - 4);
      }
    });
    if (feet.length === 0) this.text("no node is on the ground", 56, 16);
    this.lines(scene, place, 0, height - 24);
    this.text(`${decimals(times[0], 2)} s`, 56, height - 6);
    this.text(`${decimals(times[times.length - 1], 2)} s`, width, height - 6, "muted", "right");
  }
}

// A row for each actuator and a column for each sample, in the colours of the bars. A line is drawn above each of the rows
// `breaks`.
class Heat extends OverTime {
  paint(scene, width, height) {
    const { rows, times, colour, chosen, breaks } = scene;
    const { wide, place } = this.along(times, 0, width);
    const row = height / Math.max(1, rows.length);
    rows.forEach((values, k) => {
      values.forEach((value, column) => {
        this.pen.fillStyle = colour(value);
        this.pen.fillRect(column * wide, k * row + 2, wide + 0.5, row - 4);
      });
    });
    for (const first of breaks) this.line([[0, first * row], [width, first * row]], this.colour("ink"), 1.5);
    this.lines(scene, place, 0, height);
    this.pen.strokeStyle = this.colour("accent");
    this.pen.lineWidth = 2;
    if (chosen >= 0) this.pen.strokeRect(1, chosen * row + 1, width - 2, row - 2);
    this.rows = rows.length;
  }

  rowAt(clientY) {
    const { top, height } = this.canvas.getBoundingClientRect();
    const row = Math.floor((clientY - top) / height * this.rows);
    return row >= 0 && row < this.rows ? row : -1;
  }
}

// The largest push and pull in every bar, with the number of its edge and a mark at the current force.
class Peaks extends Drawing {
  // `bars` is a list of {edge, push, pull, now}: the largest push and pull (N, both positive) and the current force.
  paint({ bars, highlight }, width, height) {
    const most = side => Math.max(1e-9, ...bars.map(bar => bar[side]));
    const [left, top] = [48, 10];
    const [push, pull] = [most("push"), most("pull")];
    const below = 44;
    const place = force => top + (height - top - below) * (pull - force) / (pull + push);
    const step = roundStep((pull + push) / 5);
    for (let k = Math.ceil(-push / step); k * step <= pull; k++) {
      this.line([[left, place(k * step)], [width, place(k * step)]], this.colour(k === 0 ? "muted" : "rule"), 1);
      this.text(decimals(k * step, digitsOf(step)), left - 8, place(k * step) + 4, "muted", "right");
    }
    const wide = (width - left) / Math.max(1, bars.length);
    this.span = { left, wide, bars };
    // Numbers are written upwards, and only as many as there is room for.
    const every = Math.max(1, Math.ceil(11 / wide));
    bars.forEach((bar, k) => {
      const x = left + (k + 0.5) * wide;
      const thick = Math.max(1, Math.min(10, 0.6 * wide));
      const column = (force, colour) => {
        this.pen.fillStyle = this.colour(colour);
        this.pen.fillRect(x - thick / 2, Math.min(place(0), place(force)), thick, Math.abs(place(force) - place(0)));
      };
      if (bar.edge === highlight) {
        this.pen.fillStyle = this.colour("rule");
        this.pen.fillRect(x - wide / 2 - 1, top, wide + 2, height - top - below);
        this.text(`edge ${bar.edge}`, Math.min(width - 30, Math.max(left + 26, x)), height - 6, "ink", "center");
      }
      if (k % every === 0) this.upwards(bar.edge, x + 4, height - below + 30, bar.edge === highlight ? "ink" : "muted");
      column(bar.pull, "longer");
      column(-bar.push, "shorter");
      if (bar.now !== null) this.disc(x, place(bar.now), Math.max(1.5, Math.min(3, wide / 3)), this.colour("ink"));
    });
  }

  // Writes a number upwards from a point.
  upwards(number, x, y, colour) {
    this.pen.save();
    this.pen.translate(x, y);
    this.pen.rotate(-Math.PI / 2);
    this.text(String(number), 0, 0, colour, "left", "11px");
    this.pen.restore();
  }

  // The edge at a point of the window, or null.
  edgeAt(clientX) {
    const { left, wide, bars } = this.span;
    const k = Math.floor((clientX - this.canvas.getBoundingClientRect().left - left) / wide);
    return bars[k]?.edge ?? null;
  }
}
