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
from functools import partial
from typing import Any, Optional

import jax
import jax.numpy as jnp
import numpy as np

from ._checks import whole
from ._errors import InputError
from ._goal import Goal, Goals, as_goals
from ._loss import Loss, Steps
from ._simulator import Inputs, Observed, Simulator, Trajectory

__all__ = ["loss", "rollout"]


class _Plan:
    """Which steps of a rollout are observed, and how. For JAX this is a static argument. Plans of equal
    rollouts are equal, so that JAX reuses compiled functions."""

    def __init__(
        self,
        simulator: Simulator,
        observed: list[int],
        first: int,
        bounded: bool,
        changes: Optional[list[int]],
    ) -> None:
        self.simulator = simulator
        self.observed = observed
        self.first = first
        self.bounded = bounded
        self.changes = changes
        of_goal = None if changes is None else tuple(changes)
        self._key = (id(simulator), tuple(observed), first, bounded, of_goal)

    def __hash__(self) -> int:
        return hash(self._key)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Plan) and self._key == other._key

    def shape(self) -> tuple[int, ...]:
        nodes, _ = self.simulator.shapes["x0"]
        return (len(self.observed), nodes, 2)

    def run(self, *arrays: Any) -> Trajectory:
        inputs, _, batch = _one_axis(arrays, self.bases())
        if 0 in batch:
            return Trajectory(*(np.zeros(batch + self.shape(), arrays[0].dtype),) * 2)
        given, goal = self._given(inputs)
        seen = self.simulator.rollout(
            given, observed=self.observed, first=self.first, check=False, goal=goal
        )
        return Trajectory(*(_axes_again(array, batch, 3) for array in seen))

    def pull(self, *arrays: Any) -> tuple[Any, ...]:
        inputs, bars, batch = _one_axis(arrays, self.bases(), 2)
        if 0 in batch:
            return tuple(np.zeros(batch + shape, arrays[0].dtype) for shape in self.shapes())
        given, goal = self._given(inputs)
        pulled: Any = self.simulator.vjp(
            given,
            Trajectory(*bars),
            observed=self.observed,
            first=self.first,
            bounded=self.bounded,
            check=False,
            goal=goal,
        )
        gradient = pulled if goal is None else (*pulled[0], pulled[1])
        pairs = zip(gradient, self.bases())
        return tuple(_axes_again(array, batch, base) for array, base in pairs)

    def _given(self, arrays: list[Any]) -> tuple[Inputs, Optional[Goals]]:
        """The inputs and the goals in the arrays of a rollout."""
        if self.changes is None:
            return Inputs(*arrays), None
        *inputs, points = arrays
        return Inputs(*inputs), Goals(self.changes, points)

    def shapes(self) -> list[tuple[int, ...]]:
        """The shapes of the arrays of one robot."""
        goals = [] if self.changes is None else [(1 + len(self.changes), 2)]
        return [*self.simulator.shapes.values(), *goals]

    def bases(self) -> list[int]:
        """The number of axes of each array of one robot."""
        return [len(shape) for shape in self.shapes()]


_Arrays = list[Any]


def _one_axis(
    arrays: tuple[Any, ...], bases: list[int], bars: int = 0
) -> tuple[_Arrays, _Arrays, tuple[int, ...]]:
    """Merges the axes in front of each array into one. Returns the inputs, the cotangents, and the
    shape of the merged axes. The first ``len(bases)`` arrays are inputs; an input whose axes in front
    all have length 1 is shared by all robots."""
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


def _checked(simulator: Simulator, inputs: Any) -> Inputs:
    """Checks that the arrays have the shapes of one robot. The check is here and not in the callback, because
    JAX would wrap the exception."""
    count = len(Inputs._fields)
    if not isinstance(inputs, (tuple, list)) or len(inputs) != count:
        found = len(inputs) if isinstance(inputs, (tuple, list)) else type(inputs).__name__
        raise InputError(f"expected the {count} arrays of Inputs, found {found}")
    arrays: list[Any] = []
    for (name, shape), given in zip(simulator.shapes.items(), inputs):
        array: Any = jnp.asarray(given)
        is_real = jnp.issubdtype(array.dtype, jnp.floating) or jnp.issubdtype(
            array.dtype, jnp.integer
        )
        if not is_real:
            raise InputError(f"{name} is of type {array.dtype}: expected float32 or float64")
        if array.shape != shape:
            raise InputError(
                f"{name}: expected the shape {list(shape)}, found {list(array.shape)}; "
                "use jax.vmap for several robots"
            )
        arrays.append(array)
    return Inputs(*arrays)


