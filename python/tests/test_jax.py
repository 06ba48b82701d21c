"""Rollouts in JAX: derivatives, compilation, batches and losses."""

from __future__ import annotations

import gc
import os
import subprocess
import sys
from functools import partial

import cosmic
import numpy as np
import pytest
from common import (
    SCENE,
    SEED,
    airborne,
    beginning,
    changed,
    is_same_run,
    is_shared,
    like_robot,
    mapped,
    one_of,
    pairs,
    robot,
    same,
    stacked,
)
from cosmic._simulator import leaves, tree

jax = pytest.importorskip("jax")
import cosmic.jax  # noqa: E402
import jax.numpy as jnp  # noqa: E402
from jax.test_util import check_grads  # noqa: E402

SPAN = (32, 16)


@pytest.fixture(autouse=True)
def double_precision():
    """Sets JAX to double precision for the tests of this file."""
    before = jax.config.jax_enable_x64
    jax.config.update("jax_enable_x64", True)
    yield
    jax.config.update("jax_enable_x64", before)


def number(sim: cosmic.Simulator):
    """A function that computes one number from all states of a rollout, not linearly."""

    def of(inputs: cosmic.Inputs):
        seen = cosmic.jax.rollout(sim, inputs, *SPAN)
        return jnp.sum(jnp.sin(3.0 * seen.x)) + jnp.sum(jnp.cos(seen.v))

    return of


def test_all_derivatives_at_once(sim: cosmic.Simulator) -> None:
    # JAX uses a step of about 1e-6 in double precision. The third derivative of a projection is about 20**3
    # times the first, so the difference errs by 1e-8; rounding adds 1e-9.
    check_grads(number(sim), (airborne(sim),), order=1, modes=["fwd", "rev"], rtol=1e-5, atol=1e-6, eps=1e-6)


def test_states_and_gradients_equal_those_of_numpy(sim: cosmic.Simulator) -> None:
    inputs = robot(sim, 0)
    seen, pull = jax.vjp(lambda inputs: cosmic.jax.rollout(sim, inputs, *SPAN), inputs)
    assert same(seen, sim.rollout(inputs, *SPAN))
    bars = cosmic.Trajectory(*(0.5 * np.asarray(array) for array in seen))
    (gradient,) = pull(bars)
    assert same(gradient, sim.vjp(inputs, bars, *SPAN))


def test_steps_before_the_start_count_and_bounds_hold(sim: cosmic.Simulator) -> None:
    inputs = robot(sim, 0)

    def of(inputs: cosmic.Inputs) -> cosmic.Trajectory:
        return cosmic.jax.rollout(sim, inputs, *SPAN, first=100, bounded=True)

    seen, pull = jax.vjp(of, inputs)
    assert same(seen, sim.rollout(inputs, *SPAN, first=100))
    assert not same(seen, sim.rollout(inputs, *SPAN))
    (gradient,) = pull(seen)
    bars = cosmic.Trajectory(*(np.asarray(array) for array in seen))
    assert same(gradient, sim.vjp(inputs, bars, *SPAN, first=100, bounded=True))
    assert not same(gradient, sim.vjp(inputs, bars, *SPAN, first=100))


def test_compiled_functions_give_the_same_results(sim: cosmic.Simulator) -> None:
    inputs = robot(sim, 0)
    compiled = jax.jit(lambda inputs: cosmic.jax.rollout(sim, inputs, *SPAN))
    assert same(compiled(inputs), sim.rollout(inputs, *SPAN))
    gradient = jax.grad(number(sim))
    for a, b in pairs(jax.jit(gradient)(inputs), gradient(inputs)):
        # The compiler reorders what is around the rollout: rounding of some 1e-16 in cotangents.
        np.testing.assert_allclose(a, b, rtol=1e-10, atol=1e-13)


def test_single_precision_stays_single(sim: cosmic.Simulator) -> None:
    narrow = mapped(jnp.float32, robot(sim, 0))
    seen = cosmic.jax.rollout(sim, narrow, *SPAN)
    assert seen.x.dtype == jnp.float32
    plain = mapped(np.asarray, narrow)
    assert same(seen, sim.rollout(plain, *SPAN))
    assert {g.dtype for g in leaves(jax.grad(number(sim))(narrow)).values()} == {jnp.dtype("float32")}


