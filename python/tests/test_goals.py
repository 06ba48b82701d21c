"""Goals as inputs of rollouts, of losses and of environments."""

from __future__ import annotations

import copy
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import cosmic
import numpy as np
import pytest
from common import GOALS, SEED, airborne, like, like_robot, mapped, one_of, pairs, robot, same, stacked

SPAN = (256, 16)
#: An episode has six frames; the last one is shorter.
FRAMES: dict[str, Any] = {"frame_skip": 50}
#: The robot of GOALS in space. Its goals are also beside it.
GOALS_IN_SPACE: dict[str, Any] = {
    **GOALS,
    "lattice.kind": "cubic",
    "lattice.depth": 2,
    "goals": {"along": [-1.5, 1.5], "across": [-0.5, 1.0]},
}
#: The goal changes after 50 and 150 steps of 1 ms.
CHANGES = [(0, 1.2), (0.05, -1.2), (0.15, (0.8, 0.1))]


@pytest.fixture(scope="module")
def sim() -> cosmic.Simulator:
    """A simulator of robots that observe their goals."""
    return cosmic.Simulator(GOALS)


def test_a_goal_counts_from_the_payload(sim: cosmic.Simulator) -> None:
    inputs = robot(sim, 0)
    start = sim.initial().x0[0]
    for goal, point in [(1.2, start + [1.2, 0.0]), ((-1.2, 0.3), start + [-1.2, 0.3])]:
        scene = {"scene": sim.scene, "controller.goal": point}
        seen = sim.rollout(inputs, *SPAN, goal=goal)
        assert same(seen, cosmic.Simulator(scene).rollout(inputs, *SPAN))
        assert not same(seen, sim.rollout(inputs, *SPAN))
    # The scene's goal is 2 m from the world's origin and 0.1 m above the ground. The payload starts at the origin.
    assert same(sim.rollout(inputs, *SPAN, goal=(2.0, 0.1)), sim.rollout(inputs, *SPAN))


def test_the_frame_of_a_goal_is_that_of_the_ground() -> None:
    scene = {**GOALS, "physics.incline_deg": 10.0}
    sim = cosmic.Simulator(scene)
    inputs, start = robot(sim, 0), sim.initial().x0[0]
    up = np.array([-sim.along[1], sim.along[0]])
    point = [start @ sim.along + 1.2, start @ up]
    expected = cosmic.Simulator({**scene, "controller": {**GOALS["controller"], "goal": point}})
    # The payload is rotated into the ground's frame here and in the library.
    for array, other in zip(sim.rollout(inputs, *SPAN, goal=1.2), expected.rollout(inputs, *SPAN)):
        np.testing.assert_allclose(array, other, atol=1e-10)


def test_a_goal_that_changes_is_a_sequence_of_rollouts(sim: cosmic.Simulator) -> None:
    inputs = robot(sim, 0)
    seen = sim.rollout(inputs, observed=[50, 100, 150, 256], goal=CHANGES)
    now, before = inputs, 0
    for step, goal in [(50, 1.2), (150, -1.2), (256, (0.8, 0.1))]:
        leg = sim.rollout(now, observed=[step - before], first=before, goal=goal)
        now, before = now._replace(x0=leg.x[-1], v0=leg.v[-1]), step
        # Passing a state on rounds it, as in `test_a_rollout_can_continue_another`.
        np.testing.assert_allclose(leg.x[-1], seen.x[[50, 100, 150, 256].index(step)], atol=1e-12)
    one_goal = sim.rollout(inputs, observed=[50, 100, 150, 256], goal=1.2)
    assert same((seen.x[0],), (one_goal.x[0],)) and not np.array_equal(seen.x[1], one_goal.x[1])
    # The times are those of the clock.
    middle = inputs._replace(x0=seen.x[0], v0=seen.v[0])
    rest = sim.rollout(middle, observed=[206], first=50, goal=CHANGES)
    np.testing.assert_allclose(rest.x[-1], seen.x[-1], atol=1e-12)


