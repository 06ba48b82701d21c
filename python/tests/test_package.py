"""What comes with the package: the program, the version, licences, docs, and errors about packages that are missing."""

from __future__ import annotations

import importlib.metadata
import json
import pydoc
import signal
import subprocess
import sys
import time
from pathlib import Path

import cosmic
import pytest
from common import PROGRAM, SCENE, SEED


def ended(*command: str | Path) -> tuple[int, str, str]:
    """Runs a command. Returns its exit code, its output and its errors."""
    done = subprocess.run(command, capture_output=True, text=True, timeout=120)
    return done.returncode, done.stdout, done.stderr


def metadata() -> importlib.metadata.Distribution:
    """The metadata of the installed package."""
    try:
        return importlib.metadata.distribution("cosmic-codesign")
    except importlib.metadata.PackageNotFoundError:
        pytest.skip("the package is not installed")


def test_the_program_prints_results_and_ends_with_the_exit_codes_of_its_errors() -> None:
    code, out, _ = ended(*PROGRAM, "scene", "list")
    assert code == 0 and [line.split()[0] for line in out.splitlines()] == cosmic.scenes()
    assert ended(*PROGRAM, "--version") == (0, f"cosmic {cosmic.__version__}\n", "")
    code, out, errors = ended(*PROGRAM, "optimise")
    assert (code, out) == (2, "") and "Usage: cosmic" in errors
    code, out, errors = ended(*PROGRAM, "evaluate", "missing.json")
    assert (code, out) == (4, "") and "error: cannot read missing.json" in errors


def test_the_command_cosmic_is_the_program() -> None:
    metadata()
    assert ended(Path(sys.executable).with_name("cosmic"), "--help") == ended(*PROGRAM, "--help")


@pytest.mark.skipif(sys.platform == "win32", reason="sends signals as Unix does")
def test_ctrl_c_stops_a_run_of_the_program_which_can_be_resumed(tmp_path: Path) -> None:
    scene = cosmic.as_scene({**SCENE, "schedule.iterations": 2000})
    (tmp_path / "long.toml").write_text(scene.to_toml())
    history = tmp_path / "run/history.jsonl"
    command = [*PROGRAM, "optimize", "long.toml", "--seed", str(SEED), "--out", "run"]
    child = subprocess.Popen(command, cwd=tmp_path, stderr=subprocess.PIPE, text=True)
    while not history.exists() or len(history.read_text().splitlines()) < 3:
        assert child.poll() is None
        time.sleep(0.01)
    child.send_signal(signal.SIGINT)
    _, errors = child.communicate(timeout=60)
    assert child.returncode == 75 and "cosmic resume run" in errors
    stopped = json.loads((tmp_path / "run/snapshot.json").read_text())["progress"]["iteration"]
    assert 3 <= stopped < 2000


STOPPED = """
import os, signal, sys, threading
from cosmic.__main__ import main

sys.argv[1:] = ["check"]
threading.Timer(0.2, os.kill, (os.getpid(), signal.SIGINT)).start()
main()
"""


@pytest.mark.skipif(sys.platform == "win32", reason="sends signals as Unix does")
def test_ctrl_c_ends_a_command_that_saves_nothing() -> None:
    # `check` prints each part when it is done, so its output depends on the moment.
    status, _, errors = ended(sys.executable, "-c", STOPPED)
    assert (status, errors) == (-signal.SIGINT, "")


def test_the_version_and_the_licences_are_those_of_the_distribution() -> None:
    assert cosmic.__version__ == metadata().version
    files = {file.name: file for file in metadata().files or []}
    for name, words in [("LICENSE-MIT", "MIT License"), ("LICENSE-APACHE", "Apache License")]:
        assert words in files[name].read_text()


HIDDEN = "import importlib, sys; sys.modules[sys.argv[1]] = None; importlib.import_module(sys.argv[2])"


@pytest.mark.parametrize(
    ("extra", "package"), [("jax", "jax"), ("torch", "torch"), ("gym", "gymnasium")]
)
def test_a_module_whose_package_is_missing_names_the_extra(extra: str, package: str) -> None:
    code, _, errors = ended(sys.executable, "-c", HIDDEN, package, f"cosmic.{extra}")
    assert code == 1 and f"pip install 'cosmic-codesign[{extra}]'" in errors.splitlines()[-1]


def test_help_shows_the_docs_of_attributes() -> None:
    for owner, name, words in [
        (cosmic.Simulator, "rest_length", "Rest length of every edge, m."),
        (cosmic.Inputs, "x0", "Initial positions, ``(nodes, D)``, m."),
        (cosmic.Run, "times", "The times of these states, s."),
    ]:
        assert f" |  {name}\n |      {words}\n" in pydoc.render_doc(owner, renderer=pydoc.plaintext)
