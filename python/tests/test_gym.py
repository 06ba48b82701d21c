"""Environments of gymnasium."""

from __future__ import annotations

from typing import Any

import cosmic
import numpy as np
import pytest
from common import SCENE

gymnasium = pytest.importorskip("gymnasium")
import cosmic.gym  # noqa: E402
from gymnasium.utils.env_checker import check_env  # noqa: E402

#: Six frames to an episode, the last of them short.
FRAMES = {"frame_skip": 50}
NAME = "cosmic.gym:cosmic/Walk-v0"


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("render_mode", [None, "rgb_array"])
def test_an_environment_is_what_gymnasium_wants(render_mode: str | None) -> None:
    env = gymnasium.make(NAME, robot=SCENE, render_mode=render_mode, **FRAMES)
    check_env(env.unwrapped)


def episode(env: Any, seed: int) -> list[Any]:
    """Observations, rewards and ends of an episode of drawn actions."""
    random = np.random.default_rng(seed)
    seen: list[Any] = [env.reset(seed=seed)[0]]
    while len(seen) == 1 or not (seen[-1][2] or seen[-1][3]):
        action = random.uniform(-1.0, 1.0, env.action_space.shape).astype(np.float32)
        seen.append(env.step(action))
    return seen


def test_an_episode_is_a_rollout_of_the_scene() -> None:
    env = cosmic.gym.WalkEnv(SCENE, **FRAMES)
    seen = episode(env, 0)
    assert len(seen) == 1 + 6
    assert [over for *_, over, _ in seen[1:]] == 5 * [False] + [True]
    assert not any(lost for _, _, lost, _, _ in seen[1:])
    assert [info["time"] for *_, info in seen[1:]] == [
        steps * 0.002 for steps in (50, 100, 150, 200, 250, 256)
    ]
    with pytest.raises(gymnasium.error.ResetNeeded):
        env.step(np.zeros(env.action_space.shape, np.float32))


def test_rewards_are_the_distance_made_good() -> None:
    env = cosmic.gym.WalkEnv(SCENE, **FRAMES)
    _, info = env.reset(seed=3)
    start, made = info["along"], 0.0
    for _ in range(6):
        _, reward, _, _, info = env.step(np.ones(env.action_space.shape, np.float32))
        made += reward
    # A sum of six differences of numbers below one.
    assert made == pytest.approx(info["along"] - start, abs=1e-14)
    assert made != 0.0


def test_seeds_repeat_and_differ() -> None:
    env = cosmic.gym.WalkEnv(SCENE, **FRAMES)
    starts = [env.reset(seed=seed)[0] for seed in (1, 1, 2)]
    assert np.array_equal(starts[0], starts[1]) and not np.array_equal(starts[0], starts[2])
    # Without a seed the next start is another.
    assert not np.array_equal(env.reset()[0], starts[2])
    calm = cosmic.gym.WalkEnv(SCENE, scatter=0.0, **FRAMES)
    assert np.array_equal(calm.reset(seed=1)[0], calm.reset(seed=2)[0])


def test_actions_beyond_the_bounds_are_held_at_them() -> None:
    def after(action: float) -> Any:
        env = cosmic.gym.WalkEnv(SCENE, **FRAMES)
        env.reset(seed=0)
        return env.step(np.full(env.action_space.shape, action, np.float32))[0]

    assert np.array_equal(after(1.0), after(7.0))
    assert not np.array_equal(after(1.0), after(-1.0))