#: The arrays that robots share; `in_axes` is None for them.
SHARED = [(), ("controller", "x0", "v0"), ("z", "x0", "v0")]


@pytest.mark.parametrize("shared", SHARED)
def test_vmap_equals_a_loop_over_the_robots(sim: cosmic.Simulator, shared: tuple[str, ...]) -> None:
    robots = [robot(sim, seed) for seed in range(3)]
    batch = stacked(robots, shared)
    axes = tree({name: None if is_shared(name, shared) else 0 for name in sim.shapes})

    def of(inputs: cosmic.Inputs) -> cosmic.Trajectory:
        return cosmic.jax.rollout(sim, inputs, *SPAN)

    many = jax.vmap(of, in_axes=(axes,))(batch)
    gradients = jax.vmap(jax.grad(number(sim)), in_axes=(axes,))(batch)
    compiled = jax.jit(jax.vmap(of, in_axes=(axes,)))(batch)
    assert same(compiled, many)
    for k in range(3):
        alone = one_of(batch, k, shared)
        assert same(of(alone), (many.x[k], many.v[k]))
        for a, b in pairs(jax.grad(number(sim))(alone), gradients):
            # Sines of a batch may be rounded in another way, by 1e-16.
            np.testing.assert_allclose(a, b[k], rtol=1e-10, atol=1e-13)


def test_gradients_of_shared_arrays_are_sums_over_the_batch(sim: cosmic.Simulator) -> None:
    robots = [robot(sim, seed) for seed in range(3)]
    designs = jnp.stack([each.z for each in robots])
    rest = robots[0]

    def total(designs, rest):
        of = jax.vmap(lambda z: number(sim)(rest._replace(z=z)))
        return jnp.sum(of(designs))

    by_designs, by_rest = jax.grad(total, argnums=(0, 1))(designs, rest)
    singles = [jax.grad(number(sim))(rest._replace(z=each.z)) for each in robots]
    for k, single in enumerate(singles):
        # Rounding of sums in another order.
        np.testing.assert_allclose(by_designs[k], single.z, rtol=1e-10, atol=1e-13)
    summed = sum(np.asarray(single.controller["w2"]) for single in singles)
    np.testing.assert_allclose(by_rest.controller["w2"], summed, rtol=1e-10, atol=1e-13)


def test_nested_vmap(sim: cosmic.Simulator) -> None:
    rest = robot(sim, 0)
    designs = jnp.stack([robot(sim, seed).z for seed in range(3)])
    starts = jnp.stack([robot(sim, seed).x0 for seed in range(2)])

    def of(z, x0):
        return cosmic.jax.rollout(sim, rest._replace(z=z, x0=x0), *SPAN).x

    grid = jax.vmap(lambda z: jax.vmap(lambda x0: of(z, x0))(starts))(designs)
    assert grid.shape == (3, 2, 3, 6, 2)
    for i in range(3):
        for j in range(2):
            assert np.array_equal(grid[i, j], of(designs[i], starts[j]))


def test_forward_mode_equals_that_of_numpy(sim: cosmic.Simulator) -> None:
    inputs, along = robot(sim, 0), like_robot(robot(sim, 0), 1)

    def of(inputs: cosmic.Inputs) -> cosmic.Trajectory:
        return cosmic.jax.rollout(sim, inputs, *SPAN)

    _, slopes = sim.jvp(inputs, along, *SPAN)
    seen, pushed = jax.jit(lambda *pair: jax.jvp(of, *pair))((inputs,), (along,))
    assert same(seen, sim.rollout(inputs, *SPAN)) and same(pushed, slopes)
    seen, linear = jax.linearize(of, inputs)
    assert same(linear(along), slopes)
    # A direction of one array only, and several directions at once.
    by_x0 = tree({name: along.x0 if name == "x0" else 0.0 * array for name, array in leaves(along).items()})
    _, alone = jax.jvp(lambda x0: of(inputs._replace(x0=x0)), (inputs.x0,), (along.x0,))
    assert same(alone, sim.jvp(inputs, by_x0, *SPAN)[1])
    many = jax.vmap(linear)(stacked([along, by_x0]))
    assert same((many.x[0], many.v[1]), (slopes.x, alone.v))


