"""Draws the pictures of docs/method.md from a run of the program, in a minute.

    pip install ./python
    python docs/images/pictures.py

Every picture has colours for light and for dark pages. Only NumPy and the package `cosmic` are needed.
"""

from __future__ import annotations

import json
import tempfile
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import cosmic
import numpy as np
import numpy.typing as npt

FOLDER = Path(__file__).parent
Floats = npt.NDArray[np.float64]
#: The width of all pictures, in units of text of 15: on a narrow screen they stay readable.
WIDTH = 560
#: The iteration whose design `horizon` shows.
UNDECIDED = 210
#: The colours of five horizons, from the shortest to the longest.
COLOURS = ["accent", "actuator", "green", "violet", "long"]
STYLE = """
svg{--bg:#fff;--ink:#1f2328;--soft:#59636e;--rule:#d5dbe1;--panel:#eef2f6;--skeleton:#262b33;--actuator:#d9541e;
--short:#0b4fc4;--long:#d61f1f;--accent:#0b62b8;--green:#1a7f4b;--violet:#7a4bc2}
@media(prefers-color-scheme:dark){svg{--bg:#0e1116;--ink:#e6eaef;--soft:#9aa5b1;--rule:#3b444e;--panel:#1c232c;
--skeleton:#c9d1d9;--actuator:#ff8a4c;--short:#4b93ff;--long:#ff5c53;--accent:#5aa9f5;--green:#4cc38a;--violet:#b08cf0}}
text{fill:var(--ink);font:15px system-ui,"Segoe UI",Helvetica,Arial,sans-serif}
.s{fill:var(--soft);font-size:13px}.b{font-weight:600}
path{fill:none;stroke-linecap:round;stroke-linejoin:round}"""


class Picture:
    """An SVG picture."""

    def __init__(self, title: str, height: float) -> None:
        self.parts = [
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height}" role="img"><title>{title}</title>'
            f'<style>{STYLE}</style><rect width="{WIDTH}" height="{height}" rx="8" style="fill:var(--bg)"/>'
        ]

    def text(self, x: float, y: float, words: str, kind: str = "", anchor: str = "start") -> None:
        name = f' class="{kind}"' if kind else ""
        self.parts.append(f'<text x="{x:.0f}" y="{y:.0f}"{name} text-anchor="{anchor}">{words}</text>')

    def path(self, way: str, colour: str, width: float = 1.5, opacity: float = 1.0, more: str = "") -> None:
        seen = f";opacity:{opacity:.2g}" if opacity < 1 else ""
        self.parts.append(f'<path d="{way}" style="stroke:var(--{colour});stroke-width:{width:g}{seen}{more}"/>')

    def line(self, points: Iterable[Any], colour: str, width: float = 1.5, opacity: float = 1.0) -> None:
        self.path("M" + " ".join(f"{x:.1f},{y:.1f}" for x, y in points), colour, width, opacity)

    def area(self, points: Iterable[Any], colour: str) -> None:
        way = "M" + " ".join(f"{x:.0f},{y:.1f}" for x, y in points) + "z"
        self.parts.append(f'<path d="{way}" style="fill:var(--{colour})"/>')

    def box(self, x: float, y: float, width: float, height: float, colour: str = "panel") -> None:
        self.parts.append(
            f'<rect x="{x:g}" y="{y:g}" width="{width:g}" height="{height:g}" rx="6" '
            f'style="fill:var(--{colour});stroke:var(--rule)"/>'
        )

    def dot(self, x: float, y: float, colour: str, radius: float = 4) -> None:
        self.parts.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{radius:g}" style="fill:var(--{colour})"/>')

    def arrow(self, *points: tuple[float, float]) -> None:
        """A line with a head at its last point."""
        self.line(points, "soft")
        (x0, y0), (x, y) = points[-2:]
        along = np.array([x - x0, y - y0]) / np.hypot(x - x0, y - y0)
        across = np.array([-along[1], along[0]])
        head = [np.array([x, y]) - 8 * along + side * 4 * across for side in (-1, 1)]
        self.area([(x, y), *head], "soft")

    def save(self, name: str) -> None:
        written = "".join([*self.parts, "</svg>\n"])
        (FOLDER / name).write_text(written)
        print(f"docs/images/{name}: {len(written) / 1000:.1f} kB")


