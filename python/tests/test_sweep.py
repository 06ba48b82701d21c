"""Sweeps: runs in any executor, and merged results."""

from __future__ import annotations

import multiprocessing
from collections.abc import Callable, Iterable
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path

import cosmic
import numpy as np
import pytest

SPEC = """
seeds = 1
iterations = 2
[grid]
physics.friction = [0.6, 2.5]
controller.clocks = [6, 8]
[[trials]]
name = "tiny"
scene = "stability"
[trials.settings]
lattice = { columns = 3, rows = 3 }
physics.steps = 256
schedule.horizon = [128, 256]
loss.window = 64
"""

Map = Callable[[Callable[[int], str], Iterable[int]], Iterable[str]]


@pytest.fixture
def spec(tmp_path: Path) -> Path:
    path = tmp_path / "spec.toml"
    path.write_text(SPEC)
    return path


def numbers(out: Path) -> dict[str, list[str]]:
    """The merged results without wall times."""
    merged = cosmic.sweep.merge(out)
    return {name: list(map(str, column)) for name, column in merged.items() if name != "seconds"}


def test_executors_of_any_kind_do_the_same_runs(spec: Path, tmp_path: Path) -> None:
    def swept(name: str, each: Map) -> Path:
        out = tmp_path / name
        did = list(each(partial(cosmic.sweep.run, spec, out), range(cosmic.sweep.count(spec))))
        assert did == ["done"] * 4
        return out

    serial = swept("serial", map)
    spawn = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(2, mp_context=spawn) as pool:
        processes = swept("processes", pool.map)
    assert numbers(processes) == numbers(serial)
    assert cosmic.sweep.run(spec, serial, 3) == "over"
    # The values of the grid are numbers. The keys are sorted.
    merged = cosmic.sweep.merge(serial)
    assert merged["controller.clocks"].tolist() == [6, 6, 8, 8]
    assert merged["physics.friction"].tolist() == [0.6, 2.5] * 2
    run = cosmic.load(serial / "runs/tiny+clocks=6+friction=2.5-0")
    assert run.displacement == merged["displacement_robust_p50"][1]


def test_the_executor_of_dask_does_the_runs(spec: Path, tmp_path: Path) -> None:
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(2, threads_per_worker=1, dashboard_address=None) as cluster:
        with distributed.Client(cluster) as client:
            one = partial(cosmic.sweep.run, spec, tmp_path / "dask")
            assert client.gather(client.map(one, range(4))) == ["done"] * 4


def test_unfinished_runs_have_no_numbers(spec: Path, tmp_path: Path) -> None:
    assert cosmic.sweep.run(spec, tmp_path / "s", 1) == "done"
    merged = cosmic.sweep.merge(tmp_path / "s")
    assert list(merged["state"]) == ["unfinished", "done"] + ["unfinished"] * 2
    assert np.isnan(merged["displacement_p50"]).tolist() == [True, False] + [True] * 2


def test_wrong_sweeps_are_refused(spec: Path, tmp_path: Path) -> None:
    with pytest.raises(cosmic.InputError, match="there is no run 4; the runs of this sweep have the numbers 0 to 3"):
        cosmic.sweep.run(spec, tmp_path / "s", 4)
    with pytest.raises(cosmic.InputError, match="index: -1: expected a whole number, 0 or more"):
        cosmic.sweep.run(spec, tmp_path / "s", -1)
    with pytest.raises(cosmic.FileError):
        cosmic.sweep.count(tmp_path / "nowhere.toml")
    with pytest.raises(cosmic.FileError):
        cosmic.sweep.merge(tmp_path / "s")
    spec.write_text(SPEC.replace("friction", "frictoin"))
    with pytest.raises(cosmic.InputError, match="did you mean `friction`"):
        cosmic.sweep.count(spec)
