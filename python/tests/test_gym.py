"""The environments for gymnasium."""

from __future__ import annotations

import copy
import importlib.util
import pickle
import sys
from typing import Any

import cosmic
import numpy as np
import pytest
from common import GOALS, SCENE, SPACE

gymnasium = pytest.importorskip("gymnasium")
import cosmic.gym  # noqa: E402
import gymnasium.wrappers.vector  # noqa: E402
from gymnasium.utils.env_checker import check_env  # noqa: E402

#: An episode has six frames; the last one is shorter.
FRAMES = {"frame_skip": 50}
NAME = "cosmic.gym:cosmic/Walk-v0"


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("scene", [SCENE, SPACE], ids=["plane", "space"])
@pytest.mark.parametrize("render_mode", [None, "rgb_array"])
def test_an_environment_passes_the_checks_of_gymnasium(scene: dict[str, Any], render_mode: str | None) -> None:
    env = gymnasium.make(NAME, robot=scene, render_mode=render_mode, **FRAMES)
    # The check of rendering opens a window.
    check_env(env.unwrapped, skip_render_check=importlib.util.find_spec("pygame") is None)


def episode(env: Any, seed: int) -> list[Any]:
    """Observations, rewards and ends of an episode with random actions."""
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


def test_robots_in_space_are_observed_and_shown() -> None:
    env = cosmic.gym.WalkEnv(SPACE, render_mode="rgb_array", observation="paper", **FRAMES)
    observation, _ = env.reset(seed=0)
    picture = env.render()
    for _ in range(3):
        x, v, weight = env._walk.x[0], env._walk.v[0], np.array(env._walk.core.presence[0])[:, None]
        assert x.shape == v.shape == (12, 3)
        offsets = weight * (x - (weight * x).sum(axis=0) / weight.sum())
        # Ten clocks, a goal 2 m ahead and 0.1 m high, and both vectors of all nodes.
        expected = 0.05 * np.concatenate([[2.0, 0.0, 0.1], offsets.ravel(), (weight * v).ravel()])
        assert observation.shape == (10 + 3 + 2 * 36,) and observation[10:] == pytest.approx(expected, abs=1e-12)
        observation, *_ = env.step(np.ones(env.action_space.shape, np.float32))
    assert np.abs(x[:, 1] - env._walk.rest[:, 1]).max() > 1e-3
    # The robot is seen from the side.
    assert picture.shape == env.render().shape == (240, 480, 3) and (picture != env.render()).any()


def test_rewards_add_up_to_the_distance() -> None:
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
    # Without a seed, every reset draws another start.
    assert not np.array_equal(env.reset()[0], starts[2])
    calm = cosmic.gym.WalkEnv(SCENE, scatter=0.0, **FRAMES)
    assert np.array_equal(calm.reset(seed=1)[0], calm.reset(seed=2)[0])


def test_actions_beyond_the_bounds_are_clipped() -> None:
    def after(action: float) -> Any:
        env = cosmic.gym.WalkEnv(SCENE, **FRAMES)
        env.reset(seed=0)
        return env.step(np.full(env.action_space.shape, action, np.float32))[0]

    assert np.array_equal(after(1.0), after(7.0))
    assert not np.array_equal(after(1.0), after(-1.0))


def test_an_observation_is_the_papers_in_other_units() -> None:
    # The robot of 3x3 nodes is 0.2 m wide and high, its goal is at (2 m, 0.1 m), and its factors are 0.05.
    units = {"clock": (1.0, 10), "goal": (np.hypot(2.0, 0.1), 2), "x": (0.1, 18), "v": (1.0, 18)}
    unit = np.concatenate([np.full(count, size) for size, count in units.values()])
    factor = np.repeat([1.0, 0.05], [10, 38])
    both = [cosmic.gym.WalkEnv(SCENE, observation=kind, **FRAMES) for kind in ("scaled", "paper")]
    scaled, papers = (episode(env, 1) for env in both)
    assert both[0].observation_space.dtype == np.float32 and both[1].observation_space.dtype == np.float64
    for (seen, *_), (raw, *_) in zip(scaled[1:], papers[1:], strict=True):
        assert seen.dtype == np.float32 and raw.dtype == np.float64
        # Velocities of 10 m/s and more are clipped.
        assert seen == pytest.approx(np.clip(raw / factor / unit, -10.0, 10.0), rel=1e-6, abs=1e-6)
    # Random actions on a small robot are about the fastest motion there is.
    assert 0.3 < np.std([seen for seen, *_ in scaled[1:]]) < 3.0


