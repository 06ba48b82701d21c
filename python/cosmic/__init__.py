"""Co-design of truss-lattice robots: optimises structure, material and neural control together, by
gradients through a differentiable simulator.

>>> import cosmic
>>> run = cosmic.optimize("stability", seed=0)  # doctest: +SKIP
>>> run.displacement                            # doctest: +SKIP
4.2

- :func:`optimize` designs a robot, :func:`load` reads a run's folder, :func:`resume` continues one.
- :class:`Simulator` simulates one robot or many at once, with ``vjp`` and ``jvp``.
- :mod:`cosmic.sweep` does many runs in any executor or on a cluster.
- ``python -m cosmic`` is the program ``cosmic``, with all its commands.
- :mod:`cosmic.jax` and :mod:`cosmic.torch` offer rollouts as differentiable functions and turn your
  functions into objectives. :mod:`cosmic.gym` has environments for reinforcement learning. Import
  them separately; each needs its package.
"""

from . import sweep
from ._core import VERSION as __version__
from ._core import Scene, scenes
from ._docs import documented
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
from ._loss import Loss
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

documented(Design, Inputs, Run, Simulator, Trajectory)
