"""Gymnasium environments in which a policy controls robots of one lattice.

>>> import cosmic.gym, gymnasium
>>> env = gymnasium.make("cosmic/Walk-v0", robot="three_legged")
>>> many = gymnasium.make_vec("cosmic/Walk-v0", 64, robot="three_legged")
>>> env.action_space.shape, many.observation_space.shape
((28,), (64, 156))
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Literal, Optional, Union

import numpy as np
import numpy.typing as npt

from . import _core
from ._errors import InputError, extra
from ._goal import Goals, as_goals
from ._run import Run
from ._scene import SceneLike
from ._checks import array, choice, floats, real, whole
from ._simulator import FRAME_SKIP, Simulator, batch_of, ordered

with extra("gym"):
    import gymnasium
    from gymnasium import spaces
    from gymnasium.utils import seeding
    from gymnasium.vector import AutoresetMode, VectorEnv
    from gymnasium.vector.utils import batch_space

__all__ = ["WalkEnv", "WalkVectorEnv"]


def __dir__() -> list[str]:
    return __all__


#: The kinds of observations, each with its bound and its type of numbers. Scaled observations are clipped. Those of the
#: paper keep to their bound: beyond 1e6 m or m/s a robot counts as diverged, and goals are at most 1e6 m away. An offset
#: from the mean is then at most 2e6 m, rotated to a slope at most 3e6 m. Scales are at most 1e6.
_OBSERVATIONS: dict[str, tuple[float, type[np.floating[Any]]]] = {
    "scaled": (10.0, np.float32),
    "paper": (1e13, np.float64),
}

#: The kinds of observations.
Observation = Literal["scaled", "paper"]

#: The terms of a reward.
_TERMS = ("distance", "goal", "energy", "upright")

_Floats = npt.NDArray[np.float64]
#: Numbers of the physics, as in :attr:`cosmic.Inputs.physics`, or a function that draws them for a robot.
Physics = Union[Mapping[str, Any], Callable[[np.random.Generator], Mapping[str, Any]]]
#: Observations, in single precision, or in double precision as in the paper.
_Seen = npt.NDArray[Any]


class _Walk:
    """The robots of an environment: the part that both environments share."""

    def __init__(
        self,
        robot: Union[Run, SceneLike],
        z: Optional[npt.ArrayLike],
        robots: int,
        frame_skip: int,
        scatter: float,
        observation: Observation,
        reward: Optional[Mapping[str, float]],
        physics: Optional[Physics],
    ) -> None:
        choice("observation", observation, list(_OBSERVATIONS))
        self.observation = observation
        self.sim = Simulator(robot.scene if isinstance(robot, Run) else robot)
        first = self.sim.initial()
        if z is None:
            z = robot.design.z if isinstance(robot, Run) else first.z
        given, shape = ordered(floats("z", z)), self.sim.shapes["z"]
        if given.shape not in (shape, (robots, *shape)) or not np.isfinite(given).all():
            expected = f"{list(shape)}, or {[robots, *shape]} for a design of each robot"
            raise InputError(f"z: expected the shape {expected}, and finite numbers, found {list(given.shape)}")
        self.z = given.reshape(-1, *shape)
        self.draw = physics if callable(physics) else None
        self.physics = [{}] * robots if self.draw else self.physics_of({} if physics is None else physics, robots)
        self.core = self.driven(robots)
        self.weight = np.array(self.core.presence)[..., None]
        if not self.core.actuators:
            raise InputError("the design has no actuator, so actions would have no effect; choose another design")
        self.frame_skip = whole("frame_skip", frame_skip, 1, self.sim.steps)
        self.scatter = real("scatter", scatter, 0.0, " m")
        self.seconds = self.frame_skip * self.sim.dt
        self.origin = self.sim._core.goal_origin
        self.reward = self.weights(reward)
        self.rest = first.x0
        self.x = np.repeat(self.rest[None], robots, axis=0)
        self.v = np.zeros_like(self.x)
        self.done = np.zeros(robots, np.int64)
        self.goals: list[Optional[Goals]] = [None] * robots
        self.action_space = spaces.Box(-1.0, 1.0, (len(self.core.actuators),), np.float32)
        self.bound, kind = _OBSERVATIONS[observation]
        self.observation_space = spaces.Box(-self.bound, self.bound, (self.core.inputs,), kind)

    def driven(self, robots: int) -> _core.Driven:
        made = _core.Driven(self.sim._core, self.z, robots, self.observation == "scaled")
        for robot, own in enumerate(self.physics):
            if own:
                made.vary(robot, list(own.items()))
        return made

    def physics_of(self, physics: Any, robots: int) -> list[dict[str, list[float]]]:
        """The numbers of the physics of each robot, with the shapes of :attr:`cosmic.Inputs.physics`."""
        if not isinstance(physics, Mapping):
            raise InputError(f"physics: {physics!r}: expected a dictionary of numbers, or a function that returns one")
        each: list[dict[str, list[float]]] = [{} for _ in range(robots)]
        for name, value in physics.items():
            if name not in self.sim.physics:
                raise InputError(f"physics: {name!r}: allowed: {', '.join(self.sim.physics)}")
            numbers = floats(name, value).astype(np.float64)
            count = batch_of(name, numbers, self.sim._factor(name, numbers))
            if count not in (None, robots) or not np.isfinite(numbers).all():
                raise InputError(f"{name}: expected finite numbers, for all robots or for {robots}, found {value!r}")
            for robot, own in enumerate(each):
                own[name] = np.atleast_1d(numbers if count is None else numbers[robot]).tolist()
        return each

    def weights(self, reward: Optional[Mapping[str, float]]) -> dict[str, float]:
        """The weights of the terms of a reward. Raises :class:`InputError` if the scene lacks a term."""
        terms = [term for term in _TERMS if term != "goal" or self.origin is not None]
        if reward is None:
            return {"distance" if self.origin is None else "goal": 1.0}
        if not isinstance(reward, Mapping) or not reward or not all(term in terms for term in reward):
            allowed = ", ".join(map(repr, terms))
            given = "" if "goal" in terms else " ('goal' needs a scene with given goals)"
            raise InputError(f"reward: {reward!r}: expected weights of the terms {allowed}{given}")
        return {term: real(f"reward[{term!r}]", weight, -np.inf) for term, weight in reward.items()}

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in self.__dict__.items() if name != "core"}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self.core = self.driven(len(self.done))

    @property
    def frames_per_second(self) -> int:
        """The frame rate of a video, rounded to a whole number of 1 or more, as video players need."""
        return max(1, round(1.0 / self.seconds))

    def picture(self, seen: list[_Floats], robot: int = 0) -> Any:
        """Draws a robot in the last of the states ``seen``, which are its positions at the start and
        after each frame."""
        steps = [min(k * self.frame_skip, self.sim.steps) for k in range(len(seen))]
        return self.core.picture(robot, steps, np.array(seen))

    def begin(
        self, robot: int, random: np.random.Generator, goals: Optional[Goals] = None
    ) -> None:
        """Resets a robot to its start, with small random changes of all coordinates. Without ``goals``, they
        are drawn if the scene has given goals."""
        moved = random.uniform(-self.scatter, self.scatter, self.rest.shape)
        self.x[robot] = self.rest + moved
        self.v[robot] = 0.0
        self.done[robot] = 0
        if self.origin is not None and goals is None:
            goals = Goals(*self.core.draw_goals(int(random.integers(2**63))))
        self.goals[robot] = goals
        if self.draw is not None:
            [self.physics[robot]] = self.physics_of(self.draw(random), 1)
            self.core.vary(robot, list(self.physics[robot].items()))

    def goals_of(self, options: Optional[dict[str, Any]], *others: str) -> list[Optional[Goals]]:
        """The goals that the options of a reset give to each robot. There may be ``others`` among the options."""
        robots = len(self.done)
        if not isinstance(options, (dict, type(None))):
            raise InputError(f"options: {options!r}: expected a dictionary, such as {{'goal': 1.0}}")
        allowed = ("goal", *others)
        for name in options or {}:
            if name not in allowed:
                raise InputError(f"options: {name!r}: allowed: {', '.join(map(repr, allowed))}")
        if options is None or options.get("goal") is None:
            return [None] * robots
        changes, points = as_goals(options["goal"], self.origin, self.sim.dt, _finite)
        if points.ndim == 2:
            points = np.broadcast_to(points, (robots, *points.shape))
        if len(points) != robots:
            raise InputError(f"goal: expected goals for {robots} robots, found {len(points)}")
        return [Goals(changes, of_robot) for of_robot in points]

    def towards(self) -> Optional[_Floats]:
        """The goal of each robot in its next step, or None if the scene's goal is fixed."""
        if self.origin is None:
            return None
        rows = [
            goals.points[sum(change <= done for change in goals.changes)]
            for goals, done in zip(self.goals, self.done)
            if goals is not None
        ]
        return np.array(rows)

    def held(self, actions: npt.ArrayLike) -> _Floats:
        """Converts actions to the activations of all edges, one row for each robot."""
        given = floats("action", actions).astype(np.float64)
        expected = (len(self.done), len(self.core.actuators))
        if given.shape != expected:
            raise InputError(f"action: expected the shape {expected}, found {given.shape}")
        if not np.all(np.isfinite(given)):
            raise InputError(f"action: expected finite numbers, found {given}")
        held = np.zeros((len(self.done), self.z.shape[1]))
        held[:, self.core.actuators] = np.clip(given, -1.0, 1.0)
        return held

    def advance(self, held: _Floats) -> tuple[_Floats, npt.NDArray[np.bool_]]:
        """Simulates one frame with constant activations. Returns the reward of each robot, and whether it
        diverged. Robots that diverge keep their last state, and get no reward."""
        before, goals = self.core.places(self.x), self.towards()
        lost = np.zeros(len(self.done), np.bool_)
        energy, is_metered = np.zeros(len(self.done)), "energy" in self.reward
        frames = np.minimum(self.frame_skip, self.sim.steps - self.done)
        # No law of this package depends on the time, so robots of any age are simulated together.
        for steps in np.unique(frames):
            those = np.flatnonzero(frames == steps)
            first = int(self.done[those].min())
            x, v, diverged, energy[those] = self.core.advance(
                those.tolist(), held[those], self.x[those], self.v[those], first, int(steps), is_metered
            )
            kept = ~np.array(diverged)
            self.x[those[kept]], self.v[those[kept]] = x[kept], v[kept]
            lost[those[~kept]] = True
        self.done += frames
        after = self.core.places(self.x)
        terms: dict[str, _Floats] = {"distance": after[:, 0] - before[:, 0], "energy": energy}
        if goals is not None:
            before, after = ((goals - place)[:, :-1] for place in (before, after))
            terms["goal"] = np.linalg.norm(before, axis=1) - np.linalg.norm(after, axis=1)
        if "upright" in self.reward:
            terms["upright"] = frames * self.sim.dt * self.upright()
        made = np.zeros(len(lost))
        for term, weight in self.reward.items():
            made += weight * terms[term]
        return np.where(lost, 0.0, made), lost

    def upright(self) -> _Floats:
        """The cosine of each robot's tilt: of the rotation that best turns its shape at rest into its shape now."""
        weight = self.weight

        def offsets(x: _Floats) -> _Floats:
            offset: _Floats = x - (weight * x).sum(-2, keepdims=True) / weight.sum(-2, keepdims=True)
            return offset

        u, _, vt = np.linalg.svd(offsets(self.x).swapaxes(-1, -2) @ (weight * offsets(self.rest)))
        u[..., -1] *= np.linalg.det(u @ vt)[:, None]
        turned: _Floats = (u @ vt)[:, -1, -1]
        return turned

    @property
    def is_over(self) -> npt.NDArray[np.bool_]:
        return self.done >= self.sim.steps

    def observe(self) -> _Seen:
        goals = self.towards()
        seen = self.core.observe(
            self.x, self.v, self.done.tolist(), None if goals is None else goals.tolist()
        )
        numbers: _Seen = seen.astype(self.observation_space.dtype, copy=False)
        return numbers.clip(-self.bound, self.bound, out=numbers)

    def info(self) -> dict[str, Any]:
        """The numbers of all robots for the infos of an environment."""
        places, goals = self.core.places(self.x), self.towards()
        of_each = {"along": places[:, 0], "time": self.done * self.sim.dt}
        if places.shape[1] > 2:
            of_each["across"] = places[:, 1]
        if goals is not None:
            of_each["goal"] = goals[:, 0]
        if goals is not None and goals.shape[1] > 2:
            of_each["goal_across"] = goals[:, 1]
        return of_each


