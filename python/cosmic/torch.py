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

from ._loss import Loss, Steps
from ._simulator import Inputs, Observed, Simulator, Trajectory

__all__ = ["inputs", "loss", "rollout"]


class _Rollout(torch.autograd.Function):
    @staticmethod
    def forward(ctx: Any, simulator: Simulator, options: dict[str, Any], *arrays: Any) -> Any:
        ctx.simulator, ctx.options = simulator, options
        ctx.save_for_backward(*arrays)
        forward = {key: value for key, value in options.items() if key != "bounded"}
        seen = simulator.rollout(_numpy(arrays), check=False, **forward)
        device = arrays[0].device
        return tuple(torch.from_numpy(array).to(device) for array in seen)

    @staticmethod
    @torch.autograd.function.once_differentiable
    def backward(ctx: Any, x_bar: Any, v_bar: Any) -> Any:
        arrays = ctx.saved_tensors
        bars = Trajectory(x_bar.detach().cpu().numpy(), v_bar.detach().cpu().numpy())
        gradient = ctx.simulator.vjp(_numpy(arrays), bars, check=False, **ctx.options)
        of_inputs = []
        for g, array, base in zip(gradient, arrays, ctx.simulator.shapes.values()):
            own = torch.from_numpy(g)
            # The gradient of a shared array is the sum over the robots.
            shared = own.dim() > array.dim()
            own = own.sum(0) if shared else own
            of_inputs.append(own.to(array) if array.requires_grad else None)
        return (None, None, *of_inputs)


def _numpy(arrays: Any) -> Inputs:
    return Inputs(*(array.detach().cpu().numpy() for array in arrays))


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
) -> Trajectory:
    """:meth:`cosmic.Simulator.rollout` with torch tensors, which ``autograd`` can differentiate.

    If a robot diverges, its later states and its gradient are NaN. For ``bounded`` see
    :meth:`cosmic.Simulator.vjp`.
    """
    options = {
        "observed": simulator.observed(steps, observed),
        "first": first,
        "bounded": bounded,
    }
    return Trajectory(*_Rollout.apply(simulator, options, *map(torch.as_tensor, inputs)))


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

    def value_and_gradient(x: Any, v: Any) -> tuple[float, Any, Any]:
        with torch.enable_grad():
            states = [torch.from_numpy(array).requires_grad_() for array in (x, v)]
            value = function(*states)
            gradients = torch.autograd.grad(value, states, allow_unused=True)
        zeros = (np.zeros_like(x), np.zeros_like(v))
        x_bar, v_bar = (z if g is None else g.numpy() for g, z in zip(gradients, zeros))
        return float(value.detach()), x_bar, v_bar

    return Loss(value_and_gradient, observed, is_far)
