"""Rollouts: shapes, types and batches. Every way to request a state gives the same bits."""

from __future__ import annotations

import copy
import pickle
from typing import Any

import cosmic
import numpy as np
import pytest
from common import NAMES, SCENE, SEED, SHORT, airborne, changed, mapped, one_of, robot, same, stacked
from cosmic._simulator import leaves


def test_a_simulator_has_the_sizes_of_its_scene(sim: cosmic.Simulator) -> None:
    edges = len(sim.edges)
    assert sim.shapes["z"] == (edges, 3)
    assert sim.shapes["w2"] == (edges, *sim.shapes["b1"])
    assert sim.shapes["x0"] == sim.shapes["v0"] == (6, 2)
    assert (sim.steps, sim.dt) == (256, 0.002)
    assert sim.along.tolist() == [1.0, 0.0]
    first = sim.initial(seed=3)
    assert {name: array.shape for name, array in leaves(first).items()} == sim.shapes
    assert tuple(sim.shapes) == NAMES
    # Rest lengths are the distances of the nodes at rest, up to the rounding of a square root.
    ends = first.x0[sim.edges]
    lengths = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    np.testing.assert_allclose(sim.rest_length, lengths, rtol=1e-14)


@pytest.mark.parametrize("name", cosmic.scenes())
def test_the_ground_and_the_first_column_are_at_zero(name: str) -> None:
    sim = cosmic.Simulator({"scene": name, "lattice.drop": 0.02}, "performance")
    x0, along = sim.initial().x0, sim.along
    up = np.zeros_like(along)
    up[0], up[-1] = -along[-1], along[0]
    # A rotation rounds coordinates below 2 m by some 1e-16.
    assert [(x0 @ along).min(), (x0 @ up).min()] == pytest.approx([0.0, 0.02], abs=1e-15)


def test_no_node_falls_below_zero(sim: cosmic.Simulator) -> None:
    seen = sim.rollout(sim.initial())
    # A node that lands is rounded once.
    assert seen.x[..., 1].min() == pytest.approx(0.0, abs=1e-15)


def test_the_payload_need_not_be_node_0() -> None:
    assert [cosmic.Simulator(name).payload for name in ("earth", "errand", "cube")] == [0, 3, 4]
    assert cosmic.Simulator({**SHORT, "lattice.payload": 5}).payload == 5


def test_a_rollout_may_be_shorter_than_the_horizon_of_an_optimisation() -> None:
    for scene in ("stability", "coulomb", "large", "workshop"):
        assert cosmic.Simulator({"scene": scene, "physics.steps": 1024}).steps == 1024


def test_seeds_differ_and_repeat(sim: cosmic.Simulator) -> None:
    assert same(sim.initial(1), sim.initial(1))
    assert not np.array_equal(sim.initial(1).controller["w1"], sim.initial(2).controller["w1"])


def pieces(edges: np.ndarray, layout: np.ndarray) -> set[int]:
    """The pieces that have a bar or the payload, named by their first nodes."""
    bars = edges[layout[:, 0] == 0.0]
    of = np.arange(edges.max() + 1)
    for _ in of:
        for i, j in bars:
            of[[i, j]] = of[[i, j]].min()
    return {int(of[node]) for node in (0, *bars.ravel())}


