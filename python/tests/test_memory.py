"""Lack of memory and bugs in the library raise exceptions; they never end the process."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import cosmic
import pytest

ROOT = Path(__file__).resolve().parents[2]

#: Allows a few MB more than are in use, and then does work that needs more.
LIMITED = """
import resource, sys
import cosmic, numpy as np

sim = cosmic.Simulator("stability")
first = sim.initial()

def limited(megabytes, call):
    pages = int(open("/proc/self/statm").read().split()[0])
    old = resource.getrlimit(resource.RLIMIT_AS)
    resource.setrlimit(resource.RLIMIT_AS, (pages * 4096 + megabytes * 2**20, old[1]))
    try:
        call()
    except MemoryError as error:
        assert isinstance(error, cosmic.OutOfMemoryError), repr(error)
        print(error)
    else:
        raise SystemExit("nothing was refused")
    finally:
        resource.setrlimit(resource.RLIMIT_AS, old)

many = first._replace(v0=np.zeros((2000, *first.v0.shape)))
# Small work first, because memory that was allocated once may be reused.
bars = cosmic.Trajectory(np.zeros((1, 36, 2)), np.zeros((1, 36, 2)))
limited(30, lambda: sim.vjp(first, bars, observed=[8192]))
long = {"scene": "stability", "physics.steps": 1000000}
limited(40, lambda: cosmic.Simulator(long))
sim.rollout(many._replace(v0=many.v0[:4]), 8)
limited(500, lambda: sim.rollout(many, 8192, 8))
limited(300, lambda: sim.jvp(many._replace(v0=many.v0[:100]), first, 8192, 8))
wide = {"scene": "stability", "lattice": {"columns": 64, "rows": 64}, "controller.hidden": 4096}
large = cosmic.Simulator(wide)
limited(500, large.initial)
limited(500, lambda: cosmic.optimize(wide, progress=False))
limited(500, lambda: cosmic.optimize({**long, "schedule.horizon": [4096, 1000000]}, progress=False))
limited(500, lambda: cosmic.sweep.run(sys.argv[1], "nowhere", 0))
# The simulator still works.
sim.rollout(first)
"""


@pytest.mark.skipif(sys.platform != "linux", reason="limits the memory of a process as Linux does")
def test_work_that_needs_too_much_memory_is_refused(tmp_path: Path) -> None:
    wide = tmp_path / "wide.toml"
    wide.write_text('base = "stability"\nlattice = { columns = 64, rows = 64 }\ncontroller.hidden = 4096\n')
    line = [sys.executable, "-c", LIMITED, wide]
    done = subprocess.run(line, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stdout + done.stderr
    gradient, simulator, rollout, tangents, start, *runs = done.stdout.splitlines()
    # 2000 robots x 1025 states x 36 nodes x 4 numbers of 8 bytes.
    assert rollout == (
        "a rollout of 2000 robots with 1025 observed states needs 2.4 GB of memory, but the system refuses "
        "to allocate it; use fewer robots at once, or observe fewer states (`observed`)"
    )
    assert gradient.startswith("the gradient of a rollout of 1 robot with 1 observed state needs 53 MB")
    assert gradient.endswith("or set gradient.memory in the scene")
    assert tangents.startswith("a rollout of 100 robots")
    assert simulator.startswith("a simulator of 110 edges and 1000000 steps needs 72 MB")
    assert start.startswith("a controller of 4096 hidden neurons for 16002 edges needs 3.2 GB")
    assert len(runs) == 3 and "over 1000000 steps" in runs[1]
    assert "Traceback" not in done.stderr


def test_more_robots_than_any_machine_holds_are_refused(sim: cosmic.Simulator) -> None:
    first = sim.initial()
    # The copies of the inputs and the results each need 1e11 bytes or more.
    many = first._replace(b1=first.b1[None].repeat(4_000_000, axis=0))
    with pytest.raises(MemoryError, match="a copy of the inputs of 4000000 robots needs .* GB .* (free|allocate)"):
        sim.rollout(many, 256, 1)


def test_every_entry_point_catches_panics() -> None:
    # Otherwise a panic would become an exception that `except Exception` does not catch.
    plain = {"dt", "steps", "shapes", "along", "actuators", "inputs", "rest", "edges", "rest_length", "goal_origin"}
    plain |= {"__repr__", "__reduce__", "restore", "to_toml", "scenes", "set", "usual_threads", "check_span"}
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
                if name in plain or (name == "new" and "Self::default()" in body):
                    continue
                found += 1
                assert "caught(" in body or "attended(" in body or "self.states(" in body, (file.name, name)
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
