"""Robots of one design as a vector environment of stable-baselines3.

>>> from cosmic.sb3 import WalkVecEnv
>>> from stable_baselines3 import PPO                             # doctest: +SKIP
>>> PPO("MlpPolicy", WalkVecEnv(64, "three_legged")).learn(10**6) # doctest: +SKIP
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any, Optional, Union

import numpy as np
import numpy.typing as npt

from ._errors import InputError, extra
from ._run import Run
from ._scene import SceneLike

with extra("sb3"):
    from gymnasium.vector import AutoresetMode
    from stable_baselines3.common.vec_env import VecEnv

    from .gym import WalkVectorEnv

__all__ = ["WalkVecEnv"]


def __dir__() -> list[str]:
    return __all__


#: Robots of a vector environment: all of them, one, or some.
_Indices = Union[None, int, Iterable[int]]


class WalkVecEnv(VecEnv):
    """Many robots of one design for stable-baselines3, simulated in SIMD lanes and threads.

    It takes the arguments of :class:`cosmic.gym.WalkVectorEnv` except ``autoreset_mode``: a robot is reset
    in the step that ends its episode, as stable-baselines3 expects. All robots have the same
    attributes and options. For statistics of episodes, wrap it in ``VecMonitor``.
    """

    def __init__(
        self,
        num_envs: int,
        robot: Union[Run, SceneLike] = "earth",
        z: Optional[npt.ArrayLike] = None,
        **arguments: Any,
    ) -> None:
        self._many = WalkVectorEnv(
            num_envs, robot, z, autoreset_mode=AutoresetMode.SAME_STEP, **arguments
        )
        self._actions = np.empty(0, np.float32)
        spaces = self._many.single_observation_space, self._many.single_action_space
        super().__init__(self._many.num_envs, *spaces)

    def reset(self) -> npt.NDArray[Any]:
        options = self._options[0]
        if any(own is not options for own in self._options if own or options):
            raise InputError("the options of a reset must be the same for all robots; give one dictionary")
        seen, info = self._many.reset(seed=self._seeds, options=options or None)
        self.reset_infos = self._rows(info)
        self._reset_seeds()
        self._reset_options()
        return seen

    def step_async(self, actions: npt.NDArray[np.float32]) -> None:
        self._actions = actions

    def step_wait(self) -> tuple[npt.NDArray[Any], npt.NDArray[Any], npt.NDArray[Any], list[dict[str, Any]]]:
        seen, made, lost, over, info = self._many.step(self._actions)
        ends, infos = lost | over, self._rows(info)
        if ends.any():
            last = self._rows(info["final_info"])
            for robot in map(int, np.flatnonzero(ends)):
                self.reset_infos[robot] = infos[robot]
                infos[robot] = {**last[robot], "terminal_observation": info["final_obs"][robot]}
        for robot, is_cut in enumerate((over & ~lost).tolist()):
            infos[robot]["TimeLimit.truncated"] = is_cut
        return seen, made.astype(np.float32), ends, infos

    @staticmethod
    def _rows(info: dict[str, Any]) -> list[dict[str, Any]]:
        """The infos of every robot."""
        names = [name for name in ("along", "across", "time", "goal", "goal_across") if name in info]
        rows = zip(*(info[name].tolist() for name in names))
        return [dict(zip(names, row)) for row in rows]

    def close(self) -> None:
        self._many.close()

    def get_images(self) -> Sequence[Optional[npt.NDArray[np.uint8]]]:
        pictures: Sequence[Optional[npt.NDArray[np.uint8]]] = self._many.render()
        return pictures

    def get_attr(self, attr_name: str, indices: _Indices = None) -> list[Any]:
        return [getattr(self._many, attr_name)] * len(list(self._get_indices(indices)))

    def set_attr(self, attr_name: str, value: Any, indices: _Indices = None) -> None:
        if len(list(self._get_indices(indices))) != self.num_envs:
            raise InputError(f"{attr_name}: all robots have the same attributes; set it without `indices`")
        setattr(self._many, attr_name, value)

    def env_method(self, method_name: str, *args: Any, indices: _Indices = None, **kwargs: Any) -> list[Any]:
        raise InputError(f"{method_name}: a robot of `WalkVecEnv` is not an environment with methods")

    def env_is_wrapped(self, wrapper_class: type[Any], indices: _Indices = None) -> list[bool]:
        return [False] * len(list(self._get_indices(indices)))
