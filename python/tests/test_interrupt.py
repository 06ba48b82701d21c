"""Ctrl-C: an interrupted run returns its current robot and can be resumed."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import cosmic
import pytest
from common import SCENE, SEED, is_same_run

INTERRUPTED = """
import json, os, pathlib, pickle, signal, sys, threading, warnings
import cosmic, numpy as np

scene, out = json.loads(sys.argv[1]), sys.argv[2] or None

def progress(iteration, last, numbers):
    if iteration == 3:
        threading.Timer(0.02, os.kill, (os.getpid(), signal.SIGINT)).start()

with warnings.catch_warnings(record=True) as told:
    warnings.simplefilter("always")
    run = cosmic.optimize(scene, int(sys.argv[3]), out=out, threads=1, progress=progress)
text = [str(each.message) for each in told if "interrupted" in str(each.message)]
files = [each.filename for each in told]
moved = float(abs(run.trajectory[-1] - run.trajectory[0]).max())
iterations, reason, folder = run.summary["iterations"], run.summary["stop_reason"], run.folder
copy = pickle.loads(pickle.dumps(run))
assert copy.folder == folder.absolute() and np.array_equal(copy.trajectory, run.trajectory)
assert run.report().stat().st_size and run.report(sys.argv[4]).parent == pathlib.Path(sys.argv[4])
# A temporary folder must outlive the first run.
run = copy = cosmic.resume(folder, progress=False) if not out else None
print(json.dumps([iterations, text, files, moved, str(folder), reason, run and run.summary["iterations"]]))
"""

#: Enough iterations that the signal arrives before the run ends.
LONG = {**SCENE, "schedule": {**SCENE["schedule"], "iterations": 400}}
#: The same as the text of a scene file.
LONG_TEXT = cosmic.as_scene(LONG).to_toml()


def interrupted(out: Path | str, copy: Path) -> tuple[int, str, str, int | None]:
    """Interrupts a run. Returns the number of its last iteration, its warning, its folder, and the number of the last iteration
    of a temporary run that is continued."""
    arguments = [json.dumps(LONG), str(out), str(SEED), str(copy)]
    done = subprocess.run(
        [sys.executable, "-c", INTERRUPTED, *arguments],
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert done.returncode == 0, done.stderr
    iterations, [warning], files, moved, folder, reason, later = json.loads(done.stdout)
    assert reason == "unfinished"
    # The warning is about the line that called optimize.
    assert set(files) == {"<string>"} and moved > 0.0
    return iterations, warning, folder, later


def test_an_interrupted_run_is_returned_and_can_be_resumed(tmp_path: Path) -> None:
    out = tmp_path / "run"
    iterations, warning, folder, _ = interrupted(out, tmp_path / "copy")
    assert 3 <= iterations < 400 and folder == str(out)
    assert cosmic.load(tmp_path / "copy").summary["iterations"] == iterations
    assert f"after iteration {iterations}:" in warning and f"cosmic.resume('{out}')" in warning
    with pytest.raises(cosmic.FileError):
        cosmic.load(out)
    whole = cosmic.optimize(LONG, SEED, progress=False)
    assert is_same_run(cosmic.resume(folder, progress=False).folder, whole.folder)


def test_a_run_without_a_folder_is_returned_and_can_be_resumed(tmp_path: Path) -> None:
    iterations, warning, folder, later = interrupted("", tmp_path / "copy")
    assert 3 <= iterations < 400 and later == 400
    assert warning.endswith("the robot of that iteration; continue with cosmic.resume(run.folder)")
    assert not Path(folder).exists()


def test_a_run_of_a_sweep_saves_itself(tmp_path: Path) -> None:
    spec, stopped, whole = [tmp_path / name for name in ("long.toml", "s", "whole")]
    spec.write_text(LONG_TEXT)

    def stop() -> None:
        while not list(stopped.glob("runs/*/history.jsonl")):
            time.sleep(0.01)
        os.kill(os.getpid(), signal.SIGINT)

    threading.Thread(target=stop).start()
    with pytest.raises(KeyboardInterrupt):
        cosmic.sweep.run(spec, stopped, 0)
    assert cosmic.sweep.merge(stopped)["state"][0] == "unfinished"
    assert [cosmic.sweep.run(spec, out, 0) for out in (stopped, whole)] == ["done", "done"]
    assert is_same_run(stopped / "runs/long-0", whole / "runs/long-0")


STOPPED = """
import json, os, signal, sys, threading, time
import cosmic, numpy as np

sim = cosmic.Simulator("stability")
first = sim.initial()
rng = np.random.default_rng(0)
many = first._replace(v0=1e-3 * rng.normal(size=(4096, *first.v0.shape)))
bars = cosmic.Trajectory(np.ones((4096, 1, 36, 2)), np.zeros((4096, 1, 36, 2)))
calls = {
    "rollout": lambda: sim.rollout(many, observed=[8192]),
    "vjp": lambda: sim.vjp(many, bars, observed=[8192]),
    "jvp": lambda: sim.jvp(many, first, observed=[8192]),
}
sent = []

def stop():
    sent.append(time.monotonic())
    os.kill(os.getpid(), signal.SIGINT)

threading.Timer(1.0, stop).start()
try:
    calls[sys.argv[1]]()
except KeyboardInterrupt as stopped:
    late = time.monotonic() - sent[0]
    done = getattr(stopped, "trajectory", None)
    which = [] if done is None else np.flatnonzero(np.isfinite(done.x[:, -1]).all(axis=(1, 2)))
    if len(which):
        k = which[0]
        alone = sim.rollout(many._replace(v0=many.v0[k]), observed=[8192])
        assert np.array_equal(alone.x, done.x[k]) and np.array_equal(alone.v, done.v[k])
    print(json.dumps([late, len(which)]))
"""


@pytest.mark.parametrize("call", ["rollout", "vjp", "jvp"])
def test_an_interrupted_batch_keeps_its_finished_robots(call: str) -> None:
    done = subprocess.run(
        [sys.executable, "-c", STOPPED, call], capture_output=True, text=True, timeout=120
    )
    assert done.returncode == 0, done.stderr
    late, finished = json.loads(done.stdout)
    # The current robots take a tenth of a second, and several times as long on a busy machine.
    assert late < 2.0
    assert 0 < finished < 4096 if call == "rollout" else finished == 0
