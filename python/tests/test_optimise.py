"""Runs: files equal to those of the program, folders, reports, and errors that stop a run."""

from __future__ import annotations

import gc
import json
import re
import shutil
import subprocess
from pathlib import Path

import cosmic
import numpy as np
import pytest
from common import PROGRAM, SCENE, SEED, changed, is_same_run, same


def test_a_run_has_the_same_bytes_as_that_of_the_program(run: cosmic.Run, tmp_path: Path) -> None:
    scene = tmp_path / "small.toml"
    scene.write_text(run.scene.to_toml())
    out = tmp_path / "run"
    command = [*PROGRAM, "optimize", scene, "--seed", str(SEED), "--out", out, "--quiet"]
    subprocess.run(command, check=True)
    assert is_same_run(run.folder, out)


def test_the_number_of_threads_changes_no_bit(run: cosmic.Run) -> None:
    again = cosmic.optimize(SCENE, SEED, threads=1, progress=False)
    assert is_same_run(run.folder, again.folder)


def test_a_run_has_its_arrays(run: cosmic.Run) -> None:
    edges = len(run.design.edges)
    assert run.design.z.shape == (edges, 3)
    assert np.array_equal(run.design.z, np.eye(3)[run.design.materials])
    assert run.trajectory.shape == run.velocities.shape == (len(run.steps), 9, 2)
    assert run.steps[-1] == 256
    # The time is a product of two floats.
    assert run.times[-1] == 256 * 0.002
    assert run.seed == SEED and run.summary["scene"] == "stability"
    assert run.displacement == run.summary["displacement_robust_p50"] > 0.01
    assert repr(run).startswith("<Run stability, seed 1: 0.0")


def test_the_history_has_columns(run: cosmic.Run) -> None:
    history = run.history
    assert history["iteration"].tolist() == list(range(1, 41))
    assert {len(column) for column in history.values()} == {40}
    assert history["phase"].dtype.kind == "U" and history["displacement"].dtype == np.float64
    # A displacement is measured in some iterations; in the others there is none.
    measured = np.isfinite(history["displacement"])
    assert 0 < measured.sum() < 40
    written = (run.folder / "history.jsonl").read_text().splitlines()
    assert [json.loads(line)["V"] for line in written] == history["V"].tolist()
    # Numbers in lists are columns too. The gradients of the snap are missing.
    lists = [json.loads(line)["measures"] for line in written]
    assert lists == np.stack([history[f"measures.{k}"] for k in range(4)], axis=1).tolist()
    assert np.isnan(history["controller_gradient"]).any() and "format" not in history


def test_the_simulator_repeats_the_delivered_rollout(run: cosmic.Run) -> None:
    seen = run.simulator().rollout(run.inputs, observed=run.steps)
    assert same(seen, (run.trajectory, run.velocities))


def test_a_run_is_saved_and_loaded(run: cosmic.Run, tmp_path: Path) -> None:
    copy = cosmic.load(run.save(tmp_path / "copy"))
    assert is_same_run(run.folder, copy.folder)
    assert same(run.inputs, copy.inputs)
    assert copy.scene.to_toml() == run.scene.to_toml()
    with pytest.raises(cosmic.InputError, match="name a new or empty folder"):
        run.save(tmp_path / "copy")


def test_a_run_is_reported(run: cosmic.Run, tmp_path: Path) -> None:
    page = run.report(tmp_path / "walker")
    assert page == tmp_path / "walker/report.html" and "<html" in page.read_text()
    beside = {file.name for file in page.parent.iterdir()}
    assert {"robot.svg", "gait.gif", "design.json"} <= beside
    shown = run._repr_html_()
    assert "onload=" in shown
    assert shown.startswith("<iframe srcdoc=") and "&lt;html" in shown and "0.0" in shown


def test_progress_is_called_once_per_iteration() -> None:
    told = []
    cosmic.optimize(SCENE, SEED, iterations=12, progress=lambda *told_now: told.append(told_now))
    assert [iteration for iteration, _, _ in told] == list(range(1, 13))
    assert {last for _, last, _ in told} == {12}
    assert set(told[0][2]) == {"phase", "displacement", "V", "V_act"}


def test_a_bar_is_shown(capsys: pytest.CaptureFixture[str]) -> None:
    cosmic.optimize(SCENE, SEED, iterations=3)
    assert "stability seed 1" in capsys.readouterr().err


