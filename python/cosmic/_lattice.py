"""Lattices from arrays."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from typing import Any, Optional, Union

import numpy as np
import numpy.typing as npt

from . import _core
from ._core import Scene
from ._checks import path as as_path
from ._errors import FileError, InputError

_Whole = npt.NDArray[np.int64]


class Lattice:
    """Any nodes and edges, in the plane or in space, for the key ``"lattice"`` of a scene that is a dictionary.

    ``nodes`` has positions in m: along the ground and above it, shape ``(nodes, 2)``, or along, across and above,
    shape ``(nodes, 3)``, for a robot in space. ``edges`` has the two nodes of every edge, shape ``(edges, 2)``. The other arguments are the keys of a truss file:

    - ``payload``: the nodes with extra mass: one node, several, or a dictionary from nodes to masses in kg.
      The displacement of the first one counts.
    - ``keep``, ``skeleton``, ``actuator``, ``forbid``: edges that are always solid, always of this material,
      or always void; ``tie``: lists of edges that share a design vector.
    - ``rest``, ``stiffness``: for every edge its rest length in m, and the stiffness of its bar in N/m.

    The library renumbers nodes: the payload is its node 0. Arrays of nodes are in its order, so
    ``x[..., lattice.node_of, :]`` is in yours, and ``yours[lattice.given_node]`` is in the library's.
    Edges keep their numbers.

    >>> lattice = cosmic.Lattice([[0, 0], [0.1, 0], [0.05, 0.08]], [[0, 1], [1, 2], [2, 0]], payload=2)
    >>> sim = cosmic.Simulator({"scene": "stability", "lattice": lattice})
    >>> lattice.node_of
    array([2, 1, 0])
    """

    nodes: npt.NDArray[np.float64]
    """The positions of your nodes, shape ``(nodes, 2)``, or ``(nodes, 3)`` in space."""
    edges: _Whole
    """The two nodes of each edge in your numbers, shape ``(edges, 2)``."""
    node_of: _Whole
    """For each of your nodes, its number in the library."""
    given_node: _Whole
    """For each node of the library, your number."""
    truss: str
    """The lattice as the text of a truss file, in the library's numbers."""

    def __init__(
        self,
        nodes: npt.ArrayLike,
        edges: npt.ArrayLike,
        *,
        payload: Union[int, Sequence[int], Mapping[int, float]] = 0,
        keep: Sequence[int] = (),
        skeleton: Sequence[int] = (),
        actuator: Sequence[int] = (),
        forbid: Sequence[int] = (),
        tie: Sequence[Sequence[int]] = (),
        rest: Optional[npt.ArrayLike] = None,
        stiffness: Optional[npt.ArrayLike] = None,
    ) -> None:
        truss: dict[str, Any] = {
            "format": "cosmic-truss",
            "version": 1,
            "nodes": _floats("nodes", nodes, 2),
            "edges": _pairs("edges", edges),
            "payload": _payload(payload),
            "tie": [_whole(f"tie[{k}]", group) for k, group in enumerate(_listed("tie", tie))],
        }
        rules = {"keep": keep, "skeleton": skeleton, "actuator": actuator, "forbid": forbid}
        truss.update({name: _whole(name, rule) for name, rule in rules.items()})
        for name, own in (("rest", rest), ("stiffness", stiffness)):
            truss[name] = [] if own is None else _floats(name, own, 1)
        try:
            self._read(_core.truss(json.dumps(truss)))
        except InputError as error:
            raise InputError(f"Lattice: {error}") from None

    @classmethod
    def of(cls, scene: Scene) -> Lattice:
        """The lattice of a scene, if it came from arrays or from a truss file."""
        if not isinstance(scene, Scene):
            raise InputError(f"Lattice.of: expected a scene, found {type(scene).__name__}; cosmic.as_scene makes one")
        if scene.truss is None:
            raise InputError(
                "Lattice.of: the lattice of this scene is generated from columns and rows, and no node was renumbered"
            )
        made = cls.__new__(cls)
        made._read(scene.truss)
        return made

    def save(self, path: Union[str, os.PathLike[str]]) -> None:
        """Writes a truss file, which a scene can name as its ``lattice.file``."""
        try:
            as_path("path", path).write_text(self.truss, encoding="utf-8")
        except OSError as error:
            raise FileError(f"Lattice.save: cannot write {path}: {error.strerror}") from None

    def _read(self, truss: str) -> None:
        """Takes the arrays from the text of a truss file."""
        read = json.loads(truss)
        positions = np.array(read["nodes"], np.float64)
        numbers = np.arange(len(positions))
        self.given_node = np.array(read.get("given_numbers") or numbers)
        self.node_of = np.argsort(self.given_node)
        self.nodes = positions[self.node_of]
        self.nodes.flags.writeable = False
        self.edges = self.given_node[np.array(read["edges"])]
        self.truss = truss

    def __eq__(self, other: object) -> bool:
        return self.truss == other.truss if isinstance(other, Lattice) else NotImplemented

    def __hash__(self) -> int:
        return hash(self.truss)

    def __repr__(self) -> str:
        return f"<Lattice: {len(self.nodes)} nodes, {len(self.edges)} edges>"


def _array(name: str, given: Any, kinds: str, noun: str) -> Any:
    """Converts an argument to an array of numbers."""
    try:
        made = np.asarray(given)
    except ValueError:
        made = np.array(None)
    if made.size == 0:
        made = made.astype(np.int64)
    if made.dtype.kind not in kinds:
        raise InputError(f"{name}: expected an array of {noun}, found {_short(given)}")
    return made


def _short(given: Any) -> str:
    """The first characters of an argument on one line."""
    text = " ".join(repr(given).split())
    return text if len(text) <= 60 else text[:60] + "..."


def _floats(name: str, given: Any, axes: int) -> Any:
    made = _array(name, given, "fiu", "numbers")
    if made.ndim != axes:
        shape = f"({name}, 2)" if axes == 2 else "(edges,)"
        raise InputError(f"{name}: expected the shape {shape}, found {list(made.shape)}")
    lost = np.argwhere(~np.isfinite(made))
    if lost.size:
        place = lost[0].tolist()
        raise InputError(f"{name}{place} is {made[tuple(place)]}: expected finite numbers")
    return made.astype(np.float64).tolist()


def _whole(name: str, given: Any) -> Any:
    made = _array(name, given, "iu", "whole numbers")
    if made.ndim != 1 or (made < 0).any():
        raise InputError(f"{name}: expected a list of whole numbers, 0 or more, found {_short(given)}")
    return made.tolist()


def _listed(name: str, given: Any) -> Sequence[Any]:
    if not isinstance(given, (list, tuple)):
        raise InputError(f"{name}: expected a list of lists of edges, found {_short(given)}")
    return given


def _pairs(name: str, given: Any) -> Any:
    made = _array(name, given, "iu", "whole numbers")
    if made.ndim != 2 or made.shape[1] != 2:
        raise InputError(f"{name}: expected the shape ({name}, 2), found {list(made.shape)}")
    lost = np.argwhere((made < 0).any(1))
    if lost.size:
        edge = int(lost[0, 0])
        raise InputError(f"{name}[{edge}] is {made[edge].tolist()}: expected nodes, 0 or more")
    return made.tolist()


def _payload(payload: Any) -> Any:
    if isinstance(payload, Mapping):
        nodes, masses = _whole("payload", [*payload]), _floats("payload", [*payload.values()], 1)
        return [{"node": node, "mass": mass} for node, mass in zip(nodes, masses)]
    given = [payload] if isinstance(payload, (int, np.integer)) else payload
    return [{"node": node} for node in _whole("payload", given)]
