"""Lattices from arrays, with node numbers of the user."""

from __future__ import annotations

import json
import pickle
from pathlib import Path
from typing import Any

import cosmic
import numpy as np
import pytest
from common import SCENE, SEED, same

#: A ring of four nodes with two diagonals, whose payload is the last node. The library numbers its nodes in another order.
NODES = np.array([[0.2, 0.1], [0.1, 0.0], [0.2, 0.0], [0.1, 0.1]])
EDGES = np.array([[0, 1], [1, 2], [2, 3], [3, 0], [0, 2], [1, 3]])


def lattice(**options: Any) -> cosmic.Lattice:
    return cosmic.Lattice(NODES, EDGES, **{"payload": 3, **options})


def test_a_lattice_keeps_the_numbers_of_its_nodes() -> None:
    own = lattice()
    assert same((own.nodes, own.edges), (NODES, EDGES))
    assert own.node_of[3] == 0 and own.given_node[0] == 3
    assert np.array_equal(own.node_of[own.given_node], np.arange(4))
    assert not np.array_equal(own.node_of, np.arange(4))
    sim = cosmic.Simulator({**SCENE, "lattice": own})
    inputs = sim.initial()
    # Arrays of the library in the user's numbers, and the other way.
    ground = [0.0, inputs.x0[own.node_of[1]][1]]
    assert np.allclose(inputs.x0[own.node_of] - ground, NODES)
    assert np.allclose((NODES + ground)[own.given_node], inputs.x0)
    assert {frozenset(edge) for edge in own.given_node[sim.edges].tolist()} == {frozenset(edge) for edge in EDGES.tolist()}
    assert np.array_equal(np.sort(own.given_node[sim.edges], 1), np.sort(EDGES, 1))


def test_the_same_lattice_in_a_file_is_the_same_scene(tmp_path: Path) -> None:
    own = lattice(payload={3: 0.02, 1: 0.01}, keep=[0], actuator=[4], tie=[[1, 2]], stiffness=np.full(6, 300.0))
    file = {"nodes": NODES.tolist(), "edges": EDGES.tolist(), "keep": [0], "actuator": [4], "tie": [[1, 2]]}
    file |= {"payload": [{"node": 3, "mass": 0.02}, {"node": 1, "mass": 0.01}], "stiffness": [300.0] * 6}
    (tmp_path / "own.json").write_text(json.dumps({"format": "cosmic-truss", "version": 1, **file}))
    own.save(tmp_path / "saved.json")
    scenes = [cosmic.as_scene({**SCENE, "lattice": own})]
    for name in ("own.json", "saved.json"):
        scenes.append(cosmic.as_scene({**SCENE, "lattice.file": tmp_path / name}))
    assert scenes[0] == scenes[1] == scenes[2] and hash(scenes[0]) == hash(scenes[1])
    assert scenes[0] != cosmic.as_scene({**SCENE, "lattice": lattice()})
    sims = [cosmic.Simulator(scene) for scene in scenes]
    inputs = sims[0].initial()
    assert same(sims[0].rollout(inputs), sims[1].rollout(inputs))
    for scene in scenes:
        assert cosmic.Lattice.of(scene) == own and hash(cosmic.Lattice.of(scene)) == hash(own)
    assert cosmic.Lattice.of(pickle.loads(pickle.dumps(scenes[0]))) == own
    assert repr(scenes[0]) == "<Scene stability: 4 nodes, 6 edges, 256 steps>"


def test_a_robot_is_designed_on_a_lattice_from_arrays(tmp_path: Path) -> None:
    scene = {**SCENE, "lattice": lattice(), "lattice.mirror": False}
    run = cosmic.optimize(scene, SEED, out=tmp_path / "run", progress=False)
    again = cosmic.load(tmp_path / "run")
    own = cosmic.Lattice.of(again.scene)
    assert own == lattice() and again.scene == run.scene
    assert np.array_equal(np.sort(own.given_node[again.design.edges], 1), np.sort(EDGES, 1))
    # Later settings keep the lattice; another lattice replaces it.
    other = cosmic.as_scene({"scene": again.scene, "physics.steps": 64})
    assert cosmic.Lattice.of(other) == own and other["physics.steps"] == 64
    square = cosmic.Lattice(NODES, EDGES[:4])
    assert cosmic.Lattice.of(cosmic.as_scene({"scene": other, "lattice": square})) == square