def _finite(goal: Any) -> _Floats:
    """Converts a goal of a reset to an array of finite numbers."""
    try:
        numbers = np.array(goal, np.float64)
    except (TypeError, ValueError):
        numbers = np.array(np.nan)
    if not np.all(np.isfinite(numbers)):
        raise InputError(f"goal: expected finite numbers, found {goal!r}")
    return numbers


def _check_mode(render_mode: Optional[str], modes: Sequence[str]) -> None:
    choice("render_mode", render_mode, (None, *modes))


class _Window:
    """A window that shows pictures, as many per second as in the simulated time."""

    def __init__(self, frames_per_second: int) -> None:
        try:
            import pygame
        except ImportError:
            raise gymnasium.error.DependencyNotInstalled(
                "render_mode='human' needs pygame: pip install pygame-ce"
            ) from None
        self.pygame = pygame
        self.rate = frames_per_second
        self.clock = pygame.time.Clock()

    def show(self, picture: npt.NDArray[np.uint8]) -> None:
        columns_first = picture.swapaxes(0, 1)
        screen = self.pygame.display.get_surface() or self.pygame.display.set_mode(columns_first.shape[:2])
        self.pygame.surfarray.blit_array(screen, columns_first)
        self.pygame.event.pump()
        self.pygame.display.flip()
        self.clock.tick(self.rate)

    def close(self) -> None:
        self.pygame.display.quit()


