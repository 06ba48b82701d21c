"""Rollouts and their derivatives over NumPy arrays."""

from __future__ import annotations

import math
import operator
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import Any, Literal, NamedTuple, Optional, TypeVar, Union, get_args, overload

import numpy as np
import numpy.typing as npt

from . import _core
from ._checks import array, choice, floats, whole
from ._checks import path as as_path
from ._checks import seed as as_seed
from ._core import Scene
from ._errors import InputError
from ._goal import Goal, Goals, as_goals
from ._memory import check_rollouts, check_simulator, check_start
from ._scene import SceneLike, as_scene

#: An array of floats in single or double precision.
Array = npt.NDArray[Any]
#: The steps to observe: an interval, or a list of steps.
Observed = Union[int, Sequence[int], npt.NDArray[np.integer[Any]]]
#: From positions, velocities and the time in seconds to the activations of all edges.
Policy = Callable[[Any, Any, Any], Any]


#: The projections from design vectors to mixtures of materials.
Projection = Literal["auto", "performance", "stability", "none", "layout"]
#: Where a simulator computes.
Device = Literal["cpu", "gpu"]

#: By default the number of steps with the same activations. It is also the default interval of observed states.
FRAME_SKIP = 16

_Made = TypeVar("_Made")


def _shown(arrays: Any) -> str:
    """A text that has the shapes of arrays in place of their numbers."""
    if not isinstance(arrays, Mapping):
        return str(list(np.shape(arrays)))
    return "{" + ", ".join(f"{name!r}: {_shown(own)}" for name, own in arrays.items()) + "}"


def short(of: Any) -> str:
    """The text of a named tuple of arrays, with their shapes."""
    return f"{type(of).__name__}({', '.join(f'{name}={_shown(own)}' for name, own in of._asdict().items())})"


def equal(one: Any, other: Any) -> bool:
    """True if arrays have equal numbers, or dictionaries and tuples of arrays do."""
    if isinstance(one, Mapping):
        return isinstance(other, Mapping) and one.keys() == other.keys() and all(equal(one[k], other[k]) for k in one)
    if isinstance(one, tuple):
        return isinstance(other, tuple) and len(one) == len(other) and all(map(equal, one, other))
    return bool(np.array_equal(one, other))


class Inputs(NamedTuple):
    """All arrays that a rollout depends on, and with respect to which it can be differentiated.

    For several robots, an array has one more axis in front; all robots share an array without it. Positions and velocities
    have ``D`` components: 2 (along and above), or 3 in space (along, across and above).
    For JAX, a named tuple and a dictionary are trees of arrays.
    """

    z: Array
    """Design vectors, shape ``(edges, 3)``: void, skeleton, actuator."""
    controller: Mapping[str, Array]
    """The blocks of the controller's parameters by name, as in ``design.json``. The policy ``mlp`` has ``w1``,
    ``b1``, ``w2`` and ``b2``: ``tanh(w2 tanh(w1 o + b1) + b2)`` for an observation ``o``.

    A robot without a controller has the single block ``activations``, of shape ``(steps, edges)``, or ``(1, edges)`` if
    they stay constant: a number from
    -1 to 1 for every step of the rollout and every edge. Edges without actuator ignore their numbers."""
    x0: Array
    """Initial positions, ``(nodes, D)``, m."""
    v0: Array
    """Initial velocities, ``(nodes, D)``, m/s."""
    physics: Mapping[str, Array] = {}
    """Numbers that replace those of the scene, by the names in :attr:`Simulator.physics`. Numbers whose name is a key
    of the scene, such as ``"physics.gravity"``, are scalars. The factors ``"bars.stiffness"``, ``"bars.strain"``,
    ``"bars.rest_length"`` and ``"nodes.mass"`` multiply the numbers of the lattice and the design: one factor for all edges or
    nodes, or one for each."""

    def replace(self, **arrays: Any) -> Inputs:
        """A copy with other ``z``, ``controller``, ``x0``, ``v0`` or ``physics``."""
        for name in arrays:
            if name not in self._fields:
                raise InputError(f"replace: {name!r}: allowed: {', '.join(self._fields)}")
        return self._replace(**arrays)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Inputs) and equal(tuple(self), tuple(other))

    def __ne__(self, other: object) -> bool:
        return not self == other

    def __repr__(self) -> str:
        return short(self)


