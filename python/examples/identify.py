"""Identifies friction, drag and stiffness of a robot from its motion, and predicts another walk.

With --draws 20 it counts how often the 95 % intervals contain the true physics. Arguments NAME=FACTOR replace
the true physics. --space takes a robot in space."""

from __future__ import annotations

import argparse
from typing import Any, NamedTuple

import cosmic
import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

SCENE: dict[str, object] = {
    "scene": "coulomb",
    "lattice": {"columns": 3, "rows": 3},
    "physics": {"friction": 0.8, "steps": 1024},
    "schedule": {"iterations": 60, "attraction_from": 20, "snap_at": 40, "horizon": [128, 512]},
    "loss.window": 64,
}
#: The lattice in space.
SPACE = {"kind": "cubic", "columns": 3, "depth": 2, "rows": 2}
#: The physics of the real robot, as factors on the scene's. Its friction is 0.63 in place of 0.8.
TRUE = {"physics.friction": 0.7875, "physics.damping": 1.2, "bars.stiffness": 0.95}
#: The camera sees every fourth step with an error of 1 mm. The first 16 frames, in which the robot starts from rest on
#: the ground, are left out. Every ten other frames are a window.
NOISE, EVERY, SKIPPED, FRAMES = 1e-3, 4, 16, 10
#: The units of unknown positions, velocities and factors.
UNITS = (1e-3, 0.1, 0.1)


class Estimate(NamedTuple):
    """Factors on the scene's physics, half the lengths of their 95 % intervals, and the noise's standard deviation."""

    factors: dict[str, float]
    margins: Array
    noise: float


def physics(sim: cosmic.Simulator, factors: dict[str, Any]) -> dict[str, Array]:
    """The scene's physics times factors. Numbers of bars and nodes have an axis of edges or nodes."""
    numbers = {name: sim.physics[name] * np.asarray(factor) for name, factor in factors.items()}
    return {name: number[..., None] if name in sim.factors else number for name, number in numbers.items()}


def shaken(sim: cosmic.Simulator, random: np.random.Generator) -> Array:
    """Activations for a record: two slow waves of random frequencies and phases for each edge."""
    times, shape = sim.dt * np.arange(sim.steps)[:, None], (2, 1, len(sim.edges))
    waves: Array = np.sin(times * random.uniform(6, 25, shape) + random.uniform(0, 7, shape))
    bounded: Array = waves.sum(axis=0).clip(-1.0, 1.0)
    return bounded


def filmed(run: cosmic.Run, factors: dict[str, float], random: np.random.Generator) -> tuple[Array, Array]:
    """The frames of a real robot that is shaken, and its activations."""
    sim = run.simulator()
    activations = shaken(sim, random)
    real = run.inputs._replace(controller={"activations": activations}, physics=physics(sim, factors))
    frames = sim.rollout(real, observed=EVERY).x[:-1]
    return frames + random.normal(scale=NOISE, size=frames.shape), activations


