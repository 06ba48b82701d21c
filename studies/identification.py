"""Identifies a robot whose real world is MuJoCo, and predicts its walk there.

    python studies/identification.py

It needs the package cosmic and the program `cosmic`, and the packages mujoco and numpy."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import cosmic
import mujoco
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "python" / "examples"))
from identify import EVERY, NOISE, SCENE, TRUE, identify, mistakes, physics, shaken


def main() -> None:
    with TemporaryDirectory() as folder:
        run = cosmic.optimize(SCENE, seed=2, out=Path(folder) / "run")
        subprocess.run(["cosmic", "export", run.folder, "--mujoco", "--quiet"], check=True)
        sys.path.insert(0, str(run.folder / "export"))
        import walk  # the player that `cosmic export` writes

        model, net = walk.load(run.folder / "export")
    # The real robot: TRUE in MuJoCo's own terms.
    model.geom_friction[:, 0] *= TRUE["physics.friction"]
    model.dof_damping *= TRUE["physics.damping"]
    for stiffness in (model.tendon_stiffness, model.actuator_gainprm, model.actuator_biasprm):
        stiffness *= TRUE["bars.stiffness"]
    random, rest, steps = np.random.default_rng(0), run.inputs.x0, int(net["steps"])
    activations = shaken(run.simulator(), random)

    def real(drive: object) -> np.ndarray:
        """The states of every fourth step, if `drive` does a step."""
        data, states = mujoco.MjData(model), []
        mujoco.mj_resetDataKeyframe(model, data, 0)
        begun = data.qpos.copy()
        for step in range(steps + 1):
            if step % EVERY == 0:
                # Nodes without a bar stay where they are.
                states.append(rest.copy())
                states[-1][net["nodes"]] += (data.qpos - begun).reshape(len(net["nodes"]), -1)
            drive(data, step)
        return np.array(states)

    def driven(data: mujoco.MjData, step: int) -> None:
        data.ctrl = net["strain"] * activations[min(step, steps - 1), net["actuators"]]
        mujoco.mj_step(model, data, int(net["substeps"]))

    walked, frames = real(lambda data, step: walk.step(model, [data], net, step)), real(driven)[:-1]
    frames += random.normal(scale=NOISE, size=frames.shape)
    print(f"a walk of {walked[-1, 0, 0] - walked[0, 0, 0]:.3f} m in MuJoCo")
    # MuJoCo takes four steps in each of ours.
    for substeps in (1, 4):
        sim = cosmic.Simulator({"scene": run.scene, "physics.substeps": substeps}, "layout")
        fit = identify(sim, run.design.z, frames, activations, list(TRUE))
        print(f"{substeps} substeps, noise {1e3 * fit.noise:.3f} mm")
        for (name, factor), margin in zip(fit.factors.items(), fit.margins):
            true, estimate, half = sim.physics[name] * np.array([TRUE[name], factor, margin])
            print(f"  {name}: true {true:.3f}, estimate {estimate:.3f} ± {half:.3f}")
        for name, factors in (("uncorrected", {}), ("true", TRUE), ("corrected", fit.factors)):
            seen = sim.rollout(run.inputs._replace(physics=physics(sim, factors)), observed=EVERY).x
            print(f"  {name}:", mistakes(walked, seen).round(1), "mm")


if __name__ == "__main__":
    main()
