"""Records a film from a page of `cosmic report` or `cosmic walk`.

    cosmic optimize --seed 5 && cosmic report runs/earth-5
    python3 docs/images/film.py runs/earth-5/report.html docs/images/evolution.gif
    python3 docs/images/film.py runs/earth-5/report.html docs/images/evolution-dark.gif --dark

The film of a run begins with the finished robot. Then it shows the robots of some iterations, and at last the first robot
above the finished one, on the same ground. The film of a walk shows the whole walk. The page draws the frames, so a film
looks like the page: time, distance and iteration are in its corner. `--dark` draws it in the page's dark colours. Needs Chromium and the package pillow.
"""

import base64
import io
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image

#: The time between two frames, s.
EVERY = 0.1
#: The iterations in the film of a run. If the page lacks one of them, the film shows the nearest that the page has.
ITERATIONS = [1, 5, 10, 20, 40]
#: The number of colours of a film. More colours make a larger file.
COLOURS = 28
#: Runs after the page's own script, in the same scope. The page is drawn once before, so that its canvas has its size.
SCRIPT = """<script>
setTimeout(() => {
  view.playing = false;
  const { clientWidth: width, clientHeight: height } = stage.canvas;
  const film = Object.assign(document.createElement("canvas"), { width, height });
  const paper = getComputedStyle(document.body).backgroundColor;
  // Adds a frame with these canvases, one below the other, on the page's paper.
  const keep = (...canvases) => {
    const pen = film.getContext("2d");
    pen.fillStyle = paper;
    pen.fillRect(0, 0, width, height);
    canvases.forEach((canvas, k) => pen.drawImage(canvas, 0, k * height / canvases.length));
    document.body.append(Object.assign(document.createElement("img"), { src: film.toDataURL(), className: "film" }));
  };
  const times = seconds => Array.from({ length: Math.floor(seconds / %EVERY% + 1e-9) }, (_, k) => k * %EVERY%);
  const says = (drawing, words) => drawing.text(words, width - 14, 26, "muted", "right", "600 15px");
  const alone = (robot, seconds, words = "") => {
    show(robot);
    for (const time of times(Math.min(seconds, walker().duration))) {
      view.now = time;
      moving.forEach(draw => draw(walker().at(time)));
      says(stage, words);
      keep(stage.canvas);
    }
  };
  if (last === 0) return alone(0, Infinity);
  alone(last, 3, "finished");
  for (const iteration of %ITERATIONS%) {
    const off = walkers.map(walker => Math.abs(walker.iteration - iteration));
    alone(off.indexOf(Math.min(...off)), 2);
  }
  // Two lanes with one camera, which does not move.
  const seconds = 4;
  const ends = [0, last].flatMap(robot => [0, seconds].map(time => walkers[robot].at(time).camera[0]));
  const [from, to] = [Math.min(...ends), Math.max(...ends)];
  const scale = Math.min(0.33 * height / robot.side, width / (to - from + 1.5 * robot.side));
  const lanes = [0, last].map(k => {
    const canvas = document.createElement("canvas");
    canvas.style.height = `${height / 2}px`;
    stage.canvas.after(canvas);
    const lane = new Stage(canvas, { ...world, payloads: robot.payloads, width: Math.min(1.2 * height, 2 * width) / scale });
    lane.orbit = stage.orbit;
    return [lane, walkers[k], k ? "finished" : "first"];
  });
  for (const time of times(seconds)) {
    for (const [lane, walker, words] of lanes) {
      const moment = walker.at(time);
      const camera = [(from + to) / 2, 0, moment.camera[2]];
      const label = `${decimals(time, 1)} s   ${decimals(moment.metres, 2)} m   iteration ${walker.iteration}`;
      lane.draw({ ...moment, camera, level: moment.camera, label });
      says(lane, words);
    }
    keep(...lanes.map(([lane]) => lane.canvas));
  }
}, 1000);
</script>
</body>"""
OPTIONS = "--headless --no-sandbox --disable-gpu --window-size=645,900 --virtual-time-budget=20000 --dump-dom"


def frames(page: Path, dark: bool) -> list[Image.Image]:
    browser = next(filter(None, map(shutil.which, ["chromium", "chromium-browser", "google-chrome"])), None)
    if browser is None:
        sys.exit("film.py needs Chromium on the path")
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / "page.html"
        script = SCRIPT.replace("%EVERY%", str(EVERY)).replace("%ITERATIONS%", str(ITERATIONS))
        copy.write_text(page.read_text().replace("</body>", script))
        scheme = f"--blink-settings=preferredColorScheme={0 if dark else 1}"
        command = [browser, *OPTIONS.split(), scheme, f"--user-data-dir={folder}/profile", copy.as_uri()]
        document = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    pictures = re.findall(r'<img src="data:image/png;base64,([^"]+)" class="film">', document)
    if not pictures:
        sys.exit(f"{page}: the page drew no frames; is it a page of `report` or `walk`?")
    return [Image.open(io.BytesIO(base64.b64decode(picture))).convert("RGB") for picture in pictures]


def with_few_colours(pictures: list[Image.Image]) -> list[Image.Image]:
    """The pictures with one palette, which contains the rare colours, too."""
    some, (width, height) = pictures[::12], pictures[0].size
    sheet = Image.new("RGB", (width, height * len(some)))
    for k, picture in enumerate(some):
        sheet.paste(picture, (0, k * height))
    palette = sheet.quantize(COLOURS, Image.Quantize.MAXCOVERAGE, kmeans=1)
    return [picture.quantize(palette=palette, dither=Image.Dither.NONE) for picture in pictures]


if __name__ == "__main__":
    match sys.argv[1:]:
        case [page, film]:
            dark = False
        case [page, film, "--dark"]:
            dark = True
        case _:
            sys.exit("usage: film.py PAGE.html FILM.gif [--dark]")
    first, *others = with_few_colours(frames(Path(page), dark))
    first.save(film, save_all=True, append_images=others, duration=round(1000 * EVERY), loop=0)
    print(f"{film}: {1 + len(others)} frames")
