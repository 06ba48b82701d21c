"""Threads and forked processes."""

from __future__ import annotations

import copy
import gc
import multiprocessing
import os
import pickle
import subprocess
import sys
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from pathlib import Path

import cosmic
import pytest
from common import SCENE, SEED, is_same_run, like, robot, same, stacked
from cosmic._simulator import leaves


def test_threads_do_not_disturb_one_another(sim: cosmic.Simulator) -> None:
    batches = [stacked([robot(sim, 10 * k + r) for r in range(20)]) for k in range(4)]

    def work(batch: cosmic.Inputs) -> list[object]:
        seen = sim.rollout(batch)
        bars = cosmic.Trajectory(*like(seen, 1))
        return [*seen, *leaves(sim.vjp(batch, bars)).values()]

    alone = [work(batch) for batch in batches]
    with ThreadPoolExecutor(4) as pool:
        together = list(pool.map(work, batches))
    assert all(same(a, b) for a, b in zip(alone, together))


def test_two_threads_optimise_at_once(run: cosmic.Run) -> None:
    def work(seed: int) -> cosmic.Run:
        return cosmic.optimize(SCENE, seed, progress=False)

    with ThreadPoolExecutor(2) as pool:
        first, second = pool.map(work, [SEED, SEED + 1])
    assert is_same_run(first.folder, run.folder)
    assert not is_same_run(second.folder, run.folder)


def test_a_simulator_can_be_sent_to_another_process(sim: cosmic.Simulator) -> None:
    one = robot(sim, 0)
    for other in (pickle.loads(pickle.dumps(sim)), copy.deepcopy(sim)):
        assert other.scene.to_toml() == sim.scene.to_toml()
        assert other.scene.name == sim.scene.name
        assert same(other.rollout(one), sim.rollout(one))


def designed(seed: int) -> cosmic.Run:
    """A run in a temporary folder, made in another process."""
    return cosmic.optimize(SCENE, seed, progress=False)


def test_a_run_comes_back_from_another_process_with_its_folder(run: cosmic.Run) -> None:
    spawn = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(1, mp_context=spawn) as pool:
        made = pool.submit(designed, SEED).result()
    assert is_same_run(made.folder, run.folder)
    assert made.report().exists() and "<iframe" in made._repr_html_()
    folder = made.folder
    twin = copy.deepcopy(made)
    del made
    gc.collect()
    assert not folder.exists() and is_same_run(twin.folder, run.folder)


def test_a_run_in_a_named_folder_stays_there(
    run: cosmic.Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(run.folder.parent)
    here = pickle.dumps(cosmic.load(run.folder.name))
    monkeypatch.chdir(tmp_path)
    assert pickle.loads(here).folder == run.folder


THREADS = """
import os
import cosmic, numpy as np

sim = cosmic.Simulator("stability")
first = sim.initial()
before = len(os.listdir("/proc/self/task"))
sim.rollout(first._replace(v0=np.zeros((16, *first.v0.shape))), 64)
print(len(os.listdir("/proc/self/task")) - before, cosmic._core.usual_threads())
"""


@pytest.mark.skipif(sys.platform != "linux", reason="counts threads as Linux does")
@pytest.mark.parametrize("threads", [1, 3])
def test_an_environment_variable_sets_the_number_of_threads(threads: int) -> None:
    environment = {**os.environ, "RAYON_NUM_THREADS": str(threads)}
    done = subprocess.run(
        [sys.executable, "-c", THREADS], capture_output=True, text=True, env=environment, timeout=60
    )
    assert done.stdout.split() == [str(threads), str(threads)], done.stderr


FORKS = """
import multiprocessing, os, sys
import cosmic, numpy as np

sim = cosmic.Simulator({"scene": "stability", "physics.steps": 64, "schedule.horizon": [64, 64], "loss.window": 64})
first = sim.initial()
batch = first._replace(v0=np.random.default_rng(0).normal(size=(20, *first.v0.shape)))
expected = sim.rollout(batch)

def child():
    seen = sim.rollout(batch)
    sys.exit(0 if np.array_equal(seen.x, expected.x) else 3)

process = multiprocessing.get_context("fork").Process(target=child)
process.start()
process.join(60)
if process.exitcode is None:
    process.kill()
    sys.exit("the child hangs")
assert np.array_equal(sim.rollout(batch).x, expected.x)
sys.exit(process.exitcode)
"""


def test_a_forked_process_makes_its_own_threads() -> None:
    # In a separate process, because other libraries in this process cannot be forked safely.
    done = subprocess.run([sys.executable, "-c", FORKS], capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
