// The charts of a check: lines with dots on linear or logarithmic axes, with their names below each other at the right.

addEventListener("error", event => { document.body.dataset.error = event.message; });

class Lines extends Drawing {
  paint({ title, along, is_log, lines }, width, height) {
    const [left, top, wide, deep] = [64, 30, Math.max(80, width - 300), height - 78];
    const shown = lines.map(({ points }) => points.filter(point => point.every((x, k) => Number.isFinite(x) && (x > 0 || !is_log[k]))));
    const axes = [0, 1].map(k => this.#axis(shown.flat().map(point => point[k]), is_log[k]));
    const place = point => [left + wide * axes[0].share(point[0]), top + deep * (1 - axes[1].share(point[1]))];
    this.text(title, 0, 14, "ink", "left", "600 13px");
    for (const [value, name] of axes[1].marks) {
      const y = top + deep * (1 - axes[1].share(value));
      this.line([[left, y], [left + wide, y]], this.colour("rule"), 1);
      this.text(name, left - 8, y + 4, "muted", "right");
    }
    for (const [value, name] of axes[0].marks) {
      const x = left + wide * axes[0].share(value);
      this.line([[x, top + deep], [x, top + deep + 4]], this.colour("ink"), 1);
      this.text(name, x, top + deep + 18, "muted", "center");
    }
    this.text(along, left + wide / 2, top + deep + 38, "muted", "center");
    const colours = ["accent", "second", "third", "fourth", "ink", "muted"];
    lines.forEach(({ name }, k) => {
      const colour = this.colour(colours[k % colours.length]);
      const places = shown[k].map(place);
      this.line(places, colour, 1.75);
      for (const [x, y] of places) this.disc(x, y, 3, colour);
      const y = top + 10 + 20 * k;
      this.disc(left + wide + 24, y - 4, 4, colour);
      this.text(name, left + wide + 34, y, "ink");
    });
  }

  // The range of an axis, with a margin, and the numbers to label.
  #axis(numbers, isLog) {
    const scale = isLog ? Math.log10 : x => x;
    const scaled = numbers.length ? numbers.map(scale) : [0, 1];
    const [least, most] = [Math.min(...scaled), Math.max(...scaled)];
    const margin = Math.max(0.06 * (most - least), isLog ? 0.1 : 0.05 * (Math.abs(most) || 1));
    const [low, high] = [least - margin, most + margin];
    const step = isLog && high - low > 1 ? Math.ceil((high - low) / 6) : roundStep((high - low) / 5);
    const marks = [];
    for (let k = Math.ceil(low / step); k * step <= high; k++) {
      const value = isLog ? 10 ** (k * step) : k * step;
      marks.push([value, isLog ? value.toPrecision(high - low > 1 ? 1 : 2) : decimals(value, digitsOf(step))]);
    }
    return { marks, share: x => (scale(x) - low) / (high - low) };
  }
}

const charts = JSON.parse(document.getElementById("data").textContent);
document.querySelectorAll("canvas.chart").forEach((canvas, k) => new Lines(canvas).draw(charts[k]));
document.body.dataset.ready = "true";
