"""Losses written in Python."""

from __future__ import annotations

import operator
from collections.abc import Callable, Sequence
from typing import Any, Optional, Union

import numpy as np
import numpy.typing as npt

from ._checks import whole
from ._errors import InputError

Floats = npt.NDArray[np.float64]
#: From ``x`` and ``v``, and ``goal`` if goals are given, to the value and its gradients with respect to positions
#: and velocities.
ValueAndGradient = Callable[..., tuple[float, Floats, Floats]]
#: Steps to observe: an interval, or a function from the number of steps of a rollout to a list of steps.
Steps = Union[int, Callable[[int], Sequence[int]]]


class Loss:
    """An objective to minimise: a number computed from the states of a rollout, with its gradient.

    ``function(x, v)`` gets positions and velocities of shape ``(states, nodes, 2)``. It returns the
    loss and its gradients with respect to both, which have the same shapes. :func:`cosmic.jax.loss`
    and :func:`cosmic.torch.loss` need only a function that returns the loss. In a scene with given
    goals it is ``function(x, v, goal)``: ``goal`` has the goal at the time of each state, shape
    ``(states, 2)``, along the ground and normal to it, from the world's origin.

    ``observed`` chooses the states that the loss sees. It is an interval in steps, or a function that takes
    the number of steps of a rollout and returns a list of steps in ascending order, as in
    ``lambda steps: [steps // 2]``. The last state is always added; by default the loss sees only this
    state. Rollouts get longer in the course of a run, and their length need not be a multiple of the
    interval. Robots are ranked by minus the loss, or, with ``is_far``, by their distance along the
    ground.
    """

    def __init__(
        self,
        function: ValueAndGradient,
        observed: Optional[Steps] = None,
        is_far: bool = False,
    ) -> None:
        self.function = function
        self.is_far = is_far
        if observed is not None and not callable(observed):
            observed = whole("observed", observed, 1)
        self._observed = observed

    def observed(self, steps: int) -> list[int]:
        """The steps of the states that the loss sees."""
        if self._observed is None:
            return [steps]
        if isinstance(self._observed, int):
            return [*range(0, steps, self._observed), steps]
        answer = self._observed(steps)
        try:
            observed = [operator.index(step) for step in answer]
        except TypeError:
            raise InputError(
                f"the loss observes {answer!r}: expected a list of step numbers"
            ) from None
        if observed[-1:] != [steps]:
            observed.append(steps)
        if min(observed) < 0 or any(a >= b for a, b in zip(observed, observed[1:])):
            raise InputError(
                f"the loss observes {list(answer)} in a rollout of {steps} steps: expected steps "
                f"in ascending order, from 0 to {steps}"
            )
        return observed

    def value_and_gradient(self, x: Floats, v: Floats, *goal: Floats) -> tuple[float, Floats]:
        """The loss, and its gradient as one vector: with respect to positions, then velocities."""
        answer = self.function(x, v, *goal)
        if not isinstance(answer, (tuple, list)) or len(answer) != 3:
            raise InputError(
                "the loss must return three things, its value and its gradients with respect to "
                f"positions and velocities; found {answer!r}"
            )
        value, *gradients = map(np.asarray, answer)
        if value.ndim != 0 or value.dtype.kind not in "fiu":
            raise InputError(f"the loss: expected a number as its value, found {answer[0]!r}")
        for name, array, like in zip(("x", "v"), gradients, (x, v)):
            if array.shape != like.shape or array.dtype.kind not in "fiu":
                raise InputError(
                    f"the gradient of the loss with respect to {name}: expected floats of the "
                    f"shape {like.shape}, found {array.dtype} of the shape {array.shape}"
                )
        return float(value), np.concatenate([np.float64(array).ravel() for array in gradients])


def as_loss(loss: Union[Loss, ValueAndGradient, None]) -> Optional[Loss]:
    """Converts a function to a loss. A loss, or None, is returned as it is."""
    if loss is None or isinstance(loss, Loss):
        return loss
    if callable(loss):
        return Loss(loss)
    raise InputError(f"a loss is a function or a cosmic.Loss, not {type(loss).__name__}")