@pytest.mark.parametrize(
    ("call", "says"),
    [
        (lambda: cosmic.Lattice(NODES[:, :1], EDGES), r"Lattice: `nodes\[0\]`: expected two coordinates, .* found \[0.2\]"),
        (lambda: cosmic.Lattice(np.zeros((4, 3)), EDGES), r"Lattice: `edges\[0\]`: expected nodes at least"),
        (lambda: cosmic.Lattice(NODES[0], EDGES), r"nodes: expected the shape \(nodes, 2\), found \[2\]"),
        (lambda: cosmic.Lattice([["a", 1]], EDGES), "nodes: expected an array of numbers"),
        (lambda: cosmic.Lattice([[0, 1], [1]], EDGES), "nodes: expected an array of numbers"),
        (lambda: cosmic.Lattice(NODES * [1, np.nan], EDGES), r"nodes\[0, 1\] is nan: expected finite"),
        (lambda: cosmic.Lattice(NODES * 1e5, EDGES), r"Lattice: `nodes\[0\]`: expected numbers from -1000"),
        (lambda: cosmic.Lattice(NODES, EDGES * 1.0), "edges: expected an array of whole numbers"),
        (lambda: cosmic.Lattice(NODES, EDGES[0]), r"edges: expected the shape \(edges, 2\), found \[2\]"),
        (lambda: cosmic.Lattice(NODES, EDGES - 1), r"edges\[0\] is \[-1, 0\]"),
        (lambda: cosmic.Lattice(NODES, [*EDGES, [0, 9]]), r"`edges\[6\]`: expected two different nodes below 4, found \[0, 9\]; nodes are counted from 0$"),
        (lambda: cosmic.Lattice(NODES, [*EDGES, [1, 0]]), r"`edges\[6\]`: \[1, 0\] is given twice"),
        (lambda: cosmic.Lattice(NODES, EDGES[:1]), r"`nodes\[2\]`: no edge has node 2"),
        (lambda: cosmic.Lattice(NODES, []), r"edges: expected the shape \(edges, 2\), found \[0\]"),
        (lambda: lattice(payload=4), "`payload`: expected a node below 4, found 4"),
        (lambda: lattice(payload=-1), "payload: expected a list of whole numbers, 0 or more"),
        (lambda: lattice(payload=[]), "`payload`: expected at least one node"),
        (lambda: lattice(payload="top"), "payload: expected an array of whole numbers, found"),
        (lambda: lattice(payload={1: -1.0}), r"`payload\[0\].mass`: expected a number from 0 to 1000, found -1"),
        (lambda: lattice(keep=[6]), r"`keep\[0\]`: expected an edge below 6, found 6"),
        (lambda: lattice(keep=[1], forbid=[1]), "edge 1 is also in"),
        (lambda: lattice(keep=[0.5]), "keep: expected an array of whole numbers"),
        (lambda: lattice(keep=3), "keep: expected a list of whole numbers"),
        (lambda: lattice(tie=[[1]]), r"`tie\[0\]`: expected two edges or more"),
        (lambda: lattice(rest=[0.1]), "`rest`: expected 6 numbers, one for every edge, found 1"),
        (lambda: lattice(rest=NODES), r"rest: expected the shape \(edges,\), found \[4, 2\]"),
        (lambda: lattice(stiffness=np.zeros(6)), r"`stiffness\[0\]`: expected a number above 0 N/m"),
        (lambda: cosmic.Lattice.of(cosmic.as_scene("stability")), "is generated from columns and rows"),
        (lambda: cosmic.as_scene({"physics.steps": lattice()}), 'a lattice has the key "lattice"'),
    ],
)
def test_a_wrong_lattice_is_named(call: Any, says: str) -> None:
    with pytest.raises(cosmic.InputError, match=says):
        call()


def test_a_scene_with_a_lattice_is_a_dictionary(tmp_path: Path) -> None:
    scene = cosmic.as_scene({**SCENE, "lattice": lattice(keep=[1])})
    assert scene["lattice.file"] == lattice(keep=[1])
    assert cosmic.as_scene(dict(scene)) == scene
    (tmp_path / "scene.toml").write_text(scene.to_toml())
    lattice(keep=[1]).save(tmp_path / "truss.json")
    assert cosmic.as_scene(dict(cosmic.as_scene(tmp_path / "scene.toml"))) == scene


def test_a_file_that_cannot_be_written_is_named(tmp_path: Path) -> None:
    with pytest.raises(cosmic.FileError, match="Lattice.save: cannot write .*missing.a.json: No such file"):
        lattice().save(tmp_path / "missing/a.json")
    with pytest.raises(cosmic.InputError, match="path: 3: expected a path"):
        lattice().save(3)  # type: ignore[arg-type]


def test_points_of_robots_in_space_have_three_coordinates() -> None:
    sim = cosmic.Simulator({"scene": "coulomb", "lattice": {"kind": "cubic", "columns": 3, "depth": 2, "rows": 2}})
    start = sim.initial(seed=1)
    assert start.x0.shape == start.v0.shape == (12, 3)
    start = start._replace(v0=np.tile([0.3, 0.2, -0.4], (12, 1)))
    seen = sim.rollout(start, steps=48)
    assert seen.x.shape == (4, 12, 3)
    assert np.abs(seen.x[-1, :, 1] - start.x0[:, 1]).min() > 1e-3
    bars = cosmic.Trajectory(np.ones_like(seen.x), np.zeros_like(seen.v))
    gradient = sim.vjp(start, bars, steps=48)
    still = {name: np.zeros_like(block) for name, block in start.controller.items()}
    along = np.random.default_rng(0).normal(size=(12, 3))
    tangents = cosmic.Inputs(np.zeros_like(start.z), still, np.zeros((12, 3)), along)
    _, moved = sim.jvp(start, tangents, steps=48)
    # Both modes differentiate the same steps.
    assert np.sum(gradient.v0 * along) == pytest.approx(moved.x.sum(), rel=1e-9)
