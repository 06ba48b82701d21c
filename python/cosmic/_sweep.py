"""Sweeps: many runs from one fixed plan."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor, wait
from pathlib import Path
from typing import Any, Optional, Protocol, Union, cast

import numpy.typing as npt

from . import _core
from ._checks import seed as as_seed
from ._checks import whole
from ._run import Run, _columns
from ._scene import SceneLike, _value, as_scene

_Path = Union[str, "os.PathLike[str]"]


def run_one(folder: str, index: int) -> str:
    """Does or continues one run of a sweep on one thread. Executors call this function.

    Returns ``"done"``, ``"diverged"``, ``"over"`` if it was done before, or ``"taken"`` if another
    process is running it.
    """
    return _core.sweep_run(folder, index)


class Submits(Protocol):
    """An object that passes calls to workers, such as an executor of ``concurrent.futures``."""

    def submit(self, function: Callable[..., str], /, *arguments: Any) -> Future[str]: ...


class Sweep:
    """The folder of a sweep. Any number of processes on any number of hosts that share the folder
    may work on it at the same time, including ``cosmic sweep run``."""

    def __init__(self, folder: _Path) -> None:
        self.folder = Path(folder).absolute()
        self._folders, _ = _core.sweep_status(self.folder)

    def __len__(self) -> int:
        return len(self._folders)

    def left(self) -> list[int]:
        """The numbers of the unfinished runs."""
        return _core.sweep_status(self.folder)[1]

    def submit(self, executor: Submits) -> list[Future[str]]:
        """Submits every unfinished run to an executor of ``concurrent.futures``, of Dask, or to
        another object with such a ``submit``. A run uses one thread and releases the global lock."""
        return [executor.submit(run_one, str(self.folder), index) for index in self.left()]

    def run(self, threads: Optional[int] = None) -> None:
        """Does all unfinished runs in threads of this process. By default there is one thread per core,
        or as many as ``RAYON_NUM_THREADS`` says. If a run raises an exception, it is raised after
        the other runs have ended.

        Ctrl-C stops the runs after the current iteration. Finished runs are kept, and another call
        continues the others."""
        usual = _core.usual_threads() if threads is None else whole("threads", threads, 1, 1024)
        stop, folder = _core.Stop(), str(self.folder)
        with ThreadPoolExecutor(usual) as executor:
            futures = [executor.submit(_core.sweep_run, folder, k, stop) for k in self.left()]
            try:
                wait(futures)
            except BaseException as error:
                stop.set()
                executor.shutdown(wait=True, cancel_futures=True)
                if not isinstance(error, KeyboardInterrupt):
                    raise
                done = len(self) - len(self.left())
                raise KeyboardInterrupt(
                    f"{done} of {len(self)} runs are finished; call run() again to continue"
                ) from None
        for future in futures:
            future.result()

    def merge(self) -> dict[str, npt.NDArray[Any]]:
        """Writes ``results.json`` and ``results.csv``, and returns the columns of the table, ready for
        a data frame. Unfinished runs have a state but no numbers."""
        table, _ = _core.sweep_merge(self.folder)
        return _columns(Path(table).read_text())

    def __getitem__(self, index: int) -> Run:
        """Reads the finished run number ``index``."""
        return Run(self._folders[index])

    def __repr__(self) -> str:
        return f"<Sweep {self.folder}: {len(self)} runs, {len(self.left())} left>"


def sweep(
    folder: _Path,
    scenes: Union[SceneLike, Sequence[SceneLike]],
    *,
    seeds: int,
    grid: Optional[Mapping[str, Sequence[Any]]] = None,
    first_seed: int = 0,
    iterations: Optional[int] = None,
) -> Sweep:
    """Plans all combinations of scenes, settings and seeds in a new or empty folder.

    ``grid`` contains values for keys of the scenes; every combination is planned:
    ``{"physics.friction": [0.6, 1.0, 2.5]}``. The phases of every scene are fitted into ``iterations``.
    An existing sweep is opened by :class:`Sweep`.
    """
    several = isinstance(scenes, (list, tuple))
    listed = cast(Sequence[SceneLike], scenes if several else [scenes])
    axes = [f"{key}={','.join(map(_value, values))}" for key, values in (grid or {}).items()]
    last = None if iterations is None else whole("iterations", iterations, 1)
    _core.sweep_plan(
        folder,
        [as_scene(scene) for scene in listed],
        axes,
        as_seed(first_seed),
        whole("seeds", seeds, 1),
        last,
    )
    return Sweep(folder)
