"""Compares this tool with another one: sends the messages of a GradBench log to both and prints a Markdown table.

    python3 benches/gradbench/compare.py LOG target/unwind/gradbench "PEER'S COMMAND"

LOG is the output of `gradbench run --output LOG`. Times are in milliseconds, each the minimum of all runs. The
difference is the relative distance in the 2-norm, of the primals or of the derivatives, whichever is larger.
"""

import itertools
import json
import math
import shlex
import subprocess
import sys

TURNS = 3
EFFORT = {"min_runs": 3, "min_seconds": 0.1}


class Tool:
    def __init__(self, command):
        self.process = subprocess.Popen(
            shlex.split(command), stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )
        self.module = None

    def ask(self, message):
        print(json.dumps(message), file=self.process.stdin, flush=True)
        reply = json.loads(self.process.stdout.readline())
        assert reply.get("success", True), reply.get("error")
        return reply

    def evaluate(self, message):
        """Returns the answer, and the time of the fastest run in milliseconds."""
        if message["module"] != self.module:
            self.module = message["module"]
            self.ask({"id": 0, "kind": "start", "eval": self.module})
            self.ask({"id": 1, "kind": "define", "module": self.module})
        reply = self.ask(message)
        runs = [t["nanoseconds"] for t in reply["timings"] if t["name"] == "evaluate"]
        return reply["output"], min(runs) * 1e-6


def numbers(value):
    if isinstance(value, (int, float)):
        return [value]
    parts = value if isinstance(value, list) else [value[key] for key in sorted(value)]
    return list(itertools.chain.from_iterable(map(numbers, parts)))


def distance(answer, right):
    answer, right = numbers(answer), numbers(right)
    assert len(answer) == len(right), "the answers have different shapes"
    return math.dist(answer, right) / (math.hypot(*right) or 1.0)


def evaluations(log):
    for line in map(json.loads, open(log)):
        message = line.get("message", line)
        if message.get("kind") == "evaluate" and isinstance(message["input"], dict):
            message["input"] |= EFFORT
            yield message


def main():
    log, *commands = sys.argv[1:]
    tools = [Tool(command) for command in commands]
    print("| workload | difference | primal | derivative | peer's primal | peer's derivative | ratio |")
    print("| --- | --- | --- | --- | --- | --- | --- |")
    workload = lambda message: (message["module"], message.get("description", ""))
    for name, functions in itertools.groupby(evaluations(log), workload):
        times, error = [], 0.0
        for message in functions:
            turns = [[tool.evaluate(message) for tool in tools] for _ in range(TURNS)]
            times.append([min(turn[side][1] for turn in turns) for side in range(2)])
            error = max(error, distance(*(output for output, _ in turns[-1])))
        (primal, its_primal), (slope, its_slope) = times
        ratio = (primal + slope) / (its_primal + its_slope)
        cells = " | ".join(f"{time:.4f}" for time in (primal, slope, its_primal, its_slope))
        print(f"| {' '.join(name)} | {error:.0e} | {cells} | {ratio:.2f} |", flush=True)


main()
