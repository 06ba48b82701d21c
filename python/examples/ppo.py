"""Trains controllers of a fixed robot, by gradients and by PPO, and prints how far it walks with them.

    python python/examples/ppo.py --seeds 3

This needs `pip install './python[sb3]'`. Gradients train the scene's controller through the simulator. PPO of
stable-baselines3 trains its own policy network by trial and error. Both run on one core, and the table has the processor
seconds of the training. A distance is the median over 16 robots whose nodes start up to 1 mm off, after a whole rollout.

With `--designed`, gradients design the robot of each seed too, and PPO trains a policy for the robot that they delivered.
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Iterator
from typing import NamedTuple, Union

# Each method has one core. NumPy, torch and cosmic read this when they start.
os.environ.update(OMP_NUM_THREADS="1", RAYON_NUM_THREADS="1")

import cosmic
import numpy as np
from cosmic.sb3 import WalkVecEnv
from stable_baselines3 import PPO
from stable_baselines3.common.vec_env import VecNormalize

Scene = dict[str, object]
Robot = Union[cosmic.Run, Scene]

#: The three-legged robot of the paper in the world of the default scene. Only its controller is trained.
FIXED: Scene = {"scene": "earth", "start": {"kind": "layout", "layout": "short"}}
#: Iterations of the optimisation, one run for each number. The third is the default of the scene.
ITERATIONS = (75, 150, 300, 600)
#: Actions of PPO, of all robots together, after which its policy is measured.
ACTIONS = (131_072, 262_144, 524_288, 1_048_576)
#: Steps of the simulator for which an action is held: a policy acts 25 times per second.
FRAME = 20
ROBOTS, SCATTER = 16, 1e-3


class Row(NamedTuple):
    method: str
    budget: str
    seconds: float
    distance: float


def by_gradients(scene: Scene, seed: int, iterations: int) -> tuple[Row, cosmic.Run]:
    began = time.process_time()
    run = cosmic.optimize(scene, seed, iterations=iterations, threads=1, progress=False)
    seconds = time.process_time() - began
    inputs, sim = run.inputs, run.simulator()
    moved = np.random.default_rng(seed).uniform(-SCATTER, SCATTER, (ROBOTS, *inputs.x0.shape))
    seen = sim.rollout(inputs._replace(x0=inputs.x0 + moved), observed=[0, sim.steps], check=False)
    start, end = (seen.x[:, :, 0] @ sim.along).T
    # A robot that diverges counts as one that stays in place.
    distance = float(np.median(np.nan_to_num(end - start)))
    return Row("gradients", f"{iterations} iterations", seconds, distance), run


def by_ppo(robot: Robot, seed: int) -> Iterator[Row]:
    many = VecNormalize(WalkVecEnv(64, robot, frame_skip=FRAME), norm_obs=False)
    noise = {"log_std_init": -0.5}
    model = PPO(
        "MlpPolicy", many, n_steps=128, batch_size=1024, seed=seed, device="cpu", policy_kwargs=noise
    )
    seconds = 0.0
    for actions in ACTIONS:
        began = time.process_time()
        model.learn(actions - model.num_timesteps, reset_num_timesteps=False)
        seconds += time.process_time() - began
        yield Row("PPO", f"{model.num_timesteps} actions", seconds, walked(robot, model, seed))


def walked(robot: Robot, model: PPO, seed: int) -> float:
    """The median distance in whole episodes without exploration."""
    many = WalkVecEnv(ROBOTS, robot, frame_skip=FRAME, scatter=SCATTER)
    many.seed(10_000 + seed)
    seen, made, running = many.reset(), np.zeros(ROBOTS), np.ones(ROBOTS, np.bool_)
    while running.any():
        many.step_async(model.predict(seen, deterministic=True)[0])
        seen, rewards, over, _ = many.step_wait()
        made += rewards * running
        running &= ~over
    return float(np.median(made))


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--designed", action="store_true", help="the robots that gradients design")
    arguments = parser.parse_args()
    scene: Scene = {"scene": "earth"} if arguments.designed else FIXED
    budgets = (300,) if arguments.designed else ITERATIONS
    seeds = range(arguments.seeds)
    print("| method | training | processor seconds | median distance, m | of each seed |")
    print("| --- | --- | --: | --: | --- |")

    def show(rows: list[Row]) -> None:
        seconds, median = (np.median(own) for own in ([row.seconds for row in rows], [row.distance for row in rows]))
        each = ", ".join(f"{row.distance:.2f}" for row in rows)
        print(f"| {rows[0].method} | {rows[0].budget} | {seconds:.0f} | {median:.2f} | {each} |", flush=True)

    done: list[tuple[Row, cosmic.Run]] = []
    for iterations in budgets:
        done = [by_gradients(scene, seed, iterations) for seed in seeds]
        show([row for row, _ in done])
    robots: list[Robot] = [run if arguments.designed else scene for _, run in done]
    # The seeds take turns, and stable-baselines3 has one random generator. So their rows depend on the number of seeds.
    for rows in zip(*map(by_ppo, robots, seeds)):
        show(list(rows))


if __name__ == "__main__":
    main()
