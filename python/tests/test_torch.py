"""Rollouts in torch: derivatives, batches and losses."""

from __future__ import annotations

import warnings

import cosmic
import numpy as np
import pytest
from common import SCENE, SEED, airborne, beginning, is_same_run, mapped, robot, same, stacked
from cosmic._simulator import leaves

torch = pytest.importorskip("torch")
import cosmic.torch  # noqa: E402

SPAN = (32, 16)


def test_states_and_gradients_equal_those_of_numpy(sim: cosmic.Simulator) -> None:
    plain = robot(sim, 0)
    inputs = cosmic.torch.inputs(plain, requires_grad=True)
    seen = cosmic.torch.rollout(sim, inputs, *SPAN)
    assert same([array.detach().numpy() for array in seen], sim.rollout(plain, *SPAN))
    bars = [0.5 * array.detach() for array in seen]
    torch.autograd.backward(list(seen), bars)
    expected = sim.vjp(plain, cosmic.Trajectory(*(bar.numpy() for bar in bars)), *SPAN)
    assert same(mapped(lambda array: array.grad.numpy(), inputs), expected)


def test_steps_before_the_start_count_and_bounds_hold(sim: cosmic.Simulator) -> None:
    plain = robot(sim, 0)
    inputs = cosmic.torch.inputs(plain, requires_grad=True)
    seen = cosmic.torch.rollout(sim, inputs, *SPAN, first=100, bounded=True)
    expected = sim.rollout(plain, *SPAN, first=100)
    assert same([array.detach().numpy() for array in seen], expected)
    torch.autograd.backward(list(seen), [array.detach() for array in seen])
    gradient = sim.vjp(plain, expected, *SPAN, first=100, bounded=True)
    assert same(mapped(lambda array: array.grad.numpy(), inputs), gradient)


def test_the_gradient_of_a_shared_array_is_the_sum_over_the_robots(sim: cosmic.Simulator) -> None:
    plain = stacked([robot(sim, seed) for seed in range(3)], ("controller",))
    inputs = cosmic.torch.inputs(plain, requires_grad=True)
    seen = cosmic.torch.rollout(sim, inputs, *SPAN)
    assert seen.x.shape == (3, 3, 6, 2)
    seen.x.sum().backward()
    bars = cosmic.Trajectory(np.ones(seen.x.shape), np.zeros(seen.v.shape))
    expected = sim.vjp(plain, bars, *SPAN)
    for name, array in leaves(inputs).items():
        own = leaves(expected)[name]
        own = own if name in ("z", "x0", "v0") else own.sum(0)
        # Three numbers may be summed in another order.
        np.testing.assert_allclose(array.grad.numpy(), own, rtol=1e-13, atol=1e-15)


def test_only_inputs_that_require_a_gradient_get_one(sim: cosmic.Simulator) -> None:
    inputs = cosmic.torch.inputs(robot(sim, 0))
    inputs.z.requires_grad_()
    cosmic.torch.rollout(sim, inputs, *SPAN).x.sum().backward()
    assert inputs.z.grad is not None and inputs.controller["w1"].grad is None


def test_single_precision_stays_single(sim: cosmic.Simulator) -> None:
    inputs = mapped(lambda array: array.float(), cosmic.torch.inputs(robot(sim, 0)))
    inputs.z.requires_grad_()
    seen = cosmic.torch.rollout(sim, inputs, *SPAN)
    assert seen.x.dtype == torch.float32
    seen.x.sum().backward()
    assert inputs.z.grad.dtype == torch.float32


def test_an_objective_in_torch() -> None:
    scene = {**SCENE, "loss.kind": "final"}

    @cosmic.torch.loss(is_far=True)
    def far(x, v):
        return -x[-1, 0, 0]

    own = cosmic.optimize(scene, SEED, loss=far, progress=False)
    # The same objective as the scene's: the same gradient, ones and zeros, and so the same bits.
    assert is_same_run(own.folder, cosmic.optimize(scene, SEED, progress=False).folder)


def test_a_policy_is_differentiated_through_steps(sim: cosmic.Simulator) -> None:
    start = cosmic.torch.inputs(airborne(sim))
    weights = torch.full((len(sim.edges), 12), 0.1, dtype=torch.float64, requires_grad=True)

    def walk(weights: torch.Tensor) -> torch.Tensor:
        own = {"policy": lambda x, v, time: torch.tanh(weights @ x.ravel() + time), "frame_skip": 4}
        x, v = cosmic.torch.rollout(sim, start, 12, 4, **own)
        return torch.sin(3.0 * x).sum() + torch.cos(v).sum()

    # torch takes differences with a step of 1e-6, as for the other inputs.
    assert torch.autograd.gradcheck(walk, (weights,), atol=1e-5, rtol=1e-4)


def test_an_objective_in_torch_sees_forces() -> None:
    arrays = {}

    @cosmic.torch.loss(observed=32)
    def tense(x, v, *, mass, tension, time):
        arrays.update(mass=mass, tension=tension, time=time)
        return (mass * x[-1, :, 0]).sum() + (tension**2).mean()

    def by_hand(x, v, *, mass, tension):
        x_bar = np.zeros_like(x)
        x_bar[-1, :, 0] = mass
        bars = {"mass": x[-1, :, 0], "tension": 2.0 * tension / tension.size}
        return (mass * x[-1, :, 0]).sum() + (tension**2).mean(), x_bar, np.zeros_like(v), bars

    own = cosmic.optimize(SCENE, SEED, loss=tense, iterations=20, progress=False)
    other = cosmic.optimize(SCENE, SEED, loss=cosmic.Loss(by_hand, 32), iterations=20, progress=False)
    assert np.allclose(beginning(own, 2), beginning(other, 2), rtol=1e-9, atol=0.0, equal_nan=True)
    states = len(arrays["time"])
    assert arrays["tension"].shape == (states, 20) and arrays["mass"].shape == (9,)


def test_activations_are_limited(sim: cosmic.Simulator) -> None:
    start = cosmic.torch.inputs(airborne(sim))

    def gradient(size: float) -> tuple[float, np.ndarray]:
        given = torch.full((1, len(sim.edges)), size, dtype=torch.float64, requires_grad=True)
        made = cosmic.torch.rollout(sim, start._replace(controller={"activations": given}), *SPAN).x.sum()
        made.backward()
        return float(made.detach()), given.grad.numpy()

    (at, within), (beyond, outside) = gradient(1.0), gradient(2.0)
    assert at == beyond and np.all(outside == 0.0) and np.any(within != 0.0)


def test_the_arrays_of_a_run_are_inputs(run: cosmic.Run) -> None:
    # torch warns about memory that is read-only.
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        seen = cosmic.torch.rollout(run.simulator(), run.inputs, observed=run.steps.tolist())
    assert np.array_equal(seen.x.numpy(), run.trajectory)
