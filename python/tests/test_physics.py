"""Rollouts with other physics and with given activations, and their derivatives."""

from __future__ import annotations

import pickle
from pathlib import Path
from typing import Any

import cosmic
import numpy as np
import pytest
from common import SHORT, airborne, like, like_robot, pairs, robot, same, stacked
from cosmic._simulator import DRIVEN, leaves, tree

SPAN = (48, 16)
#: A robot that slides on the ground, with laws that have settings.
SLIDING: dict[str, Any] = {
    **SHORT,
    "physics.contact": "coulomb",
    "physics.friction": 0.3,
    "physics.forces": ["damper", "stops"],
    "stops.at": 0.1,
}
#: Other physics, with a factor for all edges or nodes, and one for each.
NUMBERS = ("physics.gravity", "physics.damping", "physics.friction", "damper.time", "stops.stiffness")
FACTORS = ("bars.stiffness", "bars.strain", "bars.rest_length", "nodes.mass")


def pairing(a: Any, b: Any) -> float:
    """The inner product of two trees of arrays."""
    return float(sum(np.sum(x * y) for x, y in pairs(a, b)))


@pytest.fixture(scope="module", params=["explicit", "implicit"])
def sliding(request: pytest.FixtureRequest) -> cosmic.Simulator:
    integrator = {} if request.param == "explicit" else {"physics.integrator": "implicit"}
    return cosmic.Simulator({**SLIDING, **integrator}, "performance")


def all_physics(sim: cosmic.Simulator, seed: int = 0, each: bool = True) -> dict[str, np.ndarray]:
    """All that may be changed, a little off the values of the scene."""
    random = np.random.default_rng(seed)
    sizes = {name: (count if each else ()) for name, count in sim.factors.items()}
    return {
        name: value * random.uniform(0.98, 1.02, sizes.get(name, ())) for name, value in sim.physics.items()
    }


def test_physics_are_the_numbers_of_the_scene(sliding: cosmic.Simulator) -> None:
    assert set(sliding.physics) == {*NUMBERS, *FACTORS, "stops.at"}
    assert (sliding.physics["physics.friction"], sliding.physics["bars.stiffness"]) == (0.3, 1.0)
    inputs = robot(sliding, 0)
    like_scene = inputs._replace(physics={name: np.array(x) for name, x in sliding.physics.items()})
    # A factor of 1 changes no bit.
    assert same(sliding.rollout(like_scene, *SPAN), sliding.rollout(inputs, *SPAN))


@pytest.mark.parametrize("name", NUMBERS[:3])
def test_a_number_acts_as_in_the_scene(sliding: cosmic.Simulator, name: str) -> None:
    inputs = robot(sliding, 0)
    value = 0.9 * sliding.physics[name]
    other = cosmic.Simulator({"scene": sliding.scene, name: value}, "performance")
    changed = sliding.rollout(inputs._replace(physics={name: np.array(value)}), *SPAN)
    assert same(changed, other.rollout(inputs, *SPAN))
    assert not same(changed, sliding.rollout(inputs, *SPAN))


@pytest.mark.parametrize("each", [True, False], ids=["each", "all"])
def test_derivatives_by_physics_agree_with_differences(sliding: cosmic.Simulator, each: bool) -> None:
    inputs = robot(sliding, 0)._replace(physics=all_physics(sliding, each=each))
    bars = cosmic.Trajectory(*like(sliding.rollout(inputs, *SPAN), 1))
    gradient = sliding.vjp(inputs, bars, *SPAN)
    for name, array in inputs.physics.items():
        assert gradient.physics[name].shape == array.shape
        (direction,) = like([array], 2)
        tangents = tree({key: np.zeros_like(own) for key, own in leaves(inputs).items()})
        tangents.physics[name] = direction
        _, along = sliding.jvp(inputs, tangents, *SPAN)
        slope = float(np.sum(gradient.physics[name] * direction))
        # Both are exact up to rounding, which grows over the 48 steps.
        assert pairing(along, bars) == pytest.approx(slope, rel=1e-8)
        h = 1e-6 * max(1e-3, float(np.max(np.abs(array))))

        def shifted(step: float) -> float:
            moved = {**inputs.physics, name: array + step * direction}
            return pairing(sliding.rollout(inputs._replace(physics=moved), *SPAN), bars)

        difference = (shifted(h) - shifted(-h)) / (2.0 * h)
        # Rounding errors of 1e-13 divided by h, and the curvature of the motion.
        assert difference == pytest.approx(slope, rel=1e-4, abs=1e-6), name


