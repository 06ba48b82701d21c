"""Environments of gymnasium: a policy drives one design.

>>> import cosmic.gym, gymnasium
>>> env = gymnasium.make("cosmic/Walk-v0", robot="three_legged")
>>> many = gymnasium.make_vec("cosmic/Walk-v0", 64, robot="three_legged")
>>> env.action_space.shape, many.observation_space.shape
((28,), (64, 156))
"""

from __future__ import annotations

from typing import Any, Optional, Union

import gymnasium
import numpy as np
import numpy.typing as npt
from gymnasium import spaces
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from . import _core
from ._errors import InputError
from ._run import Run
from ._scene import SceneLike, as_scene
from ._checks import whole
from ._simulator import Simulator

__all__ = ["WalkEnv", "WalkVectorEnv"]

#: No observation is larger: beyond 1e6 m or m/s a robot counts as diverged, and scales are below 1000.
_BOUND = 1e9

_Floats = npt.NDArray[np.float64]


class _Walk:
    """Robots of one design at work: the part that both environments share."""

    def __init__(
        self,
        robot: Union[Run, SceneLike],
        z: Optional[npt.ArrayLike],
        robots: int,
        frame_skip: int,
        scatter: float,
    ) -> None:
        if isinstance(robot, Run):
            self.scene = robot.scene
            design: Any = robot.design.z if z is None else z
        else:
            self.scene = as_scene(robot)
            design = Simulator(self.scene).initial().z if z is None else z
        self.z = np.ascontiguousarray(design, np.float64)
        self.core = _core.Driven(self.scene, self.z)
        if not self.core.actuators:
            raise InputError("the design has no actuator: there is nothing to drive")
        self.frame_skip = whole("frame_skip", frame_skip, 1, self.core.steps)
        if not 0.0 <= scatter < np.inf:
            raise InputError(f"scatter: {scatter}: expected a length of 0 or more")
        self.scatter = scatter
        self.seconds = frame_skip * self.core.dt
        self.x = np.repeat(self.core.rest[None], robots, axis=0)
        self.v = np.zeros_like(self.x)
        self.done = np.zeros(robots, np.int64)
        self.action_space = spaces.Box(-1.0, 1.0, (len(self.core.actuators),), np.float32)
        self.observation_space = spaces.Box(-_BOUND, _BOUND, (self.core.inputs,), np.float64)

    def begin(self, robot: int, random: np.random.Generator) -> None:
        """Sets a robot back to its start, every coordinate moved a little at random."""
        rest = self.core.rest
        self.x[robot] = rest + random.uniform(-self.scatter, self.scatter, rest.shape)
        self.v[robot] = 0.0
        self.done[robot] = 0

    def held(self, actions: npt.ArrayLike) -> _Floats:
        """What every edge is told by actions, a row for every robot."""
        given = np.asarray(actions, np.float64)
        expected = (len(self.done), len(self.core.actuators))
        if given.shape != expected:
            raise InputError(f"action: expected the shape {expected}, found {given.shape}")
        if not np.all(np.isfinite(given)):
            raise InputError(f"action: expected finite numbers, found {given}")
        held = np.zeros((len(self.done), len(self.z)))
        held[:, self.core.actuators] = np.clip(given, -1.0, 1.0)
        return held

    def advance(self, held: _Floats) -> tuple[_Floats, npt.NDArray[np.bool_]]:
        """Holds activations for the steps of a frame. Returns distances made good along the ground
        and which robots diverged; these stay where they were."""
        before = self.core.along(self.x)
        lost = np.zeros(len(self.done), np.bool_)
        # The time of the step matters to laws that read it: robots of one age go together.
        for first in np.unique(self.done):
            those = np.flatnonzero(self.done == first)
            steps = int(min(self.frame_skip, self.core.steps - first))
            x, v, diverged = self.core.advance(
                held[those], self.x[those], self.v[those], int(first), steps
            )
            kept = ~np.array(diverged)
            self.x[those[kept]], self.v[those[kept]] = x[kept], v[kept]
            lost[those[~kept]] = True
            self.done[those] += steps
        return self.core.along(self.x) - before, lost

    @property
    def is_over(self) -> npt.NDArray[np.bool_]:
        return self.done >= self.core.steps

    def observe(self) -> _Floats:
        return self.core.observe(self.x, self.v, [int(done) for done in self.done])


