"""Small scenes and robots for the tests."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import cosmic
import numpy as np

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
#: A scene with given goals, which change after 85 and 170 of 256 steps.
GOALS: dict[str, Any] = {
    **SHORT,
    "scene": "errand",
    "lattice.mirror": False,
    "lattice.payload": 0,
    "physics.dt": 0.001,
    "controller": {"hidden": 6, "clock": "fixed", "goal": [2.0, 0.1], "goal_scale": 3.0},
    "goals": {"along": [-1.5, 1.5], "apart": 0.75},
}
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
    first = sim.initial(seed)
    drawn = {name: 0.1 * random.normal(size=shape) for name, shape in sim.shapes.items()}
    return cosmic.Inputs(
        z=first.z + drawn["z"],
        w1=first.w1,
        b1=drawn["b1"],
        w2=first.w2,
        b2=drawn["b2"],
        x0=first.x0 + [0.0, height] + 0.03 * drawn["x0"],
        v0=drawn["v0"],
    )


def airborne(sim: cosmic.Simulator, seed: int = 0) -> cosmic.Inputs:
    """A robot so high that it never touches the ground, so its rollout has no kinks."""
    return robot(sim, seed, height=1.0)


def like(arrays: Any, seed: int) -> list[np.ndarray]:
    """Random numbers in the shapes of these arrays."""
    random = np.random.default_rng(seed)
    return [random.normal(size=np.shape(array)) for array in arrays]


def stacked(robots: list[cosmic.Inputs], shared: tuple[str, ...] = ()) -> cosmic.Inputs:
    """Makes one batch of robots. The arrays named in ``shared`` come from the first robot."""
    return cosmic.Inputs(
        *(
            arrays[0] if name in shared else np.stack(arrays)
            for name, arrays in zip(cosmic.Inputs._fields, zip(*robots))
        )
    )


def one_of(batch: cosmic.Inputs, k: int, shared: tuple[str, ...] = ()) -> cosmic.Inputs:
    """Robot ``k`` of a batch."""
    pairs = zip(cosmic.Inputs._fields, batch)
    return cosmic.Inputs(*(array if name in shared else array[k] for name, array in pairs))


def same(a: Any, b: Any) -> bool:
    """True if the arrays are bit-identical, pair by pair."""
    pairs = list(zip(a, b, strict=True))
    return all(
        np.asarray(x).dtype == np.asarray(y).dtype and np.array_equal(x, y) for x, y in pairs
    )


def without_seconds(history: Path) -> list[dict[str, Any]]:
    """The lines of `history.jsonl` without the wall times."""
    rows = [json.loads(line) for line in history.read_text().splitlines()]
    return [{key: value for key, value in row.items() if key != "seconds"} for row in rows]


def is_same_run(a: Path, b: Path) -> bool:
    """True if the files of two runs are equal except for wall times."""
    exact = all((a / name).read_bytes() == (b / name).read_bytes() for name in EXACT)
    return exact and without_seconds(a / "history.jsonl") == without_seconds(b / "history.jsonl")


def program() -> Path | None:
    """The program `cosmic`, if it was built."""
    target = Path(__file__).resolve().parents[2] / "target"
    named = os.environ.get("COSMIC_PROGRAM")
    places = [Path(named)] if named else [target / "release/cosmic", target / "debug/cosmic"]
    return next((place for place in places if place.exists()), None)
