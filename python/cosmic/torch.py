"""Rollouts as differentiable torch functions, and objectives written in torch.

>>> import cosmic, cosmic.torch, torch
>>> sim = cosmic.Simulator("stability")
>>> inputs = cosmic.torch.inputs(sim.initial(), requires_grad=True)
>>> seen = cosmic.torch.rollout(sim, inputs, steps=200, observed=50)
>>> seen.x[:, sim.payload, 1].mean().backward()
>>> inputs.z.grad.shape
torch.Size([110, 3])
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any, Optional

import numpy as np

from ._checks import array
from ._errors import extra
from ._goal import Goal
from ._loss import Loss, Steps, decorator
from ._plan import Plan, planned
from ._simulator import FRAME_SKIP, Inputs, Observed, Policy, Simulator, Trajectory, leaves, stepped, tree, with_policy

# Without torch, pyright takes this file for it.
# pyright: reportAttributeAccessIssue=false
with extra("torch"):
    import torch

__all__ = ["inputs", "loss", "rollout", "step"]


def __dir__() -> list[str]:
    return __all__


class _Rollout(torch.autograd.Function):
    @staticmethod
    def forward(ctx: Any, plan: Plan, *arrays: Any) -> Any:
        ctx.plan = plan
        ctx.save_for_backward(*arrays)
        return tuple(torch.from_numpy(array).to(arrays[0].device) for array in plan.run(_numpy(arrays)))

    # By its type, torch's decorator makes `ctx` an argument without a name.
    @staticmethod
    @torch.autograd.function.once_differentiable
    def backward(ctx: Any, *bars: Any) -> Any:  # pyright: ignore[reportIncompatibleMethodOverride]
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


def inputs(arrays: Inputs, requires_grad: bool = False) -> Any:
    """Converts the arrays of :class:`cosmic.Inputs` to torch tensors."""
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
    policy: Optional[Policy] = None,
    frame_skip: int = FRAME_SKIP,
) -> Trajectory:
    """:meth:`cosmic.Simulator.rollout` with torch tensors, which ``autograd`` can differentiate. So are the
    goal and the parameters of the policy, which may be tensors.

    If a robot diverges, its later states and its gradient are NaN. For ``bounded`` see
    :meth:`cosmic.Simulator.vjp`.
    """
    if policy is not None:
        run = partial(rollout, simulator, bounded=bounded)
        return with_policy(run, simulator, inputs, steps, observed, first, policy, frame_skip, goal, torch)
    device = array("z", leaves(inputs)["z"], torch).device

    def numbers(point: Any) -> Any:
        return array("goal", point, torch).to(device, torch.float64)

    plan, arrays = planned(simulator, inputs, steps, observed, first, bounded, goal, numbers, torch)
    return Trajectory(*_Rollout.apply(plan, *arrays))


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


@decorator
def loss(function: Callable[..., Any], observed: Optional[Steps], is_far: bool) -> Loss:
    """Turns a torch function into an objective for :func:`cosmic.optimize`. Also a decorator; see
    :func:`cosmic.jax.loss`."""

    def value_and_gradient(x: Any, v: Any, *goal: Any, **seen: Any) -> tuple[Any, ...]:
        with torch.enable_grad():
            given = [torch.from_numpy(array).requires_grad_() for array in (x, v, *seen.values())]
            value = function(*given[:2], *map(torch.from_numpy, goal), **dict(zip(seen, given[2:])))
            bars = torch.autograd.grad(value, given, allow_unused=True, materialize_grads=True)
        x_bar, v_bar, *by_seen = (bar.detach().numpy() for bar in bars)
        return float(value.detach()), x_bar, v_bar, dict(zip(seen, by_seen))

    return Loss(value_and_gradient, observed, is_far, of=function)
