"""Tables and a chart of a finished sweep, beyond the table that `cosmic sweep merge` prints.

    cosmic sweep run studies/findings.toml --out sweeps/findings
    python3 studies/tables.py sweeps/findings --compare stability simp --compare stability stops
    python3 studies/tables.py sweeps/transfer --mujoco 5 2.5 1 0.6
    python3 studies/tables.py sweeps/scout --goals 0.4 0.8 --seconds 12.6

It needs pandas and matplotlib; with `--mujoco` and `--goals` also the packages mujoco and numpy, and the program `cosmic` on
the path. It prints Markdown and writes seeds.svg, the chart of every seed, and mujoco.csv or goals.csv into
the folder of the sweep. Runs that diverged are left out of medians and quantiles.
"""

from __future__ import annotations

import argparse
import json
import math
import subprocess
import sys
from pathlib import Path

import pandas as pd

#: The number to quote for a run.
DISTANCE = "displacement_robust_p50"

#: The columns of the table, with the column of results.csv and the statistic over the seeds.
COLUMNS = {
    "best": (DISTANCE, "max"),
    "p10": (DISTANCE, lambda sample: sample.quantile(0.1)),
    "median": (DISTANCE, "median"),
    "p90": (DISTANCE, lambda sample: sample.quantile(0.9)),
    "last": ("displacement_last_p50", "median"),
    "open loop": ("displacement_clock_p50", "median"),
    "peak strain": ("strain_peak", "median"),
    "V": ("V", "median"),
    "V_act": ("V_act", "median"),
    "runs": ("seed", "count"),
    "reliable": ("reliability", lambda sample: (sample == "reliable").sum()),
    "in one piece": ("pieces", lambda sample: (sample == 1).sum()),
    "gradients skipped": ("skipped_gradients", "sum"),
    "seconds": ("seconds", "median"),
}


def markdown(table: pd.DataFrame) -> str:
    """The table as Markdown, with two decimals."""
    cell = lambda x: "–" if pd.isna(x) else f"{x:.2f}" if isinstance(x, float) else str(x)
    cells = table.reset_index().map(cell)
    lines = [list(cells.columns), ["---", *["--:"] * table.shape[1]], *cells.values.tolist()]
    return "\n".join("| " + " | ".join(map(str, line)) + " |" for line in lines) + "\n"


def trials(results: pd.DataFrame, plan: dict) -> pd.DataFrame:
    """A row for each trial."""
    table = results.groupby("trial", sort=False).agg(**COLUMNS)
    published = {trial["name"]: trial["published"] for trial in plan["trials"]}
    table.insert(0, "published", pd.Series(published, dtype=float))
    titles = {trial["name"]: trial["title"] for trial in plan["trials"]}
    return table.rename(index=titles)


def change(results: pd.DataFrame, before: str, after: str) -> dict:
    """The change from one trial to another. Runs of one seed begin alike, so it is taken from seed to seed."""
    by_seed = results.pivot(index="seed", columns="trial", values=DISTANCE)
    changes = (by_seed[after] - by_seed[before]).dropna()
    mean, error = changes.mean(), changes.sem()
    verdict = "undecided" if not abs(mean) > 2 * error else "more" if mean > 0 else "less"
    return {"from": before, "to": after, "change": mean, "±": error, "verdict": verdict}


def chart(results: pd.DataFrame, plan: dict, path: Path) -> None:
    """Draws every seed of every trial, with medians as bars and published numbers as strokes."""
    import matplotlib

    matplotlib.use("svg")
    from matplotlib import pyplot as plt

    figure, axes = plt.subplots(figsize=(9, 1 + 0.35 * len(plan["trials"])))
    for row, trial in enumerate(plan["trials"]):
        sample = results.loc[results["trial"] == trial["name"], DISTANCE]
        axes.barh(row, sample.median(), color="#cfd8e3")
        axes.plot(sample, [row] * len(sample), "o", color="#33658a", markersize=3)
        if trial["published"] is not None:
            axes.plot([trial["published"]] * 2, [row - 0.4, row + 0.4], color="#c0392b")
    axes.set_yticks(range(len(plan["trials"])), [trial["title"] for trial in plan["trials"]])
    axes.invert_yaxis()
    axes.set_xlabel("displacement along the ground, m (bar: median; dots: seeds; stroke: published)")
    figure.savefig(path, bbox_inches="tight")