@pytest.mark.parametrize("shared", [("controller",), ()], ids=["one controller", "many"])
def test_robots_with_other_goals_equal_single_robots(
    sim: cosmic.Simulator, shared: tuple[str, ...]
) -> None:
    robots = [robot(sim, seed) for seed in range(5)]
    batch = stacked(robots, shared)
    places = np.linspace(-1.5, 1.5, 5)[:, None]
    seen = sim.rollout(batch, *SPAN, goal=places)
    changed = sim.rollout(batch, *SPAN, goal=[(0, places), (0.05, 0.5), (0.15, -places)])
    for k in range(5):
        own = one_of(batch, k, shared)
        place = float(places[k, 0])
        assert same((seen.x[k], seen.v[k]), sim.rollout(own, *SPAN, goal=place))
        legs = [(0, place), (0.05, 0.5), (0.15, -place)]
        assert same((changed.x[k], changed.v[k]), sim.rollout(own, *SPAN, goal=legs))
    # One robot with many goals, and many robots with one goal.
    many = sim.rollout(robots[0], *SPAN, goal=places)
    assert same((many.x[3], many.v[3]), sim.rollout(robots[0], *SPAN, goal=float(places[3, 0])))
    one = sim.rollout(batch, *SPAN, goal=0.7)
    assert same((one.x[0], one.v[0]), sim.rollout(robots[0], *SPAN, goal=0.7))


def test_single_precision_stays_single(sim: cosmic.Simulator) -> None:
    narrow = mapped(np.float32, robot(sim, 0))
    assert sim.rollout(narrow, *SPAN, goal=CHANGES).x.dtype == np.float32


def test_gradients_by_goals_agree_with_differences(sim: cosmic.Simulator) -> None:
    inputs, places = airborne(sim), np.array([0.1, -0.15, 0.2])

    def goal(places: Any) -> Any:
        return [(0, places[0]), (0.05, (places[1], 0.05)), (0.15, places[2])]

    seen = sim.rollout(inputs, *SPAN, goal=goal(places))
    bars = cosmic.Trajectory(*like(seen, 1))
    gradient, by_goal = sim.vjp(inputs, bars, *SPAN, goal=goal(places))
    assert by_goal.shape == (3, 2)
    for k in range(3):
        # The observed goal changes over a distance of 1/3 m, so the difference errs by (3 h)**2. Rounding errors, which the walk
        # has amplified to 1e-13, are divided by 2 h and by the gradient, 5e-3. With h = 1e-4 the sum is below 1e-6.
        h = 1e-4 * np.eye(3)[k]
        ahead, behind = (sim.rollout(inputs, *SPAN, goal=goal(places + step)) for step in (h, -h))
        difference = sum(np.sum((a - b) * bar) for a, b, bar in zip(ahead, behind, bars)) / 2e-4
        assert by_goal[k, 0] != 0.0
        assert difference == pytest.approx(by_goal[k, 0], rel=2e-6)
    # The other gradients are those of the same rollout.
    direction = like_robot(inputs, 2)
    again, slopes = sim.jvp(inputs, direction, *SPAN, goal=goal(places))
    np.testing.assert_allclose(again.x, seen.x, atol=1e-12)
    forward = sum(np.sum(slope * bar) for slope, bar in zip(slopes, bars))
    reverse = sum(np.sum(array * way) for array, way in pairs(gradient, direction))
    # Two exact derivatives; they differ by rounding.
    assert forward == pytest.approx(reverse, rel=1e-9)


def test_gradients_of_a_batch_of_goals_equal_single_gradients(sim: cosmic.Simulator) -> None:
    inputs, places = robot(sim, 0), np.array([[0.5, 0.0], [-0.5, 0.1]])
    bars = cosmic.Trajectory(*like(sim.rollout(inputs, *SPAN, goal=places), 1))
    gradient, by_goal = sim.vjp(inputs, bars, *SPAN, goal=places)
    assert by_goal.shape == (2, 1, 2)
    for k in range(2):
        own = cosmic.Trajectory(bars.x[k], bars.v[k])
        expected, of_goal = sim.vjp(inputs, own, *SPAN, goal=tuple(places[k]))
        assert same(one_of(gradient, k), expected)
        assert same((by_goal[k],), (of_goal,))
    without = sim.vjp(inputs, cosmic.Trajectory(bars.x[0], bars.v[0]), *SPAN)
    assert isinstance(without, cosmic.Inputs)


