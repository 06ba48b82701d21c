"""Does the stiffness of a single bar change a robot's distance by more than chance?

    cosmic optimize earth --seed 5 --out runs/earth-5
    python studies/bars.py runs/earth-5 [ROBOTS]

Makes one bar after the other a tenth stiffer, in two independent sets of robots: `nm`, whose starts differ by a nanometre, and
`varied`, whose starts, friction and bars differ as much as those of `displacement_robust_p50`. `nothing` moves the starts by
another nanometre instead. Needs the package cosmic.
"""

import os
import sys

# One thread, also for batches. The library reads this when it starts.
os.environ["RAYON_NUM_THREADS"] = "1"

import cosmic
import numpy as np

if len(sys.argv) < 2:
    sys.exit(__doc__)
run, n = cosmic.load(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 16
sim, rest = run.simulator(), run.inputs.x0
bars = np.flatnonzero(run.design.materials > 0)
scale = 10 * float(run.scene["lattice.spacing"])


def drawn(varies: float, seed: int) -> cosmic.Inputs:
    """Robots whose starts, friction and bars vary, or only their starts, by a nanometre."""
    random = np.random.default_rng(seed)
    x0 = rest + scale * (1e-3 if varies else 1e-9) * random.uniform(-1, 1, (n, *rest.shape))
    physics = {"bars.stiffness": 1 + varies * random.uniform(-0.05, 0.05, (n, len(sim.edges)))}
    if "physics.friction" in sim.physics:
        physics["physics.friction"] = sim.physics["physics.friction"] * (1 + varies * random.uniform(-0.05, 0.05, n))
    return run.inputs._replace(x0=x0, physics=physics)


def walked(robots: cosmic.Inputs, stiffer: object = ()) -> np.ndarray:
    """The distances of the robots with stiffer bars, m."""
    stiffness = robots.physics["bars.stiffness"].copy()
    stiffness[:, stiffer] *= 1.1
    changed = robots._replace(physics={**robots.physics, "bars.stiffness": stiffness})
    seen = sim.rollout(changed, observed=[sim.steps], check=False)
    return (seen.x[:, 0, sim.payload] - robots.x0[:, sim.payload]) @ sim.along


def nudged(robots: cosmic.Inputs, seed: int) -> cosmic.Inputs:
    return robots._replace(x0=robots.x0 + 1e-9 * scale * np.random.default_rng(seed).uniform(-1, 1, robots.x0.shape))


def error(own: np.ndarray, other: np.ndarray) -> float:
    """The standard error of the difference of two medians, by a bootstrap over robots."""
    picks = np.random.default_rng(1).integers(n, size=(1000, n))
    return float(np.std(np.median(other[picks], 1) - np.median(own[picks], 1)))


print("| robots | change | median distance, m | typical difference, m | standard error, m | above 2 errors: set 1, set 2, both "
      "with one sign | correlation of the sets |")
print("| --- | --- |" + " --: |" * 5)
for kind, varies in (("nm", 0.0), ("varied", 1.0)):
    sets = [drawn(varies, seed) for seed in (10, 11)]
    owns = [walked(robots) for robots in sets]
    for change in ("stiffer", "nothing"):
        changed = walked if change == "stiffer" else lambda robots, bar: walked(nudged(robots, bar))
        far = [[changed(robots, bar) for bar in bars] for robots in sets]
        a, b = (np.median(each, 1) - np.median(own) for own, each in zip(owns, far))
        errors = np.array([[error(own, other) for other in each] for own, each in zip(owns, far)])
        sure, again = abs(a) > 2 * errors[0], abs(b) > 2 * errors[1]
        both = (sure & again & (a * b > 0)).sum()
        print(f"| {kind} | {change} | {np.median(owns):.2f} | {np.median(abs(np.r_[a, b])):.4f} | {np.median(errors):.4f} "
              f"| {sure.sum()}, {again.sum()}, {both} | {np.corrcoef(a, b)[0, 1]:.2f} |", flush=True)