def identify(sim: cosmic.Simulator, z: Array, frames: Array, activations: Array, names: list[str]) -> Estimate:
    """Fits the factors of these names to `frames`, of shape `(frames, nodes, D)`, by Gauss-Newton steps.

    Each window starts from unknown positions and velocities, which a Schur complement eliminates. Windows that stay in
    a local minimum are left out."""
    count, shape = (len(frames) - SKIPPED) // FRAMES, frames.shape[1:]
    seen = frames[SKIPPED : SKIPPED + count * FRAMES].reshape(count, FRAMES, *shape)
    # Windows are simulated up to the start of the next window.
    spans = EVERY * (SKIPPED + FRAMES * np.arange(count)[:, None]) + np.arange(EVERY * FRAMES)
    driven, observed = activations[spans], EVERY * np.arange(FRAMES + 1)
    size = seen[0, 0].size
    starts, unknowns = 2 * size, 2 * size + len(names)
    units = np.repeat(UNITS, (size, size, len(names)))
    # No node starts below the ground, on which the lowest nodes of a robot at rest are. No factor is negative.
    least = np.full(unknowns, -np.inf)
    above = shape[-1] - 1
    least[above : size : shape[-1]], least[starts:] = sim.initial().x0[:, above].min() / units[0], 0.0

    def inputs(rows: Array, driven: Array) -> cosmic.Inputs:
        x0, v0 = (units * rows)[:, :starts].reshape(-1, 2, *shape).swapaxes(0, 1)
        factors = dict(zip(names, (units * rows)[:, starts:].T))
        return cosmic.Inputs(z, {"activations": driven}, x0, v0, physics(sim, factors))

    def missed(rows: Array) -> Array:
        states = sim.rollout(inputs(rows, driven), observed=observed, check=False)
        return used[:, None] * (seen - states.x[:, :-1]).reshape(count, -1)

    def jacobian(rows: Array, error: Array) -> Array:
        # A robot for each window and column.
        robots = inputs(np.repeat(rows, unknowns, axis=0), np.repeat(driven, unknowns, axis=0))
        along = inputs(np.tile(np.eye(unknowns), (count, 1)), np.zeros_like(driven[0]))
        _, moved = sim.jvp(robots, along._replace(z=np.zeros_like(z)), observed=observed)
        slopes: Array = moved.x[:, :-1].reshape(count, unknowns, -1).swapaxes(1, 2)
        # A node that would go from the ground into the ground stays.
        free: Array = ((rows > least) | (np.einsum("wnu,wn->wu", slopes, error) > 0))[:, None]
        return used[:, None, None] * slopes * free

    def solve(slopes: Array, error: Array, damping: float) -> tuple[Array, Array]:
        """The Gauss-Newton matrix of the factors, and the step of all unknowns."""
        across = slopes.swapaxes(1, 2)
        matrix = across @ slopes + damping * units[0] ** 2 * np.eye(unknowns)
        right = np.dstack([matrix[..., starts:], across @ error[..., None]])
        solved = np.linalg.solve(matrix[:, :starts, :starts], right[:, :starts])
        rest = (right[:, starts:] - matrix[:, starts:, :starts] @ solved).sum(axis=0)
        step = np.linalg.solve(rest[:, :-1], rest[:, -1])
        by_start = solved[..., -1] - solved[..., :-1] @ step
        return rest[:, :-1], np.hstack([by_start, np.tile(step, (count, 1))])

    begin = np.stack([seen[:, 0], (seen[:, 1] - seen[:, 0]) / (EVERY * sim.dt)], axis=1).reshape(count, -1)
    parts = np.ones((4, 1, unknowns))
    parts[:, 0, :starts] = np.reshape([1.0, 0.5, 0.2, 0.0], (-1, 1))
    factors = np.ones(len(names))
    for least_gain in (1e-2, 1e-2, 1.0 / seen.size):
        used = np.ones(count, dtype=bool)
        rows = np.maximum(np.hstack([begin, np.tile(factors, (count, 1))]) / units, least)
        error, gain = missed(rows), 1.0
        while gain > least_gain:
            slopes, before, tried = jacobian(rows, error), np.sum(error**2), [(rows, error)]
            for damping in (1e-2, 1.0, 1e2):
                _, step = solve(slopes, error, damping)
                # Contacts are kinks: each window takes the part of its own step that serves it best.
                moved = np.maximum(rows + parts * step, least)
                left = np.stack([missed(some) for some in moved])
                best = np.nan_to_num(np.sum(left**2, axis=-1), nan=np.inf).argmin(axis=0), np.arange(count)
                tried.append((moved[best], left[best]))
            rows, error = min(tried, key=lambda trial: float(np.sum(trial[1] ** 2)))
            gain, sums = 1.0 - np.sum(error**2) / before, np.sum(error**2, axis=-1)
            # Beyond four standard deviations of its sum of squares, a window is in a local minimum.
            lost = sums > np.median(sums[used]) * (1.0 + 4.0 * np.sqrt(2.0 / (error.shape[1] - starts)))
            if gain <= least_gain and lost.any():
                used, error, gain = used & ~lost, error * ~lost[:, None], 1.0
        factors = units[starts:] * rows[0, starts:]
        # Starts that were fitted with wrong factors may stay in local minima. The ends of windows are better starts.
        ends = sim.rollout(inputs(rows, driven), observed=observed[-1:], check=False)
        begin[1:][used[:-1]] = np.concatenate(ends, axis=1).reshape(count, -1)[:-1][used[:-1]]
    slopes = jacobian(rows, error)
    known = np.linalg.matrix_rank(slopes[..., :starts], 1e-2 * units[0]).sum() + len(names)
    noise = float(np.sqrt(np.sum(error**2) / (used.sum() * error.shape[1] - known)))
    spread = noise * units[-1] * np.sqrt(np.diag(np.linalg.inv(solve(slopes, error, 1e-6)[0])))
    return Estimate(dict(zip(names, factors.tolist())), 1.96 * spread, noise)


