"""Records a film from a page of `cosmic report` or `cosmic walk`.

    cosmic optimize workshop --seed 7 && cosmic report runs/workshop-7
    python3 docs/images/film.py runs/workshop-7/report.html docs/images/evolution.gif

The page of a run becomes a film of six iterations for two seconds each, and then of the final robot for four. The page of
a walk becomes a film of the whole walk. Needs Chromium and the package pillow. The page draws the frames, so a film looks
like the page: time, distance and iteration are in its corner.
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
EVERY = 0.08
#: Runs after the page's own script, in the same scope. The page is drawn once before, so that its canvas has its size.
SCRIPT = """<script>
setTimeout(() => {
  view.playing = false;
  const robots = Array.from({ length: Math.min(6, last) }, (_, k) => [Math.floor(k * last / Math.min(6, last)), 2]);
  for (const [robot, seconds] of [...robots, [last, last ? 4 : Infinity]]) {
    show(robot);
    for (let time = 0; time <= Math.min(seconds, walker().duration); time += %EVERY%) {
      view.now = time;
      moving.forEach(draw => draw(walker().at(time)));
      const frame = Object.assign(document.createElement("img"), { src: stage.canvas.toDataURL(), className: "film" });
      document.body.append(frame);
    }
  }
}, 1000);
</script>
</body>"""
OPTIONS = "--headless --no-sandbox --disable-gpu --window-size=860,900 --virtual-time-budget=20000 --dump-dom"


def frames(page: Path) -> list[Image.Image]:
    browser = next(filter(None, map(shutil.which, ["chromium", "chromium-browser", "google-chrome"])), None)
    if browser is None:
        sys.exit("film.py needs Chromium on the path")
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / "page.html"
        script = SCRIPT.replace("%EVERY%", str(EVERY))
        copy.write_text(page.read_text().replace("</body>", script))
        command = [browser, *OPTIONS.split(), f"--user-data-dir={folder}/profile", copy.as_uri()]
        document = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    pictures = re.findall(r'<img src="data:image/png;base64,([^"]+)" class="film">', document)
    if not pictures:
        sys.exit(f"{page}: the page drew no frames; is it a page of `report` or `walk`?")
    return [paper(Image.open(io.BytesIO(base64.b64decode(picture)))) for picture in pictures]


def paper(picture: Image.Image) -> Image.Image:
    """The picture on white paper, with few colours."""
    white = Image.new("RGBA", picture.size, "white")
    white.alpha_composite(picture.convert("RGBA"))
    return white.convert("RGB").quantize(64)


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit("usage: film.py PAGE.html FILM.gif")
    first, *others = frames(Path(sys.argv[1]))
    first.save(sys.argv[2], save_all=True, append_images=others, duration=round(1000 * EVERY), loop=0)
    print(f"{sys.argv[2]}: {1 + len(others)} frames")