@pytest.mark.parametrize("changes", [{}, {"design": {"crossings": False, "feet": 2}}, {"volume.actuator": [0.3, 0.3]}])
def test_random_numbers_become_robots_in_one_piece(changes: dict[str, Any]) -> None:
    sim = cosmic.Simulator({**SHORT, "lattice.rows": 3, **changes})
    edges, random = len(sim.edges), np.random.default_rng(0)
    z = random.uniform(size=(50, edges, 3))
    made = sim.layout(z)
    assert made.shape == z.shape and np.array_equal(np.sort(made), np.tile([0.0, 0.0, 1.0], (50, edges, 1)))
    solid, actuator = 1.0 - made[:, :, 0].mean(1), made[:, :, 2].mean(1)
    # Bounds of the scene, 0.03 wider, as numbers of edges.
    for volume, key in ((solid, "volume.solid"), (actuator, "volume.actuator")):
        least, most = sim.scene[key]
        assert np.all(np.round(volume * edges) >= np.ceil((least - 0.03) * edges - 1e-9))
        assert np.all(np.round(volume * edges) <= np.floor((most + 0.03) * edges + 1e-9))
    assert all(pieces(sim.edges, layout) == {0} for layout in made)
    # The largest numbers alone are not: their volumes are 2/3 and 1/3.
    assert not any(np.array_equal(np.eye(3)[rows.argmax(1)], layout) for rows, layout in zip(z, made))
    assert len({layout.tobytes() for layout in made}) == 50
    # A robot of a batch is the robot alone, and robots that obey the rules stay as they are.
    assert np.array_equal(sim.layout(z[7]), made[7]) and np.array_equal(sim.layout(made), made)
    # Layouts decide nothing about the robots that the simulator takes.
    assert sim.projection == "auto"


def test_a_layout_is_the_robot_to_which_an_optimisation_snaps() -> None:
    # Without trials of other materials, the snap of an optimisation is the layout of its last design vectors.
    ends = {"schedule": {**SCENE["schedule"], "snap_trials": 0, "polish_trials": 0}}
    sim = cosmic.Simulator({**SCENE, **ends})
    begun = sim.initial(SEED).z
    at_once = {"iterations": 1, "attraction_from": 1, "snap_at": 1, "horizon_over": [0, 0]}
    scene = {**SCENE, "schedule": {**ends["schedule"], **at_once}, "binarisation.threshold_over": [0, 0]}
    snapped = cosmic.optimize(scene, SEED, progress=False)
    assert np.array_equal(snapped.design.z, sim.layout(begun))
    assert not np.array_equal(snapped.design.z, np.eye(3)[begun.argmax(1)])


def test_a_mirrored_robot_has_a_mirrored_layout() -> None:
    scene: dict[str, Any] = {**SHORT, "lattice": {"columns": 5, "rows": 3, "mirror": True, "payload": "auto"}}
    sim = cosmic.Simulator(scene)
    layout = sim.layout(np.random.default_rng(0).uniform(size=sim.shapes["z"]))
    places = sim.initial().x0
    ends = places[:, 0].min() + places[:, 0].max()
    turned = [np.abs(places - [ends - x, y]).sum(1).argmin() for x, y in places]
    materials = {frozenset(bar): row for bar, row in zip(sim.edges.tolist(), layout.argmax(1))}
    assert all(materials[frozenset(turned[node] for node in bar)] == own for bar, own in materials.items())


def test_a_network_does_not_see_nodes_without_a_bar() -> None:
    sim = cosmic.Simulator({**SHORT, "volume": {"solid": [0.3, 0.4], "actuator": [0.2, 0.3]}})
    layouts = sim.layout(np.random.default_rng(0).uniform(size=(8, *sim.shapes["z"])))
    absent = np.array([[~(layout[(sim.edges == node).any(1), 0] == 0.0).any() for node in range(6)] for layout in layouts])
    assert absent.any(1).sum() >= 4
    inputs = robot(sim, 0)._replace(z=layouts)
    # Absent nodes elsewhere, with velocities.
    moved = inputs._replace(x0=inputs.x0 + 0.1 * absent[..., None], v0=inputs.v0 + 0.3 * absent[..., None])
    one, other = sim.rollout(inputs), sim.rollout(moved)
    present = np.broadcast_to(~absent[:, None], one.x.shape[:3])
    assert np.array_equal(one.x[present], other.x[present])
    assert np.abs(one.x - other.x).max() > 0.09


def test_a_rollout_returns_the_requested_steps(sim: cosmic.Simulator) -> None:
    inputs = robot(sim, 0)
    assert sim.observed(40, 16) == [0, 16, 32, 40]
    whole = sim.rollout(inputs)
    assert whole.x.shape == whole.v.shape == (17, 6, 2)
    assert same(whole, sim.rollout(inputs, sim.steps, 16))
    some = sim.rollout(inputs, observed=[0, 16, 256])
    assert same(some, (whole.x[[0, 1, -1]], whole.v[[0, 1, -1]]))
    assert np.array_equal(whole.x[0], inputs.x0)
    assert np.ptp(whole.x[:, 0, 0]) > 0.0