def mistakes(real: Array, predicted: Array) -> Array:
    """By how much the distance of the payload is wrong, and the mean error of the nodes at four times, mm."""
    of_nodes = np.sqrt(np.mean(np.sum((predicted - real) ** 2, axis=-1), axis=-1))
    times = np.arange(1, 5) * (len(real) - 1) // 4
    return 1e3 * np.array([abs(predicted[-1, 0, 0] - real[-1, 0, 0]), *of_nodes[times]])


def main() -> None:
    options = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    options.add_argument("factors", nargs="*", metavar="NAME=FACTOR", help="the true physics [default: TRUE]")
    options.add_argument("--draws", type=int, default=0, help="number of true physics to draw, with factors from 0.8 to 1.25")
    options.add_argument("--space", action="store_true", help="a robot in space")
    given = options.parse_args()
    true = {name: float(factor) for name, factor in (pair.split("=") for pair in given.factors)} or TRUE
    scene = {**SCENE, "lattice": SPACE} if given.space else SCENE
    run = cosmic.optimize(scene, seed=2, progress=lambda *_: None)
    sim, random = run.simulator(), np.random.default_rng(0)
    drawn = [{name: random.uniform(0.8, 1.25) for name in true} for _ in range(given.draws)] or [true]
    off, margins, wrong = [], [], []
    for truth in drawn:
        fit = identify(sim, run.design.z, *filmed(run, truth, random), list(truth))
        # The walk that the robot was designed for.
        walks = [run.inputs._replace(physics=physics(sim, factors)) for factors in (truth, {}, fit.factors)]
        walked, *predicted = (sim.rollout(inputs, observed=EVERY).x for inputs in walks)
        off.append([abs(fit.factors[name] - truth[name]) for name in truth])
        margins.append(fit.margins)
        wrong.append([mistakes(walked, walk) for walk in predicted])
        if not given.draws:
            for name, margin in zip(truth, fit.margins):
                numbers = sim.physics[name] * np.array([truth[name], fit.factors[name], margin])
                print("{}: true {:.3f}, estimate {:.3f} ± {:.3f}".format(name, *numbers))
            print(f"noise {1e3 * fit.noise:.3f} mm; a walk of {walked[-1, 0, 0] - walked[0, 0, 0]:.3f} m")
    inside = np.array(off) <= margins
    for name, *column in zip(true, inside.sum(axis=0), np.median(off, axis=0), np.median(margins, axis=0)):
        print("{}: {} of {} inside, off by {:.3f}, ± {:.3f}".format(name, column[0], len(drawn), *column[1:]))
    print(f"all at once: {inside.all(axis=1).sum()} of {len(drawn)} inside")
    for name, row in zip(("uncorrected", "corrected"), np.median(wrong, axis=0)):
        print("{}: distance wrong by {:.1f} mm, nodes by {:.1f}, {:.1f}, {:.1f}, {:.1f} mm".format(name, *row))


if __name__ == "__main__":
    main()
