"""Wrong arguments raise an exception that says what was expected. Later calls still work."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import cosmic
import numpy as np
import pytest
from common import SHORT, changed, one_of, robot, same, stacked
from cosmic._simulator import leaves

Call = Callable[[cosmic.Simulator, cosmic.Inputs, cosmic.Trajectory], Any]

#: Wrong calls by name, and words that the message must contain.
WRONG: dict[str, tuple[Call, list[str]]] = {
    "no arrays": (lambda sim, i, t: sim.rollout(None, 32), ["expected Inputs", "found NoneType"]),
    "too few arrays": (lambda sim, i, t: sim.rollout(i[:3], 32), ["expected Inputs", "found 3"]),
    "another controller": (
        lambda sim, i, t: sim.rollout(i._replace(controller={"w3": i.z}), 32),
        ["controller", "expected the blocks w1, b1, w2, b2, or only activations; found w3"],
    ),
    "complex": (lambda sim, i, t: sim.rollout(changed(i, w2=1j * i.controller["w2"])), ["w2", "complex128"]),
    "objects": (lambda sim, i, t: sim.rollout(changed(i, b1=None)), ["b1", "object"]),
    "truths": (lambda sim, i, t: sim.rollout(changed(i, b2=i.controller["b2"] > 0.0)), ["b2", "bool"]),
    "text": (lambda sim, i, t: sim.rollout(i._replace(x0="start")), ["x0", "expected float"]),
    "ragged": (lambda sim, i, t: sim.rollout(i._replace(z=[[0, 1, 0], [1]])), ["z", "numbers"]),
    "NaN": (lambda sim, i, t: sim.rollout(with_speed(i, np.nan)), ["v0[2, 1]", "nan", "finite"]),
    "infinity": (lambda sim, i, t: sim.rollout(with_speed(i, np.inf)), ["v0[2, 1]", "inf", "finite"]),
    "shape": (lambda sim, i, t: sim.rollout(i._replace(z=i.z[:4])), ["z", "[11, 3]", "[4, 3]"]),
    "two axes": (lambda sim, i, t: sim.rollout(i._replace(z=i.z[None, None])), ["z", "[1, 1, 11"]),
    "no robots": (lambda sim, i, t: sim.rollout(i._replace(z=i.z[None][:0])), ["z", "no robots"]),
    "layout of NaN": (lambda sim, i, t: sim.layout(i.z * np.nan), ["z", "finite"]),
    "layout of another lattice": (lambda sim, i, t: sim.layout(i.z[:4]), ["z", "[11, 3]", "[4, 3]"]),
    "batches": (
        lambda sim, i, t: sim.rollout(i._replace(z=np.stack([i.z] * 2), x0=np.stack([i.x0] * 3))),
        ["x0: 3 robots", "z has 2"],
    ),
    "too many steps": (lambda sim, i, t: sim.rollout(i, 1000), ["1000", "256", "physics.steps"]),
    "too late": (lambda sim, i, t: sim.rollout(i, 100, first=200), ["300", "256"]),
    "first": (lambda sim, i, t: sim.rollout(i, 32, first=-1), ["first: -1", "0 or more"]),
    "steps": (lambda sim, i, t: sim.rollout(i, 3.7), ["steps: 3.7", "whole number"]),
    "every": (lambda sim, i, t: sim.rollout(i, 32, 0), ["observed: 0", "1 or more"]),
    "descending": (lambda sim, i, t: sim.rollout(i, observed=[3, 1]), ["observed", "ascend"]),
    "nothing": (lambda sim, i, t: sim.rollout(i, observed=[]), ["observed", "[]"]),
    "twice": (lambda sim, i, t: sim.rollout(i, 32, [1, 2]), ["`steps`", "`observed`"]),
    "seed": (lambda sim, i, t: sim.initial(-1), ["seed: -1", "0 to 18446744073709551615"]),
    "projection": (
        lambda sim, i, t: cosmic.Simulator(sim.scene, "soft").rollout(i, 32),
        ["projection", "soft", "performance"],
    ),
    "no cotangents": (lambda sim, i, t: sim.vjp(i, 3, 32), ["cotangents", "found int"]),
    "names": (lambda sim, i, t: sim.vjp(i, t, 32, by=[[1]]), ["by", "[1]"]),
    "activations": (lambda sim, i, t: sim.step(i.z, i.x0, i.v0, [[1], [2, 3]]), ["activations"]),
    "one cotangent": (lambda sim, i, t: sim.vjp(i, t[:1], 32), ["2 arrays", "found 1"]),
    "cotangent": (
        lambda sim, i, t: sim.vjp(i, cosmic.Trajectory(t.x, t.v[:1]), 32),
        ["v_bar", "[3, 6, 2]", "[1, 6, 2]"],
    ),
    "complex cotangent": (
        lambda sim, i, t: sim.vjp(i, cosmic.Trajectory(1j * t.x, t.v), 32),
        ["x_bar", "complex128"],
    ),
    "tangents": (lambda sim, i, t: sim.jvp(i, i[:3], 32), ["expected Inputs", "found 3"]),
    "tangents of a batch": (
        lambda sim, i, t: sim.jvp(i, i._replace(z=np.stack([i.z] * 3)), 32),
        ["tangents", "batch"],
    ),
    "no scene": (lambda sim, i, t: cosmic.Simulator(3), ["scene", "int"]),
    "no section": (lambda sim, i, t: cosmic.Simulator({"steps": 3}), ["'steps'", "section"]),
    "base": (lambda sim, i, t: cosmic.Simulator({"base": "earth"}), ["`base`", "as `scene`"]),
    "no setting": (lambda sim, i, t: cosmic.Simulator({"physics.steps": object()}), ["use a number"]),
}


#: Wrong arguments of other functions and classes, with the name that the message must contain.
ELSEWHERE: dict[str, tuple[Callable[[Any], Any], list[Any]]] = {
    "projection": (lambda bad: cosmic.Simulator(SHORT, bad), [None, 3, np.zeros(2)]),
    "device": (lambda bad: cosmic.Simulator(SHORT, device=bad), [None, "tpu"]),
    "seed": (lambda bad: cosmic.optimize(SHORT, bad), ["one", 1.5, -1, float("inf")]),
    "loss": (lambda bad: cosmic.optimize(SHORT, loss=bad), [3, "far"]),
    "iterations": (lambda bad: cosmic.optimize(SHORT, iterations=bad), [0, 1.5, "all"]),
    "start": (lambda bad: cosmic.optimize(SHORT, start=bad), [3, [1], b"run"]),
    "out": (lambda bad: cosmic.optimize(SHORT, out=bad), [3, [1], b"run"]),
    "threads": (lambda bad: cosmic.optimize(SHORT, threads=bad), [0, "all", 1.5]),
    "progress": (lambda bad: cosmic.optimize(SHORT, progress=bad), [3, "bar"]),
    "folder": (cosmic.load, [None, 3, b"run"]),
    "allow_unstable": (lambda bad: cosmic.resume("run", allow_unstable=bad), ["yes", None, 1]),
    "a loss is": (cosmic.Loss, [None, 3, "far"]),
    "observed": (lambda bad: cosmic.Loss(print, bad), ["all", 0, 1.5]),
    "is_far": (lambda bad: cosmic.Loss(print, None, bad), [1, "yes", None]),
    "megabytes": (cosmic.limit_memory, ["1 GB", -1.0, [1]]),
    "Lattice.of": (cosmic.Lattice.of, [None, "earth"]),
    "tie": (lambda bad: cosmic.Lattice([[0, 0], [1, 0]], [[0, 1]], tie=bad), [3, None]),
    "payload": (lambda bad: cosmic.Lattice([[0, 0], [1, 0]], [[0, 1]], payload=bad), [[[1], [2, 3]], "left"]),
    "spec": (cosmic.sweep.count, [None, 3]),
    "scene": (cosmic.as_scene, [None, 3, {"scene": []}]),
}


@pytest.mark.parametrize("name", ELSEWHERE)
def test_other_wrong_arguments_are_named(name: str) -> None:
    call, wrong = ELSEWHERE[name]
    for bad in wrong:
        with pytest.raises(cosmic.InputError, match=name):
            call(bad)


def with_speed(inputs: cosmic.Inputs, value: float) -> cosmic.Inputs:
    """The inputs with one velocity replaced by ``value``."""
    v0 = inputs.v0.copy()
    v0[2, 1] = value
    return inputs._replace(v0=v0)


@pytest.mark.parametrize("what", WRONG)
def test_a_wrong_argument_is_named(sim: cosmic.Simulator, what: str) -> None:
    call, words = WRONG[what]
    inputs = robot(sim, 0)
    before = sim.rollout(inputs, 32)
    with pytest.raises(cosmic.InputError) as raised:
        call(sim, inputs, before)
    assert isinstance(raised.value, ValueError)
    assert all(word in str(raised.value) for word in words), str(raised.value)
    # The simulator still works.
    assert same(sim.rollout(inputs, 32), before)


def test_the_error_about_a_divergence_names_the_place(sim: cosmic.Simulator) -> None:
    inputs = robot(sim, 0)
    fast = inputs._replace(v0=inputs.v0 + 1e9)
    with pytest.raises(cosmic.DivergedError, match="diverged in step 0: node 0"):
        sim.rollout(fast)
    both = inputs._replace(v0=np.stack([inputs.v0, fast.v0]))
    with pytest.raises(cosmic.DivergedError, match="robot 1: diverged in step 0"):
        sim.rollout(both)
    assert isinstance(cosmic.DivergedError("x"), ArithmeticError)
    seen = sim.rollout(both, check=False)
    assert same((seen.x[0], seen.v[0]), sim.rollout(inputs))
    # The start is beyond 1e6 m/s too.
    assert np.all(np.isnan(seen.x[1])) and np.all(np.isnan(seen.v[1]))


def test_derivatives_of_a_diverging_rollout_are_refused_or_nan(sim: cosmic.Simulator) -> None:
    inputs = robot(sim, 0)
    fast = inputs._replace(v0=inputs.v0 + 1e9)
    both = inputs._replace(v0=np.stack([inputs.v0, fast.v0]))
    bars = sim.rollout(inputs, 32)
    many = cosmic.Trajectory(*(np.stack([bar, bar]) for bar in bars))
    for call in (
        lambda **check: sim.vjp(both, many, 32, **check),
        lambda **check: sim.jvp(both, inputs, 32, **check)[1],
    ):
        with pytest.raises(cosmic.DivergedError, match="robot 1: diverged in step 0"):
            call()
        numbers = call(check=False)
        for array in leaves(numbers).values() if isinstance(numbers, cosmic.Inputs) else numbers:
            assert np.all(np.isfinite(array[0])) and np.all(np.isnan(array[1]))
    alone = sim.vjp(inputs, bars, 32)
    assert same(one_of(sim.vjp(both, many, 32, check=False), 0), alone)


def test_inputs_that_are_not_finite_affect_only_their_robot(sim: cosmic.Simulator) -> None:
    robots = [robot(sim, 0), changed(robot(sim, 1), b1=np.full(sim.shapes["b1"], np.nan))]
    batch = stacked(robots)
    seen = sim.rollout(batch, 32, check=False)
    assert same((seen.x[0], seen.v[0]), sim.rollout(robots[0], 32))
    assert np.all(np.isnan(seen.x[1]))
    shared = batch._replace(z=np.full(sim.shapes["z"], np.nan))
    assert np.all(np.isnan(sim.rollout(shared, 32, check=False).x))
    with pytest.raises(cosmic.InputError, match="robots, but"):
        sim.rollout(batch._replace(x0=np.full((3, 6, 2), np.nan)), 32, check=False)


@pytest.mark.parametrize(
    ("scene", "marked"),
    [
        ({"physics.stepz": 3}, ["overrides:2:1", "^^^^^ did you mean `steps`?"]),
        ("[physics]\nsteps = -3\n", ["scene:2:9", "^^ allowed: a whole number from 1"]),
    ],
)
def test_the_error_about_a_scene_marks_the_place(scene: Any, marked: list[str]) -> None:
    with pytest.raises(cosmic.InputError) as raised:
        cosmic.Simulator(scene)
    assert all(words in str(raised.value) for words in marked), str(raised.value)


def test_texts_keep_their_characters(tmp_path: Any) -> None:
    for name in ("😀.json", 'a"b\\c.json', "tab\t.json", "del\x7f.json"):
        truss = tmp_path / name
        truss.write_text('{"format": "cosmic-truss", "version": 1, "nodes": [[0, 0], [0.1, 0], [0, 0.1]], "edges": [[0, 1], [1, 2], [0, 2]]}')
        for given in (str(truss), truss):
            scene = cosmic.as_scene({**SHORT, "lattice.file": given})
            assert len(cosmic.Simulator(scene).edges) == 3
    with pytest.raises(cosmic.InputError, match="UTF-8"):
        cosmic.as_scene({**SHORT, "lattice.file": "\ud83d"})


def test_paths_may_contain_equals_signs(tmp_path: Any) -> None:
    folder = tmp_path / "earth+friction=0.6-0"
    folder.mkdir()
    (folder / "scene.toml").write_text(cosmic.as_scene(SHORT).to_toml())
    (folder / "plain=").write_text(cosmic.as_scene(SHORT).to_toml())
    for name in ("scene.toml", "plain="):
        assert cosmic.as_scene(str(folder / name)).to_toml() == cosmic.as_scene(SHORT).to_toml()
    with pytest.raises(cosmic.FileError, match="friction=0.6-0/missing.toml"):
        cosmic.as_scene(str(folder / "missing.toml"))
    text = cosmic.as_scene("physics.friction = 0.6").to_toml()
    assert "friction = 0.6" in text


def test_the_error_about_an_unknown_scene_lists_the_known_scenes() -> None:
    with pytest.raises(cosmic.FileError, match="no built-in scene .* `moon`; known: earth"):
        cosmic.Simulator("moon")


def test_scenes_have_many_forms(tmp_path: Any) -> None:
    base = cosmic.as_scene("stability")
    text = "[physics]\nfriction = 0.5\n[controller]\ngoal = [1.0, 0.25]\n"
    flat = {"physics.friction": np.float64(0.5), "controller.goal": np.array([1.0, 0.25])}
    nested = {"physics": {"friction": 0.5}, "controller": {"goal": (1, 0.25)}}
    assert cosmic.as_scene(flat).to_toml() == cosmic.as_scene(nested).to_toml()
    over = cosmic.as_scene(cosmic.scenes()[0]).overridden(text)
    assert over.to_toml() == cosmic.as_scene(flat).to_toml()
    file = tmp_path / "own.toml"
    file.write_text(base.to_toml())
    read = cosmic.as_scene(file)
    assert (read.name, read.to_toml()) == ("own", base.to_toml())
    assert cosmic.as_scene(base.to_toml()).to_toml() == base.to_toml()
    assert cosmic.as_scene(base) is base
