"""Drawings and solids of a robot for a workshop, from the tables that ``cosmic export RUN`` writes.

``python -m cosmic.workshop runs/earth-0/export`` writes into the same folder

- ``parts.dxf``: every bar as a strip of plate with a hole at each end, one beside another; and the robot, to scale;
- ``robot.stl``, ``skeleton.stl`` and ``actuators.stl``: every bar as a closed solid; no two of them overlap. The bars of a
  robot in space have their places, so they overlap at its nodes;
- ``solid.csv``: the volume, the density and the mass of every solid.

Drawings and solids are in millimetres, tables in SI units. The module needs the packages ezdxf and trimesh:
``pip install 'cosmic-codesign[workshop]'``.
"""

from __future__ import annotations

import argparse
import csv
import math
import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Optional, Union

import numpy as np
import numpy.typing as npt

from ._errors import extra

_Path = Union[str, "os.PathLike[str]"]
_Floats = npt.NDArray[np.float64]
#: Millimetres in a metre.
_MM = 1e3
#: The number of sides of a solid's section. Its area is that of the circle or the ring.
_SIDES = 48


@dataclass(frozen=True)
class Bar:
    """A row of ``bars.csv``. Lengths in m, mass in kg."""

    edge: int
    nodes: tuple[int, int]
    ends: _Floats
    """Shape ``(2, 2)``, in space ``(2, 3)``: the positions of the two nodes."""
    length: float
    material: str
    part: str
    """``tube``, ``rod``, ``strut``, ``device``, or empty for a bar of plain numbers."""
    outer: Optional[float]
    inner: Optional[float]
    mass: float


def read_bars(folder: _Path) -> list[Bar]:
    """Reads ``bars.csv`` of an export."""
    with open(Path(folder) / "bars.csv", newline="") as file:
        return [_bar(row) for row in csv.DictReader(file)]


def _bar(row: dict[str, str]) -> Bar:
    axes = [axis for axis in "xyz" if f"from_{axis}" in row]
    ends = [[float(row[f"{end}_{axis}"]) for axis in axes] for end in ("from", "to")]
    outer, inner = (float(row[name]) if row[name] else None for name in ("outer", "inner"))
    return Bar(
        edge=int(row["edge"]),
        nodes=(int(row["from"]), int(row["to"])),
        ends=np.array(ends),
        length=float(row["rest_length"]),
        material=row["material"],
        part=row["part"],
        outer=outer,
        inner=inner,
        mass=float(row["mass"]),
    )


def write_dxf(folder: _Path, *, width: float = 12.0, hole: float = 4.0, gap: float = 3.0) -> Path:
    """Writes ``parts.dxf`` into the folder of an export, and returns its path.

    A strip is ``width`` mm wide and has two holes of ``hole`` mm; their distance is the rest length of the bar. Strips
    are ``gap`` mm apart, the longest one at the bottom. The layers ``SKELETON`` and ``ACTUATOR`` have the strips,
    ``ROBOT`` has the robot as lines between its nodes, and ``LABELS`` has the numbers: ``from [edge] to``.
    """
    with extra("workshop"):
        from ezdxf import filemanagement
    bars = read_bars(folder)
    if not 0 < hole < width:
        raise ValueError(f"hole is {hole} mm; it must be above 0 and below the width, {width} mm")
    drawing = filemanagement.new("R2010", units=4)
    for name, colour in (("SKELETON", 7), ("ACTUATOR", 5), ("ROBOT", 8), ("LABELS", 3)):
        drawing.layers.add(name, color=colour)
    space = drawing.modelspace()
    longest_first = sorted(bars, key=lambda bar: -bar.length)
    for row, bar in enumerate(longest_first):
        _strip(space, bar, row * (width + gap), width, hole)
    low = np.min([bar.ends for bar in bars], axis=(0, 1))
    above = np.zeros(len(low))
    above[1] = (len(bars) + 1) * (width + gap)
    for bar in bars:
        ends = (bar.ends - low) * _MM + above
        start, end = ends.tolist()
        space.add_line(start, end, dxfattribs={"layer": "ROBOT"})
        _label(space, f"[{bar.edge}]", ends.mean(axis=0), 0.3 * width)
    for node, place in {n: p for bar in bars for n, p in zip(bar.nodes, bar.ends)}.items():
        at = (place - low) * _MM + above
        space.add_circle(at.tolist(), 0.5 * hole, dxfattribs={"layer": "ROBOT"})
        _label(space, str(node), at, 0.3 * width)
    path = Path(folder) / "parts.dxf"
    drawing.saveas(path)
    return path