def test_a_temporary_folder_is_deleted_with_its_run() -> None:
    kept = cosmic.optimize(SCENE, SEED, iterations=3, progress=False)
    folder = kept.folder
    assert (folder / "design.json").exists()
    del kept
    gc.collect()
    assert not folder.exists()


def test_a_start_is_taken_from_another_run(run: cosmic.Run, tmp_path: Path) -> None:
    made = [
        cosmic.optimize(SCENE, SEED, start=start, progress=False)
        for start in (run, run.folder, run.folder / "design.json", run.inputs)
    ]
    assert all(is_same_run(made[0].folder, other.folder) for other in made[1:])
    assert not is_same_run(made[0].folder, run.folder)


class Mine(Exception):
    """An exception of the caller."""


def test_an_exception_of_progress_stops_the_run(run: cosmic.Run, tmp_path: Path) -> None:
    raised = Mine("enough")

    def progress(iteration: int, last: int, numbers: object) -> None:
        if iteration == 5:
            raise raised

    with pytest.raises(Mine) as caught:
        cosmic.optimize(SCENE, SEED, out=tmp_path / "run", progress=progress)
    assert caught.value is raised
    # What was done is there, and the rest follows.
    with pytest.raises(cosmic.FileError):
        cosmic.load(tmp_path / "run")
    whole = cosmic.resume(tmp_path / "run", progress=False)
    assert is_same_run(whole.folder, run.folder)


@pytest.mark.skipif(shutil.which("chromium") is None, reason="needs chromium")
def test_a_notebook_shows_the_whole_page(run: cosmic.Run, tmp_path: Path) -> None:
    def heights(width: int) -> list[float]:
        page = tmp_path / f"{width}.html"
        told = (
            "<script>setTimeout(() => { const f = document.querySelector('iframe'), "
            "b = f.contentDocument.body; document.title = 'heights ' + f.clientHeight + ' ' + "
            "f.contentDocument.documentElement.scrollHeight + ' ' + b.scrollHeight }, 1500)</script>"
        )
        page.write_text(f"<body style='width:{width}px'>{run._repr_html_()}{told}</body>")
        command = ["chromium", "--headless", "--no-sandbox", "--virtual-time-budget=4000"]
        done = subprocess.run(
            [*command, "--dump-dom", page.as_uri()], capture_output=True, text=True, timeout=120
        )
        found = re.search(r"heights (\d+) (\d+) (\d+)", done.stdout)
        assert found, done.stdout[-1000:] + done.stderr[-1000:]
        return [float(number) for number in found.groups()]

    frames = []
    for width in (500, 1000):
        frame, page, body = heights(width)
        # The frame fits the page exactly, except that heights are rounded to whole pixels.
        assert page <= frame + 1 and abs(frame - body) <= 2, (width, frame, page, body)
        frames.append(frame)
    assert frames[0] != frames[1]


def test_messages_name_python_calls_instead_of_commands(run: cosmic.Run, tmp_path: Path) -> None:
    stopped = tmp_path / "a run"

    def stop(iteration: int, *_: object) -> None:
        if iteration == 3:
            raise Mine

    with pytest.raises(Mine):
        cosmic.optimize(SCENE, SEED, out=stopped, progress=stop)
    with pytest.raises(cosmic.FileError, match=re.escape(f"cosmic.resume({str(stopped)!r})")):
        cosmic.load(stopped)
    with pytest.raises(cosmic.InputError, match=re.escape("cosmic.resume(folder)")):
        cosmic.optimize(SCENE, out=stopped, progress=False)
    assert cosmic.resume(stopped, allow_unstable=True, progress=False).scene.to_toml() == (
        run.scene.to_toml().replace('unstable_step = "error"', 'unstable_step = "warn"')
    )