class _Walks:
    """What environments of one robot and of many tell about their walk."""

    _walk: _Walk

    @property
    def simulator(self) -> Simulator:
        """The simulator of the scene."""
        return self._walk.sim

    @property
    def actuators(self) -> list[int]:
        """The edge of each number of an action."""
        return self._walk.core.actuators


class WalkEnv(_Walks, gymnasium.Env[_Seen, npt.NDArray[np.float32]]):
    """One walking robot.

    - ``robot``: a run or a scene. The design is ``z``, shape ``(edges, 3)``; by default it is the
      design of the run, or the design that the scene starts with.
    - An action has an activation from -1 to 1 for every actuator, in the order of the edges; it is
      held for ``frame_skip`` steps.
    - An observation has the entries that the paper's controller observes: clocks, goal, offsets of the
      nodes from their mean, velocities. With ``observation="scaled"`` they are about 1 and at most 10,
      in single precision: offsets in units of half the robot's extent at rest, velocities in units of
      the lattice's scale divided by its time scale (1 m/s for ten spacings of 0.1 m), and a fixed goal in
      units of its distance from the origin. With ``"paper"`` they have the factors of the scene's
      ``[controller]``, in double precision.
    - An episode is a whole rollout of the scene; a robot that diverges ends it, with no reward for that
      step.
    - ``reward`` has the weights of the terms of the reward of a frame: ``distance``, the distance along
      the ground, m; ``goal``, by how much the robot came nearer to a given goal along the ground (in space along and
      across), m;
      ``energy``, what the actuators gave to the robot, J, where an actuator that takes energy counts as 0;
      ``upright``, the duration of the frame times the cosine of the robot's tilt, s. The default is
      ``{"goal": 1.0}`` in a scene with given goals, and otherwise ``{"distance": 1.0}``.
    - In a scene with given goals, the observed goal is relative to the robot. ``reset`` draws the goals
      as ``[goals]`` of the scene says, or takes them from ``options={"goal": ...}``, as
      :meth:`cosmic.Simulator.rollout` does. A goal that changes within a frame counts from the next
      frame. The info ``goal`` is its position along the ground, measured like ``along``, m; in space
      ``goal_across`` is its position across, measured like ``across``.
    - ``physics`` replaces numbers of the physics, as :attr:`cosmic.Inputs.physics` does. For domain randomization it is a
      function that takes a random generator, draws numbers for a robot and returns a dictionary; each reset calls it.
    - For rewards of your own, in a wrapper, ``env.unwrapped`` has copies of the positions ``x`` and the velocities ``v``,
      the edges ``actuators`` in the order of an action, and the ``simulator``.
    - ``scatter``: at the start, every coordinate moves at random by at most this distance, m.
    - ``render_mode``: ``"rgb_array"`` for pictures, or ``"human"`` for a window, which needs pygame.
    """

    metadata = {"render_modes": ["human", "rgb_array"], "render_fps": 50}

    def __init__(
        self,
        robot: Union[Run, SceneLike] = "earth",
        z: Optional[npt.ArrayLike] = None,
        *,
        frame_skip: int = FRAME_SKIP,
        scatter: float = 1e-3,
        observation: Observation = "scaled",
        reward: Optional[Mapping[str, float]] = None,
        physics: Optional[Physics] = None,
        render_mode: Optional[Literal["human", "rgb_array"]] = None,
    ) -> None:
        _check_mode(render_mode, ["human", "rgb_array"])
        self._walk = _Walk(robot, z, 1, frame_skip, scatter, observation, reward, physics)
        self.action_space = self._walk.action_space
        self.observation_space = self._walk.observation_space
        self.render_mode = render_mode
        self.metadata = {**self.metadata, "render_fps": self._walk.frames_per_second}
        self._window = _Window(self._walk.frames_per_second) if render_mode == "human" else None
        self._seen: list[_Floats] = []
        self._over = True

    def reset(
        self, *, seed: Optional[int] = None, options: Optional[dict[str, Any]] = None
    ) -> tuple[_Seen, dict[str, Any]]:
        super().reset(seed=None if seed is None else whole("seed", seed, 0))
        (goals,) = self._walk.goals_of(options)
        self._walk.begin(0, self.np_random, goals)
        self._seen = [self._walk.x[0].copy()]
        self._over = False
        self._show()
        return self._walk.observe()[0], self._info()

    def step(
        self, action: npt.NDArray[np.float32]
    ) -> tuple[_Seen, float, bool, bool, dict[str, Any]]:
        if self._over:
            raise gymnasium.error.ResetNeeded("no episode is running: call reset")
        made, lost = self._walk.advance(self._walk.held(floats("action", action)[None]))
        if self.render_mode is not None:
            self._seen.append(self._walk.x[0].copy())
        over = bool(self._walk.is_over[0]) and not lost[0]
        self._over = over or bool(lost[0])
        self._show()
        return self._walk.observe()[0], float(made[0]), bool(lost[0]), over, self._info()

    @property
    def x(self) -> _Floats:
        """The positions, shape ``(nodes, D)``, m."""
        own: _Floats = self._walk.x[0].copy()
        return own

    @property
    def v(self) -> _Floats:
        """The velocities, shape ``(nodes, D)``, m/s."""
        own: _Floats = self._walk.v[0].copy()
        return own

    def _info(self) -> dict[str, Any]:
        return {name: float(numbers[0]) for name, numbers in self._walk.info().items()}

    def _show(self) -> None:
        if self._window is not None:
            self._window.show(self._walk.picture(self._seen))

    def close(self) -> None:
        if self._window is not None:
            self._window.close()

    def render(self) -> Any:
        """A picture of the robot, as an array of shape ``(240, 480, 3)``; None if a window shows it."""
        if self.render_mode is None:
            gymnasium.logger.warn("render needs a mode: give render_mode='rgb_array'")
            return None
        if not self._seen:
            raise gymnasium.error.ResetNeeded("there is no picture before the first reset: call reset")
        return self._walk.picture(self._seen) if self._window is None else None