def test_goals_in_space_have_three_components() -> None:
    space = cosmic.Simulator(GOALS_IN_SPACE)
    inputs, start = robot(space, 0), space.initial().x0[0]
    for goal, way in [(1.2, [1.2, 0, 0]), ((1.2, 0.5), [1.2, 0.5, 0]), ((-1.2, 0.5, 0.3), [-1.2, 0.5, 0.3])]:
        scene = {"scene": space.scene, "controller.goal": start + way}
        assert same(space.rollout(inputs, *SPAN, goal=goal), cosmic.Simulator(scene).rollout(inputs, *SPAN))
    with pytest.raises(cosmic.InputError, match=r"\(along, across\).*found the shape \[4\]"):
        space.rollout(inputs, *SPAN, goal=[1.0, 2.0, 3.0, 4.0])
    places = np.array([[0.5, 0.2], [-0.4, 0.1]])
    batch = space.rollout(inputs, *SPAN, goal=places)
    assert same((batch.x[1], batch.v[1]), space.rollout(inputs, *SPAN, goal=tuple(places[1])))
    # The derivative by the goal, while the robot flies.
    inputs = airborne(space)

    def goal(place: Any) -> Any:
        return [(0, place), (0.05, (-0.2, 0.1, 0.05))]

    place = np.array([0.3, -0.2, 0.1])
    seen = space.rollout(inputs, *SPAN, goal=goal(place))
    bars = cosmic.Trajectory(*like(seen, 1))
    _, by_goal = space.vjp(inputs, bars, *SPAN, goal=goal(place))
    assert by_goal.shape == (2, 3) and np.all(by_goal != 0.0)
    for k in range(3):
        # As in the plane.
        h = 1e-5 * np.eye(3)[k]
        ahead, behind = (space.rollout(inputs, *SPAN, goal=goal(place + step)) for step in (h, -h))
        difference = sum(np.sum((a - b) * bar) for a, b, bar in zip(ahead, behind, bars)) / 2e-5
        assert difference == pytest.approx(by_goal[0, k], rel=1e-6)


def test_a_goal_that_is_not_finite_affects_only_its_robot(sim: cosmic.Simulator) -> None:
    places = np.array([[1.0], [np.nan]])
    seen = sim.rollout(robot(sim, 0), *SPAN, goal=places, check=False)
    assert np.all(np.isfinite(seen.x[0])) and np.all(np.isnan(seen.x[1]))


def test_a_robot_with_a_goal_that_diverges_is_named(sim: cosmic.Simulator) -> None:
    inputs = robot(sim, 0)
    starts = np.stack([inputs.v0, inputs.v0 + 1e9])
    with pytest.raises(cosmic.DivergedError, match="robot 1: diverged in step 0"):
        sim.rollout(inputs._replace(v0=starts), *SPAN, goal=CHANGES)


WRONG: dict[str, tuple[Any, list[str]]] = {
    "NaN": (np.nan, ["goal[0, 0] is nan", "finite"]),
    "text": ("ahead", ["goal", "expected float"]),
    "three": ([1.0, 2.0, 3.0], ["(batch, 1)", "found the shape [3]"]),
    "nothing": ([], ["goal", "[0]"]),
    "axes": (np.zeros((1, 1, 2)), ["[1, 1, 2]"]),
    "no robots": (np.zeros((0, 2)), ["goal: the batch has no robots"]),
    "batches": ([(0, np.zeros((2, 1))), (0.1, np.zeros((3, 1)))], ["[2, 3] robots"]),
    "late": ([(0.1, 1.0)], ["[0.1] s", "begin with 0"]),
    "descending": ([(0, 1.0), (0.2, 1.0), (0.1, 1.0)], ["[0, 0.2, 0.1] s", "ascend"]),
    "at once": ([(0, 1.0), (0.0001, 2.0)], ["ascend by a time step"]),
    "time": ([(0, 1.0), (-1, 2.0)], ["a time is -1", "0 or more"]),
    "triple": ([(0, 1.0, 2.0)], ["pairs (seconds, goal)"]),
}


@pytest.mark.parametrize("what", WRONG)
def test_a_wrong_goal_is_named(sim: cosmic.Simulator, what: str) -> None:
    goal, words = WRONG[what]
    with pytest.raises(cosmic.InputError) as raised:
        sim.rollout(robot(sim, 0), *SPAN, goal=goal)
    assert all(word in str(raised.value) for word in words), str(raised.value)


def test_the_number_of_goals_is_that_of_the_robots(sim: cosmic.Simulator) -> None:
    batch = stacked([robot(sim, seed) for seed in range(3)])
    with pytest.raises(cosmic.InputError, match="goal: 2 robots, but v0 has 3"):
        sim.rollout(batch, *SPAN, goal=np.zeros((2, 1)))