def test_robots_of_a_batch_may_have_other_physics(sliding: cosmic.Simulator) -> None:
    inputs = robot(sliding, 0)
    alone = [all_physics(sliding, seed) for seed in range(5)]
    batch = {name: np.stack([own[name] for own in alone]) for name in alone[0]}
    together = sliding.rollout(inputs._replace(physics=batch), *SPAN)
    bars = cosmic.Trajectory(*like(together, 1))
    gradient = sliding.vjp(inputs._replace(physics=batch), bars, *SPAN)
    for k, own in enumerate(alone):
        of_one = inputs._replace(physics=own)
        assert same(sliding.rollout(of_one, *SPAN), (together.x[k], together.v[k]))
        by_own = sliding.vjp(of_one, cosmic.Trajectory(bars.x[k], bars.v[k]), *SPAN)
        assert same(by_own.physics, {name: array[k] for name, array in gradient.physics.items()})


def driven(sim: cosmic.Simulator, steps: int, seed: int = 0) -> cosmic.Inputs:
    """A robot with given activations, which never touches the ground."""
    activations = np.random.default_rng(seed).uniform(-1.0, 1.0, (steps, len(sim.edges)))
    return airborne(sim, seed)._replace(controller={DRIVEN: activations})


def test_given_activations_have_derivatives(sim: cosmic.Simulator) -> None:
    inputs = driven(sim, SPAN[0])
    tangents = like_robot(inputs, 1)
    seen, along = sim.jvp(inputs, tangents, *SPAN)
    bars = cosmic.Trajectory(*like(seen, 2))
    gradient = sim.vjp(inputs, bars, *SPAN)
    assert gradient.controller[DRIVEN].shape == inputs.controller[DRIVEN].shape
    # Both are exact up to rounding, which grows over the steps.
    assert pairing(along, bars) == pytest.approx(pairing(gradient, tangents), rel=1e-10)
    (direction,), h = like([inputs.controller[DRIVEN]], 3), 1e-6

    def shifted(step: float) -> float:
        moved = {DRIVEN: inputs.controller[DRIVEN] + step * direction}
        return pairing(sim.rollout(inputs._replace(controller=moved), *SPAN), bars)

    slope = float(np.sum(gradient.controller[DRIVEN] * direction))
    assert (shifted(h) - shifted(-h)) / (2.0 * h) == pytest.approx(slope, rel=1e-6)


def test_steps_one_after_the_other_are_a_rollout(sim: cosmic.Simulator) -> None:
    robots = [driven(sim, 12, seed) for seed in range(3)]
    batch = cosmic.Inputs(
        robots[0].z,
        {DRIVEN: np.stack([robot.controller[DRIVEN] for robot in robots])},
        *(np.stack([getattr(robot, name) for robot in robots]) for name in ("x0", "v0")),
    )
    whole = sim.rollout(batch, observed=range(13))
    x, v = batch.x0, batch.v0
    for step in range(12):
        x, v = sim.step(batch.z, x, v, batch.controller[DRIVEN][:, step], first=step)
        # A step converts the state to the ground's frame and back, which rounds at 1e-16.
        np.testing.assert_allclose(x, whole.x[:, step + 1], atol=1e-13)
        np.testing.assert_allclose(v, whole.v[:, step + 1], atol=1e-11)
    held = sim.step(batch.z, batch.x0[0], batch.v0[0], batch.controller[DRIVEN][0, 0], 5)
    repeated = {DRIVEN: np.repeat(batch.controller[DRIVEN][0, :1], 5, axis=0)}
    one = cosmic.Inputs(batch.z, repeated, batch.x0[0], batch.v0[0])
    assert same(held, tuple(states[0] for states in sim.rollout(one, observed=[5])))