def segments(x: Floats, edges: Iterable[Any]) -> str:
    """The bars between the nodes `x`, of shape (nodes, 2), as one path."""
    ends = [(*x[i], *(x[j] - x[i])) for i, j in edges]
    return "".join(f"M{a:.0f} {b:.0f}l{c:.0f} {d:.0f}" for a, b, c, d in ends)


def softmax(z: Floats) -> Floats:
    grown = np.exp(z - z.max(-1, keepdims=True))
    shares: Floats = grown / grown.sum(-1, keepdims=True)
    return shares


def bars(run: cosmic.Run) -> None:
    """From fog to bars: mixtures at several iterations, and how far they are from one material per bar."""
    picture = Picture("From fog to bars: the mixtures of a robot become one material per bar", 500)
    beta = 20  # section 2 of docs/method.md; not a key of scenes
    for panel, iteration in enumerate([1, 110, 120, 130, 150, 300]):
        left, top = 28.0 + 178 * (panel % 3), 34.0 + 164 * (panel // 3)
        picture.text(left, top - 10, f"iteration {iteration}", "b")
        z = designs(run)[iteration]
        shares = softmax(beta * z) if iteration < run.scene["schedule.snap_at"] else z
        nodes = (run.inputs.x0 - run.inputs.x0.min(0)) * [248, -248] + [left, top + 124]
        for material, colour, width in [(1, "skeleton", 2), (2, "actuator", 3)]:
            levels = np.round(10 * shares[:, material]) / 10
            for level in np.unique(levels[levels > 0]):
                at_level = run.design.edges[levels == level]
                picture.path(segments(nodes, at_level), colour, width, float(level))
    top, left, right = 374.0, 44.0, WIDTH - 24.0
    picture.text(28, top - 8, "mean of 1 - |mixture| over all bars: 0 means one material per bar", "s")
    measured = run.history["measures.0"]
    seen = np.isfinite(measured)
    across = left + (right - left) * run.history["iteration"] / 300
    for value in (0.0, 0.2, 0.4):
        picture.line([(left, top + 90 - 200 * value), (right, top + 90 - 200 * value)], "rule", 1)
        picture.text(left - 6, top + 95 - 200 * value, f"{value:g}", "s", "end")
    points = np.stack([across[seen], top + 90 - 200 * np.clip(measured[seen], 0, None)], -1)
    picture.line(points, "accent", 2)
    for iteration in (0, 100, 200, 300):
        picture.text(left + (right - left) * iteration / 300, top + 112, f"{iteration}", "s", "middle")
    snap = left + (right - left) * run.scene["schedule.snap_at"] / 300
    picture.line([(snap, top + 6), (snap, top + 90)], "soft", 1)
    picture.text(snap + 6, top + 18, "snap", "s")
    picture.save("bars.svg")


def activations(run: cosmic.Run, x: Floats, v: Floats, times: Floats) -> tuple[Floats, Floats]:
    """The clock (times, clocks) and the activations (times, edges), by the equations of section 3 of docs/method.md."""
    scene, count = run.scene, run.scene["controller.clocks"]
    phases = 2 * np.pi * np.arange(count) / count
    clock = np.sin(scene["controller.omega"] * times[:, None] + phases)
    used = np.zeros((x.shape[1], 1))
    used[run.design.edges[run.design.materials > 0]] = 1
    used[0] = 1
    offsets = (x - (used * x).sum(1, keepdims=True) / used.sum()) * used * scene["controller.offset_scale"]
    speeds = v * used * scene["controller.velocity_scale"]
    goal = np.broadcast_to(np.array(scene["controller.goal"]) * scene["controller.goal_scale"], (len(x), 2))
    seen = np.concatenate([clock, goal, offsets.reshape(len(x), -1), speeds.reshape(len(x), -1)], 1)
    w1, b1, w2, b2 = (run.controller[name] for name in ("w1", "b1", "w2", "b2"))
    return clock, np.tanh(np.tanh(seen @ w1.T + b1) @ w2.T + b2)


def muscles(run: cosmic.Run) -> None:
    """From the clock to the muscles: the clock, the activations, and the robot, over two periods."""
    sim, first = run.simulator(), 2048
    period = 2 * np.pi / run.scene["controller.omega"]
    steps = round(2 * period / sim.dt)
    states = sim.rollout(run.inputs, first + steps, observed=1)
    times = np.arange(first, first + steps) * sim.dt
    clock, given = activations(run, states.x[first:-1], states.v[first:-1], times)
    # The program moves the same way with these activations, so they are the network's.
    driven = run.inputs._replace(controller={"activations": given[:64]}, x0=states.x[first], v0=states.v[first])
    again = sim.rollout(driven, observed=[64])
    assert np.allclose(again.x[-1], states.x[first + 64], atol=1e-9), "these are not the activations of the network"

    picture = Picture("From the clock to the muscles", 620)
    left, right = 28.0, WIDTH - 28.0
    across = np.linspace(left, right, steps)
    picture.text(left, 26, "the clock: ten sine waves", "b")
    for signal, wave in enumerate(clock.T[:, ::16]):
        strong = (2.5, 1.0) if signal == 0 else (1, 0.4)
        picture.line(np.stack([across[::16], 66 - 28 * wave], -1), "accent", *strong)
    muscled = np.flatnonzero(run.design.materials == 2)
    order = muscled[np.argsort(np.argmax(given[: steps // 2, muscled], 0))]
    picture.text(left, 128, f"the network's activations of {len(order)} actuators", "b")
    high, top = 11.0, 150.0
    for row, edge in enumerate(order):
        base, some = top + high * row, slice(None, None, 24)
        for colour, side in [("long", np.maximum(given[some, edge], 0)), ("short", np.minimum(given[some, edge], 0))]:
            wave = np.stack([across[some], base - 5.5 * side], -1)
            picture.area([(left, base), *wave, (wave[-1][0], base)], colour)
    bottom = top + high * len(order) + 8
    used = np.unique(run.design.edges[run.design.materials > 0])
    picture.text(left, bottom + 10, "0 s", "s")
    picture.text(right, bottom + 10, f"{2 * period:.2f} s, two periods", "s", "end")
    picture.text(left, bottom + 42, "the actuators: short is blue, long is red", "b")
    for pose in range(5):
        step = first + round(pose * period / 4 / sim.dt)
        corner = states.x[step][used].min(0)
        nodes = (states.x[step] - corner) * [165, -165] + [left + 106 * pose, bottom + 150]
        stretched = np.linalg.norm(np.diff(states.x[step][run.design.edges], axis=1)[:, 0], axis=1) / sim.rest_length - 1
        still = run.design.edges[run.design.materials == 1]
        picture.path(segments(nodes, still), "skeleton", 1.5)
        for colour, chosen in [("short", stretched < 0), ("long", stretched >= 0)]:
            picture.path(segments(nodes, run.design.edges[chosen & (run.design.materials == 2)]), colour, 3)
        picture.text(left + 40 + 106 * pose, bottom + 176, f"{pose * period / 4:.2f} s", "s", "middle")
    picture.parts[0] = picture.parts[0].replace("620", f"{bottom + 190:.0f}")
    picture.save("muscles.svg")


def designs(run: cosmic.Run) -> dict[int, Floats]:
    """The design vectors at several iterations."""
    lines = (run.folder / "designs.jsonl").read_text().splitlines()
    return {line["iteration"]: np.array(line["z"]) for line in map(json.loads, lines)}


def horizon(run: cosmic.Run) -> None:
    """How the distance and its gradient depend on the horizon, for a robot that is not finished."""
    sim, inputs = cosmic.Simulator(run.scene, "performance"), run.inputs._replace(z=designs(run)[UNDECIDED])
    horizons = [512, 1024, 2048, 4096, 8192]
    changes = np.linspace(-0.05, 0.05, 161)
    direction = np.random.default_rng(0).normal(size=run.controller["w1"].shape)
    moved = run.controller["w1"] + changes[:, None, None] * direction / np.linalg.norm(direction)
    far = sim.rollout(inputs._replace(controller={**run.controller, "w1": moved}), observed=[0, *horizons])
    along = far.x[:, 1:, 0, 0] - far.x[:, :1, 0, 0]
    norms = np.array([slopes(sim, inputs, steps) for steps in horizons])

    picture = Picture("The horizon of the gradient", 480)
    left, right, top = 62.0, WIDTH - 72.0, 40.0
    low, scale = min(0.0, along.min()), 200 / (along.max() - min(0.0, along.min()))
    picture.text(18, 24, "distance after 1 to 16 s, if the weights change", "b")
    for value in range(int(along.max()) + 1):
        base = top + 210 - scale * (value - low)
        picture.line([(left, base), (right, base)], "rule", 1)
        picture.text(left - 8, base + 5, f"{value} m", "s", "end")
    across = np.linspace(left, right, len(changes))
    for of, steps in enumerate(horizons):
        picture.line(np.stack([across, top + 210 - scale * (along[:, of] - low)], -1), COLOURS[of], 1.5)
    for at, words in [(0.0, "-0.05"), (0.5, "change of the first weights (norm)"), (1.0, "0.05")]:
        picture.text(left + at * (right - left), top + 234, words, "s", "middle")

    top = 316
    picture.text(18, top - 10, "norm of the gradient, for 16 starts that differ by 1 mm", "b")
    low, scale = np.log10(norms.min()), 120 / np.ptp(np.log10(norms))
    for power in range(0, int(np.log10(norms.max())) + 1, 8):
        base = top + 128 - scale * (power - low)
        picture.line([(left, base), (right, base)], "rule", 1)
        picture.text(left - 8, base + 5, f"1e{power}" if power else "1", "s", "end")
    for of, steps in enumerate(horizons):
        x = left + 30 + (right - left - 60) * of / (len(horizons) - 1)
        for norm in norms[of]:
            picture.dot(x, top + 128 - scale * (np.log10(norm) - low), COLOURS[of], 3)
        picture.text(x, top + 152, f"{steps * sim.dt:.1f} s", "s", "middle")
    picture.save("horizon.svg")


def slopes(sim: cosmic.Simulator, robot: cosmic.Inputs, steps: int) -> Floats:
    """The norms of the gradients of 16 robots whose starts differ by 1 mm, with respect to the first weights."""
    random = np.random.default_rng(1)
    starts = robot.x0 + np.abs(random.normal(scale=1e-3, size=(16, *robot.x0.shape))) * [0, 1]
    each = {name: np.repeat(block[None], 16, 0) for name, block in robot.controller.items()}
    inputs = robot._replace(x0=starts, controller=each)
    bar = np.zeros((16, 1, *robot.x0.shape))
    bar[:, 0, 0, 0] = 1.0
    gradient = sim.vjp(inputs, cosmic.Trajectory(bar, np.zeros_like(bar)), observed=[steps])
    norms: Floats = np.linalg.norm(gradient.controller["w1"].reshape(16, -1), axis=1)
    return norms


def step() -> None:
    """The stages of a step."""
    picture = Picture("The stages of a step", 470)
    stages = [
        ("observe", "clock, goal, offsets, velocities"),
        ("controller", "u = tanh(W2 tanh(W1 o + b1) + b2)"),
        ("forces", "bars pull: F = k (l - target), impulse J"),
        ("push", "v* = exp(-damping dt) v + J / m + g dt"),
        ("contact", "time of impact, and the velocity v+ after it"),
        ("drift", "x' = x + tau v* + (dt - tau) v+,  v' = v+"),
    ]
    picture.box(150, 12, 260, 34, "bg")
    picture.text(280, 34, "state at t:  x, v", "b", "middle")
    for row, (name, does) in enumerate(stages):
        top = 66 + 58 * row
        picture.arrow((280, top - 20), (280, top))
        picture.box(116, top, 426, 38)
        picture.text(128, top + 24, name, "b")
        picture.text(228, top + 24, does, "s")
    picture.arrow((280, 394), (280, 414))
    picture.box(150, 414, 260, 34, "bg")
    picture.text(280, 436, "state at t + dt:  x', v'", "b", "middle")
    for row, words in [(1, "weights"), (2, "body: k"), (3, "body: m"), (4, "ground")]:
        picture.text(12, 66 + 58 * row + 24, words, "s")
        picture.arrow((76, 66 + 58 * row + 19), (116, 66 + 58 * row + 19))
    picture.save("step.svg")


#: The numbers at which functions with kinks are computed; 0 and 1 are exact.
AT = np.arange(-30, 31) / 20


def computed(formula: str) -> tuple[Floats, Floats]:
    """The values and slopes of a formula of `a`: the program computes the force on a node, and what it does in a step."""
    scene = {"scene": "stability", "lattice": {"columns": 2, "rows": 2}, "physics.forces": ["node_formula"]}
    sim = cosmic.Simulator({**scene, "node_formula.force_x": formula})
    start = sim.initial()
    flying = start._replace(x0=start.x0 + [0, 1], controller={"activations": np.zeros((1, len(sim.edges)))})
    return stepped(sim, flying._replace(physics={"node_formula.a": AT}), lambda by: by.physics["node_formula.a"])


def stepped(sim: cosmic.Simulator, robots: cosmic.Inputs, slope: Callable[[cosmic.Inputs], Any]) -> tuple[Floats, Floats]:
    """The velocity of node 0 along the ground after a step, and its slope, so scaled that the largest slope is 1."""
    velocity = sim.rollout(robots, observed=[1]).v[:, 0, 0, 0]
    bar = np.zeros((len(AT), 1, *sim.shapes["x0"]))
    bar[:, 0, 0, 0] = 1.0
    slopes = slope(sim.vjp(robots, cosmic.Trajectory(np.zeros_like(bar), bar), observed=[1]))
    return velocity / np.abs(slopes).max(), slopes / np.abs(slopes).max()


def rubbed() -> tuple[Floats, Floats]:
    """The velocity along the ground after an impact with friction, against the velocity before it, in m/s."""
    sim = cosmic.Simulator({"scene": "coulomb", "lattice": {"columns": 2, "rows": 2}, "physics.friction": 0.5})
    start = sim.initial()
    speeds = np.zeros((len(AT), *start.v0.shape))
    speeds[:, 0] = np.stack([AT, np.full(len(AT), -1.2)], -1)
    robots = start._replace(v0=speeds, controller={"activations": np.zeros((1, len(sim.edges)))})
    return stepped(sim, robots, lambda by: by.v0[:, 0, 0])


def kinks() -> None:
    """Functions with kinks and their derivatives at and beside each kink, computed by the program."""
    picture = Picture("Conventions at kinks", 480)
    drawn = [
        ("abs(x)", computed("abs(a)"), [0.0], "at 0 the derivative is 0"),
        ("x.max(0)", computed("max(a, 0)"), [0.0], "at 0 that of the bound: 0"),
        ("x.min(0)", computed("min(a, 0)"), [0.0], "at 0 that of the bound: 0"),
        ("x.clamp(-1, 1)", computed("min(max(a, -1), 1)"), [-1.0, 1.0], "at and past a bound: 0"),
        ("select(x &lt; 0, a, b)", computed("where(a < 0, -a, a / 2 - 0.8)"), [0.0], "that of the chosen side"),
        ("friction", rubbed(), [], "0 for a stopped node"),
    ]
    for panel, (name, (value, slope), at, says) in enumerate(drawn):
        left, top = 18.0 + 182 * (panel % 3), 34.0 + 226 * (panel // 3)
        middle, base, unit = left + 80, top + 84, 50
        picture.text(left, top - 8, name, "b")
        picture.line([(left, base), (left + 160, base)], "rule", 1)
        picture.line([(middle, top + 6), (middle, top + 162)], "rule", 1)
        # A line breaks where the function jumps, and the derivative's also at each kink.
        for numbers, colour, width, apart in [(value, "ink", 3.5, []), (slope, "long", 2.0, at)]:
            is_break = (np.abs(np.diff(numbers)) > 0.3) | np.isin(AT[1:], apart) | np.isin(AT[:-1], apart)
            for part in np.split(np.arange(len(AT)), np.flatnonzero(is_break) + 1):
                if len(part) > 1:
                    picture.line(np.stack([middle + unit * AT[part], base - unit * numbers[part]], -1), colour, width)
        for kink in at:
            picture.dot(middle + unit * kink, base - unit * slope[np.searchsorted(AT, kink)], "long")
        picture.text(left, top + 184, says, "s")
    picture.text(18, 466, "thick: the value; red: the derivative, with a dot at each kink", "s")
    picture.save("kinks.svg")


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        robot = cosmic.optimize("stability", seed=0, out=f"{folder}/run")
        for draw in (bars, muscles, horizon):
            draw(robot)
    step()
    kinks()
