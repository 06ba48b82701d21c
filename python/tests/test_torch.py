"""Rollouts in torch: derivatives, batches and losses."""

from __future__ import annotations

import cosmic
import numpy as np
import pytest
from common import SCENE, SEED, airborne, is_same_run, robot, same, stacked

torch = pytest.importorskip("torch")
import cosmic.torch  # noqa: E402

SPAN = (32, 16)
NAMES = cosmic.Inputs._fields


@pytest.mark.parametrize("name", NAMES)
def test_gradients_agree_with_differences(sim: cosmic.Simulator, name: str) -> None:
    inputs = cosmic.torch.inputs(airborne(sim))
    array = getattr(inputs, name).requires_grad_()
    if name in ("w1", "w2"):
        # Only a tenth of the many weights is checked.
        kept = array.detach().reshape(-1)
        array = kept[::10].clone().requires_grad_()

    def of(moved):
        if name in ("w1", "w2"):
            whole = kept.clone()
            whole[::10] = moved
            moved = whole.reshape(getattr(inputs, name).shape)
        return tuple(cosmic.torch.rollout(sim, inputs._replace(**{name: moved}), *SPAN))

    # As in the other tests with a step of 1e-6: differences err by 1e-8, and rounding adds 1e-9.
    assert torch.autograd.gradcheck(of, (array,), eps=1e-6, atol=1e-6, rtol=1e-5)


def test_states_and_gradients_equal_those_of_numpy(sim: cosmic.Simulator) -> None:
    plain = robot(sim, 0)
    inputs = cosmic.torch.inputs(plain, requires_grad=True)
    seen = cosmic.torch.rollout(sim, inputs, *SPAN)
    assert same([array.detach().numpy() for array in seen], sim.rollout(plain, *SPAN))
    bars = [0.5 * array.detach() for array in seen]
    torch.autograd.backward(list(seen), bars)
    expected = sim.vjp(plain, cosmic.Trajectory(*(bar.numpy() for bar in bars)), *SPAN)
    assert same([array.grad.numpy() for array in inputs], expected)


def test_steps_before_the_start_count_and_bounds_hold(sim: cosmic.Simulator) -> None:
    plain = robot(sim, 0)
    inputs = cosmic.torch.inputs(plain, requires_grad=True)
    seen = cosmic.torch.rollout(sim, inputs, *SPAN, first=100, bounded=True)
    expected = sim.rollout(plain, *SPAN, first=100)
    assert same([array.detach().numpy() for array in seen], expected)
    torch.autograd.backward(list(seen), [array.detach() for array in seen])
    gradient = sim.vjp(plain, expected, *SPAN, first=100, bounded=True)
    assert same([array.grad.numpy() for array in inputs], gradient)


def test_the_gradient_of_a_shared_array_is_the_sum_over_the_robots(sim: cosmic.Simulator) -> None:
    shared = NAMES[1:5]
    plain = stacked([robot(sim, seed) for seed in range(3)], shared)
    inputs = cosmic.torch.inputs(plain, requires_grad=True)
    seen = cosmic.torch.rollout(sim, inputs, *SPAN)
    assert seen.x.shape == (3, 3, 6, 2)
    seen.x.sum().backward()
    bars = cosmic.Trajectory(np.ones(seen.x.shape), np.zeros(seen.v.shape))
    expected = sim.vjp(plain, bars, *SPAN)
    for name, array, own in zip(NAMES, inputs, expected):
        own = own.sum(0) if name in shared else own
        # Three numbers may be summed in another order.
        np.testing.assert_allclose(array.grad.numpy(), own, rtol=1e-13, atol=1e-15)


def test_only_inputs_that_require_a_gradient_get_one(sim: cosmic.Simulator) -> None:
    inputs = cosmic.torch.inputs(robot(sim, 0))
    inputs.z.requires_grad_()
    cosmic.torch.rollout(sim, inputs, *SPAN).x.sum().backward()
    assert inputs.z.grad is not None and inputs.w1.grad is None


def test_single_precision_stays_single(sim: cosmic.Simulator) -> None:
    inputs = cosmic.Inputs(*(array.float() for array in cosmic.torch.inputs(robot(sim, 0))))
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
