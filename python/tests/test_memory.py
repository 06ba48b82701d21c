"""Lack of memory and bugs in the library raise exceptions; they never end the process."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import cosmic
import numpy as np
import pytest
from common import SHORT, changed

ROOT = Path(__file__).resolve().parents[2]
LONG: dict[str, Any] = {"scene": "stability", "physics.steps": 1000000}
WIDE = {"scene": "stability", "lattice": {"columns": 64, "rows": 64}, "controller.hidden": 4096}


@pytest.fixture
def sim() -> Iterator[cosmic.Simulator]:
    """A simulator, after which the limit is that of the machine again."""
    yield cosmic.Simulator(SHORT)
    cosmic.limit_memory()


def bars(robots: int, states: int) -> cosmic.Trajectory:
    return cosmic.Trajectory(*np.zeros((2, robots, states, 6, 2)))


#: Work that needs more than 1 MB, and how its error begins.
LARGE: dict[str, tuple[Callable[[cosmic.Simulator, cosmic.Inputs], Any], str]] = {
    # 2000 robots x (129 states x 6 nodes x 4 numbers + the numbers of the inputs) x 8 bytes.
    "rollout": (lambda sim, many: sim.rollout(many, 256, 2), "a rollout of 2000 robots with 129 observed states needs "),
    "vjp": (
        lambda sim, many: sim.vjp(many, bars(2000, 1), observed=[256]),
        "the gradient of a rollout of 2000 robots with 1 observed state needs ",
    ),
    "jvp": (lambda sim, many: sim.jvp(many, sim.initial(), 256, 2), "a rollout of 2000 robots"),
    "simulator": (lambda *_: cosmic.Simulator(LONG), "a simulator of 110 edges and 1000000 steps needs 72.11 MB of memory"),
    "start": (lambda *_: cosmic.optimize(WIDE, progress=False), "a simulator of 16002 edges"),
    "horizon": (
        lambda *_: cosmic.optimize({**SHORT, "schedule.horizon": [256, 256]}, progress=False),
        "the gradient over 256 steps needs ",
    ),
}


@pytest.mark.parametrize("what", LARGE)
def test_work_that_needs_more_memory_than_the_limit_is_refused(sim: cosmic.Simulator, what: str) -> None:
    call, begins = LARGE[what]
    first = sim.initial()
    many = first._replace(v0=np.zeros((2000, *first.v0.shape)))
    cosmic.limit_memory(1.0 if what != "horizon" else 0.5)
    with pytest.raises(MemoryError) as raised:
        call(sim, many)
    assert isinstance(raised.value, cosmic.OutOfMemoryError)
    assert str(raised.value).startswith(begins), str(raised.value)
    assert "but the limit is " in str(raised.value) and "cosmic.limit_memory" in str(raised.value)
    # The simulator still works.
    sim.rollout(first, 64)


def test_a_run_of_a_sweep_obeys_the_limit(sim: cosmic.Simulator, tmp_path: Path) -> None:
    spec = tmp_path / "wide.toml"
    spec.write_text(cosmic.as_scene(WIDE).to_toml())
    cosmic.limit_memory(500)
    with pytest.raises(cosmic.OutOfMemoryError, match="a controller of 4096 hidden neurons for 16002 edges needs"):
        cosmic.sweep.run(spec, tmp_path / "s", 0)
    assert not (tmp_path / "s").exists()


def test_more_robots_than_any_machine_holds_are_refused(sim: cosmic.Simulator) -> None:
    first = sim.initial()
    b1 = first.controller["b1"]
    # A view; the results alone would need 1e13 bytes.
    many = changed(first, b1=np.broadcast_to(b1, (10**9, *b1.shape)))
    with pytest.raises(MemoryError, match="a rollout of 1000000000 robots with 257 observed states needs .* GB"):
        sim.rollout(many, 256, 1)


def test_every_entry_point_catches_panics() -> None:
    # Otherwise a panic would become an exception that `except Exception` does not catch.
    plain = {"dt", "steps", "shapes", "places", "actuators", "inputs", "edges", "rest_length", "along", "goal_origin"}
    plain |= {"payload"}
    plain |= {"projection", "__repr__", "__reduce__", "restore", "to_toml", "scenes", "observe"}
    plain |= {"keys", "__iter__", "__eq__", "__hash__", "__copy__", "__deepcopy__"}
    found = 0
    for file in sorted((ROOT / "python/src").glob("*.rs")):
        text = file.read_text()
        pieces = re.split(r"#\[pyfunction\]|#\[pymethods\]", text)[1:]
        for piece in pieces:
            # The function after the attribute, or the whole block of methods.
            block = piece[: piece.find("\n}\n")]
            bodies = re.split(r"\n(?:    )?(?:pub\(crate\) )?fn ", block)[1:]
            for body in bodies:
                name = re.match(r"\w+", body)[0]  # type: ignore[index]
                if name not in plain:
                    found += 1
                    assert re.search(r"caught\(|unlocked\(|with_loss\(|attended_run\(", body), (file.name, name)
    assert found >= 18


def test_every_error_of_the_library_has_a_class() -> None:
    errors = (ROOT / "cosmic/src/error.rs").read_text()
    enum = errors[errors.index("pub enum Error {") :]
    enum = enum[: enum.index("\n}\n")]
    variants = re.findall(r"^    ([A-Z]\w+)[ ({,]", enum, re.MULTILINE)
    assert len(variants) >= 15
    named = (ROOT / "python/src/errors.rs").read_text()
    missing = [name for name in variants if f"Library::{name}" not in named]
    assert not missing
    page = (ROOT / "docs/python.md").read_text()
    for name in cosmic.__all__:
        thing = getattr(cosmic, name)
        if isinstance(thing, type) and issubclass(thing, Exception):
            assert issubclass(thing, cosmic.Error)
            assert f"`cosmic.{name}`" in page, f"docs/python.md does not name {name}"


@pytest.mark.parametrize("megabytes", [0.0, -1.0, math.nan])
def test_a_limit_is_a_positive_number(megabytes: float) -> None:
    with pytest.raises(cosmic.InputError, match="expected a positive number"):
        cosmic.limit_memory(megabytes)