def test_scenes_with_a_fixed_goal_refuse_goals() -> None:
    fixed = cosmic.Simulator({**GOALS, "scene": "stability"})
    inputs = fixed.initial()
    bars = fixed.rollout(inputs, 32)
    for call in (
        lambda: fixed.rollout(inputs, 32, goal=1.0),
        lambda: fixed.vjp(inputs, bars, 32, goal=1.0),
        lambda: fixed.jvp(inputs, inputs, 32, goal=1.0),
    ):
        with pytest.raises(cosmic.InputError, match="`controller.goals`"):
            call()


def test_a_run_with_goals_is_read_and_simulated() -> None:
    run = cosmic.optimize(GOALS, SEED, iterations=2, progress=False)
    sim = run.simulator()
    assert run.controller["w1_behind"].shape == sim.shapes["w1_behind"] == (6, 36)
    assert same((sim.rollout(run.inputs, observed=run.steps).x,), (run.trajectory,))
    saved = (run.folder / "design.json").read_text()
    assert '"w1_behind"' in saved and np.any(run.controller["w1_behind"] != run.controller["w1_ahead"])


def test_a_loss_gets_the_goals_of_its_states() -> None:
    goals: list[np.ndarray] = []

    def near(x: np.ndarray, v: np.ndarray, goal: np.ndarray) -> Any:
        goals.append(goal)
        off = x[:, 0, 0] - goal[:, 0]
        by_x = np.zeros_like(x)
        by_x[:, 0, 0] = 2.0 * off
        return np.sum(off**2), by_x, np.zeros_like(v)

    loss = cosmic.Loss(near, observed=lambda steps: [*range(1, steps + 1)])
    cosmic.optimize(GOALS, SEED, loss=loss, progress=False)
    lengths = {len(goal): goal for goal in goals}
    assert all(goal.shape[1] == 2 for goal in goals)
    # A gradient has one goal; a robot is ranked with three, which change after 85 and 170 steps.
    assert len(np.unique(lengths[128][:, 0])) == 1
    ranked = next(goal for goal in goals if len(np.unique(goal[:, 0])) == 3)
    assert np.flatnonzero(np.diff(ranked[:, 0])).tolist() == [84, 169]


def test_a_loss_in_space_gets_goals_with_three_components() -> None:
    goals: list[np.ndarray] = []

    def near(x: np.ndarray, v: np.ndarray, goal: np.ndarray) -> Any:
        goals.append(goal)
        off = x[:, 0] - goal
        by_x = np.zeros_like(x)
        by_x[:, 0] = 2.0 * off
        return np.sum(off**2), by_x, np.zeros_like(v)

    run = cosmic.optimize(GOALS_IN_SPACE, SEED, loss=cosmic.Loss(near), iterations=2, progress=False)
    assert run.trajectory.shape[2] == 3
    assert all(goal.shape == (len(goal), 3) for goal in goals)
    across = np.unique(np.concatenate(goals)[:, 1])
    assert len(across) > 20 and across.min() < -0.3 and across.max() > 0.6


@contextmanager
def double_precision(jax: Any) -> Iterator[None]:
    before = jax.config.jax_enable_x64
    jax.config.update("jax_enable_x64", True)
    yield
    jax.config.update("jax_enable_x64", before)


def test_goals_in_jax(sim: cosmic.Simulator) -> None:
    jax = pytest.importorskip("jax")
    import cosmic.jax

    with double_precision(jax):
        inputs, places = robot(sim, 0), np.array([0.5, -0.4, 0.1])

        def height(place: Any) -> Any:
            goal = [(0, place), (0.1, (-place, 0.1))]
            return cosmic.jax.rollout(sim, inputs, *SPAN, goal=goal).x[:, 0, 1].sum()

        heights, slopes = jax.jit(jax.vmap(jax.value_and_grad(height)))(places)
        forward = jax.jit(jax.vmap(jax.jacfwd(height)))(places)
        assert np.asarray(forward) == pytest.approx(np.asarray(slopes), rel=1e-9)
        for place, found, slope in zip(places, heights, slopes):
            goal = [(0, place), (0.1, (-place, 0.1))]
            seen = sim.rollout(inputs, *SPAN, goal=goal)
            # JAX may sum in another order.
            assert float(found) == pytest.approx(float(seen.x[:, 0, 1].sum()), rel=1e-14)
            bars = cosmic.Trajectory(np.zeros_like(seen.x), np.zeros_like(seen.v))
            bars.x[:, 0, 1] = 1.0
            _, by_goal = sim.vjp(inputs, bars, *SPAN, goal=goal)
            assert float(slope) == pytest.approx(by_goal[0, 0] - by_goal[1, 0], rel=1e-12)
        with pytest.raises(cosmic.InputError, match="use jax.vmap"):
            cosmic.jax.rollout(sim, inputs, *SPAN, goal=places[:, None])
        fixed = cosmic.Simulator({**GOALS, "scene": "stability"})
        with pytest.raises(cosmic.InputError, match="`controller.goals`"):
            cosmic.jax.rollout(fixed, fixed.initial(), *SPAN, goal=1.0)