def test_forward_and_reverse_mode_give_the_same_jacobian(sim: cosmic.Simulator) -> None:
    inputs = robot(sim, 0)

    def last(v0):
        return cosmic.jax.rollout(sim, inputs._replace(v0=v0), *SPAN).x[-1, :2]

    forward, reverse = (jax.jit(of(last))(inputs.v0) for of in (jax.jacfwd, jax.jacrev))
    np.testing.assert_allclose(forward, reverse, rtol=1e-9, atol=1e-13)
    # Robots with their own directions, which share all other arrays.
    starts = jnp.stack([robot(sim, seed).v0 for seed in range(2)])
    for of in (jax.jacfwd, jax.jacrev):
        many = jax.vmap(of(last))(starts)
        for k in range(2):
            np.testing.assert_allclose(many[k], of(last)(starts[k]), rtol=1e-9, atol=1e-13)


def test_a_loop_of_short_rollouts(sim: cosmic.Simulator) -> None:
    inputs = robot(sim, 0)

    def of(inputs: cosmic.Inputs) -> cosmic.Trajectory:
        def on(state, _):
            seen = cosmic.jax.rollout(sim, inputs._replace(x0=state[0], v0=state[1]), observed=[8])
            return (seen.x[-1], seen.v[-1]), seen.x[-1]

        return jax.lax.scan(on, (jnp.asarray(inputs.x0), jnp.asarray(inputs.v0)), length=3)

    state = inputs
    for _ in range(3):
        seen = sim.rollout(state, observed=[8])
        state = state._replace(x0=seen.x[-1], v0=seen.v[-1])
    assert same(jax.jit(of)(inputs)[0], (state.x0, state.v0))

    def number(inputs: cosmic.Inputs):
        return jnp.sum(jnp.sin(of(inputs)[1]))

    check_grads(number, (airborne(sim),), order=1, modes=["fwd", "rev"], rtol=1e-5, atol=1e-6, eps=1e-6)
    gradients = jax.jit(jax.vmap(jax.grad(number)))(stacked([inputs] * 2))
    for a, b in pairs(jax.grad(number)(inputs), gradients):
        np.testing.assert_allclose(b, [a] * 2, rtol=1e-9, atol=1e-13)


def test_second_derivatives_are_refused(sim: cosmic.Simulator) -> None:
    inputs, of = robot(sim, 0), number(sim)
    for outer in (jax.grad, jax.jacfwd):
        with pytest.raises(cosmic.InputError, match="second derivatives of a rollout are not supported"):
            outer(lambda z: jnp.sum(jax.grad(of)(inputs._replace(z=z)).z))(inputs.z)
    with pytest.raises(cosmic.InputError, match="second derivatives"):
        jax.eval_shape(jax.hessian(lambda z: of(inputs._replace(z=z))), inputs.z)


def test_a_gpu_has_only_reverse_mode(sim: cosmic.Simulator) -> None:
    inputs, there = robot(sim, 0), cosmic.Simulator(sim.scene)
    # The same processor under another name: a test of what JAX calls.
    there.device = "gpu"
    assert same(jax.grad(number(there))(inputs), jax.grad(number(sim))(inputs))
    with pytest.raises(cosmic.InputError, match="not on a GPU"):
        jax.jvp(number(there), (inputs,), (inputs,))


def test_a_rollout_that_diverges_is_nan(sim: cosmic.Simulator) -> None:
    inputs = robot(sim, 0)
    fast = inputs._replace(v0=inputs.v0 + 1e9)
    seen = cosmic.jax.rollout(sim, fast)
    assert np.all(np.isnan(seen.x[1:]))
    assert all(np.all(np.isnan(g)) for g in leaves(jax.grad(number(sim))(fast)).values())
    _, pushed = jax.jvp(lambda inputs: cosmic.jax.rollout(sim, inputs), (fast,), (inputs,))
    assert np.all(np.isnan(pushed.x)) and np.all(np.isnan(pushed.v))