class Trajectory(NamedTuple):
    """States of a rollout, with one more axis in front for several robots."""

    x: Array
    """Positions, shape ``(states, nodes, D)``, m."""
    v: Array
    """Velocities, ``(states, nodes, D)``, m/s."""

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Trajectory) and equal(tuple(self), tuple(other))

    def __ne__(self, other: object) -> bool:
        return not self == other

    def __repr__(self) -> str:
        return short(self)


def leaves(inputs: Inputs) -> dict[str, Any]:
    """The arrays of a robot by name, in the order in which the library takes them: ``z``, the blocks of the
    controller, ``x0``, ``v0``, given activations, and the physics."""
    if not isinstance(inputs, (tuple, list)) or len(inputs) not in (4, 5):
        found = f"{len(inputs)} things" if isinstance(inputs, (tuple, list)) else type(inputs).__name__
        raise InputError(f"expected Inputs: z, controller, x0, v0 and perhaps physics; found {found}")
    z, controller, x0, v0, physics = Inputs(*inputs)
    for name, blocks in (("controller", controller), ("physics", physics)):
        if not isinstance(blocks, Mapping):
            raise InputError(f"{name}: expected a dictionary of arrays, found {type(blocks).__name__}")
    blocks = dict(controller)
    driven = {DRIVEN: blocks.pop(DRIVEN)} if DRIVEN in blocks else {}
    unknown = [name for name in physics if not isinstance(name, str) or "." not in name]
    if unknown:
        raise InputError(f"physics: {unknown[0]!r}: expected a name of Simulator.physics, such as 'physics.gravity'")
    return {"z": z, **blocks, "x0": x0, "v0": v0, **driven, **physics}


def tree(arrays: Mapping[str, Any]) -> Inputs:
    """The inverse of :func:`leaves`. Only the names of physics have a dot."""
    physics = {name: array for name, array in arrays.items() if "." in name}
    blocks = {name: array for name, array in arrays.items() if "." not in name}
    z, x0, v0 = (blocks.pop(name) for name in ("z", "x0", "v0"))
    return Inputs(z, blocks, x0, v0, physics)


#: The name of given activations, which take the place of a controller's blocks.
DRIVEN = "activations"


def split(numbers: Array, shapes: Mapping[str, tuple[int, ...]]) -> dict[str, Array]:
    """The arrays of these shapes whose numbers are in the last axis, by name."""
    arrays, begin, batch = {}, 0, numbers.shape[:-1]
    for name, shape in shapes.items():
        end = begin + math.prod(shape)
        arrays[name] = numbers[..., begin:end].reshape(batch + shape)
        begin = end
    return arrays


