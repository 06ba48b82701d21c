"""Measures how much longer a call from Python takes than the rollout in it: `python benches/overhead.py`.

Each time is the minimum of many rounds, which alternate between the two.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np

import cosmic


def least(call: Callable[[], object], rounds: int) -> float:
    seconds = []
    for _ in range(rounds):
        began = time.perf_counter()
        call()
        seconds.append(time.perf_counter() - began)
    return min(seconds)


def compared(
    sim: cosmic.Simulator, inputs: cosmic.Inputs, observed: list[int], rounds: int
) -> list[float]:
    """The time of a call, and the time of the library in it, s."""
    arrays = list(inputs)
    turns = [
        (
            least(lambda: sim.rollout(inputs, observed=observed), rounds),
            sim._core.library_seconds(arrays, observed, rounds),
        )
        for _ in range(30)
    ]
    return [min(times) for times in zip(*turns)]


def main() -> None:
    sim = cosmic.Simulator("stability")
    inputs = sim.initial()
    random = np.random.default_rng(0)
    moved = random.uniform(-1e-3, 1e-3, (64, *inputs.x0.shape))
    many = inputs._replace(x0=inputs.x0 + moved)
    print("| rollout | call, us | library, us | overhead, us | share |")
    print("| --- | --- | --- | --- | --- |")
    every_16th = sim.observed(4096)
    for name, of, observed, rounds in [
        ("1 step", inputs, [1], 500),
        ("4096 steps, every 16th state", inputs, every_16th, 10),
        ("64 robots, 4096 steps, the last state", many, [4096], 4),
        ("64 robots, 4096 steps, every 16th state", many, every_16th, 4),
    ]:
        call, library = compared(sim, of, observed, rounds)
        over = call - library
        print(
            f"| {name} | {1e6 * call:.1f} | {1e6 * library:.1f} | {1e6 * over:.1f} "
            f"| {100 * over / library:.1f} % |"
        )


if __name__ == "__main__":
    main()