@pytest.mark.parametrize(("name", "lost"), [("v0", 1e9), ("b2", np.nan), ("z", np.inf)])
def test_a_diverging_robot_does_not_affect_the_others(
    sim: cosmic.Simulator, name: str, lost: float
) -> None:
    robots = [robot(sim, seed) for seed in range(3)]
    wrong = np.array(leaves(robots[1])[name])
    wrong[2] = lost
    robots[1] = changed(robots[1], **{name: wrong})
    batch = stacked(robots)
    many = jax.vmap(lambda inputs: cosmic.jax.rollout(sim, inputs, *SPAN))(batch)
    gradients = leaves(jax.vmap(jax.grad(number(sim)))(batch)).values()
    _, slopes = jax.vmap(lambda inputs: jax.jvp(number(sim), (inputs,), (robots[0],)))(batch)
    assert np.all(np.isnan(many.x[1, 1:])) and all(np.all(np.isnan(g[1])) for g in gradients)
    assert np.isnan(slopes).tolist() == [False, True, False]
    for k in (0, 2):
        assert same(sim.rollout(robots[k], *SPAN), (many.x[k], many.v[k]))
        assert all(np.all(np.isfinite(g[k])) for g in gradients)


def test_vmap_over_an_empty_batch(sim: cosmic.Simulator) -> None:
    batch = stacked([robot(sim, 0)])
    none = mapped(lambda array: array[:0], batch)
    assert jax.vmap(lambda inputs: cosmic.jax.rollout(sim, inputs, *SPAN))(none).x.shape[0] == 0
    assert jax.vmap(jax.grad(number(sim)))(none).z.shape[0] == 0
    assert jax.vmap(lambda inputs: jax.jvp(number(sim), (inputs,), (inputs,)))(none)[1].shape == (0,)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda i: i._replace(z=i.z[:4]), r"z: expected the shape \[11, 3\], found \[4, 3\]"),
        (lambda i: i._replace(x0=np.stack([i.x0] * 2)), "x0: expected .* use jax.vmap for several"),
        (lambda i: changed(i, b1=1j * i.controller["b1"]), "b1 is of type complex128: expected float32"),
        (lambda i: changed(i, b2=i.controller["b2"] > 0), "b2 is of type bool"),
        (lambda i: i[:3], "expected Inputs: .* found 3 things"),
    ],
)
def test_wrong_arrays_are_refused_before_anything_runs(
    sim: cosmic.Simulator, change, says: str
) -> None:
    with pytest.raises(cosmic.InputError, match=says):
        jax.jit(lambda inputs: cosmic.jax.rollout(sim, inputs, *SPAN))(change(robot(sim, 0)))


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"steps": 1000}, "1000 is beyond the scene's last step, 256"),
        ({"steps": 100, "first": 200}, "300 is beyond"),
        ({"first": -1}, "first: -1"),
        ({"observed": [3, 1]}, "ascend"),
    ],
)
def test_invalid_steps_are_refused_before_anything_runs(
    sim: cosmic.Simulator, options, says: str
) -> None:
    with pytest.raises(cosmic.InputError, match=says):
        jax.jit(lambda inputs: cosmic.jax.rollout(sim, inputs, **options))(robot(sim, 0))


def test_too_much_memory_is_refused_before_anything_runs(sim: cosmic.Simulator) -> None:
    many = mapped(lambda array: jax.ShapeDtypeStruct((1000, *array.shape), array.dtype), robot(sim, 0))

    def pushed(inputs: cosmic.Inputs):
        return jax.jvp(number(sim), (inputs,), (inputs,))

    try:
        for of, megabytes, says in [
            (number(sim), 13, "a rollout of 1000 robots"),
            (jax.grad(number(sim)), 14, "the gradient of a rollout of 1000 robots"),
            (pushed, 14, "a rollout of 1000 robots"),
        ]:
            cosmic.limit_memory(megabytes)
            with pytest.raises(cosmic.OutOfMemoryError, match=says):
                jax.jit(jax.vmap(of)).lower(many)
            cosmic.limit_memory(1000)
            jax.jit(jax.vmap(of)).lower(many)
    finally:
        cosmic.limit_memory()


def test_other_backends_are_refused_before_anything_runs(sim: cosmic.Simulator) -> None:
    with pytest.raises(cosmic.InputError, match="needs the CPU backend"):
        jax.jit(number(sim)).trace(robot(sim, 0)).lower(lowering_platforms=("cuda",))


