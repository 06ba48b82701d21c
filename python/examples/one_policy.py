"""Trains one network that controls every robot of a lattice, and measures it on robots that it has never seen.

    python python/examples/one_policy.py --out one_policy

This needs `pip install './python[jax]' optax`. The robots are random layouts in one piece. The network sees which bars a robot
has and, in closed loop, the positions and velocities of its nodes; those of nodes that the robot lacks are 0. `--space` takes
robots in space, and `--gpu` trains on a GPU.
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any, Literal, NamedTuple, Optional

# One core. NumPy, XLA and cosmic read this when they start.
os.environ.update(OMP_NUM_THREADS="1", RAYON_NUM_THREADS="1", XLA_FLAGS="--xla_cpu_multi_thread_eigen=false")

import cosmic
import cosmic.jax
import jax
import jax.numpy as jnp
import numpy as np
import numpy.typing as npt
import optax

Array = npt.NDArray[Any]
#: The numbers of the network by name: those of the scene's controller, and `mask`.
Weights = Mapping[str, Any]

SCENE: dict[str, Any] = {
    "scene": "coulomb",
    "lattice": {"columns": 5, "rows": 4},
    "physics.steps": 1024,
    "controller": {"hidden": 64, "clock": "fixed"},
    "volume": {"solid": [0.6, 0.8], "actuator": [0.3, 0.4]},
}
#: What differs in space. The ground is a plane there, so a slope takes the place of rough ground.
SPACE: dict[str, Any] = {"lattice": {"kind": "cubic", "columns": 3, "depth": 2, "rows": 3}}
SLOPE: dict[str, Any] = {"physics.incline_deg": 5.0}
#: The share of motors that are lost, the steps between two pushes, and the largest velocity of a push, m/s.
LOST, EVERY, PUSH = 0.25, 256, 0.5
#: Bodies per update, and the first learning rate of Adam, which falls along a cosine.
BATCH, RATE = 32, 0.003


class Bodies(NamedTuple):
    """Robots at their starts: arrays with an axis of robots in front."""

    z: Array
    x0: Array
    v0: Array
    strain: Array
    """Factors on the strain of every edge, ``(robots, edges)``: 0 for the motors that are lost."""


def bodies(sim: cosmic.Simulator, random: np.random.Generator, count: int) -> Array:
    """Random layouts in one piece within the scene's volume bounds, shape ``(count, edges, 3)``."""
    return sim.layout(random.uniform(size=(count, *sim.shapes["z"]))).astype(np.float32)


def placed(sim: cosmic.Simulator, random: np.random.Generator, z: Array, lost: float = 0.0, push: float = 0.0) -> Bodies:
    """Robots whose nodes start up to 1 mm off. This share of their motors is lost, and each robot is pushed."""
    count, rest = len(z), sim.initial().x0
    drawn = np.where(z[..., 2] == 1.0, random.uniform(size=z.shape[:2]), 2.0)
    is_lost = drawn.argsort(axis=1).argsort(axis=1) < np.round(lost * z[..., 2].sum(axis=1, keepdims=True))
    x0 = rest + random.uniform(-1e-3, 1e-3, (count, *rest.shape))
    v0 = random.uniform(-push, push, (count, 1, rest.shape[-1])) * np.ones_like(x0)
    return Bodies(*(array.astype(np.float32) for array in (z, x0, v0, 1.0 - is_lost)))


def controller(weights: Weights, z: Any) -> dict[str, Any]:
    """The scene's controller for a body. The mask of its bars is an input of the network that stays constant, so it adds to
    the biases of the hidden layer."""
    mask = z[..., 1:].reshape(*z.shape[:-2], -1)
    blocks = {name: block for name, block in weights.items() if name != "mask"}
    return {**blocks, "b1": weights["b1"] + (mask[..., None, :] @ weights["mask"])[..., 0, :]}