def test_a_robot_is_upright_by_its_tilt() -> None:
    env = cosmic.gym.WalkEnv(SCENE, reward={"distance": 2.0, "upright": 1.0}, **FRAMES)
    plain = cosmic.gym.WalkEnv(SCENE, **FRAMES)
    env.reset(seed=0), plain.reset(seed=0)
    rest = env._walk.x[0].copy()
    for turn in (0.0, 1.0, np.pi, -2.0):
        c, s = np.cos(turn), np.sin(turn)
        env._walk.x[0] = 1.3 * rest @ np.array([[c, s], [-s, c]]) + [3.0, 1.0]
        # The start is scattered by 1 mm.
        assert env._walk.upright()[0] == pytest.approx(np.cos(turn), abs=0.01)
    space = cosmic.gym.WalkEnv(SPACE, **FRAMES)
    space.reset(seed=0)
    for turn, about, expected in ((0.7, (0, 2), np.cos(0.7)), (2.0, (1, 2), np.cos(2.0)), (1.0, (0, 1), 1.0)):
        turned = np.eye(3)
        turned[np.ix_(about, about)] = [[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]
        space._walk.x[0] = 1.3 * space._walk.rest @ turned.T + [3.0, -2.0, 1.0]
        assert space._walk.upright()[0] == pytest.approx(expected, abs=1e-9)
    # The mirror image of a robot is not a rotation of it; the nearest ones lie between no turn and a half turn.
    env._walk.x[0] = rest * [-1.0, 1.0]
    assert abs(env._walk.upright()[0]) <= 1.0
    env._walk.x[0] = rest
    action = np.zeros(env.action_space.shape, np.float32)
    made, distance = env.step(action)[1], plain.step(action)[1]
    assert made == pytest.approx(2.0 * distance + 0.1 * env._walk.upright()[0], abs=1e-15)
    env._walk.x[0, 0] += 9e5
    assert env.step(action)[1:3] == (0.0, True)


def test_energy_is_what_the_actuators_give() -> None:
    # Without contact, drag and other forces than springs, a bar pulls by its stiffness times its elongation.
    scene = {**SCENE, "physics.contact": "none", "physics.damping": 0.0, "physics.dt": 0.0005}
    random = np.random.default_rng(0)
    # Every edge is a bar of skeleton or an actuator.
    arguments = {"z": np.eye(3)[random.integers(1, 3, 20)], "scatter": 0.01, "reward": {"energy": 1.0}}
    each, whole = (cosmic.gym.WalkEnv(scene, frame_skip=steps, **arguments) for steps in (1, 8))
    each.reset(seed=0), whole.reset(seed=0)
    sim, actuators = each._walk.sim, each._walk.core.actuators
    ends, rest = sim.edges[actuators], sim.rest_length[actuators]
    action = random.uniform(-1.0, 1.0, each.action_space.shape).astype(np.float32)
    given = 0.0
    for _ in range(8):
        x, v = each._walk.x[0].copy(), each._walk.v[0].copy()
        made = each.step(action)[1]
        d = np.diff(x[ends], axis=1)[:, 0]
        dv = np.diff((v + each._walk.v[0])[ends], axis=1)[:, 0] / 2.0
        length = np.linalg.norm(d, axis=1)
        pull = 30.0 * (length - rest * (1.0 + 0.35 * action))
        power = -pull * (d * dv).sum(axis=1) / length
        assert made == pytest.approx(sim.dt * np.maximum(power, 0.0).sum(), rel=1e-6)
        given += made
    assert given > 0.0 and whole.step(action)[1] == pytest.approx(given, rel=1e-12)


def test_rewards_of_given_goals_are_chosen() -> None:
    made = []
    for reward in ({"goal": 1.0}, None, {"distance": 1.0}, {"goal": 3.0, "distance": 0.5}):
        env = cosmic.gym.WalkEnv(GOALS, reward=reward, **FRAMES)
        env.reset(seed=0, options={"goal": -2.0})
        made.append(env.step(np.ones(env.action_space.shape, np.float32))[1])
    # The goal is behind the robot.
    assert made[0] == made[1] == pytest.approx(-made[2], abs=1e-15) != 0.0
    assert made[3] == pytest.approx(3.0 * made[0] + 0.5 * made[2], abs=1e-15)


def test_a_window_shows_the_robot() -> None:
    pygame = pytest.importorskip("pygame")
    env = gymnasium.make(NAME, robot=SCENE, render_mode="human", **FRAMES)
    shown = []
    env.reset(seed=0)
    for _ in range(2):
        shown.append(pygame.surfarray.array3d(pygame.display.get_surface()).swapaxes(0, 1))
        env.step(np.ones(env.action_space.shape, np.float32))
    assert env.render() is None
    drawn = cosmic.gym.WalkEnv(SCENE, render_mode="rgb_array", **FRAMES)
    drawn.reset(seed=0)
    assert np.array_equal(shown[0], drawn.render()) and (shown[1] != shown[0]).any()
    env.close()
    assert pygame.display.get_surface() is None


def test_a_window_without_pygame_names_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pygame", None)
    with pytest.raises(gymnasium.error.DependencyNotInstalled, match="pip install pygame-ce"):
        cosmic.gym.WalkEnv(SCENE, render_mode="human")


def test_pictures_show_the_robot() -> None:
    env = cosmic.gym.WalkEnv(SCENE, render_mode="rgb_array", **FRAMES)
    env.reset(seed=0)
    first = env.render()
    assert first.shape == (240, 480, 3) and first.dtype == np.uint8
    env.step(np.ones(env.action_space.shape, np.float32))
    assert (env.render() != first).any()
    assert env.metadata["render_fps"] == 10
    # A frame of 1024 steps lasts 2 s, but a video needs at least 1 frame per second.
    slow = cosmic.gym.WalkEnv({**SCENE, "physics.steps": 2048}, frame_skip=1024)
    assert slow.metadata["render_fps"] == 1


def test_the_robot_of_a_run_is_driven(run: cosmic.Run) -> None:
    env = cosmic.gym.WalkEnv(run, **FRAMES)
    actuators = np.flatnonzero(run.design.materials == 2)
    assert env.action_space.shape == actuators.shape
    _, info = env.reset(seed=0)
    # Some actions leave the payload where friction holds it, so they are drawn from a seed.
    env.action_space.seed(0)
    moved = [env.step(env.action_space.sample())[4]["along"] for _ in range(3)]
    assert np.all(np.isfinite(moved)) and moved[-1] != info["along"]
    other = np.roll(run.design.z, 1, axis=0)
    with_other = cosmic.gym.WalkEnv(run, other, **FRAMES)
    assert with_other.action_space.shape == actuators.shape


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ({"frame_skip": 0}, "frame_skip: 0: expected a whole number, 1 to 256"),
        ({"scatter": float("nan")}, "scatter: nan: expected a finite number, 0 m or more"),
        ({"render_mode": "ansi"}, "render_mode: 'ansi': allowed: None, 'human', 'rgb_array'"),
        ({"observation": "raw"}, "observation: 'raw': allowed: 'scaled', 'paper'"),
        ({"reward": {"speed": 1.0}}, "expected weights of the terms 'distance', 'energy', 'upright'"),
        ({"reward": {"goal": 1.0}}, "'goal' needs a scene with given goals"),
        ({"reward": {}}, "reward: {}: expected weights"),
        ({"reward": {"distance": float("inf")}}, "reward\\['distance'\\]: inf: expected a finite number"),
        ({"z": np.zeros((3, 3))}, r"z: expected the shape \[20, 3\]"),
        ({"z": np.tile([1.0, 0.0, 0.0], (20, 1))}, "no actuator"),
    ],
)
def test_wrong_arguments_are_refused(arguments: dict[str, Any], says: str) -> None:
    with pytest.raises(cosmic.InputError, match=says):
        cosmic.gym.WalkEnv(SCENE, **arguments)
    with pytest.raises(cosmic.InputError, match="num_envs: 0"):
        cosmic.gym.WalkVectorEnv(0, SCENE)
    with pytest.raises(cosmic.InputError, match="render_mode: 'human': allowed: None, 'rgb_array'"):
        cosmic.gym.WalkVectorEnv(2, SCENE, render_mode="human")


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ({"seed": "one"}, "seed: 'one': expected a whole number"),
        ({"seed": -1}, "seed: -1: expected a whole number, 0 or more"),
        ({"seed": [None, 1.5]}, "seed: "),
        ({"options": 3}, "options: 3: expected a dictionary"),
        ({"options": {"goal": "far"}}, "goal: "),
        ({"options": {"gaol": 1.0}}, "options: 'gaol': allowed: 'goal'"),
    ],
)
def test_wrong_resets_are_refused(arguments: dict[str, Any], says: str) -> None:
    for env in (cosmic.gym.WalkEnv(GOALS), cosmic.gym.WalkVectorEnv(2, GOALS)):
        with pytest.raises(cosmic.InputError, match=says):
            env.reset(**arguments)


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
    with pytest.raises(cosmic.InputError, match="expected 2 seeds, one per robot, found 1"):
        many.reset(seed=[1])
    with pytest.raises(cosmic.InputError, match="reset_mask: expected 2 booleans"):
        many.reset(options={"reset_mask": np.zeros(2, np.bool_)})
    with pytest.raises(cosmic.InputError, match="autoreset_mode: 'never': allowed: 'NextStep'"):
        cosmic.gym.WalkVectorEnv(2, SCENE, autoreset_mode="never")


