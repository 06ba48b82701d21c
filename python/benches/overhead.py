"""What a call from Python costs beside the library's own: `python benches/overhead.py`.

Least of many rounds, taken in turns.
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


def compared(sim: cosmic.Simulator, inputs: cosmic.Inputs, steps: int, rounds: int) -> list[float]:
    """Seconds of a call and of the library within it."""
    observed = sim.observed(steps)
    arrays = list(inputs)
    turns = [
        (
            least(lambda: sim.rollout(inputs, steps), rounds),
            sim._core.library_seconds(arrays, observed, rounds),
        )
        for _ in range(10)
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
    for name, of, steps, rounds in [
        ("1 step", inputs, 1, 500),
        ("4096 steps", inputs, 4096, 10),
        ("64 robots, 4096 steps", many, 4096, 1),
    ]:
        call, library = compared(sim, of, steps, rounds)
        over = call - library
        print(
            f"| {name} | {1e6 * call:.1f} | {1e6 * library:.1f} | {1e6 * over:.1f} "
            f"| {100 * over / library:.1f} % |"
        )


if __name__ == "__main__":
    main()