class WalkEnv(gymnasium.Env[_Floats, npt.NDArray[np.float32]]):
    """One robot that walks.

    - ``robot``: a run, whose design and scene are taken, or a scene; then ``z`` has the design
      vectors, shape ``(edges, 3)``, or the scene's start is taken.
    - An action has an activation from -1 to 1 for every actuator, in the order of the edges; it is
      held for ``frame_skip`` steps.
    - An observation is that of the paper's controller: clocks, goal, offsets of the nodes from
      their mean, velocities.
    - The reward is the distance along the ground, m. An episode is a whole rollout of the scene; a
      robot that diverges ends it, with no reward for that step.
    - ``scatter``: the start moves every coordinate by up to so much at random, m.
    """

    metadata = {"render_modes": ["rgb_array"], "render_fps": 50}

    def __init__(
        self,
        robot: Union[Run, SceneLike] = "earth",
        z: Optional[npt.ArrayLike] = None,
        *,
        frame_skip: int = 10,
        scatter: float = 1e-3,
        render_mode: Optional[str] = None,
    ) -> None:
        if render_mode not in (None, "rgb_array"):
            raise InputError(f"render_mode: {render_mode!r}: allowed: None, 'rgb_array'")
        self._walk = _Walk(robot, z, 1, frame_skip, scatter)
        self.action_space = self._walk.action_space
        self.observation_space = self._walk.observation_space
        self.render_mode = render_mode
        self.metadata = {**self.metadata, "render_fps": round(1.0 / self._walk.seconds)}
        self._seen: list[_Floats] = []
        self._over = True

    def reset(
        self, *, seed: Optional[int] = None, options: Optional[dict[str, Any]] = None
    ) -> tuple[_Floats, dict[str, Any]]:
        super().reset(seed=seed)
        self._walk.begin(0, self.np_random)
        self._seen = [self._walk.x[0].copy()]
        self._over = False
        return self._walk.observe()[0], self._info()

    def step(
        self, action: npt.NDArray[np.float32]
    ) -> tuple[_Floats, float, bool, bool, dict[str, Any]]:
        if self._over:
            raise gymnasium.error.ResetNeeded("no episode has begun, or it is over: call reset")
        made, lost = self._walk.advance(self._walk.held(np.asarray(action)[None]))
        self._seen.append(self._walk.x[0].copy())
        over = bool(self._walk.is_over[0]) and not lost[0]
        self._over = over or bool(lost[0])
        return self._walk.observe()[0], float(made[0]), bool(lost[0]), over, self._info()

    def _info(self) -> dict[str, Any]:
        walk = self._walk
        return {"along": float(walk.core.along(walk.x)[0]), "time": float(walk.done[0] * walk.core.dt)}

    def render(self) -> Any:
        """The robot now, as an array of shape ``(240, 480, 3)``."""
        if self.render_mode is None:
            return None
        if not self._seen:
            raise gymnasium.error.ResetNeeded("there is nothing to see yet: call reset")
        skip, last = self._walk.frame_skip, self._walk.core.steps
        steps = [min(k * skip, last) for k in range(len(self._seen))]
        return _core.frame(self._walk.scene, self._walk.z, steps, np.array(self._seen))


class WalkVectorEnv(VectorEnv[_Floats, npt.NDArray[np.float32], npt.NDArray[Any]]):
    """Many robots of one design, stepped side by side in SIMD lanes and threads.

    Arguments are those of :class:`WalkEnv`. An episode that is over begins anew in the next step,
    as gymnasium's own vector environments have it.
    """

    metadata = {"render_modes": [], "autoreset_mode": AutoresetMode.NEXT_STEP}

    def __init__(
        self,
        num_envs: int,
        robot: Union[Run, SceneLike] = "earth",
        z: Optional[npt.ArrayLike] = None,
        *,
        frame_skip: int = 10,
        scatter: float = 1e-3,
    ) -> None:
        self.num_envs = whole("num_envs", num_envs, least=1)
        self.render_mode = None
        self._walk = _Walk(robot, z, num_envs, frame_skip, scatter)
        self.single_action_space = self._walk.action_space
        self.single_observation_space = self._walk.observation_space
        self.action_space = batch_space(self.single_action_space, num_envs)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self._over = np.zeros(num_envs, np.bool_)
        self._random: list[np.random.Generator] = []

    def reset(
        self,
        *,
        seed: Union[int, list[Optional[int]], None] = None,
        options: Optional[dict[str, Any]] = None,
    ) -> tuple[_Floats, dict[str, Any]]:
        if seed is not None or not self._random:
            seeds = seed if isinstance(seed, list) else [
                None if seed is None else seed + k for k in range(self.num_envs)
            ]
            if len(seeds) != self.num_envs:
                raise InputError(f"seed: {len(seeds)} seeds for {self.num_envs} robots")
            # As reset of a single environment draws: robot k is that of its seed.
            self._random = [gymnasium.utils.seeding.np_random(own)[0] for own in seeds]
        for robot, random in enumerate(self._random):
            self._walk.begin(robot, random)
        self._over[:] = False
        return self._walk.observe(), self._info()

    def step(
        self, actions: npt.NDArray[np.float32]
    ) -> tuple[_Floats, npt.NDArray[Any], npt.NDArray[Any], npt.NDArray[Any], dict[str, Any]]:
        if not self._random:
            raise gymnasium.error.ResetNeeded("call reset first")
        held = self._walk.held(actions)
        begins = self._over
        for robot in np.flatnonzero(begins):
            self._walk.begin(int(robot), self._random[robot])
        kept = self._walk.x[begins], self._walk.v[begins]
        made, lost = self._walk.advance(held)
        # Those that begin do not act in this step.
        self._walk.x[begins], self._walk.v[begins] = kept
        self._walk.done[begins] = 0
        made[begins], lost[begins] = 0.0, False
        over = self._walk.is_over & ~lost
        self._over = over | lost
        return self._walk.observe(), made, lost, over, self._info()

    def _info(self) -> dict[str, Any]:
        walk = self._walk
        return {"along": walk.core.along(walk.x), "time": walk.done * walk.core.dt}


# Also by `gymnasium.make("cosmic.gym:cosmic/Walk-v0", ...)`, and by `make_vec`.
gymnasium.register(
    id="cosmic/Walk-v0",
    entry_point="cosmic.gym:WalkEnv",
    vector_entry_point="cosmic.gym:WalkVectorEnv",
)
