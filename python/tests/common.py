"""Small scenes and robots for the tests."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cosmic
import numpy as np
from cosmic._simulator import leaves, tree

#: A robot of 9 nodes that begins to walk: an optimisation takes a fifth of a second.
SCENE: dict[str, Any] = {
    "scene": "stability",
    "lattice.columns": 3,
    "lattice.rows": 3,
    "physics.steps": 256,
    "schedule": {"iterations": 40, "attraction_from": 13, "snap_at": 26, "horizon": [128, 256]},
    "loss.window": 64,
}
#: A seed with which its robot walks far.
SEED = 1
#: The scene without its schedule, for rollouts.
SHORT: dict[str, Any] = {**SCENE, "lattice.rows": 2}
#: A scene with robots in space.
SPACE: dict[str, Any] = {**SCENE, "lattice": {"kind": "cubic", "columns": 3, "depth": 2, "rows": 2}}
del SPACE["lattice.columns"], SPACE["lattice.rows"]
#: A scene with given goals, which change after 85 and 170 of 256 steps.
GOALS: dict[str, Any] = {
    **SHORT,
    "scene": "errand",
    "lattice.mirror": False,
    "lattice.payload": 0,
    "physics.dt": 0.001,
    "controller": {"hidden": 6, "clock": "fixed", "goal": [2.0, 0.1], "goal_scale": 3.0},
    "goals": {"along": [-1.5, 1.5]},
}
#: The program `cosmic` of the package.
PROGRAM = [sys.executable, "-m", "cosmic"]
#: The names of the arrays of robots whose policy is the network `mlp`.
NAMES = ("z", "w1", "b1", "w2", "b2", "x0", "v0")
#: The files of a run that contain no wall time.
EXACT = ["design.json", "trajectory.json"]


def why_no_gpu() -> str | None:
    """Why there are no simulators on a GPU; None if there are."""
    try:
        cosmic.Simulator(SHORT, device="gpu")
    except cosmic.InputError as error:
        return str(error)
    return None


def robot(sim: cosmic.Simulator, seed: int, height: float = 0.0) -> cosmic.Inputs:
    """A robot that differs from all others in every number, lifted off the ground."""
    random = np.random.default_rng(seed)
    first = leaves(sim.initial(seed))
    drawn = {name: 0.1 * random.normal(size=shape) for name, shape in sim.shapes.items()}
    drawn["z"] += first["z"]
    lift = height * np.eye(sim.shapes["x0"][-1])[-1]
    drawn["x0"] = first["x0"] + lift + 0.03 * drawn["x0"]
    return tree({name: first[name] if name.startswith("w") else drawn[name] for name in first})


def airborne(sim: cosmic.Simulator, seed: int = 0) -> cosmic.Inputs:
    """A robot so high that it never touches the ground, so its rollout has no kinks."""
    return robot(sim, seed, height=1.0)


def mapped(of: Callable[[Any], Any], inputs: cosmic.Inputs) -> cosmic.Inputs:
    """Applies a function to every array of a robot."""
    return tree({name: of(array) for name, array in leaves(inputs).items()})


def changed(inputs: cosmic.Inputs, **arrays: Any) -> cosmic.Inputs:
    """A robot with other arrays of these names."""
    return tree({**leaves(inputs), **arrays})


def like(arrays: Any, seed: int) -> list[np.ndarray]:
    """Random numbers in the shapes of these arrays."""
    random = np.random.default_rng(seed)
    return [random.normal(size=np.shape(array)) for array in arrays]


def like_robot(inputs: cosmic.Inputs, seed: int) -> cosmic.Inputs:
    """Random numbers in the shapes of a robot's arrays."""
    named = leaves(inputs)
    return tree(dict(zip(named, like(named.values(), seed))))


def is_shared(name: str, shared: tuple[str, ...]) -> bool:
    """True if `shared` names this array, perhaps as a block of the controller."""
    return name in shared or "controller" in shared and name not in ("z", "x0", "v0")


def stacked(robots: list[cosmic.Inputs], shared: tuple[str, ...] = ()) -> cosmic.Inputs:
    """Makes one batch of robots. The arrays named in ``shared`` come from the first robot."""
    named = [leaves(robot) for robot in robots]
    return tree(
        {
            name: array if is_shared(name, shared) else np.stack([robot[name] for robot in named])
            for name, array in named[0].items()
        }
    )


def one_of(batch: cosmic.Inputs, k: int, shared: tuple[str, ...] = ()) -> cosmic.Inputs:
    """Robot ``k`` of a batch."""
    named = leaves(batch).items()
    return tree({name: array if is_shared(name, shared) else array[k] for name, array in named})


def pairs(a: Any, b: Any) -> list[tuple[Any, Any]]:
    """The arrays of two robots or of two lists, pair by pair."""
    if isinstance(a, cosmic.Inputs):
        first, second = leaves(a), leaves(b)
        assert first.keys() == second.keys()
        return [(array, second[name]) for name, array in first.items()]
    return list(zip(a, b, strict=True))


def same(a: Any, b: Any) -> bool:
    """True if the arrays are bit-identical, pair by pair."""
    return all(
        np.asarray(x).dtype == np.asarray(y).dtype and np.array_equal(x, y) for x, y in pairs(a, b)
    )


def without_seconds(history: Path) -> list[dict[str, Any]]:
    """The lines of `history.jsonl` without the wall times."""
    rows = [json.loads(line) for line in history.read_text().splitlines()]
    return [{key: value for key, value in row.items() if key != "seconds"} for row in rows]


def beginning(run: cosmic.Run, iterations: int = 4) -> np.ndarray:
    """For each of the first iterations of a run: the loss, and the norms of its gradients with respect to the controller
    and to the design with two projections. NaN if an iteration does not need a gradient. On the ground a rounding error
    can move a contact to another step, so runs that differ by rounding agree in the first iterations only."""
    rows = without_seconds(run.folder / "history.jsonl")[:iterations]
    keys = ("loss_horizon", "controller_gradient")
    made = np.array([[*(row[key] for key in keys), *row["design_gradient"]] for row in rows], np.float64)
    # Both gradients occur and are not zero.
    assert np.all(np.nanmax(np.abs(made[:, :3]), axis=0) > 0.0), made
    return made


def is_same_run(a: Path, b: Path) -> bool:
    """True if the files of two runs are equal except for wall times."""
    exact = all((a / name).read_bytes() == (b / name).read_bytes() for name in EXACT)
    return exact and without_seconds(a / "history.jsonl") == without_seconds(b / "history.jsonl")
