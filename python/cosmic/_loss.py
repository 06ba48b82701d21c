"""Losses written in Python."""

from __future__ import annotations

import difflib
import inspect
import operator
from collections.abc import Callable, Sequence
from functools import wraps
from typing import Any, Optional, Protocol, Union, overload

import numpy as np
import numpy.typing as npt

from ._checks import array, whole, yes
from ._errors import InputError

Floats = npt.NDArray[np.float64]
#: From ``x`` and ``v``, and ``goal`` if goals are given, to the value and its gradients with respect to positions
#: and velocities. If the loss sees more, a dictionary of gradients may follow.
ValueAndGradient = Callable[..., tuple[Any, ...]]
_Function = Callable[..., Any]
#: Steps to observe: an interval, or a function from the number of steps of a rollout to a list of steps.
Steps = Union[int, Callable[[int], Sequence[int]]]


#: The names of the arrays that a loss can see besides positions and velocities.
SEES = (
    "activation",
    "tension",
    "power",
    "work",
    "net",
    "mass",
    "presence",
    "stiffness",
    "strain",
    "time",
)


def check_function(function: Any) -> None:
    """Checks an argument that is the function of a loss."""
    if not callable(function):
        raise InputError(f"a loss is a function or a cosmic.Loss, not {type(function).__name__}")


class LossError(InputError):
    """A loss returned a gradient that is not finite."""


