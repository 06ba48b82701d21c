"""Evolves layouts under one trained network, and compares them with robots of `cosmic.optimize` at equal processor seconds.

    python python/examples/one_policy.py --out one_policy
    python python/examples/evolve.py one_policy        # with --space if one_policy.py had it

This needs what `one_policy.py` needs. The network never changes in an evolution (zero-shot), so a robot costs one rollout.
`refined` spends half of the seconds on an evolution, and half on the controller of its best robot. All use one core.
"""

from __future__ import annotations

import argparse
import time
import warnings
from pathlib import Path
from typing import Any, NamedTuple, Optional

import one_policy  # First, because it limits the number of threads.
import cosmic
import numpy as np
from one_policy import SCENE, SPACE, Array, Weights, bodies, controller, placed, walked

#: Robots of a generation, robots that survive it, and the share of edges that a mutation draws anew.
POPULATION, SURVIVORS, RATE = 64, 16, 0.03
#: The scene without changes of the layout, in which the gradient covers the whole walk.
SETTINGS: dict[str, Any] = {**SCENE, "schedule.horizon": [512, 1024], "loss.window": 256}
FIXED: dict[str, Any] = {**SETTINGS, "schedule.polish_trials": 0}


class Robot(NamedTuple):
    """A finished robot, and the processor seconds that it took."""

    z: Array
    controller: dict[str, Array]
    seconds: float


def children(sim: cosmic.Simulator, random: np.random.Generator, parents: Array) -> Array:
    """Robots with the bars of one parent on one side of a random line and those of another on the other side; in space, of a
    random plane. Some edges are drawn anew. Then edges change until each robot is in one piece and within the volume bounds."""
    middle = sim.initial().x0[sim.edges].mean(axis=1)
    middle -= middle.mean(axis=0)
    angles = random.uniform(0.0, 2.0 * np.pi, POPULATION)
    offsets = random.uniform(-0.2, 0.2, (POPULATION, 1))
    if middle.shape[1] == 2:
        normals = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    else:
        across = random.uniform(-1.0, 1.0, POPULATION)
        flat = np.sqrt(1.0 - across**2)
        normals = np.stack([flat * np.cos(angles), across, flat * np.sin(angles)], axis=1)
    side = normals @ middle.T > offsets
    one, other = parents[random.integers(len(parents), size=(2, POPULATION))]
    kept = random.uniform(size=side.shape) > RATE
    z = np.where(side[..., None], one, other) * kept[..., None] + random.uniform(size=one.shape)
    return sim.layout(0.5 * z).astype(np.float32)


def evolved(sim: cosmic.Simulator, weights: Weights, seed: int, seconds: float) -> Robot:
    """Keeps the best robots of all generations until the processor seconds are spent."""
    began, random = time.process_time(), np.random.default_rng(seed)
    best = bodies(sim, random, POPULATION)
    far = walked(sim, controller(weights, best), placed(sim, random, best))
    while time.process_time() - began < seconds:
        fresh = children(sim, random, best)
        walks = walked(sim, controller(weights, fresh), placed(sim, random, fresh))
        best, far = np.concatenate([best, fresh]), np.concatenate([far, walks])
        order = np.argsort(-far)[:SURVIVORS]
        best, far = best[order], far[order]
    return Robot(best[0], controller(weights, best[0]), time.process_time() - began)


def optimized(scene: dict[str, Any], seed: int, iterations: int, start: Optional[cosmic.Inputs] = None) -> Robot:
    began = time.process_time()
    run = cosmic.optimize(scene, seed, start=start, iterations=iterations, threads=1, progress=False)
    return Robot(run.design.z, run.controller, time.process_time() - began)


def distance(sim: cosmic.Simulator, robot: Robot) -> float:
    """The median distance over 16 starts that are up to 1 mm off, m."""
    start = placed(sim, np.random.default_rng(0), np.stack([robot.z] * 16))
    blocks = {name: np.asarray(block, np.float64) for name, block in robot.controller.items()}
    return float(np.median(walked(sim, blocks, start)))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("policy", type=Path, help="folder of one_policy.py")
    parser.add_argument("--seeds", type=int, default=16)
    parser.add_argument("--iterations", type=int, default=150, help="iterations of cosmic.optimize")
    parser.add_argument("--space", action="store_true", help="robots in space, for a network of robots in space")
    given = parser.parse_args()
    warnings.simplefilter("ignore", UserWarning)
    sim, _ = one_policy.worlds("mlp", space=given.space)
    settings, fixed = ({**scene, **(SPACE if given.space else {})} for scene in (SETTINGS, FIXED))
    weights = dict(np.load(given.policy / "mlp.npz"))
    robots: dict[str, list[Robot]] = {"optimize": [], "evolved": [], "refined": []}
    #: The processor seconds of an iteration that only changes the controller.
    each = 0.0
    for seed in range(given.seeds):
        both = optimized(settings, seed, given.iterations)
        begun = evolved(sim, weights, seed, both.seconds / 2)
        start = sim.initial()._replace(z=begun.z, controller=begun.controller)
        count = round(both.seconds / 2 / each) if each else given.iterations // 3
        tuned = optimized(fixed, seed, count, start)
        each = tuned.seconds / count
        robots["optimize"].append(both)
        robots["evolved"].append(evolved(sim, weights, seed, both.seconds))
        robots["refined"].append(tuned._replace(seconds=begun.seconds + tuned.seconds))
    print("| | processor seconds | median distance, m | 10 % | 90 % | farther than optimize |")
    print("| --- | --: | --: | --: | --: | --: |")
    far = {name: np.array([distance(sim, robot) for robot in own]) for name, own in robots.items()}
    for name, own in robots.items():
        seconds = np.median([robot.seconds for robot in own])
        low, middle, high = np.quantile(far[name], [0.1, 0.5, 0.9])
        wins = f"{(far[name] > far['optimize']).sum()} of {given.seeds}" if name != "optimize" else ""
        print(f"| {name} | {seconds:.1f} | {middle:.2f} | {low:.2f} | {high:.2f} | {wins} |")
    arrays: dict[str, Any] = {f"{name}-z": np.stack([robot.z for robot in own]) for name, own in robots.items()}
    np.savez(given.policy / "evolve.npz", **{**arrays, **far})


if __name__ == "__main__":
    main()
