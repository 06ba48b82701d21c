"""Tests of ``cosmic.workshop``: drawings and solids of the tables of ``cosmic export``, read back."""

from __future__ import annotations

import csv
import math
import subprocess
import sys
from pathlib import Path
from typing import Any

import cosmic
import numpy as np
import pytest
from common import PROGRAM
from cosmic import workshop

HEAD = "edge,from,to,from_x,from_y,to_x,to_y,rest_length,material,part,outer,inner,mass\n"
#: A square of tubes with both diagonals, which are a device and a bar of plain numbers; and a strut above it. Fittings of
#: 1 g at each end make the short tubes denser than the long ones.
ENDS = {0: (0.0, 0.0), 1: (0.3, 0.0), 2: (0.0, 0.1), 3: (0.3, 0.1), 4: (0.0, 0.3)}
BARS = [
    (0, 0, 1, "skeleton", "tube", 0.006, 0.004),
    (1, 2, 3, "skeleton", "tube", 0.006, 0.004),
    (2, 0, 2, "skeleton", "rod", 0.006, None),
    (3, 1, 3, "skeleton", "tube", 0.006, 0.004),
    (4, 0, 3, "actuator", "device", None, None),
    (5, 1, 2, "skeleton", "", None, None),
    (9, 2, 4, "skeleton", "strut", 0.005, None),
]


def area(part: str, outer: float | None, inner: float | None) -> float:
    if outer is None:
        return 1e-5
    square = outer**2 if part == "strut" else math.pi / 4 * outer**2
    return square - math.pi / 4 * (inner or 0.0) ** 2


@pytest.fixture
def made(tmp_path: Path) -> Path:
    """A folder with a table of bars."""
    rows = []
    for edge, i, j, material, part, outer, inner in BARS:
        length = math.dist(ENDS[i], ENDS[j])
        mass = 1500 * area(part, outer, inner) * length + 0.002
        places = [*ENDS[i], *ENDS[j], length]
        numbers = ",".join(f"{x:.9f}" for x in places)
        sizes = ",".join("" if size is None else str(size) for size in (outer, inner))
        rows.append(f"{edge},{i},{j},{numbers},{material},{part},{sizes},{mass:.9f}\n")
    (tmp_path / "bars.csv").write_text(HEAD + "".join(rows))
    return tmp_path


def table(path: Path) -> list[dict[str, str]]:
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def check_solids(folder: Path, **options: float) -> None:
    """Every bar is a closed solid of its length that weighs what ``bars.csv`` says, and no two overlap."""
    trimesh = pytest.importorskip("trimesh")
    workshop.write_stl(folder, **options)
    bars = {row["edge"]: row for row in table(folder / "bars.csv")}
    listed = {row["edge"]: row for row in table(folder / "solid.csv")}
    assert listed.keys() == bars.keys()
    robot = trimesh.load(folder / "robot.stl")
    assert robot.is_watertight and robot.is_winding_consistent
    solids = list(robot.split(only_watertight=True))
    assert len(solids) == len(bars)
    # Corners are in single precision. The order of the bodies after a split is arbitrary, so volumes are sorted.
    found = sorted(solid.volume / 1e9 for solid in solids)
    wanted = sorted(float(row["volume"]) for row in listed.values())
    assert found == pytest.approx(wanted, rel=2e-5)
    for edge, row in listed.items():
        weight = float(row["volume"]) * float(row["density"])
        assert weight == pytest.approx(float(bars[edge]["mass"]), rel=1e-6)
    total = sum(float(row["mass"]) for row in listed.values())
    assert total == pytest.approx(sum(float(row["mass"]) for row in bars.values()), rel=1e-12)
    if "from_z" in next(iter(bars.values())):
        return
    # Bodies of one plane do not overlap, because their boxes across the plane do and their volumes add up.
    united = trimesh.boolean.union(solids, engine="manifold")
    assert united.volume == pytest.approx(robot.volume, rel=2e-5)


def test_tubes_are_tubes_and_weigh_what_the_table_says(made: Path) -> None:
    check_solids(made, density=1100.0)
    listed = {int(row["edge"]): row for row in table(made / "solid.csv")}
    for edge, i, j, _, part, outer, inner in BARS:
        length = math.dist(ENDS[i], ENDS[j])
        if outer is None:
            assert float(listed[edge]["density"]) == pytest.approx(1100, rel=1e-6)
        else:
            expected = area(part, outer, inner) * length
            assert float(listed[edge]["volume"]) == pytest.approx(expected, rel=1e-6)
    # The diagonals cross, and bars of one node overlap, so they are in different planes.
    planes = {edge: row["plane"] for edge, row in listed.items()}
    assert planes[4] != planes[5] and planes[0] != planes[2] and planes[0] == planes[1]
    trimesh = pytest.importorskip("trimesh")
    parts = [trimesh.load(made / name).volume for name in ("skeleton.stl", "actuators.stl")]
    assert sum(parts) == pytest.approx(trimesh.load(made / "robot.stl").volume, rel=1e-9)