def test_the_first_robot_decides_the_projection(sim: cosmic.Simulator) -> None:
    soft = robot(sim, 0)
    hard = soft._replace(z=np.eye(3)[soft.z.argmax(axis=1)])
    for first, other in [(soft, hard), (hard, soft)]:
        own, alone = cosmic.Simulator(sim.scene), cosmic.Simulator(sim.scene)
        of = jax.jit(lambda inputs: cosmic.jax.rollout(own, inputs, *SPAN))
        assert same(of(first), alone.rollout(first, *SPAN)) and own.projection == alone.projection
        with pytest.raises(Exception, match="another simulator|another Simulator"):
            jax.block_until_ready(of(other))
        assert same(of(first), alone.rollout(first, *SPAN))


def test_a_compiled_function_keeps_its_simulator(sim: cosmic.Simulator) -> None:
    inputs = robot(sim, 0)
    expected = sim.rollout(inputs, *SPAN)

    def compiled():
        own = cosmic.Simulator(sim.scene)
        return jax.jit(lambda inputs: cosmic.jax.rollout(own, inputs, *SPAN)).lower(inputs).compile()

    of = compiled()
    jax.clear_caches()
    gc.collect()
    assert same(of(inputs), expected)


def test_a_simulator_that_no_longer_exists(sim: cosmic.Simulator) -> None:
    plan = cosmic._core.Planned(sim._core, [4], False, [("z", 2)])
    wrong = jax.ffi.ffi_call("cosmic_rollout", jax.ShapeDtypeStruct((), jnp.float64))
    arguments = {"plan": np.int32(plan.id), "mode": np.int32(cosmic._core.STATES), "by": np.int32(31)}
    with pytest.raises(Exception, match="the arrays of a rollout do not fit its plan"):
        jax.block_until_ready(wrong(**arguments))
    # The last plans are kept, because JAX may still call them.
    plan = [cosmic._core.Planned(sim._core, [4], False, []) for _ in range(101)]
    del plan
    with pytest.raises(Exception, match="the simulator of this compiled function no longer exists"):
        jax.block_until_ready(wrong(**arguments))


@pytest.mark.parametrize("dtype", ["float16", "bfloat16", "int32"])
def test_other_types_are_converted(sim: cosmic.Simulator, dtype: str) -> None:
    inputs = mapped(jnp.float32, airborne(sim))
    numbers = np.arange(*sim.shapes["b1"])
    other = changed(inputs, b1=jnp.asarray(numbers, dtype))
    wide = changed(inputs, b1=jnp.asarray(numbers, jnp.float32))
    is_whole = dtype == "int32"
    # Integers do not switch to double precision, as in JAX.
    seen, expected = (cosmic.jax.rollout(sim, each, *SPAN) for each in (other, wide))
    assert seen.x.dtype == jnp.float32 and same(seen, expected)
    gradient = jax.grad(number(sim), allow_int=is_whole)(other)
    assert gradient.controller["b1"].dtype == (jax.dtypes.float0 if is_whole else jnp.dtype(dtype))
    half = mapped(jnp.float16, inputs)
    assert cosmic.jax.rollout(sim, half, *SPAN).x.dtype == jnp.float32


def test_an_objective_in_jax() -> None:
    scene = {**SCENE, "loss.kind": "final"}

    @cosmic.jax.loss(is_far=True)
    def far(x, v):
        return -x[-1, 0, 0]

    own = cosmic.optimize(scene, SEED, loss=far, progress=False)
    # The same objective as the scene's: the same gradient, ones and zeros, and so the same bits.
    assert is_same_run(own.folder, cosmic.optimize(scene, SEED, progress=False).folder)


def test_an_exception_in_an_objective_is_raised_by_the_run() -> None:
    @cosmic.jax.loss
    def wrong(x, v):
        return x

    with pytest.raises(TypeError, match="scalar"):
        cosmic.optimize(SCENE, SEED, loss=wrong, progress=False)


#: A robot that floats in space: its bars alone change its kinetic energy.
FLOATING = {
    **SCENE,
    "physics": {"gravity": 0.0, "contact": "none", "damping": 0.0},
    "gradient.cotangent_bound": "off",
}