class Loss:
    """An objective to minimise: a number computed from the states of a rollout, with its gradient.

    ``function(x, v)`` gets positions and velocities of shape ``(states, nodes, D)``. It returns the
    loss and its gradients with respect to both, which have the same shapes. The payload is the node
    ``cosmic.Simulator(scene).payload``, which need not be node 0. The ground passes through the
    origin, at height 0 unless there is an incline, and the first column of a lattice starts at 0.
    :func:`cosmic.jax.loss` and :func:`cosmic.torch.loss` need only a function that returns the loss.
    In a scene with given goals it is ``function(x, v, goal)``: ``goal`` has the goal at the time of
    each state, shape ``(states, 2)``, along the ground and normal to it, from the world's origin.

    A loss sees more if its function has keyword arguments (after a ``*``) with these names:

    - ``activation``, ``tension``, ``power``, ``work``, ``net``, shape ``(states, edges)``: what the bars do.
      ``activation`` (-1 to 1) and ``tension`` (N, positive if the bar pulls) are those of the step that ends
      at the state. ``net`` (J) is the energy that the bar has given to its ends since the start less the
      energy that it has taken; in ``work`` (J) only the given energy counts. Both close the energy budget of
      the discrete steps, so they depend on the time step more than the powers of ``summary.json``. ``power`` (W)
      is the mean rate of ``net`` since the observed state before, or since the start. At the start all are 0.
    - ``mass`` and ``presence``, shape ``(nodes,)``, ``stiffness`` and ``strain``, shape ``(edges,)``: the
      robot, in kg, N/m and numbers without unit. These arrays follow from the design. The design vectors
      themselves are not an argument. ``presence`` is 0 for a node without a bar, which does not move.
    - ``time``, shape ``(states,)``: seconds since the start.

    ``function(x, v, *, tension, mass)`` returns as its fourth value a dictionary of gradients, such as
    ``{"tension": ..., "mass": ...}``. Missing gradients are 0.

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
        *,
        of: Optional[Callable[..., Any]] = None,
    ) -> None:
        check_function(function)
        # With `of`, `function` is the gradient of that function, which has the names of the arguments.
        self.function = function
        self.name: str = getattr(of or function, "__qualname__", repr(of or function))
        self.sees = _sees(of or function)
        self.is_far = yes("is_far", is_far)
        if observed is not None and not callable(observed):
            observed = whole("observed", observed, 1)
        self._observed = observed

    def __repr__(self) -> str:
        return f"<Loss {self.name}>"

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

    def value_and_gradient(self, x: Floats, v: Floats, *goal: Floats, **seen: Floats) -> tuple[float, Floats]:
        """The loss, and its gradient as one vector: with respect to positions, velocities, and the other arrays
        that it sees."""
        answer = self.function(x, v, *goal, **seen)
        if not isinstance(answer, (tuple, list)) or len(answer) not in (3, 4):
            further = ", and a dictionary of the other gradients" if seen else ""
            raise InputError(
                "the loss must return three things, its value and its gradients with respect to "
                f"positions and velocities{further}; found {answer!r}"
            )
        by_seen = answer[3] if len(answer) == 4 else {}
        if not isinstance(by_seen, dict) or not by_seen.keys() <= seen.keys():
            raise InputError(
                f"the loss: expected a dictionary of gradients with respect to {', '.join(seen)} as its fourth "
                f"thing, found {by_seen!r}"
            )
        value = array("the loss", answer[0])
        if value.ndim != 0 or value.dtype.kind not in "fiu":
            raise InputError(f"the loss: expected a number as its value, found {answer[0]!r}")
        gradients = {"x": answer[1], "v": answer[2], **by_seen}
        flat = []
        for name, like in {"x": x, "v": v, **seen}.items():
            own = array(f"the gradient of the loss with respect to {name}", gradients.get(name, np.zeros_like(like)))
            if own.shape != like.shape or own.dtype.kind not in "fiu":
                raise InputError(
                    f"the gradient of the loss with respect to {name}: expected floats of the "
                    f"shape {like.shape}, found {own.dtype} of the shape {own.shape}"
                )
            lost = np.argwhere(~np.isfinite(own))
            if len(lost):
                place = lost[0].tolist()
                raise LossError(
                    f"{self!r}: the gradient with respect to {name} is {own[tuple(place)]} at {place}; it must be finite"
                )
            flat.append(np.float64(own).ravel())
        return float(value), np.concatenate(flat)


class Decorator(Protocol):
    """The type of :func:`cosmic.jax.loss` and :func:`cosmic.torch.loss`: functions, and decorators with options."""

    @overload
    def __call__(self, function: _Function, *, observed: Optional[Steps] = None, is_far: bool = False) -> Loss: ...
    @overload
    def __call__(
        self, function: None = None, *, observed: Optional[Steps] = None, is_far: bool = False
    ) -> Callable[[_Function], Loss]: ...


def decorator(make: Callable[[_Function, Optional[Steps], bool], Loss]) -> Decorator:
    """Makes a decorator with options from a function of all arguments."""

    @wraps(make)
    def decorated(function: Any = None, *, observed: Optional[Steps] = None, is_far: bool = False) -> Any:
        if function is None:
            return lambda function: make(function, observed, is_far)
        check_function(function)
        return make(function, observed, is_far)

    return decorated


def _sees(function: Any) -> list[str]:
    """The names of the keyword arguments that a loss needs."""
    try:
        parameters = inspect.signature(function).parameters.values()
    except (TypeError, ValueError):
        return []
    named = []
    for parameter in parameters:
        name, is_keyword = parameter.name, parameter.kind is parameter.KEYWORD_ONLY
        if parameter.default is not parameter.empty:
            continue
        if name in SEES and not is_keyword:
            raise InputError(f"the loss: `{name}` must be a keyword argument: write `*` before it, as in (x, v, *, {name})")
        if is_keyword and name not in SEES:
            close = difflib.get_close_matches(name, SEES, 1)
            hint = f"did you mean `{close[0]}`?" if close else f"a loss can see {', '.join(SEES)}"
            raise InputError(f"the loss: unknown argument `{name}`: {hint}")
        if is_keyword:
            named.append(name)
    return named


def as_loss(loss: Union[Loss, ValueAndGradient, None]) -> Optional[Loss]:
    """Converts a function to a loss. A loss, or None, is returned as it is."""
    if loss is None or isinstance(loss, Loss):
        return loss
    return Loss(loss)
