"""Prints what a step of a rollout with its gradient costs on one core: in this library, in taichi, and in MuJoCo's MJX.

    pip install ./python taichi==1.7.4 mujoco-mjx
    taskset -c 0 python studies/steps.py
    taskset -c 0 python studies/steps.py --space    # a robot in space beside a planar one; needs only the package cosmic

The robot has 5x5 nodes and 72 bars, all of them actuators with given activations. The gradient is that of its distance by
all activations. The taichi program is like DiffTaichi's mass_spring.py: one kernel for the forces and one for the motion
are launched in every step, in single precision. MJX computes in single precision too, with one iteration of the solver,
because its reverse mode needs a fixed number.

With --space, the world is that of codesign-mpt on flat ground, with cubes in space and with squares in the plane. The activations
are given too, and the gradient is that of the mean distance of all nodes by them. The measurements of both alternate, and each
number is the least of nine.
"""

import os
import sys
import time
from collections.abc import Callable
from functools import partial
from typing import Any

# One thread, also for batches. The library reads this when it starts.
os.environ["RAYON_NUM_THREADS"] = "1"

import cosmic
import numpy as np

STEPS, DT, STIFFNESS, MASS, STRAIN = 256, 0.002, 30.0, 0.005, 0.2
SIM = cosmic.Simulator({"scene": "stability", "lattice": {"columns": 5, "rows": 5}}, "layout")
NODES, EDGES, REST = SIM.initial().x0, SIM.edges, SIM.rest_length
N, E = len(NODES), len(EDGES)
ACTIVATIONS = np.random.default_rng(0).uniform(-1.0, 1.0, (STEPS, E)).astype(np.float32)


def microseconds(gradient: Callable[[], Any], repeats: int) -> float:
    """The processor time of a step with its gradient by the activations, after a call that compiles."""
    assert np.abs(gradient()).max() > 0.0
    begin = time.process_time()
    for _ in range(repeats):
        gradient()
    return 1e6 * (time.process_time() - begin) / repeats / STEPS


def of_cosmic(dtype: Any) -> float:
    z, bars = np.tile(np.array([0, 0, 1], dtype), (E, 1)), np.zeros((2, 1, N, 2), dtype)
    bars[0, :, :, 0] = 1.0 / N
    robot = cosmic.Inputs(z, {"activations": ACTIVATIONS.astype(dtype)}, NODES.astype(dtype), np.zeros((N, 2), dtype))

    of = partial(SIM.vjp, robot, cosmic.Trajectory(*bars), observed=[STEPS], by=["activations"])
    return microseconds(lambda: of().controller["activations"], 1000)


def of_taichi() -> float:
    import taichi as ti

    ti.init(arch=ti.cpu, cpu_max_num_threads=1, log_level=ti.ERROR)
    x, v, force = (ti.Vector.field(2, ti.f32, (STEPS + 1, N), needs_grad=True) for _ in range(3))
    activations, loss = ti.field(ti.f32, (STEPS, E), needs_grad=True), ti.field(ti.f32, (), needs_grad=True)
    ends, rest = ti.Vector.field(2, ti.i32, E), ti.field(ti.f32, E)

    @ti.kernel
    def pull(t: int):
        for e in range(E):
            i, j = ends[e][0], ends[e][1]
            d = x[t, j] - x[t, i]
            length = d.norm(1e-6)
            f = STIFFNESS * (length - rest[e] * (1.0 + STRAIN * activations[t, e])) / length * d
            force[t, i] += f
            force[t, j] -= f

    @ti.kernel
    def move(t: int):
        for i in range(N):
            after = ti.exp(-3.0 * DT) * v[t, i] + DT * (force[t, i] / MASS - ti.Vector([0.0, 9.81]))
            if x[t, i][1] + DT * after[1] < 0.0 and after[1] < 0.0:
                x[t + 1, i] = x[t, i] + ti.min(ti.max(-x[t, i][1] / after[1], 0.0), DT) * after
                v[t + 1, i] = ti.Vector([0.0, 0.0])
            else:
                x[t + 1, i] = x[t, i] + DT * after
                v[t + 1, i] = after

    @ti.kernel
    def end():
        for i in range(N):
            loss[None] += x[STEPS, i][0] / N

    def gradient() -> Any:
        force.fill(0.0)
        loss[None] = 0.0
        with ti.ad.Tape(loss):
            for t in range(STEPS):
                pull(t)
                move(t)
            end()
        return activations.grad.to_numpy()

    ends.from_numpy(EDGES.astype(np.int32)), rest.from_numpy(REST.astype(np.float32)), activations.from_numpy(ACTIVATIONS)
    for i, node in enumerate(NODES):
        x[0, i] = node
    return microseconds(gradient, 5)