def test_a_policy_holds_its_activations_for_a_frame(sim: cosmic.Simulator) -> None:
    batch = stacked([airborne(sim, seed) for seed in range(3)], shared=("x0",))
    weights = np.random.default_rng(1).normal(size=(12, len(sim.edges)))
    times = []

    def policy(x: np.ndarray, v: np.ndarray, time: float) -> np.ndarray:
        times.append(time)
        return np.tanh((x + 0.1 * v).reshape(*x.shape[:-2], 12) @ weights)

    seen = sim.rollout(batch, 48, policy=policy, frame_skip=8, first=32)
    np.testing.assert_allclose(times, sim.dt * np.arange(32, 80, 8), rtol=1e-15)
    x, v = np.broadcast_to(batch.x0, batch.v0.shape), batch.v0
    for step in range(0, 48, 8):
        x, v = sim.step(batch.z, x, v, policy(x, v, 0.0), 8, first=32 + step)
        if step % 16 == 8:
            place = (step + 8) // 16
            assert same((seen.x[:, place], seen.v[:, place]), (x, v))
    assert np.array_equal(seen.x[1, 0], batch.x0)
    still = sim.rollout(batch, observed=[0], policy=policy)
    assert np.array_equal(still.x[0, 0], batch.x0)
    for wrong, says in [
        ({"policy": 3}, "policy: 3: expected a function"),
        ({"frame_skip": 5}, "frame_skip: 5: .* step 16 is observed"),
        ({"frame_skip": 0}, "frame_skip: 0: expected"),
        ({"goal": 1.0}, "goal: a rollout with a policy"),
        ({"first": 250}, "step 298 is beyond"),
        ({"policy": lambda x, v, time: 0.0}, "activations: expected the shape"),
    ]:
        with pytest.raises(cosmic.InputError, match=says):
            sim.rollout(batch, 48, **{"policy": policy, **wrong})


def test_constant_activations_need_one_row(sim: cosmic.Simulator) -> None:
    steps, inputs = SPAN[0], driven(sim, 1)
    repeated = inputs._replace(controller={DRIVEN: np.repeat(inputs.controller[DRIVEN], steps, axis=0)})
    seen = sim.rollout(inputs, *SPAN)
    assert same(seen, sim.rollout(repeated, *SPAN))
    bars = cosmic.Trajectory(*like(seen, 1))
    one, each = (sim.vjp(robot, bars, *SPAN).controller[DRIVEN] for robot in (inputs, repeated))
    np.testing.assert_allclose(one[0], each.sum(0), rtol=1e-12)


def test_only_the_newest_simulators_are_kept(sim: cosmic.Simulator) -> None:
    for steps in range(1, 41):
        sim.rollout(driven(sim, steps), observed=[steps])
    assert len(sim._kept) == 32
    assert same(sim.rollout(driven(sim, 1), observed=[1]), cosmic.Simulator(SHORT).rollout(driven(sim, 1), observed=[1]))


def test_numbers_of_python_do_not_decide_the_precision(sim: cosmic.Simulator) -> None:
    single = tree({name: np.float32(array) for name, array in leaves(robot(sim, 0)).items()})
    assert sim.rollout(single._replace(physics={"physics.gravity": 9.81}), *SPAN).x.dtype == np.float32


def test_only_wanted_gradients_are_computed(sim: cosmic.Simulator) -> None:
    inputs = driven(sim, SPAN[0])._replace(physics={"physics.gravity": np.array(9.0)})
    bars = cosmic.Trajectory(*like(sim.rollout(inputs, *SPAN), 1))
    whole = leaves(sim.vjp(inputs, bars, *SPAN))
    for by in (("x0",), (DRIVEN, "v0"), ("z", "physics.gravity")):
        some = leaves(sim.vjp(inputs, bars, *SPAN, by=by))
        for name in by:
            # Rounding differs where numbers are constants.
            np.testing.assert_allclose(some[name], whole[name], rtol=1e-9, atol=1e-12)
    assert not some["x0"].any()
    for wrong in (3, "x0", ["w1"]):
        with pytest.raises(cosmic.InputError, match="by: "):
            sim.vjp(inputs, bars, *SPAN, by=wrong)


def test_a_driven_robot_that_diverges_says_where(sim: cosmic.Simulator) -> None:
    inputs = driven(sim, 48)._replace(physics={"bars.stiffness": np.array(1e9)})
    with pytest.raises(cosmic.DivergedError, match="step .* under the given activations and physics"):
        sim.rollout(inputs, *SPAN)
    with pytest.raises(cosmic.DivergedError, match="step .* under the given physics"):
        sim.rollout(airborne(sim)._replace(physics=inputs.physics), *SPAN)
    assert np.isnan(sim.rollout(inputs, *SPAN, check=False).x[-1]).all()


