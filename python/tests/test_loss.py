"""Losses in NumPy."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import cosmic
import numpy as np
import pytest
from common import SCENE, SEED, beginning, is_same_run

FINAL = {**SCENE, "loss.kind": "final"}


def final(x: np.ndarray, v: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
    """Minus the distance of the payload on flat ground."""
    gradient = np.zeros_like(x)
    gradient[-1, 0, 0] = -1.0
    return -x[-1, 0, 0], gradient, np.zeros_like(v)


def test_the_objective_of_a_scene_written_in_numpy_gives_the_same_bits() -> None:
    own = cosmic.optimize(FINAL, SEED, loss=cosmic.Loss(final, is_far=True), progress=False)
    scene = cosmic.optimize(FINAL, SEED, progress=False)
    assert is_same_run(own.folder, scene.folder)


def test_a_loss_designs_another_robot(run: cosmic.Run) -> None:
    def high(x: np.ndarray, v: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
        gradient = np.zeros_like(x)
        gradient[..., 1] = -1.0 / x[..., 1].size
        return -x[..., 1].mean(), gradient, np.zeros_like(v)

    seen = []

    def observed(steps: int) -> range:
        seen.append(steps)
        return range(0, steps + 1, steps // 4)

    tall = cosmic.optimize(SCENE, SEED, loss=cosmic.Loss(high, observed), progress=False)
    assert set(seen) >= {128, 256}
    # Minus a mean height, which is between those of the ground and the lattice's top.
    assert -0.3 < tall.summary["loss_p50"] < 0.0
    assert "loss_p50" not in run.summary
    far = cosmic.optimize(SCENE, SEED, loss=cosmic.Loss(high, observed, True), progress=False)
    assert "loss_p50" not in far.summary
    assert not np.array_equal(tall.trajectory, run.trajectory)


def test_the_economy_of_a_scene_written_in_numpy_has_the_same_gradients() -> None:
    scene = cosmic.as_scene({**FINAL, "objective": {"task": "economy", "weight": 100.0}})
    # A joule per kilogram of the robot counts as a metre.
    stroke = scene["materials.max_strain"][2]

    def economy(x: np.ndarray, v: np.ndarray, *, work: Any, strain: Any, mass: Any, presence: Any) -> Any:
        value, x_bar, v_bar = final(x, v)
        given, all_mass = work[-1] @ strain / stroke, mass @ presence
        work_bar = np.zeros_like(work)
        work_bar[-1] = strain / stroke / all_mass
        price = given / all_mass
        bars = {"work": work_bar, "strain": work[-1] / stroke / all_mass}
        bars |= {"mass": -price * presence / all_mass, "presence": -price * mass / all_mass}
        return value + price, x_bar, v_bar, bars

    loss = cosmic.Loss(economy)
    own = cosmic.optimize(FINAL, SEED, loss=loss, progress=False)
    built_in = cosmic.optimize(scene, SEED, progress=False)
    assert np.allclose(beginning(own, 2), beginning(built_in, 2), rtol=1e-9, atol=0.0, equal_nan=True)
    # The energy is a part of the loss.
    assert own.history["loss_horizon"][2] > -own.history["displacement_horizon"][2] + 1e-6


def test_a_loss_sees_everything_in_its_shape() -> None:
    shapes, times = {}, []

    def curious(
        x: Any, v: Any, *, activation: Any, tension: Any, power: Any, work: Any, net: Any,
        mass: Any, presence: Any, stiffness: Any, strain: Any, time: Any,
    ) -> Any:  # fmt: skip
        own = {name: value for name, value in locals().items() if isinstance(value, np.ndarray)}
        shapes.update({name: value.shape for name, value in own.items()})
        times.append(time)
        assert np.abs(activation).max() <= 1.0 and not np.any(tension[0]) and not np.any(power[0])
        assert np.all(work >= net - 1e-12) and np.all(mass > 0.0) and np.all(stiffness >= 0.0)
        assert presence.min() >= 0.0 and presence.max() <= 1.0
        assert np.allclose(power[1:] * np.diff(time)[:, None], np.diff(net, axis=0))
        return final(x, v)

    loss = cosmic.Loss(curious, 100)
    cosmic.optimize(SCENE, SEED, loss=loss, progress=False)
    per_state, states = {"activation", "tension", "power", "work", "net"}, len(times[-1])
    assert shapes == {
        **{name: (states, 20) for name in per_state},
        **{"x": (states, 9, 2), "v": (states, 9, 2), "time": (states,)},
        **{"mass": (9,), "presence": (9,), "stiffness": (20,), "strain": (20,)},
    }
    dt = cosmic.as_scene(SCENE)["physics.dt"]
    assert {round(steps) for seen in times for steps in seen / dt} == {0, 100, 128, 200, 256}


def sees_wrong(x: Any, v: Any, *, mass: Any) -> Any:
    return (*final(x, v), {"masses": mass})


@pytest.mark.parametrize(
    ("function", "says"),
    [
        (lambda x, v, *, tensions: 0.0, "unknown argument `tensions`: did you mean `tension`"),
        (lambda x, v, *, weight: 0.0, "unknown argument `weight`: a loss can see activation, tension"),
        (lambda x, v, mass: 0.0, r"`mass` must be a keyword argument: .*\(x, v, \*, mass\)"),
        (sees_wrong, "a dictionary of gradients with respect to mass"),
        (lambda x, v, *, mass: (*final(x, v), mass), "a dictionary of gradients with respect to mass"),
        (lambda x, v, *, mass: (*final(x, v), {"mass": 1.0}), r"respect to mass: .*\(9,\), found .*\(\)"),
        (lambda x, v, *, mass: final(x, v)[:2], "and a dictionary of the other gradients"),
    ],
)
def test_wrong_arguments_of_a_loss_are_named(function: Any, says: str) -> None:
    with pytest.raises(cosmic.InputError, match=says):
        cosmic.optimize(SCENE, loss=function, progress=False)


@pytest.mark.parametrize(
    ("answer", "says"),
    [
        (lambda x, v: 1.0, "must return three things"),
        (lambda x, v: (1.0, x), "must return three things"),
        (lambda x, v: (x, x, v), "expected a number"),
        (lambda x, v: (1j, x, v), "expected a number"),
        (lambda x, v: (1.0, x[0], v), r"respect to x: .* of the shape \(1, 9, 2\), found .*\(9, 2\)"),
        (lambda x, v: (1.0, x, 0.0), r"respect to v: .* of the shape \(1, 9, 2\), found .*\(\)"),
        (lambda x, v: (1.0, 1j * x, v), "respect to x: .*found complex128"),
    ],
)
def test_wrong_answers_of_a_loss_are_named(answer: Any, says: str) -> None:
    with pytest.raises(cosmic.InputError, match=says):
        cosmic.optimize(SCENE, loss=answer, progress=False)


def test_steps_before_the_start_are_refused() -> None:
    loss = cosmic.Loss(final, lambda steps: [-1, steps])
    says = r"observes \[-1, 128\] in a rollout of 128 steps: expected steps .* from 0 to 128"
    with pytest.raises(cosmic.InputError, match=says):
        cosmic.optimize(SCENE, loss=loss, progress=False)


@pytest.mark.parametrize("observed", [[5, 3], [5, 5], [129], [0.5], 7])
def test_invalid_observed_steps_are_refused(observed: Any) -> None:
    loss = cosmic.Loss(final, lambda _: observed)
    with pytest.raises(cosmic.InputError, match="the loss observes .*expected"):
        cosmic.optimize(SCENE, loss=loss, progress=False)
    for every in (0, 2.5):
        with pytest.raises(cosmic.InputError, match=f"observed: {every}: expected a whole number"):
            cosmic.Loss(final, every)


#: Horizons that are not a multiple of the interval of a loss. The default scene has many of them.
UNEVEN = {**SCENE, "schedule": {**SCENE["schedule"], "horizon": [130, 251]}}


@pytest.mark.parametrize(
    ("observed", "of_100"),
    [
        (32, [0, 32, 64, 96, 100]),
        (lambda steps: range(steps // 2, steps + 1, 32), [50, 82, 100]),
        (lambda steps: [10], [10, 100]),
        (lambda steps: [], [100]),
        (lambda steps: np.array([10, steps]), [10, 100]),
        (None, [100]),
    ],
)
def test_the_last_step_is_always_observed(observed: Any, of_100: list[int]) -> None:
    loss = cosmic.Loss(final, observed, is_far=True)
    assert loss.observed(100) == of_100


def test_horizons_need_not_be_multiples_of_an_interval() -> None:
    loss = cosmic.Loss(final, 32, is_far=True)
    made = cosmic.optimize(UNEVEN, SEED, loss=loss, iterations=20, progress=False)
    assert made.summary["iterations"] == 20


def test_a_loss_that_is_always_nan_ends_the_run() -> None:
    def lost(x: np.ndarray, v: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
        return float("nan"), np.zeros_like(x), np.zeros_like(v)

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        with pytest.raises(cosmic.DivergedError, match="loss"):
            cosmic.optimize(SCENE, SEED, loss=lost, progress=False)


class Fickle(cosmic.Loss):
    """A loss whose observed steps change later, although the library has checked them and relies on them."""

    is_other = False

    def observed(self, steps: int) -> list[int]:
        return [3, 1] if self.is_other else [steps]


def test_a_panic_of_the_library_is_an_exception() -> None:
    loss = Fickle(final)

    def progress(iteration: int, *_: object) -> None:
        loss.is_other = iteration >= 3

    with pytest.raises(cosmic.InternalError, match="please report it") as raised:
        cosmic.optimize(SCENE, SEED, loss=loss, progress=progress)
    assert isinstance(raised.value, RuntimeError)


def test_other_types_are_refused_as_a_loss() -> None:
    with pytest.raises(cosmic.InputError, match="a loss is a function .*, not int"):
        cosmic.optimize(SCENE, loss=3, progress=False)


def test_an_exception_in_a_loss_is_raised_by_the_run() -> None:
    raised = RuntimeError("from the loss")
    calls = []

    def failing(x: np.ndarray, v: np.ndarray) -> Any:
        calls.append(len(x))
        if len(calls) > 20:
            raise raised
        return final(x, v)

    with warnings.catch_warnings(), pytest.raises(RuntimeError) as caught:
        # The exception is not preceded by a warning that the loss is NaN.
        warnings.simplefilter("error")
        # The rollouts of this test are shorter than a stride.
        warnings.filterwarnings("ignore", message="a rollout lasts")
        cosmic.optimize(SCENE, SEED, loss=failing, progress=False)
    assert caught.value is raised


def test_a_run_goes_on_after_an_exception_in_its_loss(tmp_path: Path) -> None:
    calls = []

    def failing(x: np.ndarray, v: np.ndarray) -> Any:
        calls.append(len(x))
        if len(calls) == 20:
            raise RuntimeError("once")
        return final(x, v)

    loss = cosmic.Loss(failing, is_far=True)
    with pytest.raises(RuntimeError, match="once"):
        cosmic.optimize(FINAL, SEED, out=tmp_path / "run", loss=loss, progress=False)
    resumed = cosmic.resume(tmp_path / "run", loss=loss, progress=False)
    whole = cosmic.optimize(FINAL, SEED, progress=False)
    assert is_same_run(resumed.folder, whole.folder)


def test_a_gradient_that_is_not_finite_stops_the_run() -> None:
    iterations = []

    def spoilt(x: np.ndarray, v: np.ndarray) -> Any:
        value, x_bar, v_bar = final(x, v)
        if len(iterations) >= 3:
            x_bar[-1, 0, 0] = np.nan
        return value, x_bar, v_bar

    with pytest.raises(cosmic.InputError, match=r"iteration \d+: <Loss .*spoilt>: .* respect to x is nan at \[0, 0, 0\]"):
        cosmic.optimize(FINAL, SEED, loss=spoilt, progress=lambda *_: iterations.append(1))


def test_a_run_with_a_loss_can_only_be_resumed_with_a_loss(tmp_path: Path) -> None:
    loss = cosmic.Loss(final, is_far=True)

    def stop(iteration: int, *_: object) -> None:
        if iteration == 5:
            raise KeyError("stop")

    with pytest.raises(KeyError):
        cosmic.optimize(FINAL, SEED, out=tmp_path / "run", loss=loss, progress=stop)
    with pytest.raises(cosmic.InputError) as refused:
        cosmic.resume(tmp_path / "run", progress=False)
    assert "loss" in str(refused.value)
    whole = cosmic.optimize(FINAL, SEED, progress=False)
    resumed = cosmic.resume(tmp_path / "run", loss=loss, progress=False)
    assert is_same_run(resumed.folder, whole.folder)
