"""Goals as inputs of a rollout."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple, Optional, Union

import numpy as np
import numpy.typing as npt

from ._errors import InputError

#: A position along the ground, a pair (along, above) or in space (along, across), an array with a row per robot, or a list of pairs (seconds, goal).
Goal = Union[float, npt.ArrayLike, Sequence[tuple[float, Any]], "Goals"]


class Goals(NamedTuple):
    """Goals in the form in which the library takes them."""

    changes: list[int]
    """The numbers of steps at which the goal changes."""
    points: Any
    """The goals, shape ``(goals, 2)`` or ``(batch, goals, 2)``: along the ground and normal to it, from the world's
    origin, m. In space they have three components: along, across and normal."""


def as_goals(
    goal: Any,
    origin: Optional[Sequence[float]],
    dt: float,
    numbers: Callable[[Any], Any],
    of: Any = np,
) -> Goals:
    """Converts an argument to goals. It counts from ``origin``, the payload at the start, which is None if the
    scene's goal is fixed. ``numbers`` makes arrays of the module ``of``."""
    if origin is None:
        raise InputError(
            'goal: the goal of this scene is fixed; set `controller.goals` to "given", as in the scene "errand"'
        )
    if isinstance(goal, Goals):
        return goal
    is_list = isinstance(goal, (list, tuple)) and len(goal) > 0
    changes = is_list and all(isinstance(leg, (list, tuple)) for leg in goal)
    legs = list(goal) if changes else [(0.0, goal)]
    if any(len(leg) != 2 for leg in legs):
        raise InputError(f"goal: expected pairs (seconds, goal), found {goal!r}")
    steps = [_step(seconds, dt) for seconds, _ in legs]
    if steps[0] != 0 or any(a >= b for a, b in zip(steps, steps[1:])):
        raise InputError(
            f"goal: the times are {[seconds for seconds, _ in legs]} s; they must begin with 0 and ascend by "
            f"a time step ({dt} s) or more (for several robots, give an array)"
        )
    points = [_point(numbers(point), origin, of) for _, point in legs]
    try:
        shape = np.broadcast_shapes(*(tuple(point.shape) for point in points))
    except ValueError:
        counts = [len(point) for point in points if point.ndim == 2]
        raise InputError(f"goal: the goals are for {counts} robots; the numbers must be equal") from None
    return Goals(steps[1:], of.stack([of.broadcast_to(point, shape) for point in points], -2))


def _step(seconds: Any, dt: float) -> int:
    try:
        time = float(seconds)
    except (TypeError, ValueError):
        time = -1.0
    if not 0.0 <= time < np.inf:
        raise InputError(f"goal: a time is {seconds!r}; it must be a number of seconds, 0 or more")
    return round(time / dt)


def _point(numbers: Any, origin: Sequence[float], of: Any) -> Any:
    """The components of a goal from the world's origin, on the last axis."""
    point = numbers[None] if numbers.ndim == 0 else numbers
    axes = len(origin)
    if point.ndim > 2 or not 1 <= point.shape[-1] <= axes:
        pair = "a pair (along, above)" if axes == 2 else "(along, across), (along, across, above)"
        raise InputError(
            f"goal: expected a number, {pair}, or for several robots the shape (batch, 1) to (batch, {axes}), "
            f"found the shape {list(point.shape)}"
        )
    given = [point[..., k] for k in range(point.shape[-1])]
    given += [0.0 * point[..., 0]] * (axes - len(given))
    return of.stack([number + start for number, start in zip(given, origin)], -1)