def test_goals_in_torch(sim: cosmic.Simulator) -> None:
    torch = pytest.importorskip("torch")
    import cosmic.torch

    plain = robot(sim, 0)
    inputs = cosmic.torch.inputs(plain, requires_grad=True)
    place = torch.tensor(0.5, dtype=torch.float64, requires_grad=True)
    seen = cosmic.torch.rollout(sim, inputs, *SPAN, goal=[(0, place), (0.1, -place)])
    expected = sim.rollout(plain, *SPAN, goal=[(0, 0.5), (0.1, -0.5)])
    assert same([array.detach().numpy() for array in seen], expected)
    seen.x.sum().backward()
    bars = cosmic.Trajectory(np.ones_like(expected.x), np.zeros_like(expected.v))
    gradient, by_goal = sim.vjp(plain, bars, *SPAN, goal=[(0, 0.5), (0.1, -0.5)])
    assert same(mapped(lambda array: array.grad.numpy(), inputs), gradient)
    assert float(place.grad) == pytest.approx(by_goal[0, 0] - by_goal[1, 0], rel=1e-12)


gymnasium: Any = pytest.importorskip("gymnasium")
import cosmic.gym  # noqa: E402
from gymnasium.utils.env_checker import check_env  # noqa: E402


@pytest.mark.filterwarnings("error")
def test_an_environment_with_goals_passes_the_checks_of_gymnasium() -> None:
    check_env(gymnasium.make("cosmic.gym:cosmic/Walk-v0", robot=GOALS, **FRAMES).unwrapped, skip_render_check=True)


def offset(env: Any, observation: np.ndarray) -> np.ndarray:
    """The offset `d` of a goal that is observed as `s d / sqrt(1 + s**2 d**2)` with the scale `s` of 3 / m."""
    clocks = env.observation_space.shape[0] - 2 - 4 * len(env._walk.rest)
    goal = observation[clocks : clocks + 2]
    return goal / (3.0 * np.sqrt(1.0 - goal @ goal))


def test_the_goal_is_observed_and_changes_within_an_episode() -> None:
    env = cosmic.gym.WalkEnv(GOALS, scatter=0.0, observation="paper", **FRAMES)
    still = np.zeros(env.action_space.shape, np.float32)

    def episode(goal: Any) -> tuple[list[float], list[np.ndarray]]:
        observation, info = env.reset(seed=0, options={"goal": goal})
        places, offsets = [info["goal"]], [offset(env, observation)]
        for _ in range(6):
            observation, *_, info = env.step(still)
            places.append(info["goal"])
            offsets.append(offset(env, observation))
        return places, offsets

    places, changed = episode([(0, 1.2), (0.05, -1.2), (0.125, 0.0)])
    # The payload starts at 0 m. A frame takes 0.05 s; the third goal counts from the next frame on.
    assert places == pytest.approx([1.2, -1.2, -1.2, 0.0, 0.0, 0.0, 0.0], abs=1e-15)
    # Without activations the robot moves alike, so the offsets differ by the goals.
    _, fixed = episode((0.2, 0.1))
    for place, a, b in zip(places, changed, fixed):
        # The observation has 16 digits, of which a far goal loses two.
        assert a - b == pytest.approx([place - 0.2, -0.1], abs=1e-13)


def walked(env: Any, **options: Any) -> tuple[float, float, float]:
    """The first position, the sum of the rewards and the last position of an episode."""
    _, info = env.reset(seed=3, **options)
    start, made, over = info["along"], 0.0, False
    while not over:
        action = np.ones(env.action_space.shape, np.float32)
        _, reward, lost, over, info = env.step(action)
        assert not lost
        made += reward
    return start, made, info["along"]


@pytest.mark.parametrize("place", [0.8, -0.8])
def test_rewards_add_up_to_the_way_made_good(place: float) -> None:
    env = cosmic.gym.WalkEnv(GOALS, **FRAMES)
    start, made, end = walked(env, options={"goal": place})
    # The payload starts at 0 m. A sum of six differences of numbers below one.
    assert made == pytest.approx(abs(place - start) - abs(place - end), abs=1e-14) and made != 0.0
    assert made == pytest.approx(np.sign(place) * (end - start), abs=1e-14)


