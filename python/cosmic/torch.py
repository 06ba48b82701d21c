"""Rollouts as differentiable torch functions, and objectives written in torch.

>>> import cosmic, cosmic.torch, torch
>>> sim = cosmic.Simulator("stability")
>>> inputs = cosmic.torch.inputs(sim.initial(), requires_grad=True)
>>> seen = cosmic.torch.rollout(sim, inputs, steps=200, observed=50)
>>> seen.x[:, 0, 1].mean().backward()
>>> inputs.z.grad.shape
torch.Size([110, 3])
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial, wraps
from typing import Any, Optional, Union, overload

import numpy as np

from ._errors import extra
from ._goal import Goal
from ._loss import Loss, Steps
from ._plan import Plan, planned
from ._simulator import Inputs, Observed, Simulator, Trajectory, leaves, stepped, tree

with extra("torch"):
    import torch

__all__ = ["inputs", "loss", "rollout", "step"]


class _Rollout(torch.autograd.Function):
    @staticmethod
    def forward(ctx: Any, plan: Plan, *arrays: Any) -> Any:
        ctx.plan = plan
        ctx.save_for_backward(*arrays)
        return tuple(torch.from_numpy(array).to(arrays[0].device) for array in plan.run(_numpy(arrays)))

    @staticmethod
    @torch.autograd.function.once_differentiable
    def backward(ctx: Any, *bars: Any) -> Any:
        arrays, plan = ctx.saved_tensors, ctx.plan
        by = [name for name, array in zip(plan.shapes, arrays) if array.requires_grad]
        of_inputs = []
        for g, array in zip(plan.pull(_numpy(arrays), Trajectory(*_numpy(bars)), by), arrays):
            own = torch.from_numpy(g)
            # The gradient of a shared array is the sum over the robots.
            own = own.sum(0) if own.dim() > array.dim() else own
            of_inputs.append(own.to(array) if array.requires_grad else None)
        return (None, *of_inputs)


def _numpy(arrays: Any) -> list[Any]:
    return [array.detach().cpu().numpy() for array in arrays]


def inputs(arrays: Inputs, requires_grad: bool = False) -> Inputs:
    """Converts the arrays to torch tensors."""
    tensors = {name: torch.tensor(np.asarray(array)) for name, array in leaves(arrays).items()}
    return tree({name: own.requires_grad_(requires_grad) for name, own in tensors.items()})


def rollout(
    simulator: Simulator,
    inputs: Inputs,
    steps: Optional[int] = None,
    observed: Observed = 16,
    *,
    first: int = 0,
    bounded: bool = False,
    goal: Optional[Goal] = None,
) -> Trajectory:
    """:meth:`cosmic.Simulator.rollout` with torch tensors, which ``autograd`` can differentiate. So is the
    goal, which may contain tensors.

    If a robot diverges, its later states and its gradient are NaN. For ``bounded`` see
    :meth:`cosmic.Simulator.vjp`.
    """
    device = torch.as_tensor(inputs[0]).device

    def numbers(point: Any) -> Any:
        return torch.as_tensor(point, dtype=torch.float64, device=device)

    plan, arrays = planned(simulator, inputs, steps, observed, first, bounded, goal, numbers, torch)
    return Trajectory(*_Rollout.apply(plan, *map(torch.as_tensor, arrays)))


def step(
    simulator: Simulator,
    z: Any,
    x: Any,
    v: Any,
    activations: Any,
    steps: int = 1,
    *,
    first: int = 0,
    physics: Any = {},
) -> Trajectory:
    """:meth:`cosmic.Simulator.step` with torch tensors, for policies of your own."""
    run = partial(rollout, simulator, first=first)
    return stepped(run, z, x, v, activations, steps, physics, torch)


_Function = Callable[..., Any]


@overload
def loss(function: _Function, *, observed: Optional[Steps] = None, is_far: bool = False) -> Loss: ...
@overload
def loss(
    function: None = None, *, observed: Optional[Steps] = None, is_far: bool = False
) -> Callable[[_Function], Loss]: ...
def loss(
    function: Optional[_Function] = None,
    *,
    observed: Optional[Steps] = None,
    is_far: bool = False,
) -> Union[Loss, Callable[[_Function], Loss]]:
    """Turns a torch function into an objective for :func:`cosmic.optimize`. Also a decorator; see
    :func:`cosmic.jax.loss`."""
    if function is None:
        return partial(loss, observed=observed, is_far=is_far)
    of = function

    # `Loss` reads the names of the arguments from the signature.
    @wraps(function)
    def value_and_gradient(x: Any, v: Any, *goal: Any, **seen: Any) -> tuple[Any, ...]:
        with torch.enable_grad():
            given = {"x": x, "v": v, **seen}
            states = {name: torch.from_numpy(array).requires_grad_() for name, array in given.items()}
            named = {name: states[name] for name in seen}
            value = of(states["x"], states["v"], *map(torch.from_numpy, goal), **named)
            gradients = torch.autograd.grad(value, [*states.values()], allow_unused=True)
        bars = {
            name: np.zeros_like(given[name]) if g is None else g.numpy()
            for name, g in zip(given, gradients)
        }
        x_bar, v_bar = bars.pop("x"), bars.pop("v")
        return float(value.detach()), x_bar, v_bar, *([bars] if seen else [])

    return Loss(value_and_gradient, observed, is_far)
