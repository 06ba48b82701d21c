"""Reads the files of `cosmic export` with other programs and compares them with the run.

Usage: read_back.py EXPORT EXPECTED.json. Fails at the first difference.
"""

import csv
import json
import math
import re
import sys
import xml.etree.ElementTree as xml
from pathlib import Path

import ezdxf
import ezdxf.path
import numpy
import trimesh
from shapely.geometry import Point, Polygon

folder, expected = Path(sys.argv[1]), json.loads(Path(sys.argv[2]).read_text())
sizes = expected["sizes"]


def table(name):
    with open(folder / name, newline="") as file:
        return list(csv.DictReader(file))


def close(found, wanted, tolerance, what):
    assert abs(found - wanted) <= tolerance, f"{what}: {found}, not {wanted} within {tolerance}"


# --- The tables. Their last digit is a nanometre, so a number has an error of at most half a nanometre. A distance of
# two points, each with this error along both axes, has an error of at most 1.5 nanometres.
bars = {int(row["edge"]): row for row in table("bars.csv")}
assert sorted(bars) == sorted(int(edge) for edge in expected["bars"]), "not the solid edges"
for edge, row in bars.items():
    wanted = expected["bars"][str(edge)]
    what = f"edge {edge}"
    assert [int(row["from"]), int(row["to"])] == wanted["nodes"], what
    assert row["material"] == wanted["material"], what
    ends = [float(row[key]) for key in ("from_x", "from_y", "to_x", "to_y")]
    close(float(row["rest_length"]), wanted["rest_length"], 6e-10, what)
    close(math.hypot(ends[2] - ends[0], ends[3] - ends[1]), wanted["rest_length"], 1.5e-9, what)
    strain = expected["max_strain"] if wanted["material"] == "actuator" else 0
    close(float(row["stroke"]), strain * wanted["rest_length"], 6e-10, what)

# --- Peak forces over the states of all steps, from the equations of the controller and of a spring.
robot, run = expected["robot"], json.loads(Path(expected["trajectory"]).read_text())
# Nodes without a bar do not belong to the robot.
ends = [node for bar in expected["bars"].values() for node in bar["nodes"]]
presence = numpy.isin(numpy.arange(expected["nodes"]), ends)[:, None]
tension = []
# The last state begins no step.
for step, state in list(zip(run["steps"], run["states"]))[:-1]:
    x, v = numpy.array(state["x"]), numpy.array(state["v"])
    middle = (presence * x).sum(axis=0) / presence.sum()
    phases = 2 * math.pi * numpy.arange(robot["clocks"]) / robot["clocks"]
    seen = numpy.concatenate(
        [
            numpy.sin(robot["omega"] * step * run["dt"] + phases),
            numpy.array(robot["goal"]) * robot["goal_scale"],
            (presence * (x - middle)).ravel() * robot["offset_scale"],
            (presence * v).ravel() * robot["velocity_scale"],
        ]
    )
    hidden = numpy.tanh(numpy.array(robot["w1"]).reshape(-1, len(seen)) @ seen + robot["b1"])
    active = numpy.tanh(numpy.array(robot["w2"]).reshape(-1, len(hidden)) @ hidden + robot["b2"])
    i, j = numpy.array(robot["edges"]).T
    target = numpy.array(robot["rest_length"]) * (1 + numpy.array(robot["strain"]) * active)
    change = numpy.linalg.norm(x[j] - x[i], axis=1) - target
    tension.append(numpy.array(robot["stiffness"]) * change)
most, least = numpy.max(tension, axis=0), numpy.min(tension, axis=0)
for edge, row in bars.items():
    # A length of 0.1 m is softened by 5e-12 m and summed in another order; 400 N/m multiply the difference.
    close(float(row["peak_tension"]), max(0, most[edge]), 1e-8, f"tension of {edge}")
    close(float(row["peak_compression"]), max(0, -least[edge]), 1e-8, f"compression of {edge}")
assert max(float(row["peak_force"]) for row in bars.values()) > 0.01, "no bar has a load"