def beginnings(scene: dict, *losses: cosmic.Loss) -> list[np.ndarray]:
    """The beginnings of optimisations with these losses."""
    return [beginning(cosmic.optimize(scene, SEED, loss=loss, iterations=20, progress=False)) for loss in losses]


def test_the_energy_of_bars_is_the_kinetic_energy_with_all_gradients() -> None:
    @cosmic.jax.loss(observed=32)
    def kinetic(x, v, *, mass):
        return -0.5 * (mass[:, None] * v[-1] ** 2).sum()

    @cosmic.jax.loss(observed=32)
    def given(x, v, *, net):
        return -net[-1].sum()

    @cosmic.jax.loss(observed=32)
    def powers(x, v, *, power, time):
        assert power.shape == (len(x), 20) and time.shape == (len(x),)
        return -(power[1:].sum(-1) * jnp.diff(time)).sum()

    first, *others = beginnings(FLOATING, kinetic, given, powers)
    for other in others:
        assert np.allclose(first, other, rtol=1e-6, atol=0.0, equal_nan=True)


def test_the_tension_of_springs_follows_from_activations_with_all_gradients() -> None:
    sim = cosmic.Simulator(FLOATING)
    rest, (i, j) = sim.rest_length, sim.edges.T

    @cosmic.jax.loss(observed=lambda steps: [steps - 1, steps])
    def seen(x, v, *, tension):
        return (tension[1] ** 2).sum()

    @cosmic.jax.loss(observed=lambda steps: [steps - 1, steps])
    def computed(x, v, *, stiffness, strain, activation):
        length = jnp.linalg.norm(x[0, j] - x[0, i], axis=-1)
        target = jnp.asarray(rest) * (1.0 + strain * activation[1])
        return ((stiffness * (length - target)) ** 2).sum()

    first, other = beginnings(FLOATING, seen, computed)
    assert np.allclose(first, other, rtol=1e-6, atol=0.0, equal_nan=True)


ONE_CORE = """
import os
os.sched_setaffinity(0, [min(os.sched_getaffinity(0))])
import cosmic, cosmic.jax, jax, numpy as np

sim = cosmic.Simulator("stability")
first = sim.initial()

def of(inputs):
    return cosmic.jax.rollout(sim, inputs, 64, 32).x.sum()

for robots in (64, 128, 256):
    many = jax.tree.map(lambda array: np.stack([array] * robots), first)
    for each in (of, jax.grad(of)):
        for _ in range(4):
            seen = jax.block_until_ready(jax.jit(jax.vmap(each))(many))
    print(seen.z.shape)
"""


@pytest.mark.skipif(not hasattr(os, "sched_setaffinity"), reason="needs a process on one core")
def test_batches_on_one_core() -> None:
    # Callbacks of JAX would wait for one another forever.
    done = subprocess.run([sys.executable, "-c", ONE_CORE], capture_output=True, text=True, timeout=120)
    assert done.stdout.splitlines() == [f"({robots}, 110, 3)" for robots in (64, 128, 256)], done.stderr


def test_physics_and_activations_have_derivatives(sim: cosmic.Simulator) -> None:
    steps, edges = SPAN[0], len(sim.edges)
    activations = np.random.default_rng(1).uniform(-1.0, 1.0, (steps, edges))
    physics = {"physics.gravity": np.array(9.0), "bars.stiffness": np.array(1.1), "nodes.mass": np.full(6, 1.05)}
    inputs = airborne(sim)._replace(controller={"activations": activations}, physics=physics)
    # The tolerances of the test of the other inputs.
    check_grads(number(sim), (inputs,), order=1, modes=["fwd", "rev"], rtol=1e-5, atol=1e-6, eps=1e-6)
    seen = jax.jit(number(sim))(inputs)
    many = jax.vmap(lambda gravity: number(sim)(inputs._replace(physics={**physics, "physics.gravity": gravity})))
    assert many(np.array([9.0, 3.0]))[0] == pytest.approx(float(seen), rel=1e-12)