class Exported:
    """The robot of a run in MuJoCo."""

    def __init__(self, run: Path) -> None:
        rigid = ["--rigid"] if 'integrator = "implicit"' in (run / "scene.toml").read_text() else []
        subprocess.run(["cosmic", "export", run, "--mujoco", *rigid, "--quiet"], check=True)
        sys.path.insert(0, str(run / "export"))
        import walk  # the player that `cosmic export` writes

        self.walk = walk
        self.model, self.net = walk.load(str(run / "export"))

    def path(self, steps: int, goal: object = None) -> list:
        """The positions before and after so many steps from the start of its scene; NaN after a walk that diverges."""
        import mujoco

        data = mujoco.MjData(self.model)
        mujoco.mj_resetDataKeyframe(self.model, data, 0)
        begun = data.qpos.copy()
        for step in range(steps):
            self.walk.step(self.model, [data], self.net, step, goal)
        # If the simulation diverges, MuJoCo resets it to time 0.
        whole = data.time > (steps * self.net["substeps"] - 0.5) * self.model.opt.timestep
        return [begun, data.qpos if whole else data.qpos * float("nan")]


def to_goals(run: Path, distances: list[float], seconds: float) -> pd.DataFrame:
    """The share of the way to goals on every side that is left in the end: here, and in MuJoCo with the scene's friction."""
    robot, rows = Exported(run), []
    steps = round(seconds / robot.net["dt"])
    for distance in distances:
        for degrees in range(0, 360, 45):
            angle = math.radians(degrees)
            place = [distance * math.cos(angle), distance * math.sin(angle)]
            asked = ["cosmic", "walk", run, f"--goal={place[0]},{place[1]}", "--seconds", str(seconds), "--json"]
            here = json.loads(subprocess.run(asked, check=True, stdout=subprocess.PIPE).stdout)["goals"][0]["ratio"]
            goal = robot.walk.point(robot.net, place)
            *_, there = robot.walk.ways(robot.net, [(0, goal)], robot.path(steps, goal))[0]
            rows.append([run.name, distance, min(degrees, 360 - degrees), here, there / distance])
    return pd.DataFrame(rows, columns=["run", "distance, m", "degrees aside", "left", "left in MuJoCo"])


def in_mujoco(run: Path, frictions: list[float]) -> list[float]:
    """The distances of a run's robot in MuJoCo, on ground of these frictions, from the start of its scene."""
    robot, distances = Exported(run), []
    for friction in frictions:
        # MuJoCo uses the larger friction of two bodies in contact, so all bodies get the same friction.
        robot.model.geom_friction[:, 0] = friction
        begun, end = robot.path(int(robot.net["steps"]))
        distances.append(robot.walk.moved(robot.net, end - begun)[0])
    return distances


def main() -> None:
    arguments = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    arguments.add_argument("sweep", type=Path, help="the folder of a sweep")
    arguments.add_argument("--compare", nargs=2, action="append", default=[], metavar=("FROM", "TO"))
    arguments.add_argument("--mujoco", nargs="+", type=float, default=[], metavar="FRICTION")
    arguments.add_argument("--goals", nargs="+", type=float, default=[], metavar="METRES", help="how far away goals are")
    arguments.add_argument("--seconds", type=float, default=12.0, help="the time to get to a goal [default: 12]")
    given = arguments.parse_args()
    plan = json.loads((given.sweep / "sweep.json").read_text())
    results = pd.read_csv(given.sweep / "results.csv")
    results = results[results["state"] != "unfinished"]
    print(markdown(trials(results, plan)))
    chart(results, plan, given.sweep / "seeds.svg")
    if given.compare:
        changes = [change(results, *pair) for pair in given.compare]
        print(markdown(pd.DataFrame(changes).set_index("from")))
    done = results[results["state"] == "done"]
    folders = given.sweep / "runs" / (done["trial"] + "-" + done["seed"].astype(str))
    if given.goals:
        walks = pd.concat([to_goals(Path(folder), given.goals, given.seconds) for folder in folders])
        walks.to_csv(given.sweep / "goals.csv", index=False)
        table = walks.groupby(["distance, m", "degrees aside"])[["left", "left in MuJoCo"]].median().unstack(0)
        table.columns = [f"{what}, {distance:g} m" for what, distance in table.columns]
        print(markdown(table))
    if given.mujoco:
        walks = [in_mujoco(Path(folder), given.mujoco) for folder in folders]
        walks = pd.DataFrame(walks, columns=given.mujoco, index=done.index)
        walks.insert(0, "trial", done["trial"])
        walks.insert(1, "designed", done[DISTANCE])
        walks.to_csv(given.sweep / "mujoco.csv", index=False)
        print(markdown(walks.groupby("trial", sort=False).median()))


if __name__ == "__main__":
    main()
