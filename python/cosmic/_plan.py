"""Rollouts for other packages, as functions of a list of arrays: those of the robot, and the goals if they are given."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Optional

from . import _core
from ._checks import array
from ._goal import Goal, Goals, as_goals
from ._simulator import DRIVEN, Array, Inputs, Observed, Simulator, Trajectory, check_kind, leaves, tree, with_goal


@dataclass(frozen=True)
class Plan:
    """A simulator, the steps that are observed, and how. Equal rollouts have equal plans, so that JAX reuses compiled
    functions."""

    simulator: Simulator
    observed: tuple[int, ...]
    first: int
    bounded: bool
    changes: Optional[tuple[int, ...]]
    """The numbers of steps at which goals change, or None if there are no goals."""
    arrays: tuple[tuple[str, tuple[int, ...]], ...]
    """The arrays of one robot: names and shapes."""

    @property
    def states(self) -> tuple[int, ...]:
        """The shape of the positions of one robot."""
        return (len(self.observed), *self.simulator.shapes["x0"])

    @property
    def shapes(self) -> dict[str, tuple[int, ...]]:
        """The shapes of the arrays of one robot, by name."""
        return dict(self.arrays)

    @property
    def core(self) -> _core.Planned:
        """The plan for XLA, which it can run as long as this object exists. Equal plans share it."""

        def made() -> _core.Planned:
            core = self.simulator._core_for(self.shapes, self.changes)
            ranks = [(name, len(shape)) for name, shape in self.arrays if name != "first"]
            return _core.Planned(core, self.observed, self.bounded, ranks)

        return self.simulator._kept_as((self.observed, self.bounded, self.changes, self.arrays), made)

    def run(self, arrays: Sequence[Array]) -> Trajectory:
        """The rollout. A robot that diverges gets NaN."""
        inputs, goal = self._given(arrays)
        return self.simulator.rollout(
            inputs, observed=self.observed, first=self.first, check=False, goal=goal
        )

    def pull(self, arrays: Sequence[Array], bars: Trajectory, by: Sequence[str]) -> list[Array]:
        """The gradients with respect to the arrays. Those that ``by`` does not name may be 0."""
        inputs, goal = self._given(arrays)
        options: Any = {"first": self.first, "bounded": self.bounded, "check": False, "goal": goal, "by": by}
        pulled: Any = self.simulator.vjp(inputs, bars, observed=self.observed, **options)
        of_inputs, by_goal = (pulled, None) if goal is None else pulled
        named = {**leaves(of_inputs), "goal": by_goal}
        return [named[name] for name in self.shapes]

    def _given(self, arrays: Sequence[Array]) -> tuple[Inputs, Optional[Goals]]:
        named = dict(zip(self.shapes, arrays))
        points = named.pop("goal", None)
        return tree(named), None if self.changes is None else Goals(list(self.changes), points)


def planned(
    simulator: Simulator,
    inputs: Inputs,
    steps: Optional[int],
    observed: Observed,
    first: int,
    bounded: bool,
    goal: Optional[Goal],
    numbers: Callable[[Any], Any],
    of: Any,
) -> tuple[Plan, list[Any]]:
    """The plan of a rollout, and its arrays. ``numbers`` makes arrays of the module ``of`` from the parts of a goal."""
    check_kind(simulator)
    seen, first = simulator._span(steps, observed, first)
    named, changes = simulator._named(inputs), None
    if goal is not None:
        origin = simulator._core.goal_origin
        later, points = as_goals(goal, origin, simulator.dt, numbers, of)
        named, changes = with_goal(named, points), tuple(later)
    arrays = {name: array(name, own, of) for name, own in named.items()}
    if DRIVEN in arrays:
        own = arrays[DRIVEN]
        # Within the limits the derivative is 1, also at the limits.
        arrays[DRIVEN] = of.where(abs(own) > 1.0, of.clip(own, -1.0, 1.0), own)
    # A scalar factor gets an axis of length 1, so that an axis for robots in front of it is recognised.
    arrays = {
        name: own.reshape(1) if name in simulator.factors and own.ndim == 0 else own
        for name, own in arrays.items()
    }
    shapes = simulator._shapes_of(arrays, seen[-1], changes)
    return Plan(simulator, tuple(seen), first, bounded, changes, tuple(shapes.items())), list(arrays.values())