MODES = list(gymnasium.vector.AutoresetMode)


def assert_equal_infos(ours: dict[str, Any], theirs: dict[str, Any]) -> None:
    assert ours.keys() == theirs.keys()
    for name, value in theirs.items():
        if isinstance(value, dict):
            assert_equal_infos(ours[name], value)
        elif value.dtype == object:
            pairs = zip(ours[name], value, strict=True)
            assert all((a is None) == (b is None) and np.array_equal(a, b) for a, b in pairs)
        else:
            assert ours[name].dtype == value.dtype and np.array_equal(ours[name], value), name


@pytest.mark.parametrize("scene", [SCENE, SPACE], ids=["plane", "space"])
@pytest.mark.parametrize("mode", MODES, ids=lambda mode: mode.value)
def test_many_robots_match_gymnasiums_sync_vector_env(mode: Any, scene: dict[str, Any]) -> None:
    robots, random = 4, np.random.default_rng(1)
    kwargs = {"robot": scene, **FRAMES}
    ours = gymnasium.make_vec(NAME, robots, autoreset_mode=mode, **kwargs)
    theirs = gymnasium.make_vec(
        NAME, robots, "sync", vector_kwargs={"autoreset_mode": mode}, **kwargs
    )
    # Only one robot can have a window.
    assert ours.metadata == {**theirs.metadata, "render_modes": ["rgb_array"]}
    assert ours.render_mode == theirs.render_mode
    for name in ("single_action_space", "action_space", "single_observation_space", "observation_space"):
        assert getattr(ours, name) == getattr(theirs, name)
    for seed in (3, [5, 6, 7, 8], [9, None, 9, None]):
        both = [each.reset(seed=seed) for each in (ours, theirs)]
        assert np.array_equal(both[0][0], both[1][0])
        assert_equal_infos(both[0][1], both[1][1])
    assert ours.np_random_seed == theirs.np_random_seed == (9, 6, 9, 8)
    # Sometimes a robot diverges; its observation then stays unchanged.
    for step in range(20):
        if mode.value == "Disabled" and ours._over.any() or step == 3:
            mask = ours._over.copy() if ours._over.any() else np.array([1, 0, 0, 1], np.bool_)
            both = [each.reset(options={"reset_mask": mask}) for each in (ours, theirs)]
            assert np.array_equal(both[0][0], both[1][0])
            assert_equal_infos(both[0][1], both[1][1])
        actions = random.uniform(-1.0, 1.0, ours.action_space.shape).astype(np.float32)
        for a, b in zip(ours.step(actions), theirs.step(actions), strict=True):
            if isinstance(b, dict):
                assert_equal_infos(a, b)
            else:
                assert a.dtype == b.dtype and np.array_equal(a, b)
    ours.close()
    theirs.close()
    assert ours.closed and theirs.closed
    assert gymnasium.make_vec(ours.spec).num_envs == robots


