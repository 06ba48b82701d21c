"""Simulators on a GPU, against the processor. Without GPU support or without a GPU, the tests are skipped."""

from __future__ import annotations

import pickle
from collections.abc import Callable
from typing import Any

import cosmic
import numpy as np
import pytest
from common import GOALS, SHORT, SPACE, airborne, like, mapped, pairs, robot, same, stacked, why_no_gpu
from cosmic._simulator import leaves
from cosmic import _core


def pair(scene: Any) -> tuple[cosmic.Simulator, cosmic.Simulator]:
    """The simulators of a scene on the processor and on the GPU."""
    if why := why_no_gpu():
        pytest.skip(why)
    return cosmic.Simulator(scene), cosmic.Simulator(scene, device="gpu")


def close(a: Any, b: Any, tolerance: float) -> bool:
    """True if the arrays agree, pair by pair, relative to the largest number of each."""
    both = [(np.asarray(x), np.asarray(y)) for x, y in pairs(a, b)]
    return all(
        x.shape == y.shape and x.dtype == y.dtype and np.abs(x - y).max() <= tolerance * np.abs(y).max()
        for x, y in both
    )


#: Single precision rounds a coordinate of 1 m by 6e-8 m. A bar of 0.1 m then strains by 6e-7, and over 64 steps its
#: stiffness turns that into velocities of some 1e-5 m/s. Gradients differ by as much.
STATES, GRADIENTS = 1e-4, 1e-4


@pytest.mark.skipif(_core.GPU, reason="this package has GPU support")
def test_a_package_without_gpu_support_says_so() -> None:
    with pytest.raises(cosmic.InputError, match="cosmic-codesign-gpu, from the source by python/gpu-wheel.sh"):
        cosmic.Simulator(SHORT, device="gpu")


@pytest.mark.parametrize("shared", [(), ("z",), ("controller",), ("z", "controller")])
def test_robots_walk_as_on_the_processor(shared: tuple[str, ...]) -> None:
    here, there = pair(SHORT)
    batch = stacked([robot(here, seed, height=0.02) for seed in range(5)], shared)
    for inputs in [batch, mapped(np.float32, batch)]:
        assert close(there.rollout(inputs, 64), here.rollout(inputs, 64), STATES)


@pytest.mark.parametrize("shared", [(), ("z",), ("controller",), ("z", "controller")])
def test_gradients_agree_with_those_of_the_processor(shared: tuple[str, ...]) -> None:
    here, there = pair(SHORT)
    # Contacts would amplify the rounding.
    batch = stacked([airborne(here, seed) for seed in range(5)], shared)
    bars = cosmic.Trajectory(*like(here.rollout(batch, 64), 1))
    expected = here.vjp(batch, bars, 64)
    assert close(there.vjp(batch, bars, 64), expected, GRADIENTS)
    assert same(there.vjp(batch, bars, 64), there.vjp(batch, bars, 64))


def test_robots_in_space() -> None:
    here, there = pair(SPACE)
    walking = stacked([robot(here, seed, height=0.02) for seed in range(3)])
    assert close(there.rollout(walking, 64), here.rollout(walking, 64), STATES)
    batch = stacked([airborne(here, seed) for seed in range(3)])
    bars = cosmic.Trajectory(*like(here.rollout(batch, 64), 1))
    assert close(there.vjp(batch, bars, 64), here.vjp(batch, bars, 64), GRADIENTS)


def test_one_robot_has_no_axis_in_front() -> None:
    here, there = pair(SHORT)
    inputs = airborne(here)
    seen = here.rollout(inputs, 64)
    assert close(there.rollout(inputs, 64), seen, STATES)
    bars = cosmic.Trajectory(*like(seen, 1))
    assert close(there.vjp(inputs, bars, 64), here.vjp(inputs, bars, 64), GRADIENTS)


def test_finished_robots_of_several_layouts() -> None:
    here, there = pair(SHORT)
    random = np.random.default_rng(3)
    robots = [airborne(here, seed) for seed in range(4)]
    edges = len(here.edges)
    layouts = [np.eye(3)[random.integers(1, 3, edges) * random.integers(0, 2, edges)] for _ in robots]
    batch = stacked([of._replace(z=z) for of, z in zip(robots, layouts)])
    assert close(there.rollout(batch, 64), here.rollout(batch, 64), STATES)
    bars = cosmic.Trajectory(*like(here.rollout(batch, 64), 1))
    assert close(there.vjp(batch, bars, 64), here.vjp(batch, bars, 64), GRADIENTS)


def test_a_rollout_can_continue_another() -> None:
    here, there = pair(SHORT)
    batch = stacked([airborne(here, seed) for seed in range(3)])
    span = {"steps": 32, "observed": 8, "first": 100}
    assert close(there.rollout(batch, **span), here.rollout(batch, **span), STATES)
    only = {"observed": [0]}
    assert close(there.rollout(batch, **only), here.rollout(batch, **only), STATES)
    bars = cosmic.Trajectory(*like(here.rollout(batch, **only), 1))
    assert close(there.vjp(batch, bars, **only), here.vjp(batch, bars, **only), GRADIENTS)