def _strip(space: Any, bar: Bar, height: float, width: float, hole: float) -> None:
    """Draws a strip with round ends. DXF writes a half circle as a segment with a bulge of 1."""
    length, half = _MM * bar.length, 0.5 * width
    on = {"layer": bar.material.upper()}
    corners = [
        (0.0, height - half, 0.0),
        (length, height - half, 1.0),
        (length, height + half, 0.0),
        (0.0, height + half, 1.0),
    ]
    space.add_lwpolyline(corners, format="xyb", close=True, dxfattribs=on)
    for x in (0.0, length):
        space.add_circle((x, height), 0.5 * hole, dxfattribs=on)
    text = f"{bar.nodes[0]} [{bar.edge}] {bar.nodes[1]}"
    _label(space, text, (0.5 * length, height), 0.3 * width)


def _label(space: Any, text: str, at: Sequence[float], height: float) -> None:
    from ezdxf.enums import TextEntityAlignment

    label = space.add_text(text, height=height, dxfattribs={"layer": "LABELS"})
    label.set_placement(tuple(map(float, at)), align=TextEntityAlignment.MIDDLE_CENTER)


def write_stl(folder: _Path, *, density: float = 1000.0, gap: float = 1.0) -> list[Path]:
    """Writes ``robot.stl``, ``skeleton.stl``, ``actuators.stl`` and ``solid.csv`` into the folder of an export, and
    returns their paths. A file of a material that the robot lacks is not written.

    Tubes, rods and struts have the section that ``bars.csv`` says. Other bars are round, as thick as their mass needs
    with ``density`` (kg/m3). Every bar reaches from node to node; bars of a planar robot that would overlap are in different
    planes, ``gap`` mm apart. The density in ``solid.csv`` is the mass in ``bars.csv`` divided by the volume of the solid, so
    the robot weighs what ``bars.csv`` says. The density of a part is higher than that of its material if
    ``parts.end_mass`` adds fittings.
    """
    with extra("workshop"):
        import trimesh
    if not density > 0:
        raise ValueError(f"density is {density} kg/m3; it must be above 0")
    bars = read_bars(folder)
    sections = [_section(bar, density) for bar in bars]
    sizes = [2 * reach for reach, *_ in sections]
    # In space, bars have their places.
    is_planar = bars[0].ends.shape == (2, 2)
    planes = _planes(bars, sizes, gap) if is_planar else [0] * len(bars)
    pitch = max(sizes) + gap
    solids = [
        _solid(trimesh, bar, section, plane * pitch)
        for bar, section, plane in zip(bars, sections, planes)
    ]
    kinds: list[tuple[str, Callable[[Bar], bool]]] = [
        ("robot.stl", lambda _: True),
        ("skeleton.stl", lambda bar: bar.material == "skeleton"),
        ("actuators.stl", lambda bar: bar.material == "actuator"),
    ]
    written = []
    for name, is_kind in kinds:
        own = [solid for bar, solid in zip(bars, solids) if is_kind(bar)]
        if own:
            written.append(Path(folder) / name)
            trimesh.util.concatenate(own).export(written[-1])
    written.append(Path(folder) / "solid.csv")
    with open(written[-1], "w", newline="") as file:
        rows = csv.writer(file, lineterminator="\n")
        rows.writerow(["edge", "material", "plane", "volume", "density", "mass"])
        for bar, solid, plane in zip(bars, solids, planes):
            volume = solid.volume / _MM**3
            numbers = [f"{volume:.15f}", f"{bar.mass / volume:.6f}", f"{bar.mass:.9f}"]
            rows.writerow([bar.edge, bar.material, plane, *numbers])
    return written


#: A section: the distance of its corners from its middle, and the outlines of the bar and of its hole, mm.
_Section = tuple[float, _Floats, Optional[_Floats]]


def _section(bar: Bar, density: float) -> _Section:
    if bar.part == "strut" and bar.outer is not None:
        half = 0.5 * _MM * bar.outer
        square = half * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]], dtype=np.float64)
        return math.sqrt(2) * half, square, None
    if bar.outer is not None:
        radius = 0.5 * _MM * bar.outer
    elif bar.mass > 0:
        radius = _MM * math.sqrt(bar.mass / (math.pi * density * bar.length))
    else:
        raise ValueError(f"edge {bar.edge} has no mass, so its solid has no section")
    inner = None if not bar.inner else _polygon(0.5 * _MM * bar.inner)
    outline = _polygon(radius)
    return float(np.linalg.norm(outline[0])), outline, inner