def test_without_autoreset_an_episode_that_is_over_stays_so() -> None:
    many = cosmic.gym.WalkVectorEnv(2, SCENE, autoreset_mode="Disabled", max_episode_steps=1, **FRAMES)
    many.reset(seed=0)
    actions = np.zeros(many.action_space.shape, np.float32)
    assert many.step(actions)[3].all()
    with pytest.raises(gymnasium.error.ResetNeeded, match=r"\[0, 1\] are over"):
        many.step(actions)


def test_both_environments_truncate_an_episode_alike() -> None:
    arguments = {"robot": SCENE, "max_episode_steps": 2, **FRAMES}
    one = gymnasium.make(NAME, **arguments)
    many = gymnasium.make_vec(NAME, 1, "vector_entry_point", **arguments)
    one.reset(seed=0), many.reset(seed=0)
    for over in (False, True):
        action = np.zeros(one.action_space.shape, np.float32)
        assert one.step(action)[3] is over and many.step(action[None])[3].tolist() == [over]


def test_robots_of_different_ages_act_alike() -> None:
    alone = cosmic.gym.WalkVectorEnv(3, SCENE, **FRAMES)
    mixed = cosmic.gym.WalkVectorEnv(3, SCENE, autoreset_mode="SameStep", **FRAMES)
    actions = np.random.default_rng(0).uniform(-1.0, 1.0, (5, *mixed.action_space.shape))
    alone.reset(seed=0), mixed.reset(seed=0)
    # The robots are 0, 1 and 4 frames old; the last one soon has a short frame.
    mixed._walk.done[:] = [0, 50, 200]
    for k, action in enumerate(actions):
        alone.step(action)
        _, _, _, over, _ = mixed.step(action)
        assert over.tolist() == [False, k == 4, k == 1]
        if k == 0:
            assert np.array_equal(alone._walk.x, mixed._walk.x)
        if k < 4:
            assert np.array_equal(alone._walk.x[:2], mixed._walk.x[:2])
            assert mixed._walk.done[:2].tolist() == [50 * (k + 1), 50 * (k + 2)]


