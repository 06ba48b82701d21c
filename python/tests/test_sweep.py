"""Sweeps: plans, executors and merged results."""

from __future__ import annotations

import multiprocessing
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from pathlib import Path

import cosmic
import numpy as np
import pytest
from common import SCENE

GRID = {"physics.friction": [0.6, 2.5], "controller.clocks": [6, 8]}


def planned(folder: Path) -> cosmic.Sweep:
    return cosmic.sweep(folder, SCENE, seeds=2, grid=GRID, iterations=2)


def numbers(sweep: cosmic.Sweep) -> dict[str, list[str]]:
    """The merged results without wall times."""
    merged = sweep.merge()
    return {name: list(map(str, column)) for name, column in merged.items() if name != "seconds"}


def test_executors_of_any_kind_do_the_same_runs(tmp_path: Path) -> None:
    serial = planned(tmp_path / "serial")
    assert len(serial) == 8 and serial.left() == list(range(8))
    half = serial.submit(OneAtATime(4))
    assert [future for future in half] == ["done"] * 4 + ["skipped"] * 4
    assert serial.left() == [4, 5, 6, 7]
    assert list(serial.merge()["state"]) == ["done"] * 4 + ["waiting"] * 4
    serial.run(threads=1)
    assert serial.left() == []
    threads, processes = planned(tmp_path / "threads"), planned(tmp_path / "processes")
    with ThreadPoolExecutor(3) as pool:
        assert {future.result() for future in threads.submit(pool)} == {"done"}
    spawn = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(2, mp_context=spawn) as pool:
        assert {future.result() for future in processes.submit(pool)} == {"done"}
    expected = numbers(serial)
    assert numbers(threads) == expected and numbers(processes) == expected
    assert len(set(expected["scene"])) == 4
    # The values of the grid are numbers.
    merged = serial.merge()
    assert merged["physics.friction"].tolist() == [0.6] * 4 + [2.5] * 4
    assert merged["controller.clocks"].tolist() == [6, 6, 8, 8] * 2
    # Finished runs are not submitted again.
    assert cosmic.Sweep(serial.folder).submit(OneAtATime(8)) == []


def test_the_executor_of_dask_does_the_runs(tmp_path: Path) -> None:
    distributed = pytest.importorskip("distributed")
    serial, dask = planned(tmp_path / "serial"), planned(tmp_path / "dask")
    serial.run(threads=1)
    with distributed.LocalCluster(2, threads_per_worker=1, dashboard_address=None) as cluster:
        with distributed.Client(cluster) as client:
            futures = dask.submit(client.get_executor())
            assert {future.result() for future in futures} == {"done"}
    assert numbers(dask) == numbers(serial)


class OneAtATime:
    """An executor that does the first ``most`` runs as soon as they are submitted, and drops the others."""

    def __init__(self, most: int) -> None:
        self.most = most

    def submit(self, function, *arguments):  # type: ignore[no-untyped-def]
        self.most -= 1
        return function(*arguments) if self.most >= 0 else "skipped"


def test_a_sweep_returns_its_runs(tmp_path: Path) -> None:
    sweep = cosmic.sweep(tmp_path / "s", SCENE, seeds=1, first_seed=3, iterations=2)
    sweep.run()
    alone = cosmic.optimize(SCENE, 3, iterations=2, progress=False)
    assert np.array_equal(sweep[0].trajectory, alone.trajectory)
    assert sweep[0].seed == 3 and "0 left" in repr(sweep)


def test_invalid_plans_are_refused(tmp_path: Path) -> None:
    for changes, says in [
        ({"seeds": 0}, "seeds: 0"),
        ({"grid": {"physics.frictoin": [1]}}, "did you mean `friction`"),
        ({"grid": {"physics.friction": []}}, "a value is empty"),
        ({"grid": {"physics.friction": [1, 1]}}, "the value 1 is repeated"),
    ]:
        with pytest.raises(cosmic.InputError, match=says):
            cosmic.sweep(tmp_path / "s", SCENE, **{"seeds": 1, **changes})
    planned(tmp_path / "s")
    with pytest.raises(cosmic.InputError, match="not empty"):
        planned(tmp_path / "s")
    with pytest.raises(cosmic.InputError, match="there is no run 8"):
        cosmic._sweep.run_one(str(tmp_path / "s"), 8)
    with pytest.raises(cosmic.FileError):
        cosmic.Sweep(tmp_path / "nowhere")