def _polygon(radius: float) -> _Floats:
    """A regular polygon with the area of the circle of this radius."""
    turn = 2 * math.pi / _SIDES
    angles = turn * np.arange(_SIDES)
    corner = radius * math.sqrt(turn / math.sin(turn))
    return corner * np.stack([np.cos(angles), np.sin(angles)], axis=1)


def _planes(bars: list[Bar], sizes: list[float], gap: float) -> list[int]:
    """Gives each bar the lowest plane in which its distance to all other bars of the plane is at least the gap."""
    planes: list[int] = []
    for k, bar in enumerate(bars):
        near = [
            planes[other]
            for other in range(k)
            if _MM * _distance(bar.ends, bars[other].ends) < 0.5 * (sizes[k] + sizes[other]) + gap
        ]
        planes.append(next(plane for plane in range(k + 1) if plane not in near))
    return planes


def _distance(a: _Floats, b: _Floats) -> float:
    """The smallest distance between the points of two segments; 0 if they cross."""

    def side(line: _Floats, point: _Floats) -> float:
        (dx, dy), (x, y) = line[1] - line[0], point - line[0]
        return float(dx * y - dy * x)

    def to(line: _Floats, point: _Floats) -> float:
        way = line[1] - line[0]
        share = float(np.clip((point - line[0]) @ way / (way @ way), 0, 1))
        return float(np.linalg.norm(line[0] + share * way - point))

    if side(a, b[0]) * side(a, b[1]) < 0 and side(b, a[0]) * side(b, a[1]) < 0:
        return 0.0
    return min(to(a, b[0]), to(a, b[1]), to(b, a[0]), to(b, a[1]))


def _solid(trimesh: Any, bar: Bar, section: _Section, height: float) -> Any:
    """A bar as a closed solid. A bar of a planar robot is in the plane at ``height`` mm."""
    _, outline, hole = section
    ends = [np.append(end * _MM, [height] * (3 - len(end))) for end in bar.ends]
    along = (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0])
    # The columns are the directions of the section's two axes and of the bar: a right-handed frame.
    second = np.array([0.0, 0.0, 1.0]) if abs(along[2]) < 0.9 else np.array([0.0, 1.0, 0.0])
    second = second - (second @ along) * along
    second = second / np.linalg.norm(second)
    if bar.ends.shape == (2, 3):
        # Readers of STL join equal corners. Each bar is turned by another angle, so that no two bars have a corner in common.
        second = math.cos(bar.edge) * second + math.sin(bar.edge) * np.cross(along, second)
    frame = np.stack([np.cross(second, along), second, along], axis=1)
    rings = [outline] if hole is None else [outline, hole]
    # The corners at both ends: first the outline, then the hole.
    corners = [end + np.pad(ring, ((0, 0), (0, 1))) @ frame.T for ring in rings for end in ends]
    count = len(outline)
    k = np.arange(count)
    after = (k + 1) % count
    faces = [_wall(0, count, k, after)]
    if hole is None:
        fan = np.stack([np.zeros(count - 2, dtype=np.int64), k[1:-1], k[2:]], axis=1)
        faces += [fan[:, ::-1], fan + count]
    else:
        faces.append(_wall(2 * count, 3 * count, k, after)[:, ::-1])
        # The ends are rings between the outline and the hole.
        faces.append(_wall(2 * count, 0, k, after))
        faces.append(_wall(count, 3 * count, k, after))
    return trimesh.Trimesh(np.concatenate(corners), np.concatenate(faces), process=False)


def _wall(low: int, high: int, k: npt.NDArray[Any], after: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Two triangles for each side of a band between two rings of corners."""
    first = np.stack([low + k, low + after, high + after], axis=1)
    second = np.stack([low + k, high + after, high + k], axis=1)
    return np.concatenate([first, second])


def main(arguments: Optional[Sequence[str]] = None) -> None:
    """Writes all files of this module into the folder of an export, and prints their paths."""
    parser = argparse.ArgumentParser(prog="python -m cosmic.workshop", description=main.__doc__)
    parser.add_argument("export", type=Path, help="the folder that `cosmic export RUN` wrote")
    parser.add_argument("--width", type=float, default=12.0, help="width of the strips, mm")
    parser.add_argument("--hole", type=float, default=4.0, help="diameter of their holes, mm")
    parser.add_argument("--density", type=float, default=1000.0, help="of bars without a section, kg/m3")
    parser.add_argument("--gap", type=float, default=1.0, help="distance between solids, mm")
    asked = parser.parse_args(arguments)
    print(write_dxf(asked.export, width=asked.width, hole=asked.hole))
    print(*write_stl(asked.export, density=asked.density, gap=asked.gap), sep="\n")


if __name__ == "__main__":
    main()