def test_jax_can_be_debugged(sim: cosmic.Simulator) -> None:
    inputs = airborne(sim)
    with jax.disable_jit():
        # XLA may round in another order.
        np.testing.assert_allclose(number(sim)(inputs), jax.jit(number(sim))(inputs), rtol=1e-12)
    with jax.debug_nans(True), pytest.raises(FloatingPointError, match="nan"):
        cosmic.jax.rollout(sim, inputs._replace(physics={"nodes.mass": 0.0}), *SPAN)


def test_a_policy_is_differentiated_through_steps(sim: cosmic.Simulator) -> None:
    start, frames = airborne(sim), 6
    weights = 0.3 * np.random.default_rng(2).normal(size=(len(sim.edges), 24))

    def policy(weights, x, v, time):
        return jnp.tanh(weights @ jnp.concatenate([x.ravel(), jnp.cos(40.0 * time) * v.ravel()]))

    def walk(weights):
        own = {"policy": partial(policy, weights), "frame_skip": 4}
        x, v = cosmic.jax.rollout(sim, start, 4 * frames, 4, **own)
        return jnp.sum(jnp.sin(3.0 * x)) + jnp.sum(jnp.cos(v))

    # The tolerances of the test of the inputs.
    check_grads(walk, (weights,), order=1, modes=["fwd", "rev"], rtol=1e-5, atol=1e-6, eps=1e-6)
    both = jax.jit(jax.vmap(jax.grad(walk)))(np.stack([weights, 0.5 * weights]))
    # XLA may sum in another order.
    np.testing.assert_allclose(both[0], jax.grad(walk)(weights), rtol=1e-9, atol=1e-12)
    # The states are those of NumPy.
    options = {"policy": partial(policy, weights), "frame_skip": 4, "first": 8}
    seen = cosmic.jax.rollout(sim, start, 24, 8, **options)
    for own, other in zip(seen, sim.rollout(start, 24, 8, **options)):
        np.testing.assert_allclose(own, other, rtol=1e-9, atol=1e-12)


def test_the_number_of_earlier_steps_may_be_a_counter(sim: cosmic.Simulator) -> None:
    inputs = robot(sim, 0)

    def of(first):
        return cosmic.jax.rollout(sim, inputs, *SPAN, first=first)

    compiled = jax.jit(of)
    for first in (0, 100):
        assert same(compiled(first), sim.rollout(inputs, *SPAN, first=first))

    def moved(x0, first):
        return cosmic.jax.rollout(sim, inputs._replace(x0=x0), *SPAN, first=first)

    gradient = jax.jit(jax.grad(lambda x0, first: moved(x0, first).x.sum()))
    bars = cosmic.Trajectory(*(k * np.ones_like(array) for k, array in zip((1.0, 0.0), of(0))))
    # XLA computes only the wanted gradients, which rounds in another order.
    np.testing.assert_allclose(gradient(inputs.x0, 100), sim.vjp(inputs, bars, *SPAN, first=100).x0, rtol=1e-9, atol=1e-12)
    # Robots of a batch are simulated together, so they have one clock.
    both = jax.vmap(moved)
    two = np.stack([inputs.x0, inputs.x0 + 0.1])
    assert same([both(two, np.array([100, 100])).x[0]], [of(100).x])
    for first, says in (([0, 100], "same number of earlier steps"), ([225, 225], "225: .* 0 to 224"), ([-1, -1], "first: -1")):
        with pytest.raises(Exception, match=says):
            jax.block_until_ready(both(two, np.array(first)))
    with pytest.raises(cosmic.InputError, match="first is of type float64"):
        compiled(100.0)


def test_activations_are_limited(sim: cosmic.Simulator) -> None:
    inputs = airborne(sim)

    def of(own):
        return cosmic.jax.rollout(sim, inputs._replace(controller={"activations": own[None]}), *SPAN).x.sum()

    limits = jnp.where(jnp.arange(len(sim.edges)) % 2, 1.0, -0.5)
    beyond = limits * jnp.where(limits == 1.0, 3.0, 1.0)
    assert of(beyond) == of(limits)
    at, outside = (jax.grad(of)(own) for own in (limits, beyond))
    # Beyond a limit a change has no effect. At a limit the derivative is that from within.
    assert np.array_equal(outside, np.where(limits == 1.0, 0.0, at)) and np.all(at[limits == 1.0] != 0.0)
