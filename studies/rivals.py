"""Compares this library on one core with the programs that two papers have published: with DiffTaichi's robots A to D, and
with the world of codesign-mpt on flat ground.

    pip install ./python taichi==1.7.4 pyyaml matplotlib
    git clone https://github.com/taichi-dev/difftaichi && git clone https://github.com/lstrgar/codesign-mpt
    taskset -c 0 python studies/rivals.py difftaichi codesign-mpt

DiffTaichi's mass_spring.py trains the controller of a robot by 100 steps of length 0.2 against the gradient. This script
takes the weights with which that program begins, compares both gradients there, and trains the same robot in the same way.
The weights of the goal are 0 at first, because the two programs observe it in different ways. The simulator of codesign-mpt
runs as it is, but on the processor; activations are given, so that no network is measured on either side.
"""

import importlib.util
import json
import os
import subprocess
import sys
import tempfile
import types
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any
from unittest import mock

# One thread, also for batches. The library reads this when it starts.
os.environ["RAYON_NUM_THREADS"] = "1"

import cosmic
import numpy as np
import taichi as ti
import yaml
from steps import LATTICES, STEPS, WORLD, least, sweeps, waves

ITERATIONS, LENGTH, SHORT = 100, 0.2, 50
#: The world of DiffTaichi's mass_spring.py: its ground, and how much shorter its rest lengths are than its springs, m.
GROUND, SHORTER = 0.1, 1e-4
PHYSICS = {
    "dt": 0.004, "gravity": 4.8, "damping": 15.0, "contact": "infinite", "forces": [], "payload_mass": 0.0, "node_mass": 1.0,
}
CONTROLLER = {"omega": 10.0, "offset_scale": 0.05, "velocity_scale": 0.05, "goal_scale": 1.0}


def loaded(path: Path) -> types.ModuleType:
    """A program of others, which may import the files beside it."""
    sys.path.insert(0, str(path.parent))
    spec = importlib.util.spec_from_file_location(path.stem, path)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def on_one_core(start: Callable[..., Any]) -> Callable[..., Any]:
    """``ti.init`` for programs that ask for a GPU."""
    allowed = {"default_fp", "random_seed"}

    def init(**given: Any) -> Any:
        return start(
            arch=ti.cpu, cpu_max_num_threads=1, log_level=ti.ERROR, **{k: v for k, v in given.items() if k in allowed}
        )

    return init


