"""Finished runs, and functions that design robots."""

from __future__ import annotations

import html
import json
import os
import shutil
import tempfile
import warnings
import weakref
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Optional, Union

import numpy as np
import numpy.typing as npt

from . import _core
from ._checks import seed as as_seed
from ._checks import path as as_path
from ._checks import whole, yes
from ._core import Scene
from ._errors import InputError
from ._loss import Loss, LossError, ValueAndGradient, as_loss
from ._memory import check_optimisation
from ._scene import SceneLike, as_scene
from ._simulator import Inputs, Simulator, equal

_Path = Union[str, "os.PathLike[str]"]
_Floats = npt.NDArray[np.float64]
_Whole = npt.NDArray[np.int64]
#: Called after every iteration with its number, the last iteration's number, and some results.
Progress = Callable[[int, int, dict[str, Any]], object]


@dataclass(frozen=True, eq=False, repr=False)
class Design:
    """The design of a robot: the materials on the edges of a lattice."""

    edges: _Whole
    """The two nodes of every edge, shape ``(edges, 2)``."""
    z: _Floats
    """Design vectors, ``(edges, 3)``; zeros and ones once every edge has one material."""
    materials: _Whole
    """Per edge 0 for void, 1 for skeleton, 2 for actuator."""

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Design) and equal(vars(self), vars(other))

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        counts = np.bincount(self.materials, minlength=3)
        return f"<Design: {len(self.edges)} edges, of them {counts[1]} skeleton, {counts[2]} actuators>"