class _Robots(NamedTuple):
    """Robots as the library takes them."""

    core: _core.Simulator
    shapes: dict[str, tuple[int, ...]]
    """The arrays by name, with their shapes for one robot."""
    arrays: list[Array]
    """The arrays, with an axis of robots in front."""
    batch: Optional[int]
    """The number of robots; None for a single robot, whose arrays had no axis of robots."""

    def results(self, *arrays: Array) -> list[Array]:
        """Removes the axis of a single robot."""
        return [array[0] if self.batch is None else array for array in arrays]


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

    def __init__(self, scene: SceneLike, projection: Projection = "auto", device: Device = "cpu") -> None:
        self.scene: Scene = as_scene(scene)
        choice("projection", projection, get_args(Projection))
        choice("device", device, get_args(Device))
        self.device: Device = device
        self._sizes = self.scene.sizes
        check_simulator(self._sizes)
        self._core = _core.Simulator(self.scene, device == "gpu", projection)
        self._given_projection: Projection = projection
        self._kept: dict[Any, Any] = {}
        self._design: Optional[Array] = None
        self.dt: float = self._core.dt
        """Length of a step, s."""
        self.steps: int = self._core.steps
        """The number of steps of a whole rollout."""
        self.shapes: dict[str, tuple[int, ...]] = {
            name: tuple(shape) for name, shape in self._core.shapes
        }
        """The shapes of the arrays of a robot: ``z``, the blocks of the controller, ``x0``, ``v0``."""
        physics = self._core.physics
        self.physics: Mapping[str, float] = MappingProxyType({name: value for name, value, _ in physics})
        """The numbers that :attr:`Inputs.physics` may change, by name, with their values in the scene. All of these numbers have
        derivatives. With the integrator ``leapfrog``, ``physics.damping`` is not among them. The heights of the
        ground and the time step never are: use a simulator of another scene."""
        self.factors: dict[str, int] = {name: count for name, _, count in physics if count}
        """The numbers of physics that are factors, with the number of edges or nodes."""
        self.edges: npt.NDArray[np.int64] = self._core.edges
        """The two nodes of every edge, shape ``(edges, 2)``."""
        self.rest_length: npt.NDArray[np.float64] = np.array(self._core.rest_length)
        """Rest length of every edge, m."""
        self.payload: int = self._core.payload
        """The node of the payload, whose displacement counts. It need not be node 0."""
        self.along: npt.NDArray[np.float64] = np.array(self._core.along)
        """The unit vector along the ground, in which distances are measured."""
        for own in (self.edges, self.rest_length, self.along):
            own.flags.writeable = False

    @property
    def projection(self) -> str:
        """How rows of ``z`` become a robot; ``"auto"`` until the first robot decides."""
        return self._core.projection

    def initial(self, seed: int = 0) -> Inputs:
        """The inputs that an optimisation with this seed starts with."""
        check_start(self._sizes, 3)
        return tree(split(self._core.initial(as_seed(seed))[0], self.shapes))

    def ground(self, x: npt.ArrayLike) -> npt.NDArray[np.float64]:
        """The heights of the ground in the world's frame at the places ``x``, such as ``seen.x[..., 0]``, m. At a wall, it is the
        height of its foot."""
        places = floats("x", x).astype(np.float64)
        cos, sin = self.along[0], self.along[-1]
        corners = np.array(self._core.terrain or [[0.0, 0.0]])
        # The ground ends as a line in both directions. It reaches beyond all places, also where an incline is steep.
        far = (np.abs(places[np.isfinite(places)]).max(initial=0.0) + np.abs(corners).max() + 1.0) / cos
        ends = corners[0] - [2.0 * far, 0.0], corners[-1] + [2.0 * far, 0.0]
        line = np.array([ends[0], *corners, ends[1]]) @ [[cos, sin], [-sin, cos]]
        lowest = np.full(places.shape, np.inf)
        for one, other in zip(line, line[1:]):
            (left, at_left), (right, at_right) = sorted((tuple(one), tuple(other)))
            share = (places - left) / (right - left) if right > left else 0.0
            height = at_left + share * (at_right - at_left)
            is_on = (left <= places) & (places <= right)
            lowest = np.where(is_on, np.minimum(lowest, height), lowest)
        return np.where(np.isfinite(places), lowest, np.nan)

    def layout(self, z: npt.ArrayLike) -> npt.NDArray[np.float64]:
        """The finished robots to which an optimisation would snap the design vectors ``z``, of shape ``(edges, 3)`` or
        ``(batch, edges, 3)``. The result has the same shape, and its rows are one-hot.

        Every edge gets the material of its largest number. Then edges change until the robot obeys the scene's
        ``[design]``, such as ``one_piece``, and the bounds of ``[volume]``, each wider by 0.03. Edges whose numbers differ
        least change first; of equal ones the edge with the smallest index. So
        numbers drawn uniformly from 0 to 1 give a random robot, and ``0.5 * layout`` plus such numbers times 0.5 a
        relative of a robot."""
        given = floats("z", z)
        robots = batch_of("z", given, self.shapes["z"])
        if not np.isfinite(given).all():
            raise InputError("z: expected finite numbers")
        snapped = self._core.layouts(ordered(given if robots else given[None]))
        return snapped if robots else snapped[0]

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
        if any(a >= b for a, b in zip(listed, listed[1:])):
            raise InputError(f"observed: expected steps that ascend, found {listed}")
        return listed

    def _span(
        self, steps: Optional[int] = None, observed: Observed = 16, first: int = 0
    ) -> tuple[list[int], int]:
        """The numbers of the observed steps, and ``first``. Raises :class:`InputError` if a rollout of the
        scene lacks these steps."""
        listed, first = self.observed(steps, observed), whole("first", first, 0)
        if first + listed[-1] > self.steps:
            raise InputError(
                f"step {first + listed[-1]} is beyond the scene's last step, {self.steps}; increase physics.steps"
            )
        return listed, first

    def rollout(
        self,
        inputs: Inputs,
        steps: Optional[int] = None,
        observed: Observed = 16,
        *,
        first: int = 0,
        check: bool = True,
        goal: Optional[Goal] = None,
        policy: Optional[Policy] = None,
        frame_skip: int = FRAME_SKIP,
    ) -> Trajectory:
        """Simulates one robot or several from their starts.

        ``policy`` takes the place of the controller in ``inputs``. It is a function ``policy(x, v, time)`` of the positions and
        velocities of all robots and of the seconds since the scene's start. It returns activations from -1 to 1, of shape
        ``(edges,)`` or ``(batch, edges)``, which are held for ``frame_skip`` steps. All observed steps must be multiples of
        ``frame_skip``.

        ``goal`` is where the robot should go, in a scene with ``controller.goals = "given"``; by default
        ``controller.goal``. It is a distance along the ground in metres, positive ahead, or a pair
        ``(along, above)``, in space ``(along, across)`` or ``(along, across, above)``. All count from the payload in the
        scene's start, like ``[goals]`` of a scene and ``cosmic walk --goal``. An array of shape ``(batch, 1)`` or
        ``(batch, 2)``, in space also ``(batch, 3)``, has a goal for each robot. A list of pairs ``(seconds, goal)`` is a goal that changes at these times of the clock; the
        first time is 0.

        ``first`` is the number of earlier steps, for a rollout that continues another one. A rollout
        that diverges raises :class:`DivergedError` with the place and the reason. With
        ``check=False`` its states are NaN from the first state that is not finite or is beyond 1e6
        m or 1e6 m/s. If the inputs of a robot are not finite, all its states are NaN.

        Ctrl-C stops a batch after the current robots, and on a GPU after all robots. The attribute
        ``trajectory`` of the ``KeyboardInterrupt`` has the states of the finished robots, and NaN for the
        others.
        """
        if policy is not None:
            of = (self.rollout, self, inputs, steps, observed, first, policy, frame_skip, goal, np)
            return with_policy(*of, check=check)
        seen, first = self._span(steps, observed, first)
        robots = self._robots(inputs, seen, goal, check)
        try:
            states = robots.core.rollout(robots.arrays, seen, first, check)
        except KeyboardInterrupt as stopped:
            finished = getattr(stopped, "trajectory", None)
            if finished is not None:
                setattr(stopped, "trajectory", Trajectory(*finished))
            raise
        return Trajectory(*robots.results(*states))

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
        by: Optional[Iterable[str]] = None,
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
        by: Optional[Iterable[str]] = None,
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
        by: Optional[Iterable[str]] = None,
    ) -> Union[Inputs, tuple[Inputs, Array]]:
        """The vector-Jacobian product of :meth:`rollout`: the gradient of the sum of states times
        cotangents with respect to every input. Each robot of a batch has its own gradient, also
        with respect to shared inputs.

        If ``goal`` is given, it is as in :meth:`rollout`, and the result is a pair: the gradient with
        respect to the inputs, and the gradient with respect to the goal along the ground and above it, of
        shape ``(goals, 2)`` with one row per goal, or ``(batch, goals, 2)``; in space with three numbers in a row.

        ``by`` names the arrays whose gradients are computed, such as ``("activations", "x0")``; other gradients may be 0.
        This saves time in short rollouts.

        ``bounded`` limits cotangents to the scene's ``gradient.cotangent_bound``. Long rollouts
        with contacts need this for useful gradients; without it the gradient is exact. On a GPU, the
        cotangents of step 0 are added after the bound. For ``check`` see :meth:`rollout`. With ``check=False`` the gradient of a robot that diverges is
        NaN.
        """
        seen, first = self._span(steps, observed, first)
        robots = self._robots(inputs, seen, goal, check, steps=seen[-1])
        if not isinstance(cotangents, (tuple, list)) or len(cotangents) != 2:
            found = len(cotangents) if isinstance(cotangents, (tuple, list)) else type(cotangents).__name__
            raise InputError(f"cotangents: expected the 2 arrays of Trajectory, found {found}")
        dtype = robots.arrays[0].dtype
        x_bar, v_bar = (ordered(floats(*bar), dtype) for bar in zip(("x_bar", "v_bar"), cotangents))
        batch = () if robots.batch is None else (robots.batch,)
        expected = (*batch, len(seen), *self.shapes["x0"])
        for name, bar in (("x_bar", x_bar), ("v_bar", v_bar)):
            if bar.shape != expected:
                raise InputError(f"{name}: expected the shape {list(expected)}, found {list(bar.shape)}")
        bits = wanted(by, robots.shapes)
        (gradient,) = robots.results(
            robots.core.vjp(robots.arrays, x_bar, v_bar, seen, first, bounded, check, bits)
        )
        arrays = split(gradient, robots.shapes)
        by_goal = arrays.pop("goal", None)
        return tree(arrays) if by_goal is None else (tree(arrays), by_goal)

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
        seen, first = self._span(steps, observed, first)
        goals = None if goal is None else self._goals(goal)
        robots = self._robots(inputs, seen, goals, check, copies=4)
        still = None if goals is None else Goals(goals.changes, np.zeros(robots.shapes["goal"]))
        along = self._robots(tangents, seen, still, dtype=robots.arrays[0].dtype, copies=4)
        if along.shapes != robots.shapes:
            raise InputError(
                f"tangents: expected the arrays {', '.join(robots.shapes)}, found {', '.join(along.shapes)}"
            )
        if along.batch not in (None, robots.batch):
            raise InputError("tangents: inputs and tangents must have the same batch size")
        (numbers,) = robots.results(robots.core.jvp(robots.arrays, along.arrays, seen, first, check))
        states = numbers.reshape(*numbers.shape[:-1], 4, len(seen), *self.shapes["x0"])
        x, v, dx, dv = (states[..., k, :, :, :] for k in range(4))
        return Trajectory(x, v), Trajectory(dx, dv)

    def step(
        self,
        z: Array,
        x: Array,
        v: Array,
        activations: Array,
        steps: int = 1,
        *,
        first: int = 0,
        physics: Mapping[str, Array] = {},
        check: bool = True,
    ) -> Trajectory:
        """Simulates ``steps`` steps with constant activations, of shape ``(edges,)`` or ``(batch, edges)``, from the
        positions ``x`` and velocities ``v``. Returns the positions and velocities afterwards, without an axis of
        states. Everything else is as in :meth:`rollout`."""
        return stepped(self.rollout, z, x, v, activations, steps, physics, np, first=first, check=check)

    def animate(
        self,
        trajectory: Trajectory,
        path: Union[str, os.PathLike[str]],
        z: Optional[npt.ArrayLike] = None,
        steps: Optional[int] = None,
        observed: Observed = 16,
    ) -> Path:
        """Writes any motion of one robot as an animated GIF, and returns its path. ``steps`` and ``observed`` are those of the
        rollout. ``z`` is the design, such as ``inputs.z``; a simulator of :meth:`Run.simulator` knows that of its run."""
        file, given = as_path("path", path), self._design if z is None else z
        if file.suffix.lower() != ".gif":
            raise InputError(f"path: {os.fspath(file)!r}: expected a name that ends in .gif")
        if given is None:
            raise InputError("z: expected the design of the robot, such as inputs.z")
        x, design = floats("trajectory", trajectory[0]), floats("z", given)
        for name, own, shape in (("z", design, self.shapes["z"]), ("trajectory", x, (*x.shape[:1], *self.shapes["x0"]))):
            if own.shape != shape or not len(own):
                raise InputError(f"{name}: expected the shape {list(shape)} for one robot, found {list(own.shape)}")
            if not np.isfinite(own).all():
                raise InputError(f"{name}: expected finite numbers; a robot that diverged has finite states before that")
        seen = self.observed(steps, observed)
        if steps is None and isinstance(observed, (int, np.integer)) and len(seen) != len(x):
            seen = [int(observed) * k for k in range(len(x))]
        if len(seen) != len(x):
            raise InputError(f"trajectory: {len(x)} states, but `steps` and `observed` are those of {len(seen)} states")
        _core.animate(self._core, file, ordered(design), seen, ordered(x))
        return file

    def _robots(
        self,
        inputs: Inputs,
        seen: Sequence[int],
        goal: Optional[Goal] = None,
        check: bool = True,
        dtype: Optional[np.dtype[Any]] = None,
        copies: int = 1,
        steps: Optional[int] = None,
    ) -> _Robots:
        """Checks the arrays of robots and how much memory a rollout needs, and gives each array an axis of
        robots."""
        given = self._named(inputs)
        named = {name: floats(name, own) for name, own in given.items()}
        if dtype is None:
            check_activations(named)
            # Python's numbers do not decide, as in NumPy and JAX.
            dtype = _precision(named[name] for name, own in given.items() if not isinstance(own, (int, float)))
        changes: Optional[list[int]] = None
        if goal is not None:
            changes, points = self._goals(goal)
            named = with_goal(named, points)
        shapes = self._shapes_of(named, seen[-1], changes)
        core = self._core_for(shapes, changes)
        counts = {name: batch_of(name, array, shapes[name]) for name, array in named.items()}
        batched = [(name, count) for name, count in counts.items() if count is not None]
        for (name, count), (other, of_other) in zip(batched[1:], batched):
            if count != of_other:
                raise InputError(f"{name}: {count} robots, but {other} has {of_other}")
        robots = batched[0][1] if batched else 1
        more = sum(math.prod(shape) for name, shape in shapes.items() if name not in self.shapes)
        check_rollouts(self._sizes, robots, dtype.itemsize, len(seen), copies, steps, more)
        for name, array in named.items() if check else ():
            lost = np.argwhere(~np.isfinite(array))
            if len(lost):
                place = lost[0].tolist()
                raise InputError(f"{name}{place or ''} is {array[tuple(place)]}: expected finite numbers")
        arrays = [ordered(array if counts[name] else array[None], dtype) for name, array in named.items()]
        return _Robots(core, shapes, arrays, robots if batched else None)

    def _goals(self, goal: Goal) -> Goals:
        """The goals of an argument."""
        return as_goals(goal, self._core.goal_origin, self.dt, partial(floats, "goal"))

    def _named(self, inputs: Inputs) -> dict[str, Any]:
        """The arrays of a robot by name. Raises :class:`InputError` if one is missing or unknown."""
        named = leaves(inputs)
        own = [name for name in self.shapes if name not in ("z", "x0", "v0")]
        blocks = [DRIVEN] if DRIVEN in named else own
        found = [name for name in inputs[1]]
        if sorted(found) != sorted(blocks):
            raise InputError(
                f"controller: expected the blocks {', '.join(own)}, or only {DRIVEN}; found {', '.join(found)}"
            )
        for name in named:
            if "." in name and name not in self.physics:
                raise InputError(f"physics: {name!r}: allowed: {', '.join(self.physics)}")
        order = [name for name in self.shapes if name in named]
        return {**{name: named[name] for name in order}, **named}

    def _shapes_of(
        self, named: Mapping[str, Any], steps: int, changes: Optional[Sequence[int]] = None
    ) -> dict[str, tuple[int, ...]]:
        """The shapes of these arrays for one robot and a rollout with this number of steps. The arrays may have an axis of
        robots in front."""
        goals = 0 if changes is None else 1 + len(changes)
        known = {**self.shapes, "goal": (goals, self.shapes["x0"][1])}
        if DRIVEN in named:
            held = named[DRIVEN].ndim > 1 and named[DRIVEN].shape[-2] == 1
            known[DRIVEN] = (1 if held else steps, len(self.edges))
        return {name: known[name] if name in known else self._factor(name, array) for name, array in named.items()}

    def _factor(self, name: str, array: Any) -> tuple[int, ...]:
        """The shape of an array of the physics for one robot."""
        count = self.factors.get(name)
        if count is None or array.ndim == 0:
            return ()
        if array.ndim > 2 or array.shape[-1] not in (1, count):
            raise InputError(
                f"{name}: expected one factor or [{count}]; for several robots (batch, 1) or (batch, {count}); "
                f"found {list(array.shape)}"
            )
        return (1,) if array.shape[-1] == 1 else (count,)

    def _core_for(
        self, shapes: Mapping[str, tuple[int, ...]], changes: Optional[Sequence[int]]
    ) -> _core.Simulator:
        """The simulator of the library for arrays of these shapes."""
        physics = [(name, math.prod(shape)) for name, shape in shapes.items() if "." in name]
        driven = shapes[DRIVEN][0] if DRIVEN in shapes else None
        if driven is None and changes is None and not physics:
            return self._core
        if driven is not None and self.device == "gpu":
            raise InputError(f'{DRIVEN}: not on a GPU; use a Simulator with device="cpu"')
        goals = None if changes is None else list(changes)
        key = (driven, None if goals is None else tuple(goals), tuple(physics))
        return self._kept_as(key, lambda: self._core.with_others(driven, goals, physics))

    def _kept_as(self, key: Any, make: Callable[[], _Made]) -> _Made:
        """What ``make`` made for this key. Only the newest 32 objects are kept."""
        made: _Made = self._kept.get(key) or make()
        self._kept[key] = made
        for old in list(self._kept)[:-32]:
            self._kept.pop(old, None)
        return made

    def __reduce__(self) -> tuple[Callable[..., Simulator], tuple[Any, ...]]:
        return _restored, (self.scene, self._given_projection, self.device, self.projection, self._design)

    def __repr__(self) -> str:
        device = "" if self.device == "cpu" else f", device={self.device!r}"
        return f"Simulator({self.scene!r}, projection={self.projection!r}{device})"