@pytest.mark.parametrize("shared", [(), ("controller",), ("z", "controller")])
@pytest.mark.parametrize("robots", [1, 70])
def test_a_robot_in_a_batch_equals_the_robot_alone(
    sim: cosmic.Simulator, shared: tuple[str, ...], robots: int
) -> None:
    batch = stacked([robot(sim, seed) for seed in range(robots)], shared)
    seen = sim.rollout(batch, observed=64)
    assert seen.x.shape == (robots, 5, 6, 2)
    for k in range(robots):
        alone = sim.rollout(one_of(batch, k, shared), observed=64)
        assert same(alone, (seen.x[k], seen.v[k])), k


def test_one_batched_array_is_enough(sim: cosmic.Simulator) -> None:
    first = robot(sim, 0)
    for name, array in leaves(first).items():
        other = leaves(robot(sim, 1))[name]
        both = changed(first, **{name: np.stack([array, other])})
        seen = sim.rollout(both, 64, 32)
        assert same(sim.rollout(first, 64, 32), (seen.x[0], seen.v[0])), name
        alone = sim.rollout(changed(first, **{name: other}), 64, 32)
        assert same(alone, (seen.x[1], seen.v[1])), name


def test_a_rollout_can_continue_another(sim: cosmic.Simulator) -> None:
    inputs = robot(sim, 0)
    whole = sim.rollout(inputs, observed=[100, 180, 256])
    begun = sim.rollout(inputs, observed=[100])
    middle = inputs._replace(x0=begun.x[-1], v0=begun.v[-1])
    rest = sim.rollout(middle, observed=[80, 156], first=100)
    # A rollout uses its own coordinates, so passing a state on rounds it by 1e-16 of some tenths of a
    # metre. This error grows over 156 steps on the ground.
    np.testing.assert_allclose(rest.x, whole.x[1:], atol=1e-12)
    np.testing.assert_allclose(rest.v, whole.v[1:], atol=1e-9)
    # From step 0 the clock of the controller has another phase, so the rollout differs.
    anew = sim.rollout(middle, observed=[80, 156])
    assert np.abs(anew.x - rest.x).max() > 1e-3


def test_checking_changes_no_number(sim: cosmic.Simulator) -> None:
    batch = stacked([robot(sim, seed) for seed in range(3)])
    assert same(sim.rollout(batch), sim.rollout(batch, check=False))


def test_single_precision_stays_single(sim: cosmic.Simulator) -> None:
    inputs = airborne(sim)
    narrow = mapped(np.float32, inputs)
    double, single = sim.rollout(inputs, 64), sim.rollout(narrow, 64)
    assert single.x.dtype == single.v.dtype == np.float32
    # A step rounds positions of about 1 m by 6e-8 m; 64 steps add up to 4e-6 m.
    np.testing.assert_allclose(single.x, double.x, atol=1e-5)
    assert not np.array_equal(single.x, double.x)
    gradient = sim.vjp(narrow, cosmic.Trajectory(*single), 64)
    assert all(array.dtype == np.float32 for array in leaves(gradient).values())
    # One array in double precision is enough to compute everything in double precision.
    assert sim.rollout(narrow._replace(z=inputs.z), 64).x.dtype == np.float64