def test_a_robot_that_diverges_ends_its_episode_alone() -> None:
    many = cosmic.gym.WalkVectorEnv(2, SCENE, **FRAMES)
    before, _ = many.reset(seed=0)
    many._walk.x[1, 0] += 9e5
    actions = np.zeros(many.action_space.shape, np.float32)
    seen, made, lost, over, _ = many.step(actions)
    assert lost.tolist() == [False, True] and not over.any() and made[1] == 0.0
    assert np.all(np.isfinite(seen))


#: Wrappers of gymnasium for one robot and for many robots, with their arguments.
WRAPPERS: list[tuple[str, dict[str, Any]]] = [
    ("TimeLimit", {"max_episode_steps": 3}),
    ("RecordEpisodeStatistics", {}),
    ("RescaleAction", {"min_action": np.float32(-2.0), "max_action": np.float32(2.0)}),
    ("FrameStackObservation", {"stack_size": 2}),
    ("NormalizeObservation", {}),
    ("AddRenderObservation", {}),
]


@pytest.mark.filterwarnings("ignore::DeprecationWarning")
@pytest.mark.parametrize(("name", "arguments"), WRAPPERS, ids=[name for name, _ in WRAPPERS])
def test_gymnasiums_wrappers_work_for_one_robot(name: str, arguments: dict[str, Any]) -> None:
    env: Any = cosmic.gym.WalkEnv(SCENE, render_mode="rgb_array", **FRAMES)
    wrapped = getattr(gymnasium.wrappers, name)(env, **arguments)
    observation, _ = wrapped.reset(seed=0)
    assert wrapped.observation_space.contains(observation)
    for _ in range(3):
        observation, reward, *_ = wrapped.step(wrapped.action_space.sample())
        assert wrapped.observation_space.contains(observation) and np.isfinite(reward)
    assert wrapped.render() is not None
    wrapped.close()