class WalkVectorEnv(_Walks, VectorEnv[_Seen, npt.NDArray[np.float32], npt.NDArray[Any]]):
    """Many robots of one lattice, simulated in SIMD lanes and threads.

    It takes the arguments of :class:`WalkEnv`, but opens no window. Robots may differ: ``z`` may have the shape
    ``(num_envs, edges, 3)``, and numbers of ``physics`` may have an axis for robots in front. An actuator of any robot is then
    an actuator of the action. Everything else is as in gymnasium's ``SyncVectorEnv``:

    - ``autoreset_mode`` says when a robot begins again after its episode is over: in the next step,
      in the same step, or when ``reset`` is called with a ``reset_mask`` among its options.
    - ``max_episode_steps`` is the number of calls of ``step`` after which an episode is truncated.
    """

    metadata = {"render_modes": ["rgb_array"], "autoreset_mode": AutoresetMode.NEXT_STEP}

    def __init__(
        self,
        num_envs: int,
        robot: Union[Run, SceneLike] = "earth",
        z: Optional[npt.ArrayLike] = None,
        *,
        frame_skip: int = FRAME_SKIP,
        scatter: float = 1e-3,
        observation: Observation = "scaled",
        reward: Optional[Mapping[str, float]] = None,
        physics: Optional[Physics] = None,
        render_mode: Optional[Literal["rgb_array"]] = None,
        autoreset_mode: Union[str, AutoresetMode] = AutoresetMode.NEXT_STEP,
        max_episode_steps: Optional[int] = None,
    ) -> None:
        self.num_envs = whole("num_envs", num_envs, least=1)
        _check_mode(render_mode, ["rgb_array"])
        self.render_mode = render_mode
        try:
            self.autoreset_mode = AutoresetMode(autoreset_mode)
        except ValueError:
            allowed = ", ".join(repr(mode.value) for mode in AutoresetMode)
            raise InputError(f"autoreset_mode: {autoreset_mode!r}: allowed: {allowed}") from None
        most = max_episode_steps
        self._most = None if most is None else whole("max_episode_steps", most, 1)
        self._walk = _Walk(robot, z, self.num_envs, frame_skip, scatter, observation, reward, physics)
        self.metadata = {
            **self.metadata,
            "render_fps": self._walk.frames_per_second,
            "autoreset_mode": self.autoreset_mode,
        }
        self.single_action_space = self._walk.action_space
        self.single_observation_space = self._walk.observation_space
        self.action_space = batch_space(self.single_action_space, self.num_envs)
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)
        self._over = np.zeros(self.num_envs, np.bool_)
        self._frames = np.zeros(self.num_envs, np.int64)
        self._seen: list[list[_Floats]] = [[] for _ in range(self.num_envs)]
        self._random: list[tuple[np.random.Generator, int]] = []

    # The next two are as in gymnasium's SyncVectorEnv, which contradicts the types of its base class too. Without gymnasium's
    # types nothing contradicts, hence `unused-ignore`.
    @property  # type: ignore[misc, unused-ignore]
    def np_random(self) -> tuple[np.random.Generator, ...]:  # type: ignore[override, unused-ignore]
        """The generator of every robot."""
        return tuple(random for random, _ in self._seeded([None] * self.num_envs))

    @property
    def np_random_seed(self) -> tuple[int, ...]:  # type: ignore[override, unused-ignore]
        """The seed of every robot."""
        return tuple(seed for _, seed in self._seeded([None] * self.num_envs))

    def _seeded(self, seeds: list[Optional[int]]) -> list[tuple[np.random.Generator, int]]:
        """The generators and seeds of all robots. A robot without a new seed keeps its generator."""
        drawn = seeding.np_random
        is_new = not self._random
        # Draws as the reset of a single environment does, so that robot k depends only on its seed.
        self._random = [
            drawn(own) if is_new or own is not None else self._random[k]
            for k, own in enumerate(seeds)
        ]
        return self._random

    def reset(
        self,
        *,
        seed: Union[int, Sequence[Optional[int]], None] = None,
        options: Optional[dict[str, Any]] = None,
    ) -> tuple[_Seen, dict[str, Any]]:
        if seed is None:
            seeds: list[Optional[int]] = [None] * self.num_envs
        elif isinstance(seed, (int, np.integer)):
            seeds = [whole("seed", seed, 0) + k for k in range(self.num_envs)]
        elif isinstance(seed, (list, tuple, np.ndarray)):
            seeds = [None if own is None else whole("seed", own, 0) for own in seed]
        else:
            raise InputError(f"seed: {seed!r}: expected a whole number, a list of {self.num_envs} numbers, or None")
        if len(seeds) != self.num_envs:
            raise InputError(f"seed: expected {self.num_envs} seeds, one per robot, found {len(seeds)}")
        goals, begins = self._walk.goals_of(options, "reset_mask"), self._mask(options)
        self._seeded([own if begins[k] else None for k, own in enumerate(seeds)])
        self._begin(begins, goals)
        return self._walk.observe(), self._info(begins)

    def _mask(self, options: Optional[dict[str, Any]]) -> npt.NDArray[np.bool_]:
        """The robots to reset: all, unless the options have a mask."""
        if options is None or "reset_mask" not in options:
            return np.ones(self.num_envs, np.bool_)
        mask: npt.NDArray[np.bool_] = array("reset_mask", options["reset_mask"])
        if mask.dtype != np.bool_ or mask.shape != (self.num_envs,) or not mask.any():
            raise InputError(
                f"reset_mask: expected {self.num_envs} booleans, at least one of them True, "
                f"found {options['reset_mask']!r}"
            )
        return mask

    def _begin(
        self, robots: npt.NDArray[np.bool_], goals: Optional[list[Optional[Goals]]] = None
    ) -> None:
        for robot in map(int, np.flatnonzero(robots)):
            own = None if goals is None else goals[robot]
            self._walk.begin(robot, self._random[robot][0], own)
            self._seen[robot] = [self._walk.x[robot].copy()]
        self._frames[robots] = 0
        self._over[robots] = False

    def step(
        self, actions: npt.NDArray[np.float32]
    ) -> tuple[_Seen, npt.NDArray[Any], npt.NDArray[Any], npt.NDArray[Any], dict[str, Any]]:
        walk, mode = self._walk, self.autoreset_mode
        if not all(self._seen):
            raise gymnasium.error.ResetNeeded("no episode is running: call reset")
        if mode is AutoresetMode.DISABLED and self._over.any():
            robots = np.flatnonzero(self._over).tolist()
            raise gymnasium.error.ResetNeeded(
                f"the episodes of the robots {robots} are over: call reset with a `reset_mask` in its options"
            )
        held = walk.held(actions)
        begins = self._over.copy()
        self._begin(begins)
        kept = walk.x[begins], walk.v[begins]
        made, lost = walk.advance(held)
        # Robots that are being reset do not act in this step.
        walk.x[begins], walk.v[begins] = kept
        walk.done[begins] = 0
        made[begins], lost[begins] = 0.0, False
        self._frames[~begins] += 1
        self._keep(~begins)
        over = walk.is_over & ~lost
        if self._most is not None:
            over |= self._frames >= self._most
        self._over = over | lost
        everyone = np.ones(self.num_envs, np.bool_)
        if mode is not AutoresetMode.SAME_STEP or not self._over.any():
            return walk.observe(), made, lost, over, self._info(everyone)
        final, final_info = walk.observe(), self._info(self._over)
        info: dict[str, Any] = {}
        for robot in map(int, np.flatnonzero(self._over)):
            self._add_info(info, {"final_obs": final[robot]}, robot)
        info.update(final_info=final_info, _final_info=self._over.copy())
        self._begin(self._over.copy())
        return walk.observe(), made, lost, over, {**info, **self._info(everyone)}

    @property
    def x(self) -> _Floats:
        """The positions, shape ``(num_envs, nodes, D)``, m."""
        own: _Floats = self._walk.x.copy()
        return own

    @property
    def v(self) -> _Floats:
        """The velocities, shape ``(num_envs, nodes, D)``, m/s."""
        own: _Floats = self._walk.v.copy()
        return own

    def _keep(self, robots: npt.NDArray[np.bool_]) -> None:
        """Keeps the positions of robots for their next picture."""
        if self.render_mode is not None:
            for robot in map(int, np.flatnonzero(robots)):
                self._seen[robot].append(self._walk.x[robot].copy())

    def _info(self, robots: npt.NDArray[np.bool_]) -> dict[str, Any]:
        """The infos of the masked robots, in the format of gymnasium: every entry has a mask beside it."""
        info: dict[str, Any] = {}
        for name, numbers in self._walk.info().items():
            info[name], info[f"_{name}"] = np.where(robots, numbers, 0.0), robots.copy()
        return info

    def render(self) -> Any:
        """A current picture of every robot, each an array of shape ``(240, 480, 3)``."""
        if self.render_mode is None:
            gymnasium.logger.warn("render needs a mode: give render_mode='rgb_array'")
            return None
        if not all(self._seen):
            raise gymnasium.error.ResetNeeded("there is no picture before the first reset: call reset")
        return tuple(self._walk.picture(seen, robot) for robot, seen in enumerate(self._seen))


# With `gymnasium.make("cosmic.gym:cosmic/Walk-v0", ...)` or `make_vec`, gymnasium imports this module itself.
gymnasium.register(
    id="cosmic/Walk-v0",
    entry_point="cosmic.gym:WalkEnv",
    vector_entry_point="cosmic.gym:WalkVectorEnv",
)