class Run:
    """A designed robot, from :func:`optimize` or :func:`load`. Its arrays are read-only; ``run.inputs.x0.copy()`` can be changed."""

    folder: Path
    """The run's folder; temporary unless you named one. If Ctrl-C stopped the run, the folder holds what :func:`resume`
    continues, and the files of the robot so far are temporary."""
    scene: Scene
    seed: int
    design: Design
    controller: dict[str, _Floats]
    """The blocks of the controller's parameters by name, as in :class:`Inputs`. A learned clock has the block
    ``tempo``: its frequency is ``controller.omega * exp(tempo)``."""
    summary: dict[str, Any]
    """The numbers of ``summary.json``."""
    history: dict[str, npt.NDArray[Any]]
    """The numbers of ``history.jsonl`` as columns, with one row per iteration, ready for a data frame.
    A number inside a list or an object has a name with dots, such as ``measures.0``. Missing numbers
    are NaN."""
    trajectory: _Floats
    """Positions in the final rollout, shape ``(states, nodes, D)``, m."""
    velocities: _Floats
    """Velocities in the final rollout, same shape, m/s."""
    steps: _Whole
    """The numbers of the steps after which these states were observed."""
    times: _Floats
    """The times of these states, s."""

    def __init__(self, folder: _Path, *, keep: Any = None, of: Optional[Path] = None) -> None:
        files = as_path("folder", folder)
        # The unfinished run whose robot so far is in `folder`.
        self._of = None if of is None else of.absolute()
        self.folder = files if of is None else of
        # The run may be unpickled in another working directory.
        self._files = files.absolute()
        # A temporary folder lives as long as the run.
        self._keep = keep
        # Reads and checks all files of the run.
        design, rest = _core.load(files)
        read = json.loads(design)
        self.design = Design(*(_fixed(read[name]) for name in ("edges", "z", "materials")))
        self.controller = {name: _fixed(block) for name, block in read["controller"].items()}
        self.summary = json.loads(self._text("summary.json"))
        self.seed = self.summary["seed"]
        # Read from the file, because a custom lattice is in a second file beside it.
        self.scene = Scene.load(self._files / "scene.toml")
        has_history = (self._files / "history.jsonl").exists()
        self.history = _columns(self._text("history.jsonl") if has_history else "")
        moved = json.loads(self._text("trajectory.json"))
        self.trajectory, self.velocities = (
            _fixed([state[name] for state in moved["states"]]) for name in ("x", "v")
        )
        self.steps = _fixed(moved["steps"])
        self.times = _fixed(self.steps * moved["dt"])
        self._rest = _fixed(rest)

    def _text(self, name: str) -> str:
        return (self._files / name).read_text(encoding="utf-8")

    @property
    def displacement(self) -> float:
        """Median displacement along the ground of robots that vary a little, of the payload or of the
        body that ``objective.body`` names, m; NaN if rollouts diverged."""
        median = self.summary["displacement_robust_p50"]
        return float("nan") if median is None else float(median)

    @property
    def inputs(self) -> Inputs:
        """The robot at rest, as inputs of a :class:`Simulator` of its scene."""
        return Inputs(self.design.z, dict(self.controller), self._rest, _fixed(np.zeros_like(self._rest)))

    def simulator(self) -> Simulator:
        """A simulator of the run's scene and of its kind of robot: finished, or still undecided."""
        is_finished = ((self.design.z == 0) | (self.design.z == 1)).all()
        made = Simulator(self.scene, "layout" if is_finished else "performance")
        made._design = self.design.z
        return made

    def save(self, path: _Path) -> Path:
        """Copies the files of the run to a new folder."""
        path = as_path("path", path)
        if path.exists() and (not path.is_dir() or any(path.iterdir())):
            raise InputError(f"{path} exists and is not empty; name a new or empty folder")
        shutil.copytree(self._files, path, dirs_exist_ok=True)
        return path

    def report(self, path: Optional[_Path] = None) -> Path:
        """Writes a page, a picture and an animation into the run's folder, or into a copy of the run
        in the new folder ``path``. Returns the path of the page."""
        own = self.folder if self._of is None else self._files
        folder = own if path is None else self.save(path)
        _core.report(folder)
        return folder / "report.html"

    def __reduce__(self) -> tuple[Any, ...]:
        # The files of a temporary folder are pickled with the run.
        if self._keep is None:
            return Run, (self._files,)
        files = [path for path in self._files.rglob("*") if path.is_file()]
        packed = {str(path.relative_to(self._files)): path.read_bytes() for path in files}
        return _unpacked, (packed, self._of)

    def __repr__(self) -> str:
        name, solid = self.summary["scene"], self.summary["V"]
        reliability = self.summary.get("reliability", {})
        doubt = ", stays in place" if reliability.get("stays_in_place") else ", unreliable"
        mark = doubt if reliability.get("verdict") == "unreliable" else ""
        return f"<Run {name}, seed {self.seed}: {self.displacement:.3f} m{mark}, V {solid:.3f}>"

    def __eq__(self, other: object) -> bool:
        """True if the runs have the same scene, seed, robot and final rollout."""
        if not isinstance(other, Run):
            return False
        own, others = ((run.scene.to_toml(), run.seed, run.design) for run in (self, other))
        return own == others and self.inputs == other.inputs and equal(self._seen, other._seen)

    def __hash__(self) -> int:
        return hash((self.scene.to_toml(), self.seed))

    @property
    def _seen(self) -> tuple[_Floats, _Floats, _Whole]:
        return self.trajectory, self.velocities, self.steps

    def _repr_html_(self) -> str:
        page = html.escape(_core.player_page(self._files))
        title = html.escape(repr(self))
        return f'<iframe srcdoc="{page}" style="{_STYLE}" onload="{_FIT}" title="{title}"></iframe>'


#: The height fits a page 1000 px wide. If scripts can run, the frame is as high as the page at any width.
_STYLE = "width: 100%; height: 800px; border: 0"
_FIT = (
    "const page = this.contentDocument.body; "
    # A scroll bar would make the page narrower, and so higher.
    "page.parentElement.style.overflowY = 'hidden'; "
    "new ResizeObserver(() => this.style.height = page.scrollHeight + 'px').observe(page)"
)


def _unpacked(files: dict[str, bytes], of: Optional[Path]) -> Run:
    """Makes a run from the files of its folder."""
    keep = _Temporary()
    for name, content in files.items():
        path = keep.path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)
    return Run(keep.path, keep=keep, of=of)


def _columns(history: str) -> dict[str, npt.NDArray[Any]]:
    """The columns of a history of JSON lines: numbers, or strings."""
    # A copy that was cut off may end in the middle of a line.
    whole_lines = history[: history.rfind("\n") + 1].splitlines()
    rows = [dict(_flat(json.loads(line))) for line in whole_lines]
    names = dict.fromkeys(name for row in rows for name in row)
    return {name: _column([row.get(name) for row in rows]) for name in names}


