"""Sweeps: a run for every combination of scenes, settings and seeds, in any executor.

A sweep is described by a file, which ``docs/files.md`` explains, or is one scene. Any number of processes may
work in the folder ``out``, including ``cosmic sweep run``.
"""

from __future__ import annotations

import csv
import os
from typing import Any, Union

import numpy as np
import numpy.typing as npt

from . import _core
from ._checks import path, whole
from ._memory import check_optimisation

_Path = Union[str, "os.PathLike[str]"]


def count(spec: _Path) -> int:
    """The number of runs of a sweep."""
    return _core.sweep_count(str(path("spec", spec)))


def run(spec: _Path, out: _Path, index: int) -> str:
    """Does or continues run number ``index`` of a sweep on one thread. Runs are numbered from 0.

    Returns ``"done"``, ``"diverged"``, ``"over"`` if it was done before, or ``"taken"`` if another
    process is running it. Ctrl-C saves the run; the same call continues it.
    """
    number = whole("index", index, 0)
    return _core.sweep_run(str(path("spec", spec)), path("out", out), number, check_optimisation)


def merge(out: _Path) -> dict[str, npt.NDArray[Any]]:
    """Writes ``results.csv``, and returns its columns, ready for a data frame. Unfinished runs have a
    state but no numbers."""
    with open(_core.sweep_merge(path("out", out)), newline="") as table:
        return {name: _column(cells) for name, *cells in zip(*csv.reader(table))}


def _column(cells: list[str]) -> npt.NDArray[Any]:
    """Numbers, with NaN for empty cells, or strings if a cell is not a number."""
    try:
        return np.array([float(cell or "nan") for cell in cells])
    except ValueError:
        return np.array(cells)
