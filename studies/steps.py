"""Prints what a step of a rollout with its gradient costs on one core: in this library, in taichi, and in MuJoCo's MJX.

    pip install ./python taichi==1.7.4 mujoco-mjx
    taskset -c 0 python studies/steps.py

The robot has 5x5 nodes and 72 bars, all of them actuators with given activations. The gradient is that of its distance by
all activations. The taichi program is like DiffTaichi's mass_spring.py: one kernel for the forces and one for the motion
are launched in every step, in single precision. MJX computes in single precision too, with one iteration of the solver,
because its reverse mode needs a fixed number.
"""

import time
from collections.abc import Callable
from functools import partial
from typing import Any

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


if __name__ == "__main__":
    costs = {"cosmic, single precision": of_cosmic(np.float32), "cosmic, double precision": of_cosmic(np.float64)}
    costs |= {"taichi, like DiffTaichi": of_taichi(), "MJX": of_mjx()}
    for name, cost in costs.items():
        print(f"| {name} | {cost:.1f} | {cost / min(costs.values()):.3g} |")