def _flat(value: Any, name: str = "") -> Iterator[tuple[str, Any]]:
    """The numbers and strings inside a JSON value, with their names."""
    if not isinstance(value, (dict, list)):
        # An object may be missing as a whole; then all of its parts are.
        if value is not None or "." not in name:
            yield name, value
        return
    for key, part in value.items() if isinstance(value, dict) else enumerate(value):
        if key not in ("format", "version"):
            yield from _flat(part, f"{name}.{key}".lstrip("."))


def _column(cells: list[Any]) -> npt.NDArray[Any]:
    if any(isinstance(cell, str) for cell in cells):
        return _fixed(["" if cell is None else cell for cell in cells])
    return _fixed([float("nan") if cell is None else float(cell) for cell in cells])


def _fixed(given: Any) -> npt.NDArray[Any]:
    """A read-only array, so that a change of a copy's part does not change the run."""
    made = np.array(given)
    made.flags.writeable = False
    return made


def load(folder: _Path) -> Run:
    """Reads the folder of a finished run."""
    return Run(folder)


def optimize(
    scene: Optional[SceneLike] = None,
    seed: int = 0,
    *,
    loss: Union[Loss, ValueAndGradient, None] = None,
    iterations: Optional[int] = None,
    start: Union[Run, Inputs, _Path, None] = None,
    out: Optional[_Path] = None,
    threads: Optional[int] = None,
    progress: Union[bool, Progress] = True,
) -> Run:
    """Designs a robot: structure, material and controller together.

    ``scene`` is a name from :func:`scenes`, a path, TOML text, or a dictionary of settings that
    change a scene; by default the first scene. The result is bit-identical to that of the program
    ``cosmic optimize`` for the same scene and seed, with any number of threads.

    - ``loss``: a :class:`Loss`, :func:`cosmic.jax.loss` or :func:`cosmic.torch.loss` that replaces
      the scene's objective.
    - ``iterations``: fit the phases of the schedule into this many iterations, so that a short run ends
      with a finished robot. If ``start`` is a finished robot, it is fine-tuned for so many iterations.
    - ``start``: start with the robot of a run, of its folder or of a ``design.json``, or with the design and the
      controller of :class:`Inputs`.
    - ``out``: a new or empty folder for the run, which can be resumed; by default temporary.
    - ``progress``: True for a progress bar, or a function that is called after every iteration with
      its number, the last iteration's number, and a dictionary of results.

    Ctrl-C stops the run and returns the robot of the last iteration, with a warning. ``resume(run.folder)``
    continues it.
    """
    given = as_scene(_core.scenes()[0] if scene is None else scene)
    folder, keep = _folder(out)
    if isinstance(start, Inputs):
        written = _design_file(given, start)
        start = written.path
    elif start is not None:
        start = start.folder if isinstance(start, Run) else as_path("start", start)
    if start is not None:
        start = start / "design.json" if start.is_dir() else start
    check_optimisation(given)
    own = as_loss(loss)
    seed = as_seed(seed)
    last = None if iterations is None else whole("iterations", iterations, 1)
    pool = _threads(threads)
    with _Bar(f"{given.name} seed {seed}", progress) as bar, _iteration(folder):
        interrupted = _core.optimise(
            given, given.name, seed, last, folder, start, own, pool, bar, _warn
        )
    return _result(folder, keep, own, interrupted)


def resume(
    folder: _Path,
    *,
    loss: Union[Loss, ValueAndGradient, None] = None,
    allow_unstable: bool = False,
    threads: Optional[int] = None,
    progress: Union[bool, Progress] = True,
) -> Run:
    """Continues the run in a folder; a finished run is only read. If the run has a loss in Python, pass
    the same ``loss`` again. ``allow_unstable`` sets ``physics.unstable_step`` to ``"warn"`` in the run's
    scene, for a run whose time step has become unstable."""
    own, pool, folder = as_loss(loss), _threads(threads), as_path("folder", folder)
    with _Bar(folder.absolute().name, progress) as bar, _iteration(folder):
        interrupted = _core.resume(folder, own, yes("allow_unstable", allow_unstable), pool, bar, _warn)
    return _result(folder, _TEMPORARY.get(folder.absolute()), own, interrupted)


@contextmanager
def _iteration(folder: Path) -> Iterator[None]:
    """Adds the number of the iteration to an error about the values of a loss."""
    try:
        yield
    except LossError as error:
        history = folder / "history.jsonl"
        done = len(history.read_text(encoding="utf-8").splitlines()) if history.exists() else 0
        raise LossError(f"iteration {done + 1}: {error}") from None


