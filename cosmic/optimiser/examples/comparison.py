"""Runs NLopt on the test problems and writes tests/data/nlopt.txt.

    pip install nlopt
    python cosmic/optimiser/examples/comparison.py

Each line has the problem, the algorithm, the evaluations until a point is within 1e-6 of the optimum, all evaluations
until NLopt stops, and the excess of the objective and the violation at the end.
"""

import subprocess
from pathlib import Path

import nlopt
import numpy as np

EVALUATIONS = 5000
COMMAND = ["cargo", "run", "--quiet", "-p", "cosmic-optimiser", "--example", "comparison", "--", "serve"]
server = subprocess.Popen(COMMAND, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)


def ask(line):
    server.stdin.write(line + "\n")
    server.stdin.flush()


def numbers():
    return np.array([float(word) for word in server.stdout.readline().split()])


class Run:
    """One run of an algorithm. All functions are evaluated together, once per point."""

    def __init__(self, case, algorithm):
        self.name, self.equalities, self.optimum, self.start, self.lower, self.upper = case
        self.count, self.near, self.at = 0, 0, None
        self.evaluate(self.start)
        self.count, self.near = 0, 0
        self.rows = len(self.values)
        size = len(self.start)
        self.optimiser = nlopt.opt(getattr(nlopt, "LD_" + algorithm), size)
        if algorithm == "AUGLAG":
            local = nlopt.opt(nlopt.LD_LBFGS, size)
            local.set_ftol_rel(1e-10)
            local.set_xtol_rel(1e-10)
            self.optimiser.set_local_optimizer(local)
        self.optimiser.set_lower_bounds(self.lower)
        self.optimiser.set_upper_bounds(self.upper)
        self.optimiser.set_min_objective(lambda x, g: self.function(0, x, g))
        for i in range(1, self.rows):
            add = self.optimiser.add_equality_constraint if i <= self.equalities else self.optimiser.add_inequality_constraint
            add(lambda x, g, i=i: self.function(i, x, g), 1e-8)
        self.optimiser.set_ftol_rel(1e-10)
        self.optimiser.set_xtol_rel(1e-8)
        self.optimiser.set_maxeval(EVALUATIONS)

    def evaluate(self, x):
        if self.at is not None and np.array_equal(x, self.at):
            return
        self.at = np.array(x)
        self.count += 1
        ask(self.name + " " + " ".join(repr(float(entry)) for entry in x))
        self.values = numbers()
        self.gradients = numbers().reshape(len(self.values), -1)
        if not self.near and max(abs(self.excess()), self.violation()) <= 1e-6:
            self.near = self.count

    def function(self, i, x, gradient):
        self.evaluate(x)
        if gradient.size > 0:
            gradient[:] = self.gradients[i]
        return float(self.values[i])

    def excess(self):
        return (self.values[0] - self.optimum) / max(1, abs(self.optimum))

    def violation(self):
        equalities, inequalities = np.split(self.values[1:], [self.equalities])
        return max([0.0, *abs(equalities), *inequalities])

    def line(self, algorithm):
        try:
            end = self.optimiser.optimize(self.start)
        except Exception:  # NLopt's algorithms fail by exceptions without a result.
            end = self.at
        count, near = self.count, self.near
        self.evaluate(end)
        return f"{self.name} {algorithm} {near} {count} {self.excess():.1e} {self.violation():.1e}\n"


def cases():
    ask("")
    while words := server.stdout.readline().split():
        name, equalities, optimum, *rest = words
        start, lower, upper = np.array(rest, dtype=float).reshape(3, -1)
        yield name, int(equalities), float(optimum), start, lower, upper


lines = []
for case in list(cases()):
    for algorithm in ["AUGLAG", "SLSQP"] if case[1] else ["MMA", "CCSAQ"]:
        lines.append(Run(case, algorithm).line(algorithm))
(Path(__file__).parent.parent / "tests/data/nlopt.txt").write_text("".join(lines))
