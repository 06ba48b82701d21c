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
from functools import partial
from typing import Any, Optional

import numpy as np
import torch

from ._goal import Goal, Goals, as_goals
from ._loss import Loss, Steps
from ._simulator import Inputs, Observed, Simulator, Trajectory

__all__ = ["inputs", "loss", "rollout"]


class _Rollout(torch.autograd.Function):
    @staticmethod
    def forward(ctx: Any, simulator: Simulator, options: dict[str, Any], *arrays: Any) -> Any:
        ctx.simulator, ctx.options = simulator, options
        ctx.save_for_backward(*arrays)
        ctx.changes = options.pop("changes")
        forward = {key: value for key, value in options.items() if key != "bounded"}
        given, goal = _numpy(arrays, ctx.changes)
        seen = simulator.rollout(given, check=False, goal=goal, **forward)
        device = arrays[0].device
        return tuple(torch.from_numpy(array).to(device) for array in seen)

    @staticmethod
    @torch.autograd.function.once_differentiable
    def backward(ctx: Any, x_bar: Any, v_bar: Any) -> Any:
        arrays = ctx.saved_tensors
        bars = Trajectory(x_bar.detach().cpu().numpy(), v_bar.detach().cpu().numpy())
        given, goal = _numpy(arrays, ctx.changes)
        pulled = ctx.simulator.vjp(given, bars, check=False, goal=goal, **ctx.options)
        gradient = pulled if goal is None else (*pulled[0], pulled[1])
        of_inputs = []
        for g, array in zip(gradient, arrays):
            own = torch.from_numpy(g)
            # The gradient of a shared array is the sum over the robots.
            shared = own.dim() > array.dim()
            own = own.sum(0) if shared else own
            of_inputs.append(own.to(array) if array.requires_grad else None)
        return (None, None, *of_inputs)


def _numpy(arrays: Any, changes: Optional[list[int]]) -> tuple[Inputs, Optional[Goals]]:
    """The inputs and the goals in the tensors of a rollout, as arrays."""
    given = [array.detach().cpu().numpy() for array in arrays]
    if changes is None:
        return Inputs(*given), None
    *inputs, points = given
    return Inputs(*inputs), Goals(changes, points)


def inputs(arrays: Inputs, requires_grad: bool = False) -> Inputs:
    """Converts the arrays to torch tensors."""
    tensors = (torch.tensor(np.asarray(array)) for array in arrays)
    return Inputs(*(tensor.requires_grad_(requires_grad) for tensor in tensors))


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
    options = {
        "observed": simulator.observed(steps, observed),
        "first": first,
        "bounded": bounded,
        "changes": None,
    }
    given = [*map(torch.as_tensor, inputs)]
    if goal is not None:

        def numbers(point: Any) -> Any:
            return torch.as_tensor(point, dtype=torch.float64, device=given[0].device)

        origin = simulator._core.goal_origin
        options["changes"], points = as_goals(goal, origin, simulator.dt, numbers, torch)
        given.append(points)
    return Trajectory(*_Rollout.apply(simulator, options, *given))


def loss(
    function: Optional[Callable[[Any, Any], Any]] = None,
    *,
    observed: Optional[Steps] = None,
    is_far: bool = False,
) -> Any:
    """Turns a torch function into an objective for :func:`cosmic.optimize`. Also a decorator; see
    :func:`cosmic.jax.loss`."""
    if function is None:
        return partial(loss, observed=observed, is_far=is_far)

    def value_and_gradient(x: Any, v: Any, *goal: Any) -> tuple[float, Any, Any]:
        with torch.enable_grad():
            states = [torch.from_numpy(array).requires_grad_() for array in (x, v)]
            value = function(*states, *map(torch.from_numpy, goal))
            gradients = torch.autograd.grad(value, states, allow_unused=True)
        zeros = (np.zeros_like(x), np.zeros_like(v))
        x_bar, v_bar = (z if g is None else g.numpy() for g, z in zip(gradients, zeros))
        return float(value.detach()), x_bar, v_bar

    return Loss(value_and_gradient, observed, is_far)