VECTOR_WRAPPERS: list[tuple[str, dict[str, Any]]] = [
    ("RecordEpisodeStatistics", {}),
    ("DictInfoToList", {}),
    ("NormalizeObservation", {}),
]


@pytest.mark.filterwarnings("ignore::DeprecationWarning")
@pytest.mark.parametrize(
    ("name", "arguments"), VECTOR_WRAPPERS, ids=[name for name, _ in VECTOR_WRAPPERS]
)
def test_gymnasiums_wrappers_work_for_many_robots(name: str, arguments: dict[str, Any]) -> None:
    many = cosmic.gym.WalkVectorEnv(3, SCENE, render_mode="rgb_array", **FRAMES)
    wrapped = getattr(gymnasium.wrappers.vector, name)(many, **arguments)
    wrapped.reset(seed=0)
    for _ in range(8):
        observation, reward, *_ = wrapped.step(wrapped.action_space.sample())
        assert wrapped.observation_space.contains(observation) and np.all(np.isfinite(reward))
    frames = wrapped.render()
    assert len(frames) == 3 and all(frame.shape == (240, 480, 3) for frame in frames)
    wrapped.close()


def test_environments_are_copied_with_their_state() -> None:
    action = np.full(cosmic.gym.WalkEnv(SCENE, **FRAMES).action_space.shape, 0.5, np.float32)
    env = cosmic.gym.WalkEnv(SCENE, **FRAMES)
    env.reset(seed=0)
    many = cosmic.gym.WalkVectorEnv(2, SCENE, **FRAMES)
    many.reset(seed=0)
    for copied in (copy.deepcopy, lambda it: pickle.loads(pickle.dumps(it))):
        twin, twins = copied(env), copied(many)
        assert np.array_equal(twin.step(action)[0], env.step(action)[0])
        assert np.array_equal(twins.step(np.stack([action] * 2))[0], many.step(np.stack([action] * 2))[0])
        # The next episode is the same too.
        assert np.array_equal(twin.reset()[0], env.reset()[0])


@pytest.mark.parametrize("observation", ["scaled", "paper"])
def test_large_numbers_stay_within_the_bounds(observation: str) -> None:
    scales = {f"controller.{of}_scale": 1e6 for of in ("goal", "offset", "velocity")}
    env = cosmic.gym.WalkEnv({**SCENE, **scales}, observation=observation, **FRAMES)
    env.reset(seed=0)
    env._walk.v[0] = 9e5
    assert env.observation_space.contains(env._walk.observe()[0])


