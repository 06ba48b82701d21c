"""Rollouts and their derivatives over NumPy arrays."""

from __future__ import annotations

import operator
from collections.abc import Sequence
from typing import Any, NamedTuple, Optional, Union, overload

import numpy as np
import numpy.typing as npt

from . import _core
from ._checks import seed as as_seed
from ._checks import whole
from ._core import Scene
from ._errors import InputError
from ._goal import Goal, as_goals
from ._scene import SceneLike, as_scene

#: An array of floats in single or double precision.
Array = npt.NDArray[Any]
#: The steps to observe: an interval, or a list of steps.
Observed = Union[int, Sequence[int], npt.NDArray[np.integer[Any]]]


#: The projections from design vectors to mixtures of materials.
PROJECTIONS = ("auto", "performance", "stability", "none", "layout")

#: Where a simulator computes.
DEVICES = ("cpu", "gpu")


class Inputs(NamedTuple):
    """All arrays that a rollout depends on, and with respect to which it can be differentiated.

    For several robots, an array has one more axis in front; all robots share an array without it.
    For JAX and torch, a named tuple is a tree of arrays.
    """

    z: Array
    """Design vectors, shape ``(edges, 3)``: void, skeleton, actuator."""
    w1: Array
    """First weights of the controller, ``(hidden, inputs)``. With the policy ``gaits`` they have three
    groups of ``controller.hidden`` rows: for a goal ahead, for a goal behind, and for a goal that is reached."""
    b1: Array
    """First biases, ``(hidden,)``."""
    w2: Array
    """Second weights, ``(edges, hidden)``."""
    b2: Array
    """Second biases, ``(edges,)``."""
    x0: Array
    """Initial positions, ``(nodes, 2)``, m."""
    v0: Array
    """Initial velocities, ``(nodes, 2)``, m/s."""


class Trajectory(NamedTuple):
    """States of a rollout, with one more axis in front for several robots."""

    x: Array
    """Positions, shape ``(states, nodes, 2)``, m."""
    v: Array
    """Velocities, ``(states, nodes, 2)``, m/s."""


