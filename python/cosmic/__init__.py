"""Co-design of truss-lattice robots: optimises structure, material and neural control together, by
gradients through a differentiable simulator.

>>> import cosmic
>>> run = cosmic.optimize("stability", seed=0)  # doctest: +SKIP
>>> run.displacement                            # doctest: +SKIP
3.745...

- :func:`optimize` designs a robot, :func:`load` reads a run's folder, :func:`resume` continues one.
- :class:`Simulator` simulates one robot or many at once, with ``vjp`` and ``jvp``.
- :mod:`cosmic.sweep` does many runs in any executor or on a cluster.
- ``python -m cosmic`` is the program ``cosmic``, with all its commands.
- :mod:`cosmic.jax` and :mod:`cosmic.torch` offer rollouts as differentiable functions and turn your
  functions into objectives. :mod:`cosmic.gym` and :mod:`cosmic.sb3` have environments for reinforcement
  learning. Each needs its package.
"""

import importlib as _importlib
from typing import TYPE_CHECKING as _TYPE_CHECKING
from typing import Any as _Any

from . import sweep
from ._core import VERSION as __version__
from ._core import Scene, scenes
from ._docs import documented as _documented
from ._errors import (
    DivergedError,
    Error,
    FileError,
    InputError,
    InternalError,
    InterruptedError,
    OutOfMemoryError,
    UnstableStepError,
)
from ._lattice import Lattice
from ._loss import Loss, LossError
from ._memory import limit_memory
from ._run import Design, Run, load, optimize, resume
from ._scene import SceneLike, as_scene
from ._simulator import Inputs, Simulator, Trajectory

__all__ = [
    "Design",
    "DivergedError",
    "Error",
    "FileError",
    "InputError",
    "Inputs",
    "InternalError",
    "InterruptedError",
    "Lattice",
    "Loss",
    "LossError",
    "OutOfMemoryError",
    "Run",
    "Scene",
    "SceneLike",
    "Simulator",
    "Trajectory",
    "UnstableStepError",
    "__version__",
    "as_scene",
    "limit_memory",
    "load",
    "optimize",
    "resume",
    "scenes",
    "sweep",
]

_documented(Design, Inputs, Run, Simulator, Trajectory)

if _TYPE_CHECKING:
    from . import gym, jax, sb3, torch, workshop

#: The modules that need further packages. They are imported when they are used.
_LATER = ("gym", "jax", "sb3", "torch", "workshop")


def __getattr__(name: str) -> _Any:
    if name not in _LATER:
        raise AttributeError(f"module 'cosmic' has no attribute {name!r}")
    try:
        return _importlib.import_module(f"cosmic.{name}")
    except ImportError as error:
        # `hasattr` and `help` expect this class.
        raise AttributeError(str(error)) from error


def __dir__() -> list[str]:
    return sorted({*__all__, *_LATER})