def of_mjx() -> float:
    import jax
    import mujoco
    from mujoco import mjx

    slides = '<joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 0 1"/>'
    ball = f'<geom size="0.001" mass="{MASS}" contype="0" conaffinity="1"/>'
    bodies = (f'<body pos="{x} 0 {y + 0.001}">{slides}{ball}<site name="s{i}"/></body>' for i, (x, y) in enumerate(NODES))
    ends = (f'<site site="s{i}"/><site site="s{j}"/>' for i, j in EDGES)
    rest = f'stiffness="{STIFFNESS}" springlength'
    springs = (f'<spatial name="t{e}" {rest}="{REST[e]}">{own}</spatial>' for e, own in enumerate(ends))
    motors = (f'<motor tendon="t{e}" gear="{STIFFNESS * STRAIN * REST[e]}"/>' for e in range(E))
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><option timestep="{DT}" iterations="1" ls_iterations="4"/><worldbody>'
        f'<geom type="plane" size="9 9 1" contype="1" conaffinity="0"/>{"".join(bodies)}</worldbody>'
        f'<tendon>{"".join(springs)}</tendon><actuator>{"".join(motors)}</actuator></mujoco>'
    )
    own, start = mjx.put_model(model), mjx.make_data(model)

    def distance(activations: Any) -> Any:
        step = jax.checkpoint(lambda data, held: (mjx.step(own, data.replace(ctrl=held)), None))
        return jax.lax.scan(step, start, activations)[0].qpos[::2].mean()

    compiled = jax.jit(jax.grad(distance))
    return microseconds(lambda: np.asarray(compiled(ACTIVATIONS)), 3)


#: The world of codesign-mpt (arXiv 2502.10862), on flat ground and with Coulomb friction.
WORLD: dict[str, Any] = {
    "scene": "coulomb",
    "physics": {"dt": 0.004, "steps": STEPS, "gravity": 9.8, "damping": 15.0, "friction": 0.9, "node_mass": 1.0},
    "physics.payload_mass": 0.0,
    "materials": {"stiffness": [1e-3, 15e3, 15e3], "density": [1e-6, 1e-6, 1e-6], "max_strain": [0.0, 0.0, 0.2]},
}
LATTICES: dict[str, dict[str, Any]] = {
    "space": {"kind": "cubic", "columns": 7, "depth": 7, "rows": 5},
    "plane": {"columns": 21, "rows": 21},
}


def least(calls: dict[str, Callable[[], Any]]) -> dict[str, float]:
    """The least user seconds of each call in nine measurements. The calls take turns."""
    seconds = dict.fromkeys(calls, np.inf)
    for _ in range(9):
        for name, call in calls.items():
            begin, count = os.times().user, 0
            # The clock of user seconds has ticks of 10 ms.
            while count == 0 or os.times().user - begin < 0.5:
                call()
                count += 1
            seconds[name] = min(seconds[name], (os.times().user - begin) / count)
    return seconds


def waves(sim: cosmic.Simulator, robots: int, dtype: Any) -> Any:
    """Activations: one slow wave for each bar. Noise would shake the robot in space to pieces."""
    phases = np.random.default_rng(0).uniform(0.0, 2.0 * np.pi, (robots, 1, len(sim.edges)))
    return np.sin(10.0 * sim.dt * np.arange(STEPS)[:, None] + phases).astype(dtype)


def sweeps(sim: cosmic.Simulator, robots: int, dtype: Any) -> list[Callable[[], Any]]:
    """A rollout of so many robots, and a gradient with its rollout."""
    first, edges = sim.initial(), len(sim.edges)
    z = np.tile(np.array([0, 0, 1], dtype), (edges, 1))
    robot = cosmic.Inputs(z, {"activations": waves(sim, robots, dtype)}, first.x0.astype(dtype), first.v0.astype(dtype))
    bars = np.zeros((2, robots, 1, *first.x0.shape), dtype)
    bars[0, ..., 0] = 1.0 / len(first.x0)
    forward = partial(sim.rollout, robot, observed=[STEPS])
    assert np.isfinite(forward().x).all()
    return [forward, partial(sim.vjp, robot, cosmic.Trajectory(*bars), observed=[STEPS], by=["activations"])]


def in_space() -> None:
    """Prints the cost of a step in space and in the plane, and the ratio of both for each bar."""
    sims = {name: cosmic.Simulator({**WORLD, "lattice": lattice}, "layout") for name, lattice in LATTICES.items()}
    bars = {name: len(sim.edges) for name, sim in sims.items()}
    for name, sim in sims.items():
        print(f"{name}: {sim.shapes['x0'][0]} nodes, {bars[name]} bars")
    print("| | space, us | plane, us | space, ns per bar | plane, ns per bar | ratio |")
    print("| --- | --: | --: | --: | --: | --: |")
    for robots, dtype in ((1, np.float64), (1, np.float32), (8, np.float32)):
        calls = {name: sweeps(sim, robots, dtype) for name, sim in sims.items()}
        for k, sweep in enumerate(("forward", "with the gradient")):
            seconds = least({name: calls[name][k] for name in sims})
            step = {name: 1e6 * seconds[name] / robots / STEPS for name in sims}
            each = {name: 1e3 * step[name] / bars[name] for name in sims}
            numbers = [step["space"], step["plane"], each["space"], each["plane"]]
            what = f"{sweep}, {robots} robot{'s' * (robots > 1)}, {'double' if dtype is np.float64 else 'single'} precision"
            cells = " | ".join(f"{number:.1f}" for number in numbers)
            print(f"| {what} | {cells} | {each['space'] / each['plane']:.2f} |", flush=True)


if __name__ == "__main__":
    if sys.argv[1:] == ["--space"]:
        in_space()
        sys.exit()
    costs = {"cosmic, single precision": of_cosmic(np.float32), "cosmic, double precision": of_cosmic(np.float64)}
    costs |= {"taichi, like DiffTaichi": of_taichi(), "MJX": of_mjx()}
    for name, cost in costs.items():
        print(f"| {name} | {cost:.1f} | {cost / min(costs.values()):.3g} |")