def robot_of_difftaichi(folder: Path, robot: int) -> list[str]:
    """One row: nodes, springs, distances, cosine, costs."""
    given = ["mass_spring.py", str(robot), "train", "--iters", "0"]
    with mock.patch("sys.argv", given), mock.patch.object(ti, "init", on_one_core(ti.init)), mock.patch.object(ti, "GUI"):
        theirs = loaded(folder / "examples" / "mass_spring.py")
    nodes, springs = theirs.robots[robot]()
    nodes = [tuple(node) for node in nodes]
    theirs.setup_robot(nodes, springs)
    theirs.optimize(toi=True, visualize=False)
    clocks, last = theirs.n_sin_waves, theirs.steps - 1
    fields = (theirs.weights1, theirs.bias1, theirs.weights2, theirs.bias2)
    begin = [field.to_numpy() for field in fields]
    begin[0][:, -2:] = 0.0

    def put(weights: list[Any]) -> None:
        for field, numbers in zip(fields, weights):
            field.from_numpy(numbers)

    def of_theirs() -> list[Any]:
        theirs.clear()
        with ti.ad.Tape(theirs.loss):
            theirs.forward(visualize=False)
        return [field.grad.to_numpy() for field in fields]

    # The same robot here. Springs with ends in descending order are the same springs.
    edges = [tuple(sorted(spring[:2])) for spring in springs]
    with tempfile.TemporaryDirectory() as place:
        truss = Path(place, "truss.json")
        text = {"format": "cosmic-truss", "version": 1, "nodes": [[x, y - GROUND] for x, y in nodes], "edges": edges}
        truss.write_text(json.dumps(text))
        strain, stiffness = max(spring[4] for spring in springs), springs[0][3]
        scene = {
            "scene": "stability",
            "lattice": {"file": str(truss), "drop": 0.0, "payload": 0},
            "physics": {**PHYSICS, "steps": last},
            "controller": CONTROLLER,
            "materials": {"stiffness": [1e-3, stiffness, stiffness], "density": [1e-6] * 3, "max_strain": [0.0, 0.0, strain]},
        }
        ours = cosmic.Simulator(scene, "layout")
    # The library numbers nodes and edges in its own order: for each of its nodes and edges, the one there.
    x0 = ours.initial().x0
    nodes_there = np.array([int(np.argmin(np.linalg.norm(np.array(nodes) - [0.0, GROUND] - x, axis=1))) for x in x0])
    order = [edges.index(tuple(sorted(nodes_there[edge].tolist()))) for edge in ours.edges]
    single, count = np.float32, len(nodes)
    z = np.array([[0, springs[e][4] == 0.0, springs[e][4] != 0.0] for e in order], single)
    rest = np.array([1.0 - SHORTER / springs[e][2] for e in order], single)
    x0, bars, head = x0.astype(single), np.zeros((2, 1, count, 2), single), int(np.argwhere(nodes_there == theirs.head_id)[0, 0])
    bars[0, 0, head, 0] = -1.0
    # There: clocks, then for each node offset and velocity, then the goal. Here: clocks, goal, offsets, velocities.
    of_node, goal = clocks + 4 * nodes_there[:, None], clocks + 4 * count
    columns = np.r_[np.arange(clocks), goal, goal + 1, (of_node + [0, 1]).ravel(), (of_node + [2, 3]).ravel()]

    def inputs(weights: list[Any]) -> Any:
        w1, b1, w2, b2 = weights
        controller = {"w1": w1[:, columns], "b1": b1, "w2": w2[order], "b2": b2[order]}
        return cosmic.Inputs(z, controller, x0, np.zeros_like(x0), {"bars.rest_length": rest})

    def of_ours(weights: list[Any], steps: int = last, bounded: bool = False) -> list[Any]:
        all_of = ["w1", "b1", "w2", "b2"]
        found = ours.vjp(inputs(weights), cosmic.Trajectory(*bars), observed=[steps], by=all_of, bounded=bounded).controller
        gradient = [np.zeros_like(numbers) for numbers in weights]
        gradient[0][:, columns], gradient[1] = found["w1"], found["b1"]
        gradient[2][order], gradient[3][order] = found["w2"], found["b2"]
        return gradient

    def of_theirs_at(weights: list[Any]) -> list[Any]:
        put(weights)
        return of_theirs()

    def distance_there(weights: list[Any]) -> float:
        put(weights)
        theirs.clear()
        theirs.forward(visualize=False)
        return float(theirs.x[last, theirs.head_id][0] - nodes[theirs.head_id][0])

    def distance(weights: list[Any]) -> float:
        return float(ours.rollout(inputs(weights), observed=[last]).x[0][head, 0] - x0[head, 0])

    def trained(gradient: Callable[[list[Any]], list[Any]], distance: Callable[[list[Any]], float]) -> float:
        """The longest distance during the training, m."""
        weights, longest = begin, 0.0
        for _ in range(ITERATIONS):
            slope = gradient(weights)
            scale = LENGTH / (np.sqrt(sum((part**2).sum() for part in slope)) + 1e-6)
            weights = [(numbers - scale * part).astype(single) for numbers, part in zip(weights, slope)]
            longest = max(longest, distance(weights))
        return longest

    def cosine(steps: int) -> str:
        """The cosine between both gradients of the position after so many steps; "–" while they are 0."""
        theirs.steps = steps + 1
        pair = of_theirs_at(begin), of_ours(begin, steps)
        theirs.steps = last + 1
        for slope in pair:
            # The weights of the goal, which the programs observe in different ways.
            slope[0][:, -2:] = 0.0
        there, here = (np.concatenate([part.ravel() for part in slope]) for slope in pair)
        lengths = np.linalg.norm(there) * np.linalg.norm(here)
        return f"{there @ here / lengths:.4f}" if lengths > 0.0 else "–"

    cosines = [cosine(SHORT), cosine(last)]
    put(begin)
    costs = least({"theirs": of_theirs, "ours": lambda: of_ours(begin)})
    each = [1e6 * costs[name] / last for name in ("theirs", "ours")]
    lengths = [
        trained(of_theirs_at, distance_there), trained(of_ours, distance),
        trained(partial(of_ours, bounded=True), distance),
    ]
    return [
        "ABCD"[robot], str(count), str(len(springs)), *cosines,
        *(f"{length:.2f}" for length in lengths), *(f"{microseconds:.1f}" for microseconds in each), f"{each[0] / each[1]:.0f}",
    ]