class Simulator:
    """Simulates robots on the lattice and in the world of a scene.

    ``projection`` decides what the rows of ``z`` are. With ``"performance"`` or ``"stability"`` they are
    design vectors, to which that projection is applied. With ``"none"`` they are mixtures of materials.
    With ``"layout"`` they are those of a finished robot: one number of every row is 1, or near 1 for
    differences. A node without a bar is then no part of the robot: it stays where it starts.

    ``"auto"`` decides once, by the first robots that the simulator gets: ``"layout"`` if all their rows
    consist of zeros and a one, otherwise ``"performance"``. So a small change of ``z`` never changes the
    function that is simulated and differentiated. Robots of the other kind are refused from then on.

    If all arrays are in single precision, the simulation is too; otherwise it is in double precision.

    With ``device="gpu"``, :meth:`rollout` and :meth:`vjp` run on a GPU, for all robots of a batch at once.
    They compute in single precision, and return arrays of the type that they are given. This needs the
    package ``cosmic-codesign-gpu``. It pays for hundreds of robots; one robot is faster on the processor.
    """

    def __init__(self, scene: SceneLike, projection: str = "auto", device: str = "cpu") -> None:
        self.scene: Scene = as_scene(scene)
        for name, value, choices in [
            ("projection", projection, PROJECTIONS),
            ("device", device, DEVICES),
        ]:
            if value not in choices:
                allowed = ", ".join(map(repr, choices))
                raise InputError(f"{name}: {value!r}: allowed: {allowed}")
        self.projection = projection
        """How rows of ``z`` become a robot; ``"auto"`` until the first robot decides."""
        self.device = device
        self._is_automatic = projection == "auto"
        self._core = _core.Simulator(self.scene, device == "gpu")
        self.dt: float = self._core.dt
        """Length of a step, s."""
        self.steps: int = self._core.steps
        """The number of steps of a whole rollout."""
        self.shapes: dict[str, tuple[int, ...]] = {
            name: tuple(shape) for name, shape in self._core.shapes
        }
        """The shapes of the arrays of :class:`Inputs`."""
        self.edges: npt.NDArray[np.int64] = self._core.edges
        """The two nodes of every edge, shape ``(edges, 2)``."""
        self.rest_length: npt.NDArray[np.float64] = self._core.rest_length
        """Rest length of every edge, m."""
        self.along: npt.NDArray[np.float64] = np.array(self._core.along)
        """The unit vector along the ground, in which distances are measured."""

    def initial(self, seed: int = 0) -> Inputs:
        """The inputs that an optimisation with this seed starts with."""
        return Inputs(*self._core.initial(as_seed(seed)))

    def observed(self, steps: Optional[int] = None, observed: Observed = 16) -> list[int]:
        """The numbers of the observed steps of a rollout.

        They are the list ``observed``. If ``observed`` is an interval, they are every so many steps
        up to ``steps`` (by default all steps of the scene), and the last step."""
        if isinstance(observed, (int, np.integer)):
            last = self.steps if steps is None else whole("steps", steps, 0)
            return [*range(0, last, whole("observed", observed, 1)), last]
        if steps is not None:
            raise InputError(
                "`steps` cannot be used if `observed` is a list; end the list with the last step"
            )
        given = observed.tolist() if isinstance(observed, np.ndarray) else observed
        try:
            listed = [operator.index(step) for step in given]
        except TypeError:
            listed = [-1]
        if not listed or min(listed) < 0:
            raise InputError(f"observed: expected a list of step numbers, found {observed!r}")
        return listed

    def check_span(self, observed: Sequence[int], first: int = 0) -> None:
        """Raises :class:`InputError` if a rollout of the scene lacks these steps."""
        self._core.check_span(list(observed), first)

    def rollout(
        self,
        inputs: Inputs,
        steps: Optional[int] = None,
        observed: Observed = 16,
        *,
        first: int = 0,
        check: bool = True,
        goal: Optional[Goal] = None,
    ) -> Trajectory:
        """Simulates one robot or several from their starts.

        ``goal`` is where the robot should go, in a scene with ``controller.goals = "given"``; by default
        ``controller.goal``. It is a distance along the ground in metres, positive ahead, or a pair
        ``(along, above)``. Both count from the payload in the scene's start, like ``[goals]`` of a scene
        and ``cosmic walk --goal``. An array of shape ``(batch, 1)`` or ``(batch, 2)`` has a goal for each
        robot. A list of pairs ``(seconds, goal)`` is a goal that changes at these times of the clock; the
        first time is 0.

        ``first`` is the number of earlier steps, for a rollout that continues another one. A rollout
        that diverges raises :class:`DivergedError` with the place and the reason. With
        ``check=False`` its states are NaN from the first state that is not finite or is beyond 1e6
        m or 1e6 m/s. If the inputs of a robot are not finite, all its states are NaN.

        Ctrl-C stops a batch after the current robots, and on a GPU after all robots. The attribute
        ``trajectory`` of the ``KeyboardInterrupt`` has the states of the finished robots, and NaN for the
        others.
        """
        core, arrays = self._with_goal(_prepared(inputs), goal)
        seen, first = self.observed(steps, observed), whole("first", first, 0)
        arrays, lost = (arrays, None) if check else self._finite(arrays)
        try:
            states = core.rollout(arrays, seen, first, self._projection(arrays[0], lost), check)
        except KeyboardInterrupt as stopped:
            if hasattr(stopped, "trajectory"):
                stopped.trajectory = Trajectory(*stopped.trajectory)
            raise
        return Trajectory(*_without(lost, states))

    @overload
    def vjp(
        self,
        inputs: Inputs,
        cotangents: Trajectory,
        steps: Optional[int] = None,
        observed: Observed = 16,
        *,
        first: int = 0,
        bounded: bool = False,
        check: bool = True,
        goal: None = None,
    ) -> Inputs: ...
    @overload
    def vjp(
        self,
        inputs: Inputs,
        cotangents: Trajectory,
        steps: Optional[int] = None,
        observed: Observed = 16,
        *,
        first: int = 0,
        bounded: bool = False,
        check: bool = True,
        goal: Goal,
    ) -> tuple[Inputs, Array]: ...
    def vjp(
        self,
        inputs: Inputs,
        cotangents: Trajectory,
        steps: Optional[int] = None,
        observed: Observed = 16,
        *,
        first: int = 0,
        bounded: bool = False,
        check: bool = True,
        goal: Optional[Goal] = None,
    ) -> Union[Inputs, tuple[Inputs, Array]]:
        """The vector-Jacobian product of :meth:`rollout`: the gradient of the sum of states times
        cotangents with respect to every input. Each robot of a batch has its own gradient, also
        with respect to shared inputs.

        If ``goal`` is given, it is as in :meth:`rollout`, and the result is a pair: the gradient with
        respect to the inputs, and the gradient with respect to the goal along the ground and above it, of
        shape ``(goals, 2)`` with one row per goal, or ``(batch, goals, 2)``.

        ``bounded`` limits cotangents to the scene's ``gradient.cotangent_bound``. Long rollouts
        with contacts need this for useful gradients; without it the gradient is exact. On a GPU, the
        cotangents of step 0 are added after the bound. For ``check`` see :meth:`rollout`. With ``check=False`` the gradient of a robot that diverges is
        NaN.
        """
        core, arrays = self._with_goal(_prepared(inputs), goal)
        seen, first = self.observed(steps, observed), whole("first", first, 0)
        if len(cotangents) != 2:
            raise InputError(f"expected the 2 arrays of Trajectory, found {len(cotangents)}")
        x_bar, v_bar = _floats(("x_bar", "v_bar"), cotangents, arrays[0].dtype)
        arrays, lost = (arrays, None) if check else self._finite(arrays)
        projection = self._projection(arrays[0], lost)
        pulled = core.vjp(arrays, x_bar, v_bar, seen, first, projection, bounded, check)
        gradient, count = _without(lost, pulled), len(Inputs._fields)
        of_inputs = Inputs(*gradient[:count])
        return of_inputs if goal is None else (of_inputs, gradient[count])

    def jvp(
        self,
        inputs: Inputs,
        tangents: Inputs,
        steps: Optional[int] = None,
        observed: Observed = 16,
        *,
        first: int = 0,
        check: bool = True,
        goal: Optional[Goal] = None,
    ) -> tuple[Trajectory, Trajectory]:
        """The states of :meth:`rollout`, up to rounding, and their derivatives along ``tangents``. The
        goal is constant. With ``check=False`` both are NaN for a robot that diverges. A GPU cannot
        compute them."""
        if self.device == "gpu":
            raise InputError('jvp: not on a GPU; use a Simulator with device="cpu"')
        core, arrays = self._with_goal(_prepared(inputs), goal)
        along = _prepared(tangents, arrays[0].dtype)
        seen, first = self.observed(steps, observed), whole("first", first, 0)
        arrays, lost = (arrays, None) if check else self._finite(arrays)
        numbers = core.jvp(arrays, along, seen, first, self._projection(arrays[0], lost), check)
        x, v, dx, dv = _without(lost, numbers)
        return Trajectory(x, v), Trajectory(dx, dv)

    def _projection(self, z: Array, lost: Optional[npt.NDArray[np.bool_]] = None) -> str:
        """The projection of these rows. The first call decides what ``"auto"`` is. Robots that are
        ``lost`` do not count, because their rows are not finite."""
        if not self._is_automatic or z.shape[-2:] != self.shapes["z"]:
            # Rows of another shape are left for the library to refuse.
            return self.projection
        finished = (np.isin(z, (0, 1)).all(axis=-1) & (z.sum(axis=-1) == 1)).all(axis=-1)
        if lost is not None:
            finished, lost = np.broadcast_arrays(finished, lost)
            finished = finished[~lost]
        if not finished.size:
            return "performance" if self.projection == "auto" else self.projection
        if finished.any() and not finished.all():
            raise InputError(
                "z: the batch has finished robots, whose rows are zeros and ones, and others; simulate "
                "them with two simulators"
            )
        if self.projection == "auto":
            self.projection = "layout" if finished.all() else "performance"
        if finished.all() and self.projection != "layout":
            raise InputError(
                "z: this is a finished robot, and the first robots of this simulator were design vectors; "
                'use another simulator, or choose the projection, for example Simulator(scene, "layout")'
            )
        return self.projection

    def _with_goal(
        self, arrays: list[Array], goal: Optional[Goal]
    ) -> tuple[_core.Simulator, list[Array]]:
        """The arrays with those of the goal, and the simulator that takes them."""
        if goal is None:
            return self._core, arrays
        dtype = arrays[0].dtype
        changes, points = as_goals(
            goal, self._core.goal_origin, self.dt, lambda point: _floats(["goal"], [point], dtype)[0]
        )
        core = self._core.with_changes(changes) if changes else self._core
        return core, [*arrays, ordered(points, dtype)]

    def _finite(self, arrays: list[Array]) -> tuple[list[Array], Optional[npt.NDArray[np.bool_]]]:
        """Replaces numbers that are not finite by 0. Also returns a mask of the affected robots, or
        None if there are none."""
        lost: Any = np.zeros((), np.bool_)
        kept = []
        shapes = [*self.shapes.items(), ("goal", ("goals", 2))]
        for array, (name, shape) in zip(arrays, shapes):
            finite = np.isfinite(array)
            batch = array.ndim - len(shape)
            # Other shapes and batches of different sizes are left for the library to refuse.
            if batch in (0, 1) and not finite.all():
                here = ~finite.all(axis=tuple(range(batch, array.ndim)))
                if not lost.ndim or not here.ndim or lost.shape == here.shape:
                    lost = lost | here
                array = np.where(finite, array, array.dtype.type(0))
                if name == "z":
                    # A row of zeros is not a design that every projection takes; a row of void is.
                    array[~finite.all(axis=-1)] = (1, 0, 0)
            kept.append(array)
        return kept, (lost if lost.any() else None)

    def __reduce__(self) -> tuple[type[Simulator], tuple[Scene, str, str]]:
        return Simulator, (self.scene, self.projection, self.device)

    def __repr__(self) -> str:
        device = "" if self.device == "cpu" else f", device={self.device!r}"
        return f"Simulator({self.scene!r}, projection={self.projection!r}{device})"