def test_a_render_without_a_mode_warns() -> None:
    env = cosmic.gym.WalkEnv(SCENE, **FRAMES)
    env.reset(seed=0)
    with pytest.warns(UserWarning, match="render_mode='rgb_array'"):
        assert env.render() is None


def test_robots_have_their_own_bodies_and_physics() -> None:
    sim = cosmic.Simulator(SCENE)
    random = np.random.default_rng(0)
    z = sim.layout(random.uniform(size=(3, *sim.shapes["z"])))
    stiffness, gravity = random.uniform(0.8, 1.2, (3, 20)), np.array([1.0, 5.0, 9.0])
    physics = {"bars.stiffness": stiffness, "physics.gravity": gravity, "nodes.mass": 1.1}
    many = cosmic.gym.WalkVectorEnv(3, SCENE, z, physics=physics, reward={"distance": 1.0, "energy": 1.0}, **FRAMES)
    many.reset(seed=0)
    assert many.actuators == np.flatnonzero(z[..., 2].any(0)).tolist()
    assert (many.x.shape, many.v.shape) == ((3, 9, 2), (3, 9, 2))
    x, v = many.x, many.v
    actions = random.uniform(-1.0, 1.0, many.action_space.shape)
    _, rewards, *_ = many.step(actions)
    held = np.zeros((3, 20))
    held[:, many.actuators] = actions
    batch = {"bars.stiffness": stiffness, "physics.gravity": gravity, "nodes.mass": 1.1}
    expected = many.simulator.step(z, x, v, held, 50, physics=batch)
    assert np.array_equal(many.x, expected.x) and np.array_equal(many.v, expected.v)
    for k in range(3):
        own = {name: value if name == "nodes.mass" else value[k] for name, value in physics.items()}
        alone = cosmic.gym.WalkEnv(SCENE, z[k], physics=own, reward={"distance": 1.0, "energy": 1.0}, scatter=0.0, **FRAMES)
        alone.reset()
        alone._walk.x[0], alone._walk.v[0] = x[k], v[k]
        _, reward, *_ = alone.step(held[k, alone.actuators])
        assert np.array_equal(alone.x, many.x[k]) and reward == rewards[k]
    copied = pickle.loads(pickle.dumps(many))
    assert np.array_equal(copied.step(actions)[0], many.step(actions)[0])


def test_each_reset_draws_physics() -> None:
    def physics(random: np.random.Generator) -> dict[str, Any]:
        drawn.append(random.uniform(1.0, 9.0))
        return {"physics.gravity": drawn[-1]}

    drawn: list[float] = []
    many = cosmic.gym.WalkVectorEnv(2, SCENE, physics=physics, **FRAMES)
    many.reset(seed=3)
    many.reset(seed=3)
    assert len(set(drawn)) == 2 and drawn[:2] == drawn[2:]
    x, action = many.x, np.zeros(many.action_space.shape)
    many.step(action)
    rest = np.zeros_like(x)
    held = {"physics": {"physics.gravity": np.array(drawn[2:])}}
    z = many.simulator.initial().z
    assert np.array_equal(many.x, many.simulator.step(z, x, rest, np.zeros(20), 50, **held).x)
    for wrong, says in [
        ({"gravity": 1.0}, "physics: 'gravity': allowed: .*physics.gravity"),
        ({"physics.gravity": [1.0, 2.0, 3.0]}, "physics.gravity: expected finite numbers, for all robots or for 2"),
        ({"physics.gravity": np.nan}, "physics.gravity: expected finite"),
        (3.0, "physics: 3.0: expected a dictionary"),
    ]:
        with pytest.raises(cosmic.InputError, match=says):
            cosmic.gym.WalkVectorEnv(2, SCENE, physics=wrong)
        with pytest.raises(cosmic.InputError, match=says.replace("for 2", "for 1")):
            cosmic.gym.WalkEnv(SCENE, physics=lambda random: wrong).reset()
