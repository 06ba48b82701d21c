"""Draws the pictures of the studies `one_policy` and `evolve` from the folder of their examples.

    python studies/policies.py one_policy
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

STUDIES = Path(__file__).resolve().parent
sys.path.insert(0, str(STUDIES.parent / "python/examples"))

import matplotlib  # noqa: E402
import numpy as np  # noqa: E402
from one_policy import worlds  # noqa: E402

matplotlib.use("svg")
from matplotlib import pyplot  # noqa: E402

SIM, _ = worlds("mlp")


def body(place: Any, z: Any, title: str) -> None:
    """Draws the bars of a robot: skeleton black, motors red."""
    ends = SIM.initial().x0[SIM.edges]
    for material, colour in ((1, "black"), (2, "crimson")):
        bars = ends[z[:, material] == 1.0]
        # Gaps between the bars.
        points = np.concatenate([bars, np.full_like(bars[:, :1], np.nan)], axis=1)
        place.plot(*points.reshape(-1, 2).T, colour, linewidth=1.2)
    place.set_title(title, fontsize=8)
    place.set_aspect("equal")
    place.axis("off")


def figure(bodies: int) -> Any:
    """A chart and places for so many robots beside it."""
    return pyplot.subplots(1, 1 + bodies, figsize=(3 + 1.5 * bodies, 2.6), width_ratios=[2.2, *[1] * bodies], layout="tight")


def one_policy(folder: Path) -> None:
    """The distances of unseen robots with the shared network over those with a network of their own."""
    picture, (chart, *places) = figure(6)
    for file, mark, name in (("mlp", "k.", "closed loop"), ("clock", "rx", "open loop")):
        walks = np.load(folder / f"{file}-walks.npz")
        chart.plot(walks["own"], walks["shared"], mark, label=name)
        if file == "mlp":
            for place, z, own, shared in zip(places, walks["z"], walks["own"], walks["shared"]):
                body(place, z, f"own {own:.2f} m\nshared {shared:.2f} m")
    most = chart.get_xlim()[1]
    chart.plot([0.0, most], [0.0, most], "lightgrey", zorder=0)
    chart.set(xlabel="network of its own, m", ylabel="shared network, m")
    chart.legend(fontsize=7, frameon=False)
    picture.savefig(STUDIES / "one_policy/one_policy.svg", metadata={"Date": None})


def evolve(folder: Path) -> None:
    """The distance of every seed, and the best robot of each method."""
    found = np.load(folder / "evolve.npz")
    names = [name for name in found if not name.endswith("-z")]
    picture, (chart, *places) = figure(len(names))
    for k, (name, place) in enumerate(zip(names, places)):
        far = found[name]
        chart.plot(np.full(len(far), k), far, "k.", alpha=0.6)
        chart.plot([k - 0.3, k + 0.3], [np.median(far)] * 2, "crimson")
        body(place, found[f"{name}-z"][far.argmax()], f"{name}\n{far.max():.2f} m")
    chart.set(ylabel="distance, m", xticks=range(len(names)), xticklabels=names)
    picture.savefig(STUDIES / "evolve/evolve.svg", metadata={"Date": None})


if __name__ == "__main__":
    pyplot.rcParams["svg.hashsalt"] = "policies"
    for draw, file in ((one_policy, "mlp-walks.npz"), (evolve, "evolve.npz")):
        if (Path(sys.argv[1]) / file).exists():
            draw(Path(sys.argv[1]))