def _without(lost: Optional[npt.NDArray[np.bool_]], arrays: Sequence[Array]) -> Sequence[Array]:
    """Fills the arrays of the ``lost`` robots with NaN."""
    if lost is not None:
        for array in arrays:
            array[lost if lost.ndim else ...] = np.nan
    return arrays


def _prepared(inputs: Inputs, dtype: Optional[np.dtype[Any]] = None) -> list[Array]:
    """The arrays in C order, aligned and of one type. Copies only arrays that need it."""
    count = len(Inputs._fields)
    is_list = isinstance(inputs, (tuple, list))
    if not is_list or len(inputs) != count:
        found = len(inputs) if is_list else type(inputs).__name__
        raise InputError(f"expected the {count} arrays of Inputs, found {found}")
    return _floats(Inputs._fields, inputs, dtype)


def _floats(
    names: Sequence[str], given: Sequence[Any], dtype: Optional[np.dtype[Any]]
) -> list[Array]:
    """Converts arrays to one type: the given one, or single precision if all have it, or double."""
    arrays = []
    for name, array in zip(names, given):
        try:
            arrays.append(np.asarray(array))
        except ValueError as error:
            raise InputError(f"{name}: expected an array of numbers: {error}") from None
        if arrays[-1].dtype.kind not in "fiu":
            raise InputError(f"{name} is of type {arrays[-1].dtype}: expected float32 or float64")
    if dtype is None:
        single = all(array.dtype == np.float32 for array in arrays)
        dtype = np.dtype(np.float32 if single else np.float64)
    return [ordered(array, dtype) for array in arrays]


def ordered(array: npt.ArrayLike, dtype: npt.DTypeLike = np.float64) -> Array:
    """The array in C order and aligned, as the library needs it. Copies only if necessary: a field of a
    structured array may start at any byte."""
    made = np.ascontiguousarray(array, dtype)
    return made if made.flags.aligned else made.copy()