def test_wrong_physics_and_activations_are_refused(sliding: cosmic.Simulator) -> None:
    inputs, edges = robot(sliding, 0), len(sliding.edges)
    leapfrog = cosmic.Simulator({**SHORT, "physics.integrator": "leapfrog"}, "performance")
    for sim, wrong, says in [
        (sliding, {"physics": {"physics.gravty": 1.0}}, "physics: 'physics.gravty': allowed: physics.gravity"),
        (sliding, {"physics": {"gravity": 1.0}}, "expected a name of Simulator.physics"),
        (sliding, {"physics": {"physics.gravity": np.ones((2, 2))}}, r"physics.gravity: expected the shape \[\]"),
        (sliding, {"physics": {"bars.strain": np.ones(edges + 1)}}, "bars.strain: expected one factor or"),
        (sliding, {"physics": {"nodes.mass": np.ones(4)}}, r"for several robots \(batch, 1\) or \(batch, 6\)"),
        (sliding, {"physics": {"physics.gravity": "low"}}, "physics.gravity is of type"),
        (sliding, {"physics": {"physics.gravity": np.nan}}, "expected finite numbers"),
        (sliding, {"physics": 3}, "physics: expected a dictionary of arrays, found int"),
        (leapfrog, {"physics": {"physics.damping": 1.0}}, "physics: 'physics.damping': allowed"),
        (sliding, {"controller": {DRIVEN: np.zeros((47, edges))}}, r"activations: expected the shape \[48"),
        (sliding, {"controller": {**inputs.controller, DRIVEN: np.zeros((48, edges))}}, "or only activations"),
    ]:
        with pytest.raises(cosmic.InputError, match=says):
            sim.rollout(inputs._replace(**wrong), *SPAN)
    with pytest.raises(cosmic.InputError, match="tangents: expected the arrays z, .*physics.gravity"):
        sliding.jvp(inputs._replace(physics={"physics.gravity": 1.0}), inputs, *SPAN)


def test_a_formula_acts_like_the_same_law() -> None:
    damper = {**SHORT, "physics.forces": ["damper"], "damper.time": 1e-3}
    formula = {
        **SHORT,
        "physics.forces": ["bar_formula"],
        "bar_formula": {"tension": "a * stiffness * rate", "a": 1e-3},
    }
    scenes = {"damper.time": damper, "bar_formula.a": formula}
    sims = {name: cosmic.Simulator(scene, "performance") for name, scene in scenes.items()}
    inputs = robot(sims["damper.time"], 0)
    seen = [sim.rollout(inputs, *SPAN) for sim in sims.values()]
    # Rounding of 48 steps.
    np.testing.assert_allclose(seen[1].x, seen[0].x, rtol=0, atol=1e-12)
    bars = cosmic.Trajectory(*like(seen[0], 1))
    slopes = [
        sim.vjp(inputs._replace(physics={name: np.array(1e-3)}), bars, *SPAN).physics[name]
        for name, sim in sims.items()
    ]
    assert slopes[1] == pytest.approx(slopes[0], rel=1e-8) and slopes[0] != 0.0


def test_a_wrong_formula_is_refused_with_its_column() -> None:
    scene = {**SHORT, "physics.forces": ["bar_formula"], "bar_formula.tension": "2 * lenght"}
    with pytest.raises(cosmic.InputError, match="has the unknown name `lenght` at column 5"):
        cosmic.as_scene(scene)


