"""Trains a policy of one's own, written in JAX, through the simulator, until the robot walks two of its lengths."""

from __future__ import annotations

import sys
from functools import partial
from typing import Any

import cosmic
import cosmic.jax
import jax
import jax.numpy as jnp
import numpy as np

#: Steps with the same activations, and frames of so many steps.
HELD, FRAMES = 16, 128
HIDDEN = 32

#: A small robot. Only its design is used, without its controller.
RUN = cosmic.optimize(
    {
        "scene": "stability",
        "lattice": {"columns": 3, "rows": 3},
        "physics.steps": 256,
        "schedule": {"iterations": 40, "attraction_from": 13, "snap_at": 26, "horizon": [128, 256]},
        "loss.window": 64,
    },
    seed=1,
    progress=False,
)
SIM, START = RUN.simulator(), RUN.inputs
LENGTH = float(np.ptp(START.x0[:, 0]))
EDGES = len(SIM.edges)


def policy(weights: Any, x: Any, v: Any, time: Any) -> Any:
    """The activations of all edges, from the shape of the robot, its velocities and a clock."""
    clock = jnp.stack([jnp.sin(10.0 * time), jnp.cos(10.0 * time)])
    seen = jnp.concatenate([clock, ((x - x.mean(0)) / LENGTH).ravel(), (0.1 * v).ravel()])
    return jnp.tanh(weights["w2"] @ jnp.tanh(weights["w1"] @ seen) + weights["b2"])


def walk(weights: Any, frames: int) -> Any:
    """The distance of the payload after so many frames, m."""

    def frame(state: Any, number: Any) -> Any:
        held = policy(weights, *state, HELD * SIM.dt * number)
        return tuple(cosmic.jax.step(SIM, START.z, *state, held, HELD)), None

    start = (jnp.asarray(START.x0), jnp.asarray(START.v0))
    (x, _), _ = jax.lax.scan(frame, start, jnp.arange(frames))
    return (x[0] - start[0][0]) @ SIM.along


def main(iterations: int = 150) -> float:
    jax.config.update("jax_enable_x64", True)
    random = np.random.default_rng(0)
    inputs = 2 + 2 * START.x0.size
    weights: Any = {
        "w1": random.normal(size=(HIDDEN, inputs)) / inputs**0.5,
        "w2": random.normal(size=(EDGES, HIDDEN)) / HIDDEN**0.5,
        "b2": np.zeros(EDGES),
    }
    improve = jax.jit(jax.value_and_grad(lambda weights, frames: -walk(weights, frames)), static_argnums=1)
    # Adam, with gradients of norm 1: gradients through many contacts differ in size by orders of magnitude.
    mean = square = jax.tree.map(np.zeros_like, weights)
    for k in range(iterations):
        # Short walks first, because their gradients are smooth.
        frames = FRAMES // 4 if k < iterations // 2 else FRAMES // 2
        loss, gradient = improve(weights, frames)
        norm = jnp.sqrt(sum(jnp.sum(g**2) for g in jax.tree.leaves(gradient)))
        gradient = jax.tree.map(lambda g: jnp.nan_to_num(g / norm), gradient)
        mean = jax.tree.map(lambda m, g: 0.9 * m + 0.1 * g, mean, gradient)
        square = jax.tree.map(lambda s, g: 0.99 * s + 0.01 * g**2, square, gradient)
        rate = 0.02 / (1 - 0.9 ** (k + 1)) * (1 - 0.99 ** (k + 1)) ** 0.5
        weights = jax.tree.map(lambda w, m, s: w - rate * m / (jnp.sqrt(s) + 1e-9), weights, mean, square)
        if k % 25 == 0:
            print(f"iteration {k}: {-float(loss):.3f} m in {frames * HELD * SIM.dt:.1f} s")
    far = float(jax.jit(partial(walk, frames=FRAMES))(weights))
    print(f"the robot walks {far:.3f} m, {far / LENGTH:.1f} of its lengths, in {FRAMES * HELD * SIM.dt:.1f} s")
    return far / LENGTH


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