@pytest.mark.parametrize("goal", [np.array([[0.5], [-1.0], [1.5]]), [(0, 1.2), (0.02, -1.0)]])
def test_goals_and_gradients_by_them(goal: Any) -> None:
    here, there = pair(GOALS)
    batch = stacked([airborne(here, seed) for seed in range(3)])
    seen = here.rollout(batch, 64, goal=goal)
    assert close(there.rollout(batch, 64, goal=goal), seen, STATES)
    bars = cosmic.Trajectory(*like(seen, 1))
    found, expected = (sim.vjp(batch, bars, 64, goal=goal) for sim in (there, here))
    assert close(found[0], expected[0], GRADIENTS) and close([found[1]], [expected[1]], GRADIENTS)


def test_bounded_cotangents() -> None:
    here, there = pair({**SHORT, "gradient.cotangent_bound": 1e-3})
    batch = stacked([airborne(here, seed) for seed in range(3)])
    # On a GPU, the cotangents of step 0 are added after the bound.
    span = {"observed": [16, 32, 64]}
    bars = cosmic.Trajectory(*like(here.rollout(batch, **span), 1))
    free, expected = (here.vjp(batch, bars, **span, bounded=bounded) for bounded in (False, True))
    assert not close(free, expected, 0.5)
    assert close(there.vjp(batch, bars, **span, bounded=True), expected, GRADIENTS)


def test_a_robot_that_diverges() -> None:
    here, there = pair(SHORT)
    batch = stacked([airborne(here, seed) for seed in range(3)])
    batch.v0[1] = 1e9
    with pytest.raises(cosmic.DivergedError, match="robot 1"):
        there.rollout(batch, 64)
    seen = there.rollout(batch, 64, check=False)
    assert np.isnan(seen.x[1]).any() and np.isfinite(seen.x[[0, 2]]).all()
    gradient = there.vjp(batch, cosmic.Trajectory(*like(seen, 1)), 64, check=False)
    assert all(np.isnan(g[1]).all() and np.isfinite(g[[0, 2]]).all() for g in leaves(gradient).values())


def test_a_loss_in_jax_over_many_robots() -> None:
    here, there = pair(SHORT)
    jax = pytest.importorskip("jax")
    import cosmic.jax as in_jax

    batch = stacked([airborne(here, seed) for seed in range(4)])

    def loss(sim: cosmic.Simulator) -> Callable[[Any], Any]:
        def of_one(inputs: Any) -> Any:
            return in_jax.rollout(sim, inputs, steps=64, observed=16).x[-1, :, 0].mean() ** 2

        return lambda inputs: jax.vmap(of_one)(inputs).sum()

    found, expected = (jax.grad(loss(sim))(batch) for sim in (there, here))
    assert close(found, expected, GRADIENTS)


def test_refusals_name_what_is_possible() -> None:
    here, there = pair(SHORT)
    inputs = airborne(here)
    with pytest.raises(cosmic.InputError, match="device=\"cpu\""):
        there.jvp(inputs, inputs)
    with pytest.raises(cosmic.Error, match="cannot simulate this: .*linear equations"):
        implicit = cosmic.Simulator({**SHORT, "physics.integrator": "implicit"}, device="gpu")
        implicit.rollout(inputs, 8)


def test_a_simulator_keeps_its_device() -> None:
    _, there = pair(SHORT)
    assert pickle.loads(pickle.dumps(there)).device == "gpu"
    assert 'device="gpu"' in repr(there).replace("'", '"')


def test_another_device_is_refused() -> None:
    with pytest.raises(cosmic.InputError, match="device: 'tpu': allowed: 'cpu', 'gpu'"):
        cosmic.Simulator(SHORT, device="tpu")


def test_other_physics_act_as_on_the_processor() -> None:
    here, there = pair({**SHORT, "physics.contact": "coulomb"})
    physics = {
        "physics.gravity": np.array([9.0, 5.0]),
        "physics.damping": np.array(10.0),
        "bars.stiffness": np.array([[1.1], [0.9]]),
        "bars.rest_length": np.linspace(0.98, 1.02, len(here.edges)),
        "nodes.mass": np.linspace(0.9, 1.1, 6),
    }
    inputs = airborne(here)._replace(physics=physics)
    seen = here.rollout(inputs, 64)
    assert close(there.rollout(inputs, 64), seen, STATES)
    bars = cosmic.Trajectory(*like(seen, 1))
    assert close(there.vjp(inputs, bars, 64), here.vjp(inputs, bars, 64), GRADIENTS)
    driven = inputs._replace(controller={"activations": np.zeros((64, len(here.edges)))})
    with pytest.raises(cosmic.InputError, match="activations: not on a GPU"):
        there.rollout(driven, 64)