def of_difftaichi(folder: Path) -> None:
    print(f"| robot | nodes | springs | cosine, {SHORT} steps | cosine, all steps | trained there, m | trained here, m "
          "| trained here, bounded, m | there, us | here, us | ratio |")
    print("| --- |" + " --: |" * 10)
    for robot in range(4):
        # That program has global variables, so each robot has a process of its own.
        one = [sys.executable, __file__, str(folder), str(robot)]
        print(subprocess.run(one, check=True, stdout=subprocess.PIPE, text=True).stdout.splitlines()[-1], flush=True)


def of_codesign_mpt(folder: Path) -> None:
    config = yaml.safe_load((folder / "config.yml").read_text()) | {"steps": STEPS}
    torch = types.ModuleType("torch")
    torch.random = types.SimpleNamespace(manual_seed=lambda _: None)  # type: ignore[attr-defined]
    with mock.patch.dict(sys.modules, {"torch": torch}):
        simulator = loaded(folder / "simulator.py")
    ours = cosmic.Simulator({**WORLD, "lattice": LATTICES["space"]}, "layout")
    x0, edges = ours.initial().x0, ours.edges
    masses = x0 - x0.min(0)
    workspace = {"masses": masses, "springs": edges, "spring_lengths": ours.rest_length.astype(np.float32)}
    print("| | there, us | here, us | ratio |")
    print("| --- | --: | --: | --: |")
    for robots in (1, 8):
        drawn = waves(ours, robots, np.float32)

        class Given(simulator.Simulator):  # type: ignore[misc, name-defined]
            """The simulator with given activations in place of a network."""

            def nn_forward(self, t: int) -> tuple[None, None]:
                self.torch_act_2_taichi(t, np.ascontiguousarray(drawn[:, t]))
                return None, None

            def nn_backward(self, t: int, *_: Any) -> None:
                slopes = np.zeros((robots, len(edges)), np.float32)
                self.act_grad_2_torch(t, slopes)
                gradient[:, t] = slopes

        gradient = np.zeros((robots, STEPS, len(edges)), np.float32)
        nodes = np.array([(robot, node) for robot in range(robots) for node in range(len(masses))], np.int32)
        springs = np.array([(robot, edge) for robot in range(robots) for edge in range(len(edges))], np.int32)
        batch = {
            "targets": np.full((robots, 2), 4.0, np.float32),
            "terrain": np.zeros((robots, config["grid_dim"], config["grid_dim"]), np.float32),
            "n_masses": np.full(robots, len(masses), np.int32),
            "masses": nodes, "springs": springs,
        }
        with mock.patch.object(ti, "init", on_one_core(ti.init)):
            theirs = Given(config | {"batch_size": robots}, workspace, None, 0)

        def forward() -> None:
            theirs.prep_sim(batch)
            theirs.forward()
            assert np.isfinite(theirs.center.to_numpy()).all()
            theirs.reset_sim()

        def with_gradient() -> None:
            theirs.prep_sim(batch)
            states = theirs.forward()
            theirs.compute_losses(), theirs.average_losses()
            theirs.initialize_loss_grad(), theirs.average_losses.grad(), theirs.compute_losses.grad()
            theirs.backward(*states)
            assert np.abs(gradient).max() > 0.0
            theirs.reset_sim()

        own = sweeps(ours, robots, np.float32)
        for what, there, here in zip(("forward", "with the gradient"), (forward, with_gradient), own):
            costs = least({"there": there, "here": here})
            each = [1e6 * seconds / robots / STEPS for seconds in costs.values()]
            name = f"{what}, {robots} robot{'s' * (robots > 1)}"
            print(f"| {name} | {each[0]:.0f} | {each[1]:.1f} | {each[0] / each[1]:.1f} |", flush=True)


if __name__ == "__main__":
    if sys.argv[2:] in (["0"], ["1"], ["2"], ["3"]):
        print("| " + " | ".join(robot_of_difftaichi(Path(sys.argv[1]), int(sys.argv[2]))) + " |")
        sys.exit()
    of_difftaichi(Path(sys.argv[1]))
    of_codesign_mpt(Path(sys.argv[2]))