@pytest.mark.filterwarnings("error")
def test_an_environment_in_space_has_goals_across() -> None:
    made = gymnasium.make("cosmic.gym:cosmic/Walk-v0", robot=GOALS_IN_SPACE, **FRAMES).unwrapped
    check_env(made, skip_render_check=True)
    env = cosmic.gym.WalkEnv(GOALS_IN_SPACE, **FRAMES)
    _, first = env.reset(seed=3, options={"goal": (0.8, -0.5)})
    payload = env._walk.rest[0]
    assert [first["goal"], first["goal_across"]] == pytest.approx(payload[:2] + [0.8, -0.5], abs=1e-15)
    made_good, over, info = 0.0, False, first
    while not over:
        _, reward, _, over, info = env.step(np.ones(env.action_space.shape, np.float32))
        made_good += reward
    away = [np.hypot(at["goal"] - at["along"], at["goal_across"] - at["across"]) for at in (first, info)]
    # A sum of six differences of numbers below one.
    assert made_good == pytest.approx(away[0] - away[1], abs=1e-14) and made_good != 0.0
    drawn = []
    for seed in range(40):
        env.reset(seed=seed)
        (goals,) = env._walk.goals
        drawn += [*(goals.points[:, 1] - payload[1])]
    assert -0.5 <= min(drawn) < -0.4 and 0.9 < max(drawn) <= 1.0
    many = cosmic.gym.WalkVectorEnv(3, GOALS_IN_SPACE, **FRAMES)
    places = np.array([[0.5, 0.1], [-0.5, 0.2], [1.0, -0.3]])
    _, infos = many.reset(options={"goal": places})
    assert infos["goal_across"] == pytest.approx(payload[1] + places[:, 1])


def test_drawn_goals_are_those_of_the_scene_and_of_the_seed() -> None:
    env = cosmic.gym.WalkEnv(GOALS, **FRAMES)

    def drawn(seed: int | None) -> list[float]:
        env.reset(seed=seed)
        (goals,) = env._walk.goals
        assert goals.changes == [85, 170]
        return list(goals.points[:, 0])

    places = [drawn(seed) for seed in range(40)]
    assert drawn(0) == places[0] and drawn(None) != places[0]
    for of_seed in places:
        assert all(abs(place) <= 1.5 for place in of_seed)
        assert np.abs(np.diff([0.0, *of_seed])).min() > 0.75 - 1e-12
    # Both sides are drawn, each with a probability of one half.
    assert 8 <= sum(of_seed[0] > 0.0 for of_seed in places) <= 32


def test_many_robots_with_goals_equal_single_robots() -> None:
    def made() -> Any:
        return cosmic.gym.WalkEnv(GOALS, **FRAMES)

    ours = cosmic.gym.WalkVectorEnv(3, GOALS, autoreset_mode="SameStep", **FRAMES)
    theirs = gymnasium.vector.SyncVectorEnv([made] * 3, autoreset_mode=ours.autoreset_mode)
    random = np.random.default_rng(0)
    for options in (None, {"goal": [(0, 0.7), (0.2, -0.7)]}):
        both = [each.reset(seed=5, options=copy.copy(options)) for each in (ours, theirs)]
        assert np.array_equal(both[0][0], both[1][0])
        for _ in range(9):
            actions = random.uniform(-1.0, 1.0, ours.action_space.shape).astype(np.float32)
            a, b = ours.step(actions), theirs.step(actions)
            assert all(np.array_equal(x, y) for x, y in zip(a[:4], b[:4]))
            assert np.array_equal(a[4]["goal"], b[4]["goal"])
    places = np.array([[0.5], [-0.5], [1.0]])
    _, info = ours.reset(options={"goal": places})
    assert info["goal"] == pytest.approx(places[:, 0])


def test_wrong_goals_of_a_reset_are_refused() -> None:
    env = cosmic.gym.WalkEnv(GOALS, **FRAMES)
    for goal, words in [
        (np.zeros((2, 1)), "goals for 1 robots, found 2"),
        (np.nan, "finite numbers"),
        ("ahead", "finite numbers"),
    ]:
        with pytest.raises(cosmic.InputError, match=words):
            env.reset(options={"goal": goal})
    with pytest.raises(cosmic.InputError, match="`controller.goals`"):
        cosmic.gym.WalkEnv({**GOALS, "scene": "stability"}, **FRAMES).reset(options={"goal": 1.0})
