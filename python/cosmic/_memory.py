"""Refuses work that needs too much memory. A failed allocation in the library would end the process."""

from __future__ import annotations

import math
import os
from typing import Optional

import numpy as np

from . import _core
from ._core import Scene
from ._errors import InputError, OutOfMemoryError


def _machine() -> float:
    """The memory of the machine in bytes; infinite if the system does not tell."""
    try:
        return float(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
    except (AttributeError, OSError, ValueError):
        return math.inf


_limit = _machine()

#: The sizes of a scene: `Scene.sizes`.
_Sizes = dict[str, float]


def limit_memory(megabytes: Optional[float] = None) -> None:
    """Sets how much memory a call may need, in MB. Work that needs more raises :class:`OutOfMemoryError`
    before it begins. By default, the limit is the memory of the machine."""
    global _limit
    if megabytes is not None and not (isinstance(megabytes, (int, float, np.number)) and megabytes > 0):
        raise InputError(f"megabytes: {megabytes!r}: expected a positive number")
    _limit = _machine() if megabytes is None else float(megabytes) * 1e6


def check(needed: float, what: str, remedy: str) -> None:
    """Raises an exception if ``what`` needs more bytes than the limit."""
    if needed > _limit:
        raise OutOfMemoryError(
            f"{what} needs {_words(needed)} of memory, but the limit is {_words(_limit)}; {remedy}, or "
            "raise the limit with cosmic.limit_memory"
        )


def _words(size: float) -> str:
    return f"{size / 1e6:.4g} MB" if size < 1e9 else f"{size / 1e9:.4g} GB"


def check_simulator(of: _Sizes) -> None:
    """Refuses a scene whose simulator needs too much memory."""
    edges, steps = of["edges"], of["steps"]
    # The simulator keeps a sine, a cosine and a time for each step, together 24 bytes. The list of them doubles as
    # it grows and is then copied, so it needs up to three times as much. An edge takes about 400 bytes.
    check(
        72 * steps + 1e3 * edges,
        f"a simulator of {edges:.0f} edges and {steps:.0f} steps",
        "use a smaller lattice, or lower physics.steps",
    )


def check_start(of: _Sizes, copies: int) -> None:
    """Refuses a scene if ``copies`` copies of the initial inputs need too much memory."""
    hidden, edges = of["hidden"], of["edges"]
    check(
        8 * copies * of["numbers"],
        f"a controller of {hidden:.0f} hidden neurons for {edges:.0f} edges",
        "use a smaller lattice, or lower controller.hidden",
    )


def check_optimisation(scene: Scene) -> None:
    """Refuses a scene whose optimisation needs too much memory."""
    of = scene.sizes
    check_simulator(of)
    # The ten copies include gradients and the moments of two optimisers.
    check_start(of, 10)
    horizon = of["horizon"]
    check(
        _recorded(of, horizon, 8),
        f"the gradient over {horizon:.0f} steps",
        "set gradient.memory, or lower schedule.horizon",
    )


def check_rollouts(
    of: _Sizes,
    robots: int,
    size: int,
    states: int,
    copies: int = 1,
    steps: Optional[int] = None,
    more: int = 0,
) -> None:
    """Refuses rollouts that need too much memory: numbers of ``size`` bytes, ``more`` of them for activations, goals and
    physics, and ``copies`` copies of the positions and velocities. If ``steps`` is given, gradients
    of rollouts with this number of steps."""
    numbers = of["numbers"] + more
    needed = robots * size * (numbers + 4 * copies * states * of["nodes"])
    what, remedy = "a rollout", "use fewer robots at once, or observe fewer states (`observed`)"
    if steps is not None:
        threads = 1 if robots == 1 else min(robots, _core.usual_threads())
        needed += 2 * robots * size * numbers + threads * _recorded(of, steps, size)
        what, remedy = "the gradient of a rollout", remedy + ", or set gradient.memory in the scene"
    robots_are = f"{robots} robot{'s' * (robots != 1)}"
    states_are = f"{states} observed state{'s' * (states != 1)}"
    check(needed, f"{what} of {robots_are} with {states_are}", remedy)


def _recorded(of: _Sizes, steps: float, size: int) -> float:
    """The number of bytes that a gradient records over a rollout: for every step the state and the results of
    all operations, limited by the scene's memory budget."""
    # The factors were measured on lattices of 6 x 6 and 16 x 16 nodes with 32 and 512 hidden neurons.
    row = 5 * of["nodes"] + 4 * of["edges"] + 6 * of["hidden"]
    return min(steps * row * size, of["budget"])
