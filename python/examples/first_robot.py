"""Designs a small robot and prints its materials and its walk."""

from __future__ import annotations

import cosmic
import numpy as np

SCENE: dict[str, object] = {
    "scene": "stability",
    "lattice": {"columns": 3, "rows": 3},
    "physics.steps": 256,
    "controller.omega": 14.0,
    "schedule": {"iterations": 40, "attraction_from": 13, "snap_at": 26, "horizon": [128, 256]},
    "loss.window": 64,
}


def main() -> None:
    run = cosmic.optimize(SCENE, seed=1)
    print(run)
    for number, material in enumerate(("void", "skeleton", "actuator")):
        print(f"{np.count_nonzero(run.design.materials == number)} edges of {material}")
    sim = run.simulator()
    payload = run.trajectory[:, sim.payload]
    print(f"the payload is at {payload[-1]} m after {run.times[-1]:.2f} s")

    # The same robot from another start: the simulator takes arrays and returns arrays.
    higher = run.inputs.replace(x0=run.inputs.x0 + [0.0, 0.05])
    seen = sim.rollout(higher)
    print(f"dropped from 5 cm it gets to {seen.x[-1, sim.payload]} m")


if __name__ == "__main__":
    main()