# --- The DXF drawing. Its last digit is a nanometre: 1e-6 mm.
drawing = ezdxf.readfile(folder / "pattern.dxf")
assert not drawing.audit().has_errors, drawing.audit().errors
space = drawing.modelspace()
known = {layer.dxf.name for layer in drawing.layers}
labels = {}
for text in space.query("TEXT"):
    assert text.dxf.layer == "LABELS"
    match = re.fullmatch(r"(\d+) \[(\d+)\] (\d+)", text.dxf.text)
    if match:
        i, edge, j = (int(number) for number in match.groups())
        assert [i, j] == expected["bars"][str(edge)]["nodes"], text.dxf.text
        labels[edge] = Point(text.dxf.align_point.x, text.dxf.align_point.y)
holes = [(circle.dxf.layer, circle.dxf.center, circle.dxf.radius) for circle in space.query("CIRCLE")]
half = 0.5 * sizes["width"]
# Outlines are measured as polygons. ezdxf draws an arc by cubic curves, which leave the circle by 2.7e-4
# of the radius, and they are flattened to 1e-4 mm.
off = 3e-4 * half + 1e-4
found, outlines, of_dxf = set(), {}, set()
for line in space.query("POLYLINE"):
    assert line.dxf.layer in known and line.is_closed, line.dxf.layer
    outline = Polygon([(p.x, p.y) for p in ezdxf.path.make_path(line).flattening(1e-4)])
    own = [hole for hole in holes if hole[0] == line.dxf.layer and outline.contains(Point(hole[1].x, hole[1].y))]
    assert len(own) == 2, f"{len(own)} holes in a bar on {line.dxf.layer}"
    inside = [edge for edge, middle in labels.items() if outline.contains(middle)]
    assert len(inside) == 1, inside
    edge, (a, b) = inside[0], (own[0][1], own[1][1])
    found.add(edge)
    # In metres; both ends of the hole's distance are rounded to 1e-9 m.
    close(a.distance(b) / 1e3, expected["bars"][str(edge)]["rest_length"], 1e-6, f"holes of {edge}")
    for _, _, radius in own:
        close(2 * radius, sizes["hole"], 1e-6, "a hole")
    corners = [(vertex.dxf.location, vertex.dxf.get("bulge", 0)) for vertex in line.vertices]
    assert [bulge for _, bulge in corners] == [0, 1, 0, 1], "not two half circles"
    for corner, _ in corners:
        close(min(corner.distance(a), corner.distance(b)), half, 2e-6, f"corner of {edge}")
    area = sizes["width"] * a.distance(b) + math.pi * half**2
    close(outline.area, area, 2 * math.pi * half * off, f"outline of {edge}")
    wanted = f"L{bars[edge]['layer']}_{bars[edge]['material'].upper()}"
    assert line.dxf.layer == wanted, f"edge {edge} on {line.dxf.layer}, not {wanted}"
    outlines.setdefault(bars[edge]["layer"], []).append(outline)
    of_dxf |= {(round(p.x, 3), round(p.y, 3)) for p in (a, b)}
assert found == set(bars) and len(holes) == 2 * len(bars), "not a part for each bar"

# No overlap within a layer: parts are at least the gap apart.
nearest = math.inf
for parts in outlines.values():
    for k, part in enumerate(parts):
        nearest = min([nearest] + [part.distance(other) for other in parts[k + 1 :]])
assert nearest >= sizes["gap"] - 2 * off, f"bars of a layer come as near as {nearest} mm"
# Nor between the layers on the sheet.
everything = [part for parts in outlines.values() for part in parts]
assert all(not a.intersects(b) for k, a in enumerate(everything) for b in everything[k + 1 :])