def test_many_robots_are_single_ones_side_by_side() -> None:
    robots, random = 5, np.random.default_rng(0)
    many = gymnasium.make_vec(NAME, robots, "vector_entry_point", robot=SCENE, **FRAMES)
    alone = [cosmic.gym.WalkEnv(SCENE, **FRAMES) for _ in range(robots)]
    seen, _ = many.reset(seed=10)
    assert np.array_equal(seen, [env.reset(seed=10 + k)[0] for k, env in enumerate(alone)])
    begins = [False] * robots
    # Two episodes: after the first each begins anew, for which one step is spent.
    for _ in range(14):
        actions = random.uniform(-1.0, 1.0, many.action_space.shape).astype(np.float32)
        seen, made, lost, over, info = many.step(actions)
        for k, env in enumerate(alone):
            if begins[k]:
                first, of_reset = env.reset()
                expected = (first, 0.0, False, False, of_reset)
            else:
                expected = env.step(actions[k])
            assert np.array_equal(seen[k], expected[0])
            assert (made[k], lost[k], over[k]) == expected[1:4]
            assert (info["along"][k], info["time"][k]) == tuple(expected[4].values())
            begins[k] = bool(lost[k] or over[k])
    assert many.observation_space.contains(seen)


def test_pictures_show_the_robot() -> None:
    env = cosmic.gym.WalkEnv(SCENE, render_mode="rgb_array", **FRAMES)
    env.reset(seed=0)
    first = env.render()
    assert first.shape == (240, 480, 3) and first.dtype == np.uint8
    env.step(np.ones(env.action_space.shape, np.float32))
    assert (env.render() != first).any()
    assert env.metadata["render_fps"] == 10


def test_the_robot_of_a_run_is_driven(run: cosmic.Run) -> None:
    env = cosmic.gym.WalkEnv(run, **FRAMES)
    actuators = np.flatnonzero(run.design.materials == 2)
    assert env.action_space.shape == actuators.shape
    _, info = env.reset(seed=0)
    moved = [env.step(env.action_space.sample())[4]["along"] for _ in range(3)]
    assert np.all(np.isfinite(moved)) and moved[-1] != info["along"]
    other = np.roll(run.design.z, 1, axis=0)
    with_other = cosmic.gym.WalkEnv(run, other, **FRAMES)
    assert with_other.action_space.shape == actuators.shape


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ({"frame_skip": 0}, "frame_skip: 0: expected a whole number, 1 to 256"),
        ({"scatter": float("nan")}, "scatter: nan: expected a length"),
        ({"render_mode": "human"}, "render_mode: 'human'"),
        ({"z": np.zeros((3, 3))}, "z: expected the shape"),
        ({"z": np.tile([1.0, 0.0, 0.0], (20, 1))}, "no actuator"),
    ],
)
def test_wrong_arguments_are_refused(arguments: dict[str, Any], says: str) -> None:
    with pytest.raises(cosmic.InputError, match=says):
        cosmic.gym.WalkEnv(SCENE, **arguments)
    with pytest.raises(cosmic.InputError, match="num_envs: 0"):
        cosmic.gym.WalkVectorEnv(0, SCENE)


def test_an_episode_begins_with_reset_and_ends() -> None:
    env = cosmic.gym.WalkEnv(SCENE, render_mode="rgb_array", **FRAMES)
    action = np.zeros(env.action_space.shape, np.float32)
    for call in (env.render, lambda: env.step(action)):
        with pytest.raises(gymnasium.error.ResetNeeded):
            call()
    env.reset(seed=0)
    over = False
    while not over:
        over = env.step(action)[3]
    with pytest.raises(gymnasium.error.ResetNeeded):
        env.step(action)


def test_wrong_actions_are_refused_and_change_nothing() -> None:
    env = cosmic.gym.WalkEnv(SCENE, **FRAMES)
    env.reset(seed=0)
    size = env.action_space.shape[0]
    for action, says in [(np.zeros(1), r"action: expected the shape"), (np.full(size, np.nan), "finite")]:
        with pytest.raises(cosmic.InputError, match=says):
            env.step(action)
    _, _, _, _, info = env.step(np.zeros(size))
    assert info["time"] == pytest.approx(env.metadata["render_fps"] ** -1)
    many = cosmic.gym.WalkVectorEnv(2, SCENE, **FRAMES)
    with pytest.raises(cosmic.InputError, match="1 seeds for 2 robots"):
        many.reset(seed=[1])
