"""Robots as an environment of JAX: `reset` and `step` are pure functions, for `jit`, `vmap` and `scan`."""

from typing import Any, NamedTuple

import cosmic
import cosmic.jax
import jax
import jax.numpy as jnp

SIM = cosmic.Simulator("three_legged")
REST = SIM.initial()
HELD, FRAMES = 16, SIM.steps // 16


class State(NamedTuple):
    x: Any
    v: Any
    gravity: Any
    frames: Any


def reset(key: Any) -> State:
    gravity = SIM.physics["physics.gravity"] * jax.random.uniform(key, minval=0.8, maxval=1.2)
    return State(REST.x0 + jax.random.uniform(key, REST.x0.shape, maxval=1e-3), 0.0 * REST.v0, gravity, 0)


def step(state: State, given: Any) -> Any:
    """The state after an action (or that of a new episode), the reward in m, and whether the episode is over."""
    x, v = cosmic.jax.step(SIM, REST.z, state.x, state.v, given[0], HELD, physics={"physics.gravity": state.gravity})
    is_lost, after = ~jnp.isfinite(x).all(), State(x, v, state.gravity, state.frames + 1)
    reward, over = (x - state.x)[SIM.payload] @ SIM.along, is_lost | (after.frames == FRAMES)
    after = jax.tree.map(lambda new, own: jnp.where(over, new, own), reset(given[1]), after)
    return after, (jnp.where(is_lost, 0.0, reward), over)


if __name__ == "__main__":
    keys = jax.random.split(jax.random.key(0), (FRAMES, 64))
    actions = jax.random.uniform(keys[0, 0], (FRAMES, 64, len(SIM.edges)), minval=-1.0)
    rewards = jax.lax.scan(jax.vmap(step), jax.vmap(reset)(keys[0]), (actions, keys))[1][0]
    print(f"{rewards.sum(0).mean():.3f} m by random actions")
