"""Types of the extension module, which the other modules of this package wrap."""

import os
from collections.abc import Iterator, Sequence
from typing import Any, Callable, Optional

import numpy as np
import numpy.typing as npt

_Array = npt.NDArray[Any]
_Floats = npt.NDArray[np.float64]
_Path = str | os.PathLike[str]

class Scene:
    """A complete experiment: lattice, physics, schedule and every other setting."""

    name: str
    """The name of the scene in summaries."""
    sizes: dict[str, float]
    """The sizes that determine how much memory an optimisation or a rollout needs."""
    @staticmethod
    def load(source: _Path) -> Scene:
        """Loads a built-in scene by its name, or a scene file."""
    @staticmethod
    def parse(text: str) -> Scene:
        """Parses a scene from TOML. Missing keys come from its `base`."""
    truss: Optional[str]
    """The truss of the lattice as the text of a truss file; None for a generated lattice."""
    def overridden(self, text: str, truss: Optional[str] = None) -> Scene:
        """A copy of this scene, changed by the settings in a TOML text. If a truss is given, the text names it
        ``truss.json``."""
    def __getitem__(self, key: str) -> Any:
        """The value of a setting such as ``physics.gravity``, as a scene file states it. The value of ``lattice.file`` is a
        :class:`cosmic.Lattice`, or ``"off"``."""
    def keys(self) -> list[str]:
        """The keys of all settings."""
    def __iter__(self) -> Iterator[str]: ...
    def to_toml(self) -> str:
        """The complete scene as TOML."""
    @staticmethod
    def restore(text: str) -> Scene:
        """Reads the text that `pickle` keeps of a scene."""

def scenes() -> list[str]:
    """The names of the built-in scenes, the default first."""

VERSION: str
"""The version of this package."""

def program(arguments: list[str]) -> int:
    """Runs a command of the program ``cosmic``, and returns its exit code. The first argument is the program's name."""

def truss(text: str) -> str:
    """Checks the text of a truss file. Returns it in the library's node numbers."""

GPU: bool
"""Whether this package has GPU support."""

class Simulator:
    """Simulates robots on the lattice and in the world of a scene."""

    def __init__(self, scene: Scene, on_gpu: bool, projection: str) -> None: ...
    projection: str
    dt: float
    steps: int
    shapes: list[tuple[str, list[int]]]
    edges: npt.NDArray[np.int64]
    rest_length: list[float]
    payload: int
    along: list[float]
    goal_origin: Optional[list[float]]
    terrain: list[list[float]]
    physics: list[tuple[str, float, int]]
    def with_others(
        self, driven: Optional[int], changes: Optional[list[int]], physics: list[tuple[str, int]]
    ) -> Simulator: ...
    def decide(self, projection: str) -> None: ...
    def initial(self, seed: int) -> _Floats: ...
    def layouts(self, z: _Floats) -> _Floats: ...
    def rollout(
        self, arrays: Sequence[_Array], observed: list[int], first: int, check: bool
    ) -> tuple[_Array, _Array]: ...
    def vjp(
        self,
        arrays: Sequence[_Array],
        x_bar: _Array,
        v_bar: _Array,
        observed: list[int],
        first: int,
        bounded: bool,
        check: bool,
        by: int,
    ) -> _Array: ...
    def jvp(
        self,
        arrays: Sequence[_Array],
        tangents: Sequence[_Array],
        observed: list[int],
        first: int,
        check: bool,
    ) -> _Array: ...

class Planned:
    """A rollout that JAX can compile. As long as this object exists, XLA finds it by its number."""

    def __init__(
        self,
        simulator: Simulator,
        observed: Sequence[int],
        bounded: bool,
        arrays: Sequence[tuple[str, int]],
    ) -> None: ...
    id: int

STATES: int
"""The mode in which a call of XLA computes states."""
PUSHED: int
"""The mode in which it computes derivatives of states in a direction."""
PULLED: int
"""The mode in which it computes gradients of states times cotangents."""
GRADIENTS: list[str]
"""The arrays in the order of the bits of ``by``."""

def xla_handler(minor: int) -> object: ...

def animate(simulator: Simulator, path: _Path, z: _Floats, steps: list[int], x: _Floats) -> None: ...

class Driven:
    """Robots with given design vectors, whose activations come from the caller."""

    def __init__(self, simulator: Simulator, z: _Floats, robots: int, is_scaled: bool) -> None: ...
    actuators: list[int]
    inputs: int
    presence: list[list[float]]
    def vary(self, robot: int, physics: list[tuple[str, list[float]]]) -> None: ...
    def draw_goals(self, seed: int) -> tuple[list[int], _Floats]: ...
    def places(self, x: _Floats) -> _Floats: ...
    def advance(
        self,
        which: list[int],
        activations: _Floats,
        x: _Floats,
        v: _Floats,
        first: int,
        steps: int,
        is_metered: bool,
    ) -> tuple[_Floats, _Floats, list[bool], list[float]]: ...
    def observe(
        self, x: _Floats, v: _Floats, done: list[int], goals: Optional[list[list[float]]]
    ) -> _Floats: ...
    def picture(self, robot: int, steps: list[int], x: _Floats) -> npt.NDArray[np.uint8]: ...

_Progress = Callable[[int, int, dict[str, Any]], object]

def optimise(
    scene: Scene,
    name: str,
    seed: int,
    iterations: Optional[int],
    folder: _Path,
    begin_with: Optional[_Path],
    loss: Any,
    threads: Optional[int],
    progress: Optional[_Progress],
    warning: Callable[[str], object],
) -> bool: ...
def resume(
    folder: _Path,
    loss: Any,
    allow_unstable: bool,
    threads: Optional[int],
    progress: Optional[_Progress],
    warning: Callable[[str], object],
) -> bool: ...
def deliver_so_far(folder: _Path, into: _Path, loss: Any) -> None: ...
def usual_threads() -> int: ...
def load(folder: _Path) -> tuple[str, list[list[float]]]: ...
def report(folder: _Path) -> None: ...
def player_page(folder: _Path) -> str: ...
def sweep_count(spec: str) -> int: ...
def sweep_run(spec: str, folder: _Path, index: int, check: Callable[[Scene], object]) -> str: ...
def sweep_merge(folder: _Path) -> os.PathLike[str]: ...