@pytest.mark.parametrize(
    ("command", "call"),
    [
        ("continue with: cosmic resume runs/a", "continue with: cosmic.resume('runs/a')"),
        ("cosmic resume 'my runs/a' --allow-unstable", "cosmic.resume('my runs/a', allow_unstable=True)"),
        ("cosmic resume 'it'\\''s'; and so on", 'cosmic.resume("it\'s"); and so on'),
        ("by `cosmic resume`, or name another", "by cosmic.resume(folder), or name another"),
        ("with: cosmic evaluate a/diverged.json", "with: json.load(open('a/diverged.json'))"),
        ("with record::resume_with and the loss of the run in a b", "with: cosmic.resume('a b', loss=...)"),
        ("the folder that `cosmic optimize` wrote", "the folder that cosmic.optimize wrote"),
        (
            "with: cosmic optimize a/scene.toml --seed SEED --out NEW",
            "with: cosmic.optimize('a/scene.toml', seed=SEED, out=NEW)",
        ),
        ("run it with: cosmic sweep run 'my grid' --out DIR", "run it with: cosmic.sweep.run('my grid', DIR, index)"),
        ("as `cosmic scene show SCENE` prints it", "as cosmic.Scene.load(SCENE).to_toml() gives it"),
        ("nothing of the kind", "nothing of the kind"),
    ],
)
def test_commands_are_translated(command: str, call: str) -> None:
    assert cosmic._errors.in_python(command) == call


def test_all_commands_in_messages_of_the_library_are_translated() -> None:
    root = Path(__file__).resolve().parents[2] / "cosmic/src"
    left = set()
    for file in root.rglob("*.rs"):
        lines = [line for line in file.read_text().splitlines() if not line.strip().startswith("//")]
        for said in re.findall(r'"[^"]*\bcosmic (?:[a-z]+)[^"]*"', "\n".join(lines)):
            left |= set(re.findall(r"\bcosmic [a-z]+", cosmic._errors.in_python(said)))
    # Allowed in messages of runs that `--starts` began, and in the program's own tests.
    assert left <= {"cosmic is"}, left


def test_unsuitable_folders_are_refused(run: cosmic.Run, tmp_path: Path) -> None:
    with pytest.raises(cosmic.FileError, match="missing"):
        cosmic.load(tmp_path / "missing")
    with pytest.raises(cosmic.FileError, match="missing"):
        cosmic.resume(tmp_path / "missing", progress=False)
    with pytest.raises(cosmic.InputError, match="walker: the folder is not empty"):
        cosmic.optimize(SCENE, out=run.folder, progress=False)
    with pytest.raises(cosmic.FileError, match="missing"):
        cosmic.optimize(SCENE, start=tmp_path / "missing", progress=False)
    with pytest.raises(cosmic.InputError, match=r"start: w1: expected the shape \[3, 48\], found \[32, 48\]"):
        cosmic.optimize({**SCENE, "controller.hidden": 3}, start=run.inputs, progress=False)


def test_a_folder_that_cannot_be_made_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(cosmic.FileError, match="cannot write .*file"):
        cosmic.optimize(SCENE, out=tmp_path / "file/run", progress=False)


def test_an_unstable_time_step_raises_an_exception() -> None:
    with pytest.raises(cosmic.UnstableStepError, match="set physics.dt to"):
        cosmic.optimize({**SCENE, "physics.dt": 0.02}, progress=False)


@pytest.mark.parametrize(
    ("name", "value"),
    [("seed", -1), ("seed", 2**64), ("iterations", 0), ("threads", 0), ("threads", 10**9)],
)
def test_numbers_out_of_range_are_refused(name: str, value: int) -> None:
    with pytest.raises(cosmic.InputError, match=f"{name}: {value}: expected a whole number"):
        cosmic.optimize(SCENE, **{"progress": False, name: value})


def test_a_finished_run_is_only_read(run: cosmic.Run) -> None:
    before = (run.folder / "summary.json").read_bytes()
    again = cosmic.resume(run.folder, progress=False)
    assert is_same_run(again.folder, run.folder)
    assert (run.folder / "summary.json").read_bytes() == before


def test_the_frequency_of_a_learned_clock_is_an_input() -> None:
    run = cosmic.optimize({**SCENE, "controller.clock": "learned"}, SEED, progress=False)
    tempo = run.controller["tempo"]
    assert tempo.shape == (1,) and tempo[0] != 0
    sim = run.simulator()
    seen = sim.rollout(run.inputs, observed=run.steps)
    assert same(seen, (run.trajectory, run.velocities))
    # The frequency is an input like the others.
    begun = sim.rollout(changed(run.inputs, tempo=0.0 * tempo), observed=run.steps)
    assert not np.allclose(begun.x, seen.x, rtol=0, atol=1e-6)
    gradient = sim.vjp(run.inputs, cosmic.Trajectory(*seen), observed=run.steps)
    assert gradient.controller["tempo"][0] != 0.0