def distance(sim: cosmic.Simulator, steps: int, weights: Weights, body: Bodies) -> Any:
    """How far one robot walks in so many steps, m: the mean over the last quarter, whose gradients are smoother."""
    inputs = cosmic.Inputs(body.z, controller(weights, body.z), body.x0, body.v0, {"bars.strain": body.strain})
    seen = cosmic.jax.rollout(sim, inputs, observed=range(3 * steps // 4, steps + 1, 16), bounded=True)
    return ((seen.x[:, sim.payload] - body.x0[sim.payload]) @ jnp.asarray(sim.along, np.float32)).mean()


def gradient(sim: cosmic.Simulator, steps: int, weights: Weights, batch: Bodies) -> Any:
    """The mean gradient of minus the distance by the weights, over a batch of bodies with one network. The norm of a body's
    gradient is limited to 1, because those through many contacts may be huge; 0 if the body diverged."""

    def by_body(body: Bodies) -> Any:
        of = jax.grad(lambda weights: -distance(sim, steps, weights, body))(weights)
        norm = optax.global_norm(of)
        return jax.tree.map(lambda g: jnp.nan_to_num(g / jnp.maximum(norm, 1.0)), of)

    return jax.tree.map(lambda g: g.mean(0), jax.vmap(by_body)(batch))


def begin(sim: cosmic.Simulator, seed: int) -> Weights:
    first = sim.initial(seed).controller
    mask = np.random.default_rng(seed).normal(size=(2 * len(sim.edges), len(first["b1"]))) / len(sim.edges) ** 0.5
    return {name: np.asarray(block, np.float32) for name, block in {**first, "mask": mask}.items()}


def train(sim: cosmic.Simulator, weights: Weights, draw: Callable[[], Bodies], updates: int, own: bool = False) -> Weights:
    """Trains on batches from `draw`. With `own`, every body has its own network: weights and batches have an axis of bodies
    in front."""
    method = optax.adam(optax.cosine_decay_schedule(RATE, updates))

    def update(steps: int, weights: Weights, state: Any, batch: Bodies) -> Any:
        change, state = method.update(gradient(sim, steps, weights, batch), state)
        return optax.apply_updates(weights, change), state

    each = jax.vmap if own else (lambda function: function)
    state = each(method.init)(weights)
    # Short walks first, because their gradients are smooth.
    half, whole = (jax.jit(each(partial(update, steps))) for steps in (sim.steps // 2, sim.steps))
    for k in range(updates):
        weights, state = (half if 2 * k < updates else whole)(weights, state, draw())
    return {name: np.asarray(block) for name, block in weights.items()}


def walked(sim: cosmic.Simulator, blocks: Weights, start: Bodies, pushes: Optional[np.random.Generator] = None) -> Array:
    """The distances of robots with these controllers, m, which are pushed if `pushes` is given. A robot that diverges counts
    as one that stays."""
    x, v, every = start.x0, start.v0, EVERY if pushes else sim.steps
    for first in range(0, sim.steps, every):
        if pushes:
            v = v + pushes.uniform(-PUSH, PUSH, (len(v), 1, v.shape[-1])).astype(v.dtype)
        inputs = cosmic.Inputs(start.z, blocks, x, v, {"bars.strain": start.strain})
        seen = sim.rollout(inputs, observed=[every], first=first, check=False)
        x, v = seen.x[:, -1], seen.v[:, -1]
    far: Array = np.nan_to_num((x[:, sim.payload] - start.x0[:, sim.payload]) @ sim.along)
    return far


def worlds(policy: str, device: Literal["cpu", "gpu"] = "cpu", space: bool = False) -> tuple[cosmic.Simulator, cosmic.Simulator]:
    """Simulators of robots with this policy, on flat and on rough ground: with holes of up to 2 cm every 5 cm. In space, the
    second ground is a slope."""
    scene = {**SCENE, **(SPACE if space else {}), "controller": {**SCENE["controller"], "policy": policy}}
    holes = np.random.default_rng(0).uniform(-0.02, 0.0, 60)
    rough = {"ground": {"profile": "points", "points": np.column_stack([0.05 * np.arange(-12, 48), holes])}}
    other = {**scene, **(SLOPE if space else rough)}
    return cosmic.Simulator(scene, "layout", device), cosmic.Simulator(other, "layout")


def agreement(space: bool) -> float:
    """The largest difference between gradients over 64 steps on a GPU and on the processor, relative to each array."""
    random, (here, _), (there, _) = np.random.default_rng(0), *(worlds("mlp", device, space) for device in ("cpu", "gpu"))
    batch = placed(here, random, bodies(here, random, BATCH))
    one, other = (jax.jit(partial(gradient, sim, 64))(begin(here, 0), batch) for sim in (here, there))
    return max(float(abs(one[name] - other[name]).max() / abs(one[name]).max()) for name in one)


def measured(worlds: tuple[cosmic.Simulator, cosmic.Simulator], weights: Weights, z: Array, seed: int) -> list[Array]:
    """Distances without a disturbance, without a quarter of the motors, with pushes, on other ground, and with all three."""
    found = []
    for world, lost, is_pushed in [(0, 0.0, False), (0, LOST, False), (0, 0.0, True), (1, 0.0, False), (1, LOST, True)]:
        random = np.random.default_rng(20_000 + seed)
        start = placed(worlds[world], random, z, lost)
        found.append(walked(worlds[world], controller(weights, z), start, random if is_pushed else None))
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--updates", type=int, default=1000)
    parser.add_argument("--own", type=int, default=16, help="unseen bodies that also get a network of their own")
    parser.add_argument("--space", action="store_true", help="robots in space, on a lattice of cubes")
    parser.add_argument("--gpu", action="store_true", help="train the shared networks on a GPU")
    parser.add_argument("--out", type=Path, default=Path("one_policy"), help="folder of the networks and the walks")
    given = parser.parse_args()
    if given.gpu:
        print(f"gradients on the GPU differ by {agreement(given.space):.1e} of their largest numbers")
    given.out.mkdir(parents=True, exist_ok=True)
    ground = "slope" if given.space else "rough ground"
    print(f"| | seconds | undisturbed, m | own network | motors lost | pushed | {ground} | all three |")
    print("| --- | --: | --: | --: | --: | --: | --: | --: |")
    for name, policy in (("closed loop", "mlp"), ("open loop", "clock")):
        sims, random = worlds(policy, space=given.space), np.random.default_rng(given.seed)
        sim, device = sims[0], worlds(policy, "gpu", given.space)[0] if given.gpu else sims[0]
        unseen, first = bodies(sim, np.random.default_rng(10_000 + given.seed), 4 * given.own), begin(sim, given.seed)

        def batch(z: Array) -> Bodies:
            return placed(sim, random, z, LOST * random.integers(2), PUSH)

        began = time.process_time()
        shared = train(device, first, lambda: batch(bodies(sim, random, BATCH)), given.updates)
        seconds = time.process_time() - began
        few = unseen[: given.own]
        many = {block: np.stack([array] * given.own) for block, array in first.items()}
        own = train(sim, many, lambda: Bodies(*(a[:, None] for a in batch(few))), given.updates, own=True)
        walks, best = measured(sims, shared, unseen, given.seed), measured(sims, own, few, given.seed)[0]
        far, error, kept = walks[0].mean(), walks[0].std() / len(unseen) ** 0.5, walks[0][: given.own]
        shares = " | ".join(f"{walk.mean() / far:.2f}" for walk in walks[1:])
        print(f"| {name} | {seconds:.0f} | {far:.3f} ± {error:.3f} | {kept.mean() / best.mean():.2f} | {shares} |", flush=True)
        np.savez(given.out / f"{policy}.npz", **shared)
        np.savez(given.out / f"{policy}-walks.npz", z=few, own=best, shared=kept)


if __name__ == "__main__":
    main()
