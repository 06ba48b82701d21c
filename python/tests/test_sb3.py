"""The vector environment for stable-baselines3."""

from __future__ import annotations

from typing import Any

import cosmic
import numpy as np
import pytest
from common import GOALS, SCENE, SPACE

pytest.importorskip("stable_baselines3")
import cosmic.gym  # noqa: E402
import gymnasium  # noqa: E402
from cosmic.sb3 import WalkVecEnv  # noqa: E402
from stable_baselines3 import PPO  # noqa: E402
from stable_baselines3.common.env_checker import check_env  # noqa: E402
from stable_baselines3.common.evaluation import evaluate_policy  # noqa: E402
from stable_baselines3.common.monitor import Monitor  # noqa: E402
from stable_baselines3.common.vec_env import DummyVecEnv, VecMonitor  # noqa: E402

#: An episode has six frames; the last one is shorter.
FRAMES = {"frame_skip": 50}


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("scene", [SCENE, GOALS], ids=["fixed goal", "given goals"])
def test_one_robot_passes_the_checks_of_stable_baselines3(scene: dict[str, Any]) -> None:
    check_env(cosmic.gym.WalkEnv(scene, render_mode="rgb_array", **FRAMES), skip_render_check=False)


def assert_equal_infos(ours: list[dict[str, Any]], theirs: list[dict[str, Any]]) -> None:
    for own, other in zip(ours, theirs, strict=True):
        assert own.keys() == other.keys()
        for name, value in other.items():
            assert type(own[name]) is type(value) and np.array_equal(own[name], value), name


@pytest.mark.parametrize(
    ("scene", "limit"),
    [(SCENE, None), (SCENE, 4), (GOALS, None), (SPACE, 4)],
    ids=["whole", "cut", "goals", "space"],
)
def test_many_robots_match_the_dummy_vec_env(scene: dict[str, Any], limit: int | None) -> None:
    robots, random = 3, np.random.default_rng(1)

    def one() -> Any:
        env: Any = cosmic.gym.WalkEnv(scene, **FRAMES)
        return env if limit is None else gymnasium.wrappers.TimeLimit(env, limit)

    ours = WalkVecEnv(robots, scene, max_episode_steps=limit, **FRAMES)
    theirs = DummyVecEnv([one] * robots)
    assert ours.observation_space == theirs.observation_space and ours.action_space == theirs.action_space
    assert ours.render_mode is theirs.render_mode is None
    both: tuple[Any, ...] = (ours, theirs)
    ends = 0
    for seed in (5, None):
        if seed is not None:
            assert ours.seed(seed) == theirs.seed(seed) == [5, 6, 7]
        if scene is GOALS:
            ours.set_options({"goal": 1.0}), theirs.set_options({"goal": 1.0})
        a, b = (each.reset() for each in both)
        assert np.array_equal(a, b)
        assert_equal_infos(ours.reset_infos, theirs.reset_infos)
        for step in range(14):
            if step == 2 and scene is SCENE:
                # One robot diverges.
                ours._many._walk.x[1, 0] += 9e5
                theirs.envs[1].unwrapped._walk.x[0, 0] += 9e5
            actions = random.uniform(-1.0, 1.0, (robots, *ours.action_space.shape)).astype(np.float32)
            (*a, infos), (*b, their_infos) = (each.step(actions) for each in both)
            for x, y in zip(a, b, strict=True):
                assert x.dtype == y.dtype and np.array_equal(x, y)
            assert_equal_infos(infos, their_infos)
            assert_equal_infos(ours.reset_infos, theirs.reset_infos)
            ends += int(a[2].sum())
    assert ends >= 2 * 2 * robots
    ours.close(), theirs.close()


def test_attributes_and_wrappers() -> None:
    many = WalkVecEnv(3, SCENE, render_mode="rgb_array", **FRAMES)
    assert many.env_is_wrapped(Monitor, [0, 2]) == [False, False] and many.num_envs == 3
    assert many.get_attr("render_mode") == 3 * ["rgb_array"] and not many.has_attr("weather")
    many.set_attr("weather", "rain")
    assert many.get_attr("weather", 1) == ["rain"]
    assert many.get_attr("weather", (robot for robot in [0, 2])) == ["rain", "rain"]
    with pytest.raises(cosmic.InputError, match="weather: all robots have the same attributes"):
        many.set_attr("weather", "sun", [1])
    with pytest.raises(cosmic.InputError, match="fly: a robot"):
        many.env_method("fly")
    many.set_options([{"goal": 1.0}, {}, {}])
    with pytest.raises(cosmic.InputError, match="must be the same for all robots"):
        many.reset()
    with pytest.raises(gymnasium.error.ResetNeeded):
        many.step(np.zeros((3, *many.action_space.shape), np.float32))
    many.set_options()
    many.reset()
    # Three pictures and an empty one.
    assert many.render().shape == (2 * 240, 2 * 480, 3)


@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_ppo_trains_and_learns_of_the_ends_of_episodes() -> None:
    many = VecMonitor(WalkVecEnv(4, SCENE, **FRAMES))
    model = PPO("MlpPolicy", many, n_steps=16, batch_size=32, n_epochs=1, seed=0, device="cpu")
    before = [weights.clone() for weights in model.policy.parameters()]
    model.learn(128)
    # Each of the four robots acts in 32 frames: five episodes of six frames, and a rest.
    assert [episode["l"] for episode in model.ep_info_buffer] == 20 * [6]
    assert any((old != new).any() for old, new in zip(before, model.policy.parameters()))
    made, frames = evaluate_policy(model, many, 4, return_episode_rewards=True, warn=False)
    assert frames == [6] * 4 and np.isfinite(made).all()
