"""Rollouts as differentiable JAX functions, and objectives written in JAX.

>>> import cosmic, cosmic.jax, jax
>>> sim = cosmic.Simulator("stability")
>>> def height(inputs):
...     seen = cosmic.jax.rollout(sim, inputs, steps=200, observed=50)
...     return seen.x[:, 0, 1].mean()
>>> gradient = jax.jit(jax.grad(height))(sim.initial())
>>> gradient.z.shape
(110, 3)

In JAX a rollout is a callback on the CPU. On a machine with one core, callbacks can wait for one another
forever, for example under ``jit(vmap(...))`` with 128 robots or more. On such a machine, start Python
with ``XLA_FLAGS=--xla_force_host_platform_device_count=2`` in the environment.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial, wraps
from typing import Any, Optional, Union, overload

import jax
import jax.numpy as jnp
import numpy as np

from ._errors import InputError
from ._goal import Goal
from ._loss import Loss, Steps
from ._plan import Plan, planned
from ._simulator import Inputs, Observed, Simulator, Trajectory

__all__ = ["loss", "rollout"]


def _run(plan: Plan, *arrays: Any) -> Trajectory:
    inputs, _, batch = _one_axis(arrays, plan)
    if 0 in batch:
        return Trajectory(*(np.zeros(batch + plan.states, arrays[0].dtype),) * 2)
    return Trajectory(*(_axes_again(array, batch, 3) for array in plan.run(inputs)))


def _pull(plan: Plan, *arrays: Any) -> tuple[Any, ...]:
    inputs, bars, batch = _one_axis(arrays, plan, 2)
    if 0 in batch:
        return tuple(np.zeros(batch + shape, arrays[0].dtype) for shape in plan.shapes)
    pairs = zip(plan.pull(inputs, Trajectory(*bars)), plan.shapes)
    return tuple(_axes_again(array, batch, len(shape)) for array, shape in pairs)


_Arrays = list[Any]


def _one_axis(
    arrays: tuple[Any, ...], plan: Plan, bars: int = 0
) -> tuple[_Arrays, _Arrays, tuple[int, ...]]:
    """Merges the axes in front of each array into one. Returns the inputs, the cotangents, and the
    shape of the merged axes. The last ``bars`` arrays are cotangents; an input whose axes in front all
    have length 1 is shared by all robots."""
    bases = [len(shape) for shape in plan.shapes]
    given = [np.asarray(array) for array in arrays]
    cores = [array.shape[array.ndim - base :] for array, base in zip(given, bases + [3] * bars)]
    axes = [array.shape[: array.ndim - len(core)] for array, core in zip(given, cores)]
    batch = np.broadcast_shapes(*axes)
    if not batch:
        return given[: len(bases)], given[len(bases) :], batch

    def spread(k: int) -> Any:
        return np.broadcast_to(given[k], batch + cores[k]).reshape((-1, *cores[k]))

    is_shared = [all(length == 1 for length in axes[k]) for k in range(len(bases))]
    # At least one input must have the axis, because it sets the number of robots.
    is_shared[-1] = is_shared[-1] and not all(is_shared)
    inputs = [given[k].reshape(cores[k]) if is_shared[k] else spread(k) for k in range(len(bases))]
    return inputs, [spread(len(bases) + k) for k in range(bars)], batch


def _axes_again(array: Any, batch: tuple[int, ...], base: int) -> Any:
    return array.reshape(batch + array.shape[array.ndim - base :]) if batch else array


def _check(plan: Plan, arrays: Sequence[Any]) -> None:
    """Checks that the arrays have the shapes of one robot. The check is here and not in the callback, because
    JAX would wrap the exception."""
    for (name, shape), array in zip(plan.simulator.shapes.items(), arrays):
        if not any(jnp.issubdtype(array.dtype, kind) for kind in (jnp.floating, jnp.integer)):
            raise InputError(f"{name} is of type {array.dtype}: expected float32 or float64")
        if array.shape != shape:
            raise InputError(
                f"{name}: expected the shape {list(shape)}, found {list(array.shape)}; "
                "use jax.vmap for several robots"
            )


def _precision(plan: Plan, given: Sequence[Any]) -> Any:
    """The number type of the computation: double precision if any input has it, otherwise single."""
    inputs = given[: len(plan.simulator.shapes)]
    return jnp.float64 if jnp.result_type(*inputs, float) == jnp.float64 else jnp.float32


#: The arrays of a rollout: the inputs, and then the goals if there are any.
_Given = tuple[Any, ...]


@partial(jax.custom_vjp, nondiff_argnums=(0,))
def _rollout(plan: Plan, given: _Given) -> Trajectory:
    dtype = _precision(plan, given)
    shape: Any = jax.ShapeDtypeStruct(plan.states, dtype)
    arrays = [jnp.asarray(array, dtype) for array in given]
    # Arrays that vmap does not map over arrive with an axis of length 1, and stay shared.
    seen: Trajectory = jax.pure_callback(
        partial(_run, plan), Trajectory(shape, shape), *arrays, vmap_method="expand_dims"
    )
    return seen


def _forward(plan: Plan, given: _Given) -> tuple[Trajectory, _Given]:
    return _rollout(plan, given), given


def _backward(plan: Plan, given: _Given, cotangents: Trajectory) -> tuple[_Given]:
    dtype = _precision(plan, given)
    arrays = [jnp.asarray(array, dtype) for array in given]
    cotangents = Trajectory(*(jnp.asarray(bar, dtype) for bar in cotangents))
    shapes: Any = tuple(jax.ShapeDtypeStruct(shape, dtype) for shape in plan.shapes)
    gradient = jax.pure_callback(
        partial(_pull, plan), shapes, *arrays, *cotangents, vmap_method="expand_dims"
    )
    return (tuple(map(_cotangent, gradient, given)),)


def _cotangent(gradient: Any, of: Any) -> Any:
    """Converts a gradient to the type of its input. For integers, JAX expects zeros of the type float0."""
    if not jnp.issubdtype(of.dtype, jnp.floating):
        return np.zeros(of.shape, jax.dtypes.float0)
    return gradient.astype(of.dtype)


_rollout.defvjp(_forward, _backward)


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
    """:meth:`cosmic.Simulator.rollout` as a function of JAX: for ``jit``, ``vmap`` and ``grad``. The
    goal can be mapped over and differentiated too, but not the times at which it changes.

    Computes in double precision if the inputs are in double precision, which JAX allows after
    ``jax.config.update("jax_enable_x64", True)``. If a robot diverges, its later states and its
    gradient are NaN. If its inputs are not finite, everything is NaN. Other robots of the same
    ``vmap`` are unaffected. For ``bounded`` see :meth:`cosmic.Simulator.vjp`.
    """

    def numbers(point: Any) -> Any:
        array: Any = jnp.asarray(point, float)
        if array.ndim > 1:
            raise InputError(
                f"goal: expected a number or a pair (along, above), found the shape {list(array.shape)}; "
                "use jax.vmap for several robots"
            )
        return array

    plan, arrays = planned(simulator, inputs, steps, observed, first, bounded, goal, numbers, jnp)
    given: Any = tuple(map(jnp.asarray, arrays))
    _check(plan, given)
    seen: Trajectory = _rollout(plan, given)
    return seen


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
    """Turns a JAX function into an objective for :func:`cosmic.optimize`. Also a decorator.

    ``function(x, v)`` returns the loss of positions and velocities of shape ``(states, nodes, 2)``;
    ``observed`` and ``is_far`` are those of :class:`cosmic.Loss`. In a scene with given goals it is
    ``function(x, v, goal)``. Keyword arguments such as ``tension`` are further arrays that the loss
    sees, see :class:`cosmic.Loss`.

    >>> @cosmic.jax.loss(observed=lambda steps: range(steps // 2, steps + 1, 64))
    ... def high(x, v, *, power):
    ...     return -x[:, 0, 1].mean() + 0.1 * abs(power).sum(-1).mean()
    """
    if function is None:
        return partial(loss, observed=observed, is_far=is_far)
    of = function

    def value(x: Any, v: Any, seen: Any, goal: Any) -> Any:
        return of(x, v, *goal, **seen)

    compiled = jax.jit(jax.value_and_grad(value, argnums=(0, 1, 2)))

    # So that `Loss` sees the arguments of the function.
    @wraps(function)
    def value_and_gradient(x: Any, v: Any, *goal: Any, **seen: Any) -> tuple[Any, ...]:
        answer, bars = compiled(x, v, seen, goal)
        x_bar, v_bar, others = jax.tree.map(np.asarray, bars)
        return float(answer), x_bar, v_bar, *([others] if seen else [])

    return Loss(value_and_gradient, observed, is_far)