def check_drawing(folder: Path, width: float, hole: float) -> None:
    """Every bar is a strip with two holes whose distance is its rest length, and strips do not overlap."""
    ezdxf = pytest.importorskip("ezdxf")
    drawing = ezdxf.readfile(workshop.write_dxf(folder, width=width, hole=hole))
    assert not drawing.audit().has_errors and drawing.units == 4
    space = drawing.modelspace()
    bars = {int(row["edge"]): row for row in table(folder / "bars.csv")}
    labels = {text.dxf.text: text.dxf.align_point for text in space.query("TEXT")}
    circles = [circle for circle in space.query("CIRCLE") if circle.dxf.layer != "ROBOT"]
    strips: Any = space.query("LWPOLYLINE")
    assert len(strips) == len(bars) and len(circles) == 2 * len(bars)
    heights = []
    for strip in strips:
        corners = strip.get_points("xyb")
        assert [bulge for _, _, bulge in corners] == [0, 1, 0, 1] and strip.closed
        middle = sum(y for _, y, _ in corners) / 4
        own = [c for c in circles if abs(c.dxf.center.y - middle) < 1e-9]
        (a, b) = (circle.dxf.center.x for circle in own)
        edge = next(e for e, row in bars.items() if abs(labels[named(row)].y - middle) < 1e-9)
        assert abs(b - a) == pytest.approx(1e3 * float(bars[edge]["rest_length"]), abs=1e-6)
        assert {circle.dxf.radius for circle in own} == {0.5 * hole}
        assert strip.dxf.layer == bars[edge]["material"].upper()
        heights.append(middle)
    heights.sort()
    assert min(b - a for a, b in zip(heights, heights[1:])) > width
    lines = [math.dist(line.dxf.start.xyz, line.dxf.end.xyz) for line in space.query("LINE")]
    lengths = [1e3 * float(row["rest_length"]) for row in bars.values()]
    assert sorted(lines) == pytest.approx(sorted(lengths), abs=2e-6)


def named(row: dict[str, str]) -> str:
    return f"{row['from']} [{row['edge']}] {row['to']}"


def test_a_drawing_has_a_strip_for_each_bar(made: Path) -> None:
    check_drawing(made, 20.0, 5.0)
    with pytest.raises(ValueError, match="hole is 20 mm; it must be above 0 and below the width"):
        workshop.write_dxf(made, width=20, hole=20)


def test_files_are_made_of_an_exported_robot(run: cosmic.Run, tmp_path: Path) -> None:
    command = [*PROGRAM, "export", run.folder, "--csv", "--out", tmp_path / "made"]
    subprocess.run(command, check=True)
    check_drawing(tmp_path / "made", 12.0, 4.0)
    check_solids(tmp_path / "made")


def test_robots_in_space_have_solids_at_their_places(tmp_path: Path) -> None:
    # A tetrahedron with a vertical edge, and a bar upside down.
    ends = {0: (0.0, 0.0, 0.0), 1: (0.3, 0.0, 0.0), 2: (0.0, 0.2, 0.0), 3: (0.0, 0.0, 0.25)}
    pairs = [(0, 1), (0, 2), (3, 0), (1, 2), (1, 3), (3, 2)]
    head, rows = HEAD.replace("from_y", "from_y,from_z").replace("to_y", "to_y,to_z"), []
    for edge, (i, j) in enumerate(pairs):
        numbers = ",".join(f"{x:.9f}" for x in (*ends[i], *ends[j], math.dist(ends[i], ends[j])))
        rows.append(f"{edge},{i},{j},{numbers},{'actuator' if edge == 2 else 'skeleton'},tube,0.006,0.004,0.01\n")
    (tmp_path / "bars.csv").write_text(head + "".join(rows))
    check_solids(tmp_path)
    check_drawing(tmp_path, 12.0, 4.0)
    trimesh = pytest.importorskip("trimesh")
    for solid in trimesh.load(tmp_path / "robot.stl").split(only_watertight=True):
        middles = [1e3 * (np.array(ends[i]) + ends[j]) / 2 for i, j in pairs]
        assert min(np.linalg.norm(solid.bounds.mean(axis=0) - middle) for middle in middles) < 1e-3


def test_a_missing_package_is_named(made: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for package, make in (("ezdxf", workshop.write_dxf), ("trimesh", workshop.write_stl)):
        monkeypatch.setitem(sys.modules, package, None)
        with pytest.raises(ImportError, match=rf"{package}.*pip install 'cosmic-codesign\[workshop\]'"):
            make(made)
