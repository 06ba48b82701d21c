"""`vjp` and `jvp`, compared with finite differences and with each other."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import cosmic
import numpy as np
import pytest
from common import NAMES, airborne, changed, like, like_robot, mapped, one_of, pairs, robot, same, stacked
from cosmic._simulator import leaves

SPAN = (48, 16)


def pairing(a: cosmic.Inputs | cosmic.Trajectory, b: cosmic.Inputs | cosmic.Trajectory) -> float:
    """The inner product of two trees of arrays."""
    return float(sum(np.sum(x * y) for x, y in pairs(a, b)))


@pytest.mark.parametrize("name", NAMES)
def test_the_gradient_agrees_with_differences(sim: cosmic.Simulator, name: str) -> None:
    inputs = airborne(sim)
    bars = cosmic.Trajectory(*like(sim.rollout(inputs, *SPAN), 1))
    gradient, array = leaves(sim.vjp(inputs, bars, *SPAN))[name], leaves(inputs)[name]
    (direction,) = like([array], 2)
    h = 1e-6

    def shifted(step: float) -> float:
        moved = changed(inputs, **{name: array + step * direction})
        return pairing(sim.rollout(moved, *SPAN), bars)

    difference = (shifted(h) - shifted(-h)) / (2.0 * h)
    slope = float(np.sum(gradient * direction))
    assert slope != 0.0
    # The projection has a sharpness of 20, so its third derivative is about 20**3 times the first. The
    # difference errs by (3 h)**2 20**3 / 6, which is 1e-8. Rounding adds 1e-15 / h, which is 1e-9.
    assert difference == pytest.approx(slope, rel=1e-6)


@pytest.mark.parametrize("height", [0.0, 1.0], ids=["on the ground", "above it"])
def test_vjp_and_jvp_agree(sim: cosmic.Simulator, height: float) -> None:
    inputs = robot(sim, 0, height)
    tangents = like_robot(inputs, 1)
    seen, along = sim.jvp(inputs, tangents, *SPAN)
    bars = cosmic.Trajectory(*like(seen, 2))
    gradient = sim.vjp(inputs, bars, *SPAN)
    # Both are exact up to rounding, which grows over the 48 steps.
    assert pairing(along, bars) == pytest.approx(pairing(gradient, tangents), rel=1e-10)
    # `jvp` sums in another order than `rollout`.
    np.testing.assert_allclose(seen.x, sim.rollout(inputs, *SPAN).x, atol=1e-12)


@pytest.mark.parametrize("shared", [(), ("controller", "x0", "v0"), ("z",)])
def test_products_of_a_batch_equal_those_of_its_robots(
    sim: cosmic.Simulator, shared: tuple[str, ...]
) -> None:
    batch = stacked([robot(sim, seed) for seed in range(5)], shared)
    bars = cosmic.Trajectory(*like(sim.rollout(batch, *SPAN), 1))
    gradient = sim.vjp(batch, bars, *SPAN)
    assert {name: array.shape[1:] for name, array in leaves(gradient).items()} == sim.shapes
    tangents = like_robot(batch, 2)
    _, along = sim.jvp(batch, tangents, *SPAN)
    for k in range(5):
        alone = one_of(batch, k, shared)
        bar = cosmic.Trajectory(bars.x[k], bars.v[k])
        assert same(sim.vjp(alone, bar, *SPAN), one_of(gradient, k))
        _, slope = sim.jvp(alone, one_of(tangents, k, shared), *SPAN)
        assert same(slope, (along.x[k], along.v[k]))


def test_tangents_may_be_shared(sim: cosmic.Simulator) -> None:
    robots = [robot(sim, seed) for seed in range(3)]
    tangents = like_robot(robots[0], 1)
    _, along = sim.jvp(stacked(robots), tangents, *SPAN)
    for k, alone in enumerate(robots):
        assert same(sim.jvp(alone, tangents, *SPAN)[1], (along.x[k], along.v[k]))


def test_derivatives_can_begin_at_a_later_step(sim: cosmic.Simulator) -> None:
    inputs = airborne(sim)
    tangents = like_robot(inputs, 1)
    _, along = sim.jvp(inputs, tangents, *SPAN, first=50)
    bars = cosmic.Trajectory(*like(along, 2))
    gradient = sim.vjp(inputs, bars, *SPAN, first=50)
    # As above.
    assert pairing(along, bars) == pytest.approx(pairing(gradient, tangents), rel=1e-10)
    assert not same(gradient, sim.vjp(inputs, bars, *SPAN))


def test_a_bound_limits_only_large_cotangents(sim: cosmic.Simulator) -> None:
    inputs = robot(sim, 0)
    bars = cosmic.Trajectory(*like(sim.rollout(inputs), 1))
    exact = sim.vjp(inputs, bars)
    assert not same(sim.vjp(inputs, bars, bounded=True), exact)
    small = cosmic.Trajectory(*(1e-9 * bar for bar in bars))
    assert same(sim.vjp(inputs, small, bounded=True), sim.vjp(inputs, small))


def finished(run: cosmic.Run) -> cosmic.Inputs:
    """The robot of a run, without its highest bars, in the air, with a speed of its own for every node."""
    inputs = run.inputs
    heights = inputs.x0[run.design.edges, 1].max(axis=1)
    z = np.where((heights > heights.max() - 1e-9)[:, np.newaxis], [1.0, 0.0, 0.0], inputs.z)
    (v0,) = like([inputs.v0], 3)
    return inputs._replace(z=z, x0=inputs.x0 + [0.0, 1.0], v0=0.1 * v0)


@pytest.mark.parametrize("integrator", ["symplectic_euler", "implicit"])
def test_nodes_without_a_bar_have_the_same_derivatives_in_every_mode(
    run: cosmic.Run, integrator: str
) -> None:
    sim = cosmic.Simulator({"scene": run.scene, "physics.integrator": integrator})
    inputs = finished(run)
    seen = sim.rollout(inputs, *SPAN)
    top = inputs.x0[:, 1] > inputs.x0[:, 1].max() - 1e-9
    assert np.array_equal(seen.x[-1][top], inputs.x0[top]) and not seen.v[-1][top].any()
    bars = cosmic.Trajectory(*like(seen, 1))
    gradient = sim.vjp(inputs, bars, *SPAN)
    for name in NAMES:
        array = leaves(inputs)[name]
        (direction,) = like([array], 2)
        zero = mapped(np.zeros_like, inputs)
        states, along = sim.jvp(inputs, changed(zero, **{name: direction}), *SPAN)
        # `jvp` sums in another order than `rollout`.
        np.testing.assert_allclose(states.x, seen.x, atol=1e-12)
        slope = float(np.sum(leaves(gradient)[name] * direction))
        # Both are exact up to rounding, which grows over the 48 steps.
        assert pairing(along, bars) == pytest.approx(slope, rel=1e-9, abs=1e-12), name

        def shifted(step: float) -> float:
            moved = changed(inputs, **{name: array + step * direction})
            return pairing(sim.rollout(moved, *SPAN), bars)

        if (name, integrator) == ("z", "implicit"):
            # Implicit steps count negative slopes as 0, so a void bar's stiffness of 0 is a kink.
            continue
        # Away from contacts the states are smooth; rounding adds 1e-15 / 1e-6.
        difference = (shifted(1e-6) - shifted(-1e-6)) / 2e-6
        assert difference == pytest.approx(slope, rel=1e-5, abs=1e-8), name


class Tensor:
    """As much of a tensor of torch as a rollout needs."""

    def __init__(self, numbers: Any) -> None:
        self.numbers = np.asarray(numbers)
        self.shape, self.ndim, self.device = self.numbers.shape, self.numbers.ndim, "cpu"
        self.requires_grad, self.grad = False, None

    def requires_grad_(self, requires_grad: bool = True) -> Tensor:
        self.requires_grad = requires_grad
        return self

    def detach(self) -> Tensor:
        return Tensor(self.numbers)

    def to(self, *_: Any) -> Tensor:
        return self

    cpu, numpy, dim = detach, lambda self: self.numbers, lambda self: self.ndim


class Function:
    """A function with its own rule for gradients. It gives gradients to the tensors that it gets."""

    @classmethod
    def apply(cls: Any, *given: Any) -> Any:
        context = SimpleNamespace(save_for_backward=lambda *tensors: setattr(context, "saved_tensors", tensors))
        made = cls.forward(context, *given)

        def backward(*bars: Tensor) -> None:
            for own, gradient in zip(given, cls.backward(context, *bars), strict=True):
                if isinstance(own, Tensor) and own.requires_grad:
                    own.grad = gradient

        made[0].backward = backward
        return made


def test_torch_gets_gradients_although_its_asarray_detaches(
    sim: cosmic.Simulator, monkeypatch: pytest.MonkeyPatch
) -> None:
    # A stand-in, so that the test needs no torch.
    torch: Any = ModuleType("torch")
    torch.asarray = lambda given: getattr(given, "requires_grad_", Tensor)(False)
    torch.as_tensor = lambda given: given if isinstance(given, Tensor) else Tensor(given)
    torch.tensor = torch.from_numpy = Tensor
    torch.autograd = SimpleNamespace(Function=Function)
    torch.autograd.function = SimpleNamespace(once_differentiable=lambda backward: backward)
    monkeypatch.setitem(sys.modules, "torch", torch)
    spec: Any = importlib.util.spec_from_file_location("cosmic.stand_in", Path(cosmic.__file__).with_name("torch.py"))
    own: Any = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(own)

    plain = robot(sim, 0)
    inputs = own.inputs(plain, requires_grad=True)
    seen = own.rollout(sim, inputs, *SPAN)
    bars = cosmic.Trajectory(*like(sim.rollout(plain, *SPAN), 1))
    seen.x.backward(*map(Tensor, bars))
    assert all(own.requires_grad for own in leaves(inputs).values())
    assert same(mapped(lambda own: own.grad.numbers, inputs), sim.vjp(plain, bars, *SPAN))