@pytest.mark.parametrize("incline", [0.0, 20.0, -12.0])
@pytest.mark.parametrize(
    "ground",
    [
        {"profile": "flat"},
        {"profile": "points", "points": [[0.3, 0.0], [0.5, 0.02], [0.9, -0.03]]},
        {"profile": "points", "points": [[-0.4, 0.05], [-0.2, 0.0], [0.3, 0.0], [0.3, 0.04]]},
        {"profile": "rough", "from": -1.0},
    ],
    ids=["flat", "points", "wall", "rough"],
)
def test_the_height_of_the_ground_is_that_on_which_robots_stand(ground: dict[str, Any], incline: float) -> None:
    scene = {**SHORT, "physics.dt": 0.001, "ground": ground, "physics.incline_deg": incline}
    sim = cosmic.Simulator({**scene, "physics.gravity": 9.81})
    normal = np.array([-sim.along[1], sim.along[0]])
    seen = []
    for along in (-0.5, -0.15, 0.05, 0.35, 0.6, 1.5):
        start = sim.initial()
        moved = start.replace(x0=start.x0 + along * sim.along + 0.08 * normal)
        seen.append(sim.rollout(moved, observed=[250]).x[0])
    x = np.array(seen)
    # Above the highest ground in reach, because nodes at a steep incline or a wall may be beside the ground.
    above = (x[..., 1] - sim.ground(x[..., 0])) * np.cos(np.radians(incline))
    # Contacts put nodes onto the ground up to rounding.
    assert above.min() > -1e-9 and np.sum(abs(above) < 1e-9) >= 4, above
    assert sim.ground(np.nan).shape == () and np.isnan(sim.ground(np.nan))
    with pytest.raises(cosmic.InputError, match="x: expected an array"):
        sim.ground([[1.0], [1.0, 2.0]])


def test_activations_beyond_their_limits_are_refused(sim: cosmic.Simulator) -> None:
    inputs, edges = robot(sim, 0), len(sim.edges)
    given = np.full((16, edges), 1.0)
    sim.rollout(inputs.replace(controller={DRIVEN: given}), 16)
    given[3, 2] = -1.5
    with pytest.raises(cosmic.InputError, match=r"activations\[3, 2\] is -1.5: expected numbers from -1 to 1"):
        sim.rollout(inputs.replace(controller={DRIVEN: given}), 16)
    with pytest.raises(cosmic.InputError, match="expected numbers from -1 to 1"):
        sim.rollout(inputs, 32, policy=lambda x, v, time: np.full(edges, 1.1))
    # A direction has no limits.
    along = inputs.replace(controller={DRIVEN: np.full((16, edges), 7.0)})
    sim.jvp(inputs.replace(controller={DRIVEN: 0.0 * given}), along, 16)


def test_a_motion_becomes_a_gif(sim: cosmic.Simulator, run: cosmic.Run, tmp_path: Path) -> None:
    edges, inputs = len(sim.edges), sim.initial()
    policies = {"still": lambda x, v, time: np.zeros(edges), "moved": lambda x, v, time: np.full(edges, np.sin(40 * time))}
    sizes = {}
    for name, policy in policies.items():
        seen = sim.rollout(inputs, 128, policy=policy)
        path = sim.animate(seen, tmp_path / f"{name}.gif", inputs.z, 128)
        sizes[name] = path.read_bytes()
        assert path == tmp_path / f"{name}.gif" and sizes[name][:6] == b"GIF89a"
        # Without `steps`, states are `observed` steps apart.
        assert sim.animate(seen, str(tmp_path / "same.gif"), inputs.z).read_bytes() == sizes[name]
    assert sizes["still"] != sizes["moved"]
    # The simulator of a run knows its design, also as a copy.
    own = pickle.loads(pickle.dumps(run.simulator()))
    own.animate(cosmic.Trajectory(run.trajectory, run.velocities), tmp_path / "run.gif", observed=run.steps)
    run.report(tmp_path / "report")
    assert (tmp_path / "run.gif").read_bytes() == (tmp_path / "report/gait.gif").read_bytes()
    for arguments, says in [
        ((seen, "walk.mp4", inputs.z), "path: 'walk.mp4': expected a name that ends in .gif"),
        ((seen, "walk.gif"), "z: expected the design of the robot"),
        ((seen, "walk.gif", inputs.z[:3]), r"z: expected the shape \[11, 3\]"),
        ((seen, "walk.gif", inputs.z, 64), "trajectory: 9 states, but"),
        (([seen.x[None]], "walk.gif", inputs.z), "trajectory: expected the shape .* for one robot"),
        (([np.nan * seen.x], "walk.gif", inputs.z), "trajectory: expected finite numbers"),
    ]:
        with pytest.raises(cosmic.InputError, match=says):
            sim.animate(*arguments)
