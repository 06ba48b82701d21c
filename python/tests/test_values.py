"""Runs, inputs and trajectories as values: they are equal by their numbers, short to read, and cannot be changed by accident."""

from __future__ import annotations

import pydoc
import subprocess
import sys
from pathlib import Path

import cosmic
import numpy as np
import pytest
from common import SCENE, SEED


def test_the_arrays_of_a_run_are_read_only(run: cosmic.Run) -> None:
    inputs = run.inputs
    arrays = [*vars(run.design).values(), *run.controller.values(), *run.history.values()]
    arrays += [run.trajectory, run.velocities, run.steps, run.times, inputs.x0, inputs.v0]
    arrays += [run.simulator().edges, run.simulator().rest_length]
    for array in arrays:
        with pytest.raises(ValueError, match="read-only"):
            array += 1
    inputs.controller["w1"] = 2.0 * inputs.controller["w1"]  # type: ignore[index]
    assert run.inputs != inputs and run.inputs == run.inputs
    # A simulator takes such arrays.
    assert np.array_equal(run.simulator().rollout(run.inputs, observed=run.steps).x, run.trajectory)


def test_values_are_equal_by_their_numbers(run: cosmic.Run) -> None:
    again = cosmic.load(run.folder)
    assert again == run and hash(again) == hash(run) and again.design == run.design and run != run.folder
    assert run != cosmic.optimize(SCENE, SEED, iterations=20, progress=False)
    sim = run.simulator()
    inputs, seen = run.inputs, sim.rollout(run.inputs, 32)
    assert seen == sim.rollout(inputs, 32) and seen != sim.rollout(inputs, 32, 8) and seen != run
    assert not inputs != run.inputs and inputs != sim.initial()
    assert inputs.replace(physics={"physics.gravity": 1.0}) != inputs.replace(physics={"physics.gravity": 2.0})


def test_inputs_are_replaced_by_name(run: cosmic.Run) -> None:
    moved = run.inputs.replace(x0=run.inputs.x0 + 1.0, physics={"physics.gravity": 1.0})
    assert np.array_equal(moved.x0, run.inputs.x0 + 1.0) and moved.z is run.design.z
    with pytest.raises(cosmic.InputError, match="replace: 'x': allowed: z, controller, x0, v0, physics"):
        run.inputs.replace(x=moved.x0)


def test_a_text_of_arrays_is_short(run: cosmic.Run) -> None:
    blocks = ", ".join(f"'{name}': {list(own.shape)}" for name, own in run.controller.items())
    assert repr(run.inputs) == f"Inputs(z=[20, 3], controller={{{blocks}}}, x0=[9, 2], v0=[9, 2], physics={{}})"
    assert repr(cosmic.Trajectory(run.trajectory, run.velocities)) == "Trajectory(x=[17, 9, 2], v=[17, 9, 2])"
    counts = np.bincount(run.design.materials, minlength=3)
    assert repr(run.design) == f"<Design: 20 edges, of them {counts[1]} skeleton, {counts[2]} actuators>"


def test_names_are_those_for_users(run: cosmic.Run) -> None:
    internal = {"documented", "span", "named", "shapes_of", "core_for", "kept", "TYPE_CHECKING"}
    for owner in (cosmic, run.simulator()):
        shown = [name for name in dir(owner) if not name.startswith("_")]
        assert not internal.intersection(shown), shown
    assert {"gym", "jax", "sb3", "torch", "workshop", "optimize", "LossError"} <= set(dir(cosmic))
    assert "Continues the run" in pydoc.render_doc(cosmic, renderer=pydoc.plaintext)


LATER = """
import sys
import cosmic

assert "cosmic.gym" not in sys.modules and "gymnasium" not in sys.modules
sys.modules["jax"] = None
try:
    cosmic.jax
except AttributeError as error:
    assert "pip install 'cosmic-codesign[jax]'" in str(error), error
assert not hasattr(cosmic, "gmy")
assert cosmic.workshop.read_bars
"""


def test_a_module_is_imported_when_it_is_used(tmp_path: Path) -> None:
    done = subprocess.run([sys.executable, "-c", LATER], capture_output=True, text=True, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
