"""Rollouts as differentiable JAX functions, and objectives written in JAX.

>>> import cosmic, cosmic.jax, jax
>>> sim = cosmic.Simulator("stability")
>>> def height(inputs):
...     seen = cosmic.jax.rollout(sim, inputs, steps=200, observed=50)
...     return seen.x[:, sim.payload, 1].mean()
>>> gradient = jax.jit(jax.grad(height))(sim.initial())
>>> gradient.z.shape
(110, 3)
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, Optional

import numpy as np

from . import _core
from ._checks import array as as_array
from ._errors import InputError, extra
from ._goal import Goal
from ._loss import Loss, Steps, decorator
from ._memory import check_rollouts
from ._plan import Plan, planned
from ._simulator import EVERY, FRAME_SKIP, Inputs, Observed, Policy, Simulator, Trajectory, stepped, wanted, with_policy

with extra("jax"):
    import jax
    import jax.numpy as jnp
    from jax.interpreters import ad, batching, mlir, xla

try:
    import jax.core
    import jax.extend.core
    import jax.ffi
except ImportError:
    raise ImportError(
        f"cosmic.jax needs jax 0.5.0 or newer, found {jax.__version__}; pip install 'jax>=0.5'"
    ) from None

__all__ = ["loss", "rollout", "step"]


def __dir__() -> list[str]:
    return __all__


_NAME = "cosmic_rollout"


def _version() -> int:
    """The minor version of XLA's interface. Some versions of XLA accept only handlers for their own version. For
    rollouts, the versions 0.1 to 0.3 are alike."""
    header = Path(jax.ffi.include_dir(), "xla", "ffi", "api", "c_api.h")
    [minor] = re.findall(r"#define XLA_FFI_API_MINOR (\d+)", header.read_text())
    return min(int(minor), 3)


jax.ffi.register_ffi_target(_NAME, _core.xla_handler(_version()), platform="cpu")

#: What a call of the library computes: the states of a rollout, their derivatives in a direction of the arrays, or the
#: gradients of states times cotangents by the arrays.
_STATES, _PUSHED, _PULLED = _core.STATES, _core.PUSHED, _core.PULLED

#: A call of the library. Its arguments are the arrays of a plan, and then those of a direction or of cotangents. Each may
#: have one more axis in front for several robots. Robots share an array without it, except for cotangents.
_call: Any = jax.extend.core.Primitive(_NAME)
_call.multiple_results = True


def _shapes(plan: Plan, mode: int) -> list[tuple[int, ...]]:
    """The shapes of the arguments for one robot."""
    own = list(plan.shapes.values())
    directions = {_STATES: [], _PUSHED: own, _PULLED: [plan.states] * 2}
    return own + directions[mode]


def _robots(plan: Plan, mode: int, arrays: Sequence[Any]) -> tuple[int, ...]:
    """The number of robots; empty if no argument has an axis for robots."""
    for array, shape in zip(arrays, _shapes(plan, mode)):
        if len(array.shape) > len(shape):
            return (array.shape[0],)
    return ()


@_call.def_abstract_eval
def _results(*arrays: Any, plan: Plan, mode: int, by: int) -> list[Any]:
    shapes = list(plan.shapes.values()) if mode == _PULLED else [plan.states] * 2
    robots = _robots(plan, mode, arrays)
    return [jax.core.ShapedArray(robots + shape, arrays[0].dtype) for shape in shapes]


_call.def_impl(partial(xla.apply_primitive, _call))


def _compiled(context: Any, *operands: Any, plan: Plan, mode: int, by: int) -> Any:
    simulator, arrays = plan.simulator, context.avals_in
    [robots] = _robots(plan, mode, arrays) or (1,)
    if mode == _PUSHED and simulator.device == "gpu":
        raise InputError('forward mode: not on a GPU; use a Simulator with device="cpu"')
    check_rollouts(
        simulator._sizes,
        robots,
        arrays[0].dtype.itemsize,
        len(plan.observed),
        copies=4 if mode == _PUSHED else 1,
        steps=plan.observed[-1] if mode == _PULLED else None,
        more=sum(math.prod(shape) for name, shape in plan.arrays if name not in simulator.shapes),
    )
    # XLA finds the simulator as long as the compiled function exists.
    context.module_context.add_keepalive(plan.core)
    rule = jax.ffi.ffi_lowering(_NAME)
    return rule(context, *operands, plan=np.int32(plan.core.id), mode=np.int32(mode), by=np.int32(by))


def _elsewhere(*_: Any, **__: Any) -> Any:
    raise InputError(
        "cosmic.jax.rollout needs the CPU backend of JAX; use jax.default_device(jax.devices('cpu')[0]), or "
        "jax.config.update('jax_platforms', 'cpu')"
    )


mlir.register_lowering(_call, _elsewhere)
mlir.register_lowering(_call, _compiled, platform="cpu")


def _mapped(arrays: Sequence[Any], axes: Sequence[Any], plan: Plan, mode: int, by: int) -> tuple[Any, Any]:
    """The rule of ``vmap``: merges its axis with the axis for robots. Arrays that all robots share stay shared."""
    shapes, given = _shapes(plan, mode), len(plan.shapes)
    own = [array.ndim - len(shape) - (axis is not None) for array, axis, shape in zip(arrays, axes, shapes)]
    merged: list[Any] = []
    inner: tuple[int, ...] = ()
    size = 0
    for array, axis, is_own in zip(arrays, axes, own):
        if axis is not None:
            size = array.shape[axis]
        if is_own:
            inner = (array.shape[0 if axis != 0 else 1],)
    for k, (array, axis, is_own, shape) in enumerate(zip(arrays, axes, own, shapes)):
        if axis is not None:
            array = jnp.moveaxis(array, axis, 0)
        elif is_own or mode == _PULLED and k >= given:
            array = jnp.broadcast_to(array, (size, *array.shape))
        else:
            merged.append(array)
            continue
        if inner and not is_own:
            array = jnp.broadcast_to(array[:, None], (size, *inner, *shape))
        merged.append(array.reshape(math.prod((size, *inner)), *shape))
    results = _call.bind(*merged, plan=plan, mode=mode, by=by)
    return [array.reshape(size, *inner, *array.shape[1:]) for array in results], [0] * len(results)


def _differentiated(arrays: Any, tangents: Any, plan: Plan, mode: int, by: int) -> tuple[Any, Any]:
    """The rule of forward mode. The other modes are linear in their last arguments, so they are their own derivatives."""
    count = len(plan.shapes)
    given, directions = arrays[:count], tangents[count:]
    if mode == _STATES:
        directions = tangents
    elif any(type(tangent) is not ad.Zero for tangent in tangents[:count]):
        raise InputError("second derivatives of a rollout are not supported; use differences of gradients")
    derivatives = _call.bind(
        *given, *map(ad.instantiate_zeros, directions), plan=plan, mode=mode or _PUSHED, by=by
    )
    return _call.bind(*arrays, plan=plan, mode=mode, by=by), derivatives


def _transposed(bars: Any, *arrays: Any, plan: Plan, mode: int, by: int) -> list[Any]:
    """The rule of reverse mode: derivatives in a direction and gradients are transposes of each other."""
    count = len(plan.shapes)
    given, directions = arrays[:count], arrays[count:]
    bars = map(ad.instantiate_zeros, bars)
    if mode == _PUSHED:
        named = zip(plan.shapes, directions)
        by = wanted([name for name, other in named if ad.is_undefined_primal(other)], plan.shapes)
    results = _call.bind(*given, *bars, plan=plan, mode=_PULLED if mode == _PUSHED else _PUSHED, by=by)
    own: list[Any] = [None] * count
    for result, other in zip(results, directions):
        if not ad.is_undefined_primal(other):
            own.append(None)
        else:
            # The gradient by an array that robots share is the sum over the robots.
            is_shared = result.ndim > len(other.aval.shape)
            own.append(result.sum(0) if is_shared else result)
    return own


batching.primitive_batchers[_call] = _mapped
ad.primitive_jvps[_call] = _differentiated
ad.primitive_transposes[_call] = _transposed


def _check(plan: Plan, arrays: Sequence[Any]) -> None:
    """Checks that the arrays have the shapes of one robot, before JAX compiles anything."""
    for (name, shape), array in zip(plan.arrays, arrays):
        if not any(jnp.issubdtype(array.dtype, kind) for kind in (jnp.floating, jnp.integer)):
            raise InputError(f"{name} is of type {array.dtype}: expected float32 or float64")
        if array.shape != shape:
            raise InputError(
                f"{name}: expected the shape {list(shape)}, found {list(array.shape)}; "
                "use jax.vmap for several robots"
            )


def rollout(
    simulator: Simulator,
    inputs: Inputs,
    steps: Optional[int] = None,
    observed: Observed = 16,
    *,
    first: Any = 0,
    bounded: bool = False,
    goal: Optional[Goal] = None,
    policy: Optional[Policy] = None,
    frame_skip: int = FRAME_SKIP,
) -> Trajectory:
    """:meth:`cosmic.Simulator.rollout` as a function of JAX: for ``jit``, ``vmap`` and ``grad``. The
    goal can be mapped over and differentiated too, but not the times at which it changes. ``first`` may be the counter of
    a loop. A ``policy`` runs in ``jax.lax.scan``, and has derivatives with respect to all arrays that it uses.

    Computes in double precision if the inputs are in double precision, which JAX allows after
    ``jax.config.update("jax_enable_x64", True)``. If a robot diverges, its later states and its
    gradient are NaN. If its inputs are not finite, everything is NaN. Other robots of the same
    ``vmap`` are unaffected. ``bounded`` is for reverse mode, see :meth:`cosmic.Simulator.vjp`.

    Reverse mode (``grad``, ``vjp``, ``jacrev``) and forward mode (``jvp``, ``linearize``, ``jacfwd``) work,
    but not second derivatives.
    """

    def numbers(point: Any) -> Any:
        array: Any = as_array("goal", point, jnp)
        if jnp.issubdtype(array.dtype, jnp.complexfloating):
            raise InputError(f"goal is of type {array.dtype}: expected a number")
        array = array.astype(float)
        if array.ndim > 1:
            raise InputError(
                f"goal: expected a number or a tuple of numbers, found the shape {list(array.shape)}; "
                "use jax.vmap for several robots"
            )
        return array

    if policy is not None:
        run = partial(rollout, simulator, bounded=bounded)
        return with_policy(run, simulator, inputs, steps, observed, first, policy, frame_skip, goal, jnp, _scan)
    is_traced = isinstance(first, jax.core.Tracer)
    known = 0 if is_traced else first
    plan, arrays = planned(simulator, inputs, steps, observed, known, bounded, goal, numbers, jnp)
    first = jnp.asarray(first if is_traced else plan.first)
    if not jnp.issubdtype(first.dtype, jnp.integer):
        raise InputError(f"first is of type {first.dtype}: expected a whole number")
    plan = replace(plan, first=0, arrays=(*plan.arrays, ("first", ())))
    given = [*map(jnp.asarray, arrays), first]
    _check(plan, given)
    dtype = _precision(array for name, array in zip(plan.shapes, given) if name not in ("goal", "first"))
    return Trajectory(*_call.bind(*(array.astype(dtype) for array in given), plan=plan, mode=_STATES, by=EVERY))


def _precision(arrays: Iterable[Any]) -> Any:
    """Double precision if any array is in double precision, otherwise single precision."""
    return jnp.float64 if jnp.result_type(*arrays, float) == jnp.float64 else jnp.float32


def _scan(frame: Any, start: Trajectory, frames: int, _: Any) -> Any:
    """Positions and velocities at the start and after each frame."""
    dtype = _precision(start)

    def after(state: Trajectory, number: Any) -> tuple[Trajectory, Trajectory]:
        state = Trajectory(*(array.astype(dtype) for array in frame(state, number)))
        return state, state

    start = Trajectory(*(array.astype(dtype) for array in start))
    _, later = jax.lax.scan(after, start, jnp.arange(frames))
    return [jnp.concatenate([own[None], after]) for own, after in zip(start, later)]


def step(
    simulator: Simulator,
    z: Any,
    x: Any,
    v: Any,
    activations: Any,
    steps: int = 1,
    *,
    first: Any = 0,
    physics: Any = {},
) -> Trajectory:
    """:meth:`cosmic.Simulator.step` as a function of JAX, for loops of your own."""
    run = partial(rollout, simulator, first=first)
    return stepped(run, z, x, v, activations, steps, physics, jnp)


@decorator
def loss(function: Callable[..., Any], observed: Optional[Steps], is_far: bool) -> Loss:
    """Turns a JAX function into an objective for :func:`cosmic.optimize`. Also a decorator.

    ``function(x, v)`` returns the loss of positions and velocities of shape ``(states, nodes, D)``;
    ``observed`` and ``is_far`` are those of :class:`cosmic.Loss`. In a scene with given goals it is
    ``function(x, v, goal)``. Keyword arguments such as ``tension`` are further arrays that the loss
    sees, see :class:`cosmic.Loss`.

    >>> payload = cosmic.Simulator("cube").payload
    >>> @cosmic.jax.loss(observed=lambda steps: range(steps // 2, steps + 1, 64))
    ... def high(x, v, *, power):
    ...     return -x[:, payload, -1].mean() + 0.1 * abs(power).sum(-1).mean()
    """
    compiled = jax.jit(jax.value_and_grad(lambda seen, goal: function(*seen[:2], *goal, **seen[2])))

    def value_and_gradient(x: Any, v: Any, *goal: Any, **seen: Any) -> tuple[Any, ...]:
        value, bars = compiled((x, v, seen), goal)
        return float(value), *jax.tree.map(np.asarray, bars)

    return Loss(value_and_gradient, observed, is_far, of=function)