# --- The SVG drawing: its units are millimetres, and every hole is where the DXF has it.
tag = "{http://www.w3.org/2000/svg}"
page = xml.parse(folder / "pattern.svg").getroot()
_, _, width, height = (float(number) for number in page.get("viewBox").split())
assert page.get("width") == f"{width:.6f}mm" and page.get("height") == f"{height:.6f}mm"
of_svg, seen_bars = set(), set()
for layer in page.findall(f"{tag}g"):
    number = layer.get("id").removeprefix("layer-")
    for group in layer.findall(f"{tag}g"):
        for part in group.findall(f"{tag}g"):
            edge = int(part.get("id").removeprefix("bar-"))
            seen_bars.add(edge)
            assert (bars[edge]["layer"], bars[edge]["material"]) == (number, group.get("class")), edge
            (ax, ay), (bx, by) = (
                (float(c.get("cx")), float(c.get("cy"))) for c in part.findall(f"{tag}circle")
            )
            rest = expected["bars"][str(edge)]["rest_length"]
            close(math.hypot(bx - ax, by - ay) / 1e3, rest, 1e-6, f"holes of {edge} in the SVG")
            of_svg |= {(round(ax, 3), round(height - ay, 3)), (round(bx, 3), round(height - by, 3))}
            # The four corners are half a width beside the ends, on the side that the arcs go around.
            path = part.find(f"{tag}path").get("d")
            form = r"M (\S+) (\S+) L (\S+) (\S+) A (\S+) \S+ 0 0 0 (\S+) (\S+) L (\S+) (\S+) A \S+ \S+ 0 0 0 \S+ \S+ Z"
            numbers = [float(number) for number in re.fullmatch(form, path).groups()]
            close(numbers[4], half, 1e-6, "radius of an arc")
            corners = [numbers[0:2], numbers[2:4], numbers[5:7], numbers[7:9]]
            for corner, end in zip(corners, [(ax, ay), (bx, by), (bx, by), (ax, ay)]):
                close(math.dist(corner, end), half, 2e-6, f"corner of {edge}")
            first, second = corners[0], corners[1]
            turn = (second[0] - first[0]) * (ay - first[1]) - (second[1] - first[1]) * (ax - first[0])
            assert turn < 0, f"the arcs of {edge} go inwards"
assert seen_bars == set(bars) and of_svg == of_dxf, "the two drawings differ"

# --- The solid, in millimetres. Corners are in single precision: 2e-5 mm of 500 mm. On struts of 3 mm that is at most
# 1e-5 of the section, and 1e-6 on average.
solid = trimesh.load(folder / "robot.stl")
assert solid.is_watertight and solid.is_winding_consistent, "not watertight"
weights = {row["part"]: row for row in table("solid.csv")}
radius = {"skeleton": sizes["radius"] / 1e3}
radius["actuator"] = radius["skeleton"] * math.sqrt(expected["density"][2] / expected["density"][1])
sections = [math.pi * radius[row["material"]] ** 2 * float(row["rest_length"]) for row in bars.values()]
close(solid.volume / 1e9 / sum(sections), 1, 1e-5, "volume over the sum of section times length")
# The body's void edges, 1e-8 kg/m, are in the mass but not in the solid: less than 1e-6 of it.
density = float(weights["robot"]["density"])
close(solid.volume / 1e9 * density / expected["bar_mass"], 1, 1e-5, "mass over that of the body's bars")
volume = 0
for name, parts in [("skeleton.stl", ["skeleton", "joints"]), ("actuators.stl", ["actuators"])]:
    part = trimesh.load(folder / name)
    if len(part.faces) if hasattr(part, "faces") else 0:
        assert part.is_watertight, name
        close(part.volume / 1e9 / sum(float(weights[p]["volume"]) for p in parts), 1, 1e-5, name)
        volume += part.volume
close(volume / solid.volume, 1, 1e-9, "the two parts over the whole")
# No overlap: the union has the sum of the volumes. Faces that touch may overlap by the rounding, 2e-5 mm of 100 mm.
shells = solid.split(only_watertight=True)
union = trimesh.boolean.union(list(shells), engine="manifold")
close(union.volume / solid.volume, 1, 1e-5, "volume of the union over the sum")

layers = max(int(row["layer"]) for row in bars.values())
print(f"{len(bars)} bars in {layers} layers, nearest {nearest:.4f} mm, {len(shells)} shells,", end=" ")
print(f"volume {solid.volume / 1e9 / sum(sections) - 1:.1e} off, union {union.volume / solid.volume - 1:.1e}")