def _restored(scene: Scene, given: Projection, device: Device, projection: str, design: Any) -> Simulator:
    """A copy of a simulator whose projection may already be decided."""
    made = Simulator(scene, given, device)
    made._design = design
    if projection != "auto":
        made._core.decide(projection)
    return made


def check_activations(named: Mapping[str, Array]) -> None:
    """Checks that given activations are from -1 to 1."""
    beyond = np.argwhere(np.abs(named.get(DRIVEN, 0.0)) > 1.0)
    if len(beyond):
        place = beyond[0].tolist()
        raise InputError(
            f"{DRIVEN}{place} is {named[DRIVEN][tuple(place)]}: expected numbers from -1 to 1; np.clip or np.tanh makes such"
        )


#: The bits of the argument ``by`` of ``_core.Simulator.vjp``.
_BITS = {name: 1 << k for k, name in enumerate(_core.GRADIENTS)}
#: The bits of all arrays.
EVERY = sum(_BITS.values())


def wanted(by: Optional[Iterable[str]], shapes: Mapping[str, tuple[int, ...]]) -> int:
    """The bits of the arrays whose gradients are to be computed: those in ``by``, or all if it is None."""
    if by is None:
        return EVERY
    if isinstance(by, str) or not isinstance(by, Iterable):
        raise InputError(f"by: expected a list of names, found {by!r}")
    bits = 0
    for name in by:
        if not isinstance(name, str) or name not in shapes:
            raise InputError(f"by: {name!r}: allowed: {', '.join(shapes)}")
        is_other = "." in name or name in (DRIVEN, "goal")
        bits |= _BITS.get(name, _BITS["others" if is_other else "controller"])
    return bits