def test_arrays_may_have_any_memory_layout(sim: cosmic.Simulator) -> None:
    inputs = robot(sim, 0)
    expected = sim.rollout(inputs, 64)
    columns = mapped(np.asfortranarray, inputs)
    assert not columns.z.flags.c_contiguous
    assert same(sim.rollout(columns, 64), expected)
    sparse = mapped(lambda array: np.repeat(array, 2, axis=0)[::2], inputs)
    assert same(sim.rollout(sparse, 64), expected)
    for array in leaves(inputs).values():
        array.setflags(write=False)
    assert same(sim.rollout(inputs, 64), expected)
    lists = mapped(lambda array: array.tolist(), inputs)
    # Fields of a structured array: contiguous, but not aligned.
    def packed(array: np.ndarray) -> np.ndarray:
        made = np.zeros(1, [("one", "u1"), ("numbers", "f8", array.shape)])
        made["numbers"][0] = array
        return made["numbers"][0]

    odd = mapped(packed, inputs)
    assert not odd.z.flags.aligned and odd.z.flags.c_contiguous
    assert same(sim.rollout(odd, 64), expected)
    bars = cosmic.Trajectory(*expected)
    assert same(sim.vjp(odd, bars, 64), sim.vjp(inputs, bars, 64))
    swapped = mapped(lambda array: array.astype(">f8"), inputs)
    assert same(sim.rollout(swapped, 64), expected)
    assert same(sim.rollout(lists, 64), expected)


@pytest.mark.parametrize("dtype", [np.float16, np.int32, np.uint8, np.longdouble])
def test_other_numbers_are_simulated_in_double_precision(
    sim: cosmic.Simulator, dtype: type
) -> None:
    inputs = robot(sim, 0)
    numbers = np.arange(*sim.shapes["b1"])
    other = changed(inputs, b1=numbers.astype(dtype))
    wide = changed(inputs, b1=numbers.astype(np.float64))
    assert same(sim.rollout(other, 64), sim.rollout(wide, 64))


def test_projections(sim: cosmic.Simulator) -> None:
    def last(projection: str, inputs: cosmic.Inputs) -> np.ndarray:
        return cosmic.Simulator(sim.scene, projection).rollout(inputs, 64).x[-1]

    soft = robot(sim, 0)
    hard = soft._replace(z=np.eye(3)[soft.z.argmax(axis=1)])
    assert np.array_equal(last("auto", soft), last("performance", soft))
    assert np.array_equal(last("auto", hard), last("layout", hard))
    assert not np.array_equal(last("auto", soft), last("stability", soft))
    assert not np.array_equal(last("performance", hard), last("layout", hard))


def test_the_first_robot_decides_the_projection(sim: cosmic.Simulator) -> None:
    soft = robot(sim, 0)
    hard = soft._replace(z=np.eye(3)[soft.z.argmax(axis=1)])
    both = soft._replace(z=np.stack([soft.z, hard.z]))
    with pytest.raises(cosmic.InputError, match="two simulators"):
        cosmic.Simulator(sim.scene).rollout(both, 64)
    # A robot that is not finite decides nothing.
    lost = soft._replace(z=np.full_like(soft.z, np.nan))
    for first, other, kind in [(soft, hard, "performance"), (hard, soft, "layout")]:
        own = cosmic.Simulator(sim.scene)
        assert np.isnan(own.rollout(lost, 64, check=False).x).all()
        assert own.projection == "auto"
        expected = own.rollout(first, 64)
        assert own.projection == kind
        with pytest.raises(cosmic.InputError, match="another simulator|another Simulator"):
            own.rollout(other, 64)
        batch = first._replace(z=np.stack([first.z, lost.z]))
        seen = own.rollout(batch, 64, check=False)
        assert np.array_equal(seen.x[0], expected.x) and np.isnan(seen.x[1]).all()
        copied = pickle.loads(pickle.dumps(own))
        assert copied.projection == kind


def test_a_copy_has_the_decision_of_its_original(sim: cosmic.Simulator) -> None:
    first = cosmic.Simulator(SHORT)
    designed = robot(first, 0)
    finished = designed._replace(z=np.eye(3)[np.arange(len(first.edges)) % 3])
    # Before the first robots, a copy is free.
    pickle.loads(pickle.dumps(first)).rollout(finished, 1)
    first.rollout(designed, 1)
    for other in (first, copy.copy(first), pickle.loads(pickle.dumps(first))):
        with pytest.raises(cosmic.InputError, match="this is a finished robot"):
            other.rollout(finished, 1)