def _threads(threads: Optional[int]) -> Optional[int]:
    # To start more threads takes longer than a run.
    return None if threads is None else whole("threads", threads, 1, 1024)


def _folder(out: Optional[_Path]) -> tuple[Path, Any]:
    """The folder of a run, and the object that keeps a temporary folder."""
    if out is not None:
        return as_path("out", out), None
    keep = _Temporary()
    return keep.path, keep


def _design_file(scene: Scene, robot: Inputs) -> _Temporary:
    """A temporary folder with the ``design.json`` of a robot. Raises :class:`InputError` if the arrays do not fit the scene."""
    sim = Simulator(scene)
    arrays = {name: np.asarray(array, float) for name, array in sim._named(robot).items()}
    for name, array in arrays.items():
        if array.shape != sim.shapes.get(name, array.shape):
            expected, found = list(sim.shapes[name]), list(array.shape)
            raise InputError(f"start: {name}: expected the shape {expected}, found {found}")
    design = {
        "format": "cosmic-design",
        "version": 1,
        "edges": sim.edges.tolist(),
        "z": arrays["z"].tolist(),
        "materials": arrays["z"].argmax(axis=-1).tolist(),
        "controller": {name: arrays[name].tolist() for name in robot.controller},
    }
    folder = _Temporary()
    (folder.path / "design.json").write_text(json.dumps(design), encoding="utf-8")
    return folder


class _Temporary:
    """A temporary folder, which is removed with this object."""

    def __init__(self) -> None:
        self.path = Path(tempfile.mkdtemp(prefix="cosmic-")).absolute()
        _TEMPORARY[self.path] = self
        weakref.finalize(self, shutil.rmtree, self.path, ignore_errors=True)


#: The temporary folders that exist.
_TEMPORARY: weakref.WeakValueDictionary[Path, _Temporary] = weakref.WeakValueDictionary()


def _result(folder: Path, keep: Any, loss: Any, interrupted: bool) -> Run:
    if not interrupted:
        return Run(folder, keep=keep)
    name = "run.folder" if keep else repr(os.fspath(folder))
    go_on = f"; continue with cosmic.resume({name})"
    if not (folder / "history.jsonl").stat().st_size:
        go_on = "" if keep else go_on
        raise KeyboardInterrupt(f"interrupted in the first iteration, so there is no robot yet{go_on}")
    so_far, kept = _folder(None)
    _core.deliver_so_far(folder, so_far, loss)
    run = Run(so_far, keep=(kept, keep), of=folder)
    done = run.summary["iterations"]
    _warn(f"interrupted after iteration {done}: this is the robot of that iteration{go_on}", 4)
    return run


def _warn(text: str, level: int = 3) -> None:
    """Shows a warning at the caller of :func:`optimize`."""
    warnings.warn(text, stacklevel=level)


class _Bar:
    """A progress bar in a terminal or a notebook, or the caller's function."""

    def __init__(self, title: str, progress: Union[bool, Progress]) -> None:
        self.title = title
        self.progress = progress
        self.bar: Any = None
        self.displacement: Optional[float] = None

    def __enter__(self) -> Optional[Progress]:
        if callable(self.progress):
            return self.progress
        if not isinstance(self.progress, bool):
            kind = type(self.progress).__name__
            raise InputError(f"progress: expected True, False or a function, not {kind}")
        return self._show if self.progress else None

    def _show(self, iteration: int, last: int, numbers: dict[str, Any]) -> None:
        if self.bar is None:
            self.bar = _tqdm()(total=last, initial=iteration - 1, desc=self.title, leave=False)
        if numbers["displacement"] is not None:
            self.displacement = numbers["displacement"]
        far = "" if self.displacement is None else f", {self.displacement:.3f} m"
        self.bar.set_postfix_str(numbers["phase"].replace("_", " ") + far, refresh=False)
        self.bar.update(iteration - self.bar.n)

    def __exit__(self, *_: object) -> None:
        if self.bar is not None:
            self.bar.close()


def _tqdm() -> Any:
    with warnings.catch_warnings():
        # Without ipywidgets a notebook shows a text bar, which is good enough.
        warnings.simplefilter("ignore")
        from tqdm.auto import tqdm
    return tqdm