def with_goal(named: Mapping[str, Any], goal: Any) -> dict[str, Any]:
    """These arrays with the goals, which come before the physics."""
    physics = {name: array for name, array in named.items() if "." in name}
    return {**{name: named[name] for name in named if name not in physics}, "goal": goal, **physics}


def stepped(
    rollout: Any, z: Any, x: Any, v: Any, activations: Any, steps: int, physics: Any, of: Any, **options: Any
) -> Trajectory:
    """Steps with constant activations by a function like :meth:`Simulator.rollout`, with arrays of the module ``of``."""
    held = array("activations", activations, of)
    if held.ndim not in (1, 2):
        raise InputError(
            f"activations: expected the shape (edges,), or (batch, edges) for several robots, found {list(held.shape)}"
        )
    held, steps = held[..., None, :], whole("steps", steps, 1)
    seen = rollout(Inputs(z, {DRIVEN: held}, x, v, physics), observed=[steps], **options)
    return Trajectory(*(states[..., 0, :, :] for states in seen))


def check_kind(simulator: Any) -> None:
    """Checks an argument that is a simulator."""
    if not isinstance(simulator, Simulator):
        raise InputError(f"simulator: expected a cosmic.Simulator, found {type(simulator).__name__}")


def with_policy(
    rollout: Any,
    simulator: Simulator,
    inputs: Inputs,
    steps: Optional[int],
    observed: Observed,
    first: Any,
    policy: Policy,
    frame_skip: int,
    goal: Optional[Goal],
    of: Any,
    loop: Optional[Callable[..., Sequence[Any]]] = None,
    **options: Any,
) -> Trajectory:
    """A rollout with a policy, by a function like :meth:`Simulator.rollout`, with arrays of the module ``of``."""
    check_kind(simulator)
    if not callable(policy):
        raise InputError(f"policy: {policy!r}: expected a function of x, v and time")
    if goal is not None:
        raise InputError("goal: a rollout with a policy has no goal; let the policy know the goal")
    leaves(inputs)
    z, _, x0, v0, physics = Inputs(*inputs)
    # The number of earlier steps may be a counter of JAX.
    known = int(first) if isinstance(first, (int, np.integer)) else 0
    length, (seen, _) = whole("frame_skip", frame_skip, 1), simulator._span(steps, observed, known)
    for step in seen:
        if step % length:
            raise InputError(
                f"frame_skip: {frame_skip}: the numbers of all observed steps must be multiples of it, and step {step} is "
                "observed; change frame_skip, steps or observed"
            )

    def frame(state: Trajectory, number: Any) -> Trajectory:
        begin = first + number * length
        held = policy(*state, begin * simulator.dt)
        return stepped(rollout, z, *state, held, length, physics, of, first=begin, **options)

    # A policy gets the states of all robots, also if the robots share their start.
    batches = [np.shape(own)[:-2] for own in (z, x0, v0)]
    batches += [np.shape(own)[: max(0, np.ndim(own) - (name in simulator.factors))] for name, own in physics.items()]
    batch, state = max(batches, key=len), (array("x0", x0, of), array("v0", v0, of))
    start = Trajectory(*(own if own.ndim != 2 else of.broadcast_to(own, (*batch, *own.shape)) for own in state))
    states = (loop or _loop)(frame, start, seen[-1] // length, of)
    return Trajectory(*(own[..., np.array(seen) // length, :, :] for own in states))


def _loop(frame: Callable[[Trajectory, int], Trajectory], start: Trajectory, frames: int, of: Any) -> list[Any]:
    """Positions and velocities at the start and after each frame."""
    states = [start]
    for number in range(frames):
        states.append(frame(states[-1], number))
    # A policy may return activations of several robots for one.
    shape = states[-1].x.shape
    return [of.stack([of.broadcast_to(own, shape) for own in each], -3) for each in zip(*states)]


def batch_of(name: str, array: Array, shape: tuple[int, ...]) -> Optional[int]:
    """The number of robots of an array, or None if it has no axis of robots."""
    if array.shape == shape:
        return None
    if array.ndim == 0 or array.shape[1:] != shape:
        raise InputError(
            f"{name}: expected the shape {list(shape)}, or (batch, {', '.join(map(str, shape))}) for several "
            f"robots, found {list(array.shape)}"
        )
    if array.shape[0] == 0:
        raise InputError(f"{name}: the batch has no robots; expected one or more")
    return int(array.shape[0])


def _precision(arrays: Iterable[Array]) -> np.dtype[Any]:
    """Single precision if all arrays have it, otherwise double."""
    single = all(array.dtype == np.float32 for array in arrays)
    return np.dtype(np.float32 if single else np.float64)


def ordered(array: npt.ArrayLike, dtype: npt.DTypeLike = np.float64) -> Array:
    """The array in C order and aligned, as the library needs it. Copies only if necessary: a field of a
    structured array may start at any byte."""
    made = np.ascontiguousarray(array, dtype)
    return made if made.flags.aligned else made.copy()
