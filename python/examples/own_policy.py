"""Trains a policy of your own, written in JAX, through the simulator, and prints how far the robot walks."""

from __future__ import annotations

import sys
from functools import partial
from typing import Any

import cosmic
import cosmic.jax
import jax
import jax.numpy as jnp
import numpy as np

#: A robot of eight nodes, all of whose bars are actuators.
SIM = cosmic.Simulator({"scene": "stability", "lattice": {"columns": 4, "rows": 2}}, "layout")
EDGES = len(SIM.edges)
START = SIM.initial()._replace(z=np.tile([0.0, 0.0, 1.0], (EDGES, 1)))
LENGTH = float(np.ptp(START.x0[:, 0]))
#: The number of steps with the same activations.
HELD = 8


def policy(weights: Any, x: Any, v: Any, time: Any) -> Any:
    """The activations of all edges, from a clock, the shape of the robot and its velocities."""
    clock = jnp.stack([jnp.sin(20.0 * time), jnp.cos(20.0 * time)])
    seen = jnp.concatenate([clock, ((x - x.mean(0)) / LENGTH).ravel(), (0.1 * v).ravel()])
    return jnp.tanh(weights["w2"] @ jnp.tanh(weights["w1"] @ seen) + weights["b2"])


def walk(weights: Any, frames: int) -> Any:
    """The distance that the middle of the robot moves in this number of frames, m."""
    options: Any = {"policy": partial(policy, weights), "frame_skip": HELD}
    seen = cosmic.jax.rollout(SIM, START, observed=[0, HELD * frames], **options)
    return (seen.x[1] - seen.x[0]).mean(0) @ SIM.along


def main(seed: int = 0, iterations: int = 400, frames: int = 128, hidden: int = 32) -> float:
    jax.config.update("jax_enable_x64", True)
    random = np.random.default_rng(seed)
    inputs = 2 + 2 * START.x0.size
    weights: Any = {
        "w1": random.normal(size=(hidden, inputs)) / inputs**0.5,
        "w2": random.normal(size=(EDGES, hidden)) / hidden**0.5,
        "b2": np.zeros(EDGES),
    }
    improve = jax.jit(jax.value_and_grad(walk), static_argnums=1)
    best, farthest = weights, -np.inf
    # Adam. Gradients through many contacts may be huge, so their norms are limited to 1.
    mean = square = jax.tree.map(np.zeros_like, weights)
    for k in range(1, iterations + 1):
        # Short walks first, because their gradients are smooth.
        far, gradient = improve(weights, frames // 2 if 3 * k < iterations else frames)
        if 3 * k >= iterations and far > farthest:
            best, farthest = weights, far
        norm = jnp.sqrt(sum(jnp.sum(g**2) for g in jax.tree.leaves(gradient)))
        gradient = jax.tree.map(lambda g: jnp.nan_to_num(g / jnp.maximum(norm, 1.0)), gradient)
        mean = jax.tree.map(lambda m, g: 0.9 * m + 0.1 * g, mean, gradient)
        square = jax.tree.map(lambda s, g: 0.99 * s + 0.01 * g**2, square, gradient)
        rate = 0.01 * (1 - 0.99**k) ** 0.5 / (1 - 0.9**k)
        weights = jax.tree.map(lambda w, m, s: w + rate * m / (jnp.sqrt(s) + 1e-9), weights, mean, square)
    lengths = float(walk(best, frames)) / LENGTH
    print(f"seed {seed}: {lengths:.2f} lengths in {frames * HELD * SIM.dt:.2f} s")
    return lengths


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