def _precision(given: Sequence[Any]) -> Any:
    """The number type of the computation: double precision if any input has it, otherwise single."""
    is_double = jnp.result_type(*given[: len(Inputs._fields)], float) == jnp.float64
    return jnp.float64 if is_double else jnp.float32


#: The arrays of a rollout: the inputs, and then the goals if there are any.
_Given = tuple[Any, ...]


@partial(jax.custom_vjp, nondiff_argnums=(0,))
def _rollout(plan: _Plan, given: _Given) -> Trajectory:
    dtype = _precision(given)
    shape: Any = jax.ShapeDtypeStruct(plan.shape(), dtype)
    arrays = [jnp.asarray(array, dtype) for array in given]
    # Arrays that vmap does not map over arrive with an axis of length 1, and stay shared.
    seen: Trajectory = jax.pure_callback(
        plan.run, Trajectory(shape, shape), *arrays, vmap_method="expand_dims"
    )
    return seen


def _forward(plan: _Plan, given: _Given) -> tuple[Trajectory, _Given]:
    return _rollout(plan, given), given


def _backward(plan: _Plan, given: _Given, cotangents: Trajectory) -> tuple[_Given]:
    dtype = _precision(given)
    arrays = [jnp.asarray(array, dtype) for array in given]
    cotangents = Trajectory(*(jnp.asarray(bar, dtype) for bar in cotangents))
    shapes: Any = tuple(jax.ShapeDtypeStruct(shape, dtype) for shape in plan.shapes())
    gradient = jax.pure_callback(
        plan.pull, shapes, *arrays, *cotangents, vmap_method="expand_dims"
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
    seen_at, first = simulator.observed(steps, observed), whole("first", first, 0)
    simulator.check_span(seen_at, first)
    given: tuple[Any, ...] = _checked(simulator, inputs)
    changes = None
    if goal is not None:
        changes, points = _goals(simulator, goal)
        given = (*given, points)
    plan = _Plan(simulator, seen_at, first, bounded, changes)
    seen: Trajectory = _rollout(plan, tuple(given))
    return seen


def _goals(simulator: Simulator, goal: Goal) -> Goals:
    def numbers(point: Any) -> Any:
        array: Any = jnp.asarray(point, float)
        if array.ndim > 1:
            raise InputError(
                f"goal: expected a number or a pair (along, above), found the shape {list(array.shape)}; "
                "use jax.vmap for several robots"
            )
        return array

    return as_goals(goal, simulator._core.goal_origin, simulator.dt, numbers, jnp)


def loss(
    function: Optional[Callable[[Any, Any], Any]] = None,
    *,
    observed: Optional[Steps] = None,
    is_far: bool = False,
) -> Any:
    """Turns a JAX function into an objective for :func:`cosmic.optimize`. Also a decorator.

    ``function(x, v)`` returns the loss of positions and velocities of shape ``(states, nodes, 2)``;
    ``observed`` and ``is_far`` are those of :class:`cosmic.Loss`.

    In a scene with given goals it is ``function(x, v, goal)``, see :class:`cosmic.Loss`.

    >>> @cosmic.jax.loss(observed=lambda steps: range(steps // 2, steps + 1, 64))
    ... def high(x, v):
    ...     return -x[:, 0, 1].mean()
    """
    if function is None:
        return partial(loss, observed=observed, is_far=is_far)
    compiled = jax.jit(jax.value_and_grad(function, argnums=(0, 1)))

    def value_and_gradient(x: Any, v: Any, *goal: Any) -> tuple[float, Any, Any]:
        value, (x_bar, v_bar) = compiled(x, v, *goal)
        return float(value), np.asarray(x_bar), np.asarray(v_bar)

    return Loss(value_and_gradient, observed, is_far)
