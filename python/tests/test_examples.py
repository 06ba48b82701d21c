"""The examples run without errors, and the package passes the type checker."""

from __future__ import annotations

import importlib
import re
import shutil
import subprocess
import sys
from pathlib import Path

import cosmic
import numpy as np
import pytest

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"
NOTEBOOKS = sorted(EXAMPLES.glob("*.ipynb"))
SCRIPTS = sorted(EXAMPLES.glob("*.py"))
PAGE = EXAMPLES.parents[1] / "docs/python.md"
#: Packages that a notebook needs in addition to `cosmic`.
NEEDS = {"first_robot": "IPython", "own_objective": "jax", "sensitivity": "matplotlib"}


def test_all_notebooks_exist() -> None:
    assert {notebook.stem for notebook in NOTEBOOKS} == NEEDS.keys()


@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda notebook: notebook.stem)
def test_a_notebook_runs(
    notebook: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    nbformat = pytest.importorskip("nbformat")
    nbclient = pytest.importorskip("nbclient")
    pytest.importorskip(NEEDS[notebook.stem])
    monkeypatch.setenv("IPYTHONDIR", str(tmp_path / "ipython"))
    read = nbformat.read(notebook, as_version=4)
    code = [cell for cell in read.cells if cell.cell_type == "code"]

    def shown() -> list[set[str]]:
        """The kinds of outputs of each cell, without warnings."""
        outputs = ([own for own in cell.outputs if own.get("name") != "stderr"] for cell in code)
        return [{kind for own in of_cell for kind in own.get("data", ["text"])} for of_cell in outputs]

    # Notebooks are stored with their outputs, which have pictures.
    stored = shown()
    assert any(kind.startswith("image/") for kinds in stored for kind in kinds)
    assert notebook.stat().st_size < 200_000
    client = nbclient.NotebookClient(
        read, timeout=120, resources={"metadata": {"path": str(tmp_path)}}
    )
    client.execute()
    assert shown() == stored
    if notebook.stem == "first_robot":
        assert any("text/html" in kinds for kinds in stored)


def test_the_script_runs() -> None:
    script = EXAMPLES / "first_robot.py"
    done = subprocess.run([sys.executable, script], capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("<Run stability, seed 1: 0.0")


def test_a_policy_of_your_own_learns_to_walk() -> None:
    pytest.importorskip("jax")
    # Fewer iterations and a shorter walk than by default.
    command = [sys.executable, EXAMPLES / "own_policy.py", *"0 60 32".split()]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    # With random weights, the robot barely moves. XLA may sum in another order elsewhere, so the number is not exact.
    assert float(done.stdout.split()[2]) > 0.1, done.stdout


def test_an_environment_of_jax_is_the_simulator(monkeypatch: pytest.MonkeyPatch) -> None:
    jax = pytest.importorskip("jax")
    assert len((EXAMPLES / "jax_env.py").read_text().splitlines()) <= 40
    monkeypatch.syspath_prepend(EXAMPLES)
    own = importlib.import_module("jax_env")
    keys = jax.random.split(jax.random.key(1), 3)
    state = jax.vmap(own.reset)(keys)
    actions = np.random.default_rng(0).uniform(-1.0, 1.0, (3, len(own.SIM.edges)))
    seen, (reward, over) = jax.jit(jax.vmap(own.step))(state, (actions, keys))
    expected = own.SIM.step(own.REST.z, state.x, state.v, np.float32(actions), own.HELD, physics={"physics.gravity": state.gravity})
    # JAX computes in single precision here, and so does not NumPy. The robot is 0.5 m wide.
    np.testing.assert_allclose(seen.x, expected.x, atol=1e-4)
    moved = (seen.x - state.x)[:, own.SIM.payload, 0]
    assert np.array_equal(reward, moved) and not over.any() and (seen.frames == 1).all()
    _, (_, over) = own.step(jax.tree.map(lambda own: own[0], state)._replace(frames=own.FRAMES - 1), (actions[0], keys[0]))
    assert over


#: Short runs of `one_policy.py` and `evolve.py` on a small lattice. The arguments are a folder and those of the example.
POLICIES = """import sys

import one_policy

one_policy.SCENE.update({"lattice": {"columns": 3, "rows": 3}, "physics.steps": 256, "controller": {"hidden": 8}})
one_policy.SPACE["lattice"]["rows"] = 2
is_in_space = "--space" in sys.argv
one_policy.BATCH, one_policy.EVERY, one_policy.RATE = 16, 64, 0.01
import evolve
import numpy as np

folder, is_evolution = sys.argv.pop(1), sys.argv.pop(1) == "evolve"
for settings in (evolve.SETTINGS, evolve.FIXED):
    settings.update({"schedule.horizon": [128, 256], "loss.window": 64})
if is_evolution:
    sys.argv.append(folder)
    evolve.main()
    sys.exit()
sys.argv += ["--out", folder]
one_policy.main()
sim, _ = one_policy.worlds("mlp", space=is_in_space)
unseen = one_policy.bodies(sim, np.random.default_rng(1), 100)
start = one_policy.placed(sim, np.random.default_rng(2), unseen, one_policy.LOST)
# Rounded numbers of motors: a quarter of each robot's are lost.
lost = (start.strain == 0.0).sum(1)
assert np.array_equal(lost, np.round(0.25 * unseen[..., 2].sum(1))) and lost.min() > 0
assert not np.any((start.strain == 0.0) & (unseen[..., 2] == 0.0))
for weights in (one_policy.begin(sim, 0), dict(np.load(folder + "/mlp.npz"))):
    start = one_policy.placed(sim, np.random.default_rng(2), unseen)
    print("distance", one_policy.walked(sim, one_policy.controller(weights, unseen), start).mean())
"""


@pytest.mark.parametrize("space", [[], ["--space"]], ids=["plane", "space"])
def test_one_policy_controls_robots_that_it_has_not_seen_and_evolution_uses_it(space: list[str], tmp_path: Path) -> None:
    pytest.importorskip("jax")
    pytest.importorskip("optax")
    printed = []
    for arguments in (["one_policy", "--updates", "40", "--own", "8"], ["evolve", "--seeds", "3", "--iterations", "40"]):
        command = [sys.executable, "-c", POLICIES, tmp_path / "out", *arguments, *space]
        done = subprocess.run(command, capture_output=True, text=True, timeout=300, cwd=EXAMPLES)
        assert done.returncode == 0, done.stderr
        printed.append(done.stdout)
    untrained, trained = map(float, re.findall(r"distance (\S+)", printed[0]))
    assert trained > 2.0 * untrained, printed[0]
    closed, opened = (
        [float(cell.split()[0]) for cell in row.split("|")[1:-1]] for row in re.findall(r"loop (\|.*)", printed[0])
    )
    assert len(closed) == len(opened) == 7 and closed[1] > 0.0, printed[0]
    rows = {name: row.split("|") for name, row in re.findall(r"^\| (\w+) \|(.*)", printed[1], re.MULTILINE)}
    assert list(rows) == ["optimize", "evolved", "refined"], printed[1]
    seconds, distances = ({name: float(row[k]) for name, row in rows.items()} for k in (0, 1))
    # An evolution ends with the generation in which its seconds are spent.
    assert max(seconds.values()) < 3.0 * min(seconds.values()) + 0.3, printed[1]
    # The best of many robots walks farther than a robot on average.
    assert distances["evolved"] > 2.0 * closed[1], printed


#: Losses with types. Only the last line is wrong.
LOSSES = """from typing import Any

import cosmic.{module}


@cosmic.{module}.loss(observed=4)
def high(x: Any, v: Any, *, power: Any) -> Any:
    return x.sum()


direct: cosmic.Loss = cosmic.{module}.loss(lambda x, v: x.sum())
steps: list[int] = high.observed(8) + direct.observed(8)
wrong: int = cosmic.{module}.loss(lambda x, v: x.sum())
"""


@pytest.mark.parametrize("space", [[], ["--space"]], ids=["plane", "space"])
def test_identification_finds_the_physics(
    space: list[str], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.syspath_prepend(EXAMPLES)
    identify = importlib.import_module("identify")
    # Half of the steps, which are 11 windows.
    scene = {**identify.SCENE, "physics": {**identify.SCENE["physics"], "steps": 512}}
    monkeypatch.setattr(identify, "SCENE", scene)
    monkeypatch.setattr(sys, "argv", ["identify.py", *space])
    identify.main()
    printed = capsys.readouterr().out
    found = [tuple(map(float, row)) for row in re.findall(r"true (.*), estimate (.*) ± (.*)", printed)]
    assert len(found) == len(identify.TRUE)
    for true, estimate, margin in found:
        # Four standard deviations. The scene's values are wrong by 5 % to 27 % of the true ones.
        assert abs(estimate - true) < 2.0 * margin
        assert margin < 0.2 * true
    *_, uncorrected, corrected = ([float(x) for x in re.findall(r"\d+\.\d", line)] for line in printed.splitlines())
    assert corrected[-1] < 0.3 * uncorrected[-1]


@pytest.fixture(scope="module")
def sources(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with copies of the installed package and the scripts. Type checkers do not check installed packages."""
    folder = tmp_path_factory.mktemp("sources")
    package = Path(cosmic.__file__).parent
    shutil.copytree(package, folder / "cosmic", ignore=shutil.ignore_patterns("*.so", "*.pyc"))
    for script in SCRIPTS:
        shutil.copy(script, folder)
    shutil.copy(EXAMPLES.parent / "pyproject.toml", folder)
    return folder


def test_the_package_passes_pyright(sources: Path) -> None:
    pytest.importorskip("pyright")
    command = [sys.executable, "-m", "pyright", "--pythonpath", sys.executable]
    try:
        started = subprocess.run([*command, "--version"], capture_output=True, text=True, timeout=300)
    except subprocess.TimeoutExpired:
        pytest.skip("pyright cannot download its program")
    if started.returncode != 0:
        pytest.skip(f"pyright does not start: {started.stderr[-200:]}")
    done = subprocess.run([*command, "cosmic", *(script.name for script in SCRIPTS)], capture_output=True, text=True, cwd=sources)
    assert done.returncode == 0, done.stdout + done.stderr
    (sources / "wrong.py").write_text("import cosmic\n\ncosmic.optimize(seed='one')\n")
    wrong = subprocess.run([*command, "wrong.py"], capture_output=True, text=True, cwd=sources)
    assert wrong.returncode == 1 and "wrong.py:3" in wrong.stdout, wrong.stdout


def test_the_package_passes_mypy(sources: Path) -> None:
    pytest.importorskip("mypy")
    command = [sys.executable, "-m", "mypy", "--config-file", "pyproject.toml", "--cache-dir", "cache"]
    done = subprocess.run(
        [*command, "cosmic", *(script.name for script in SCRIPTS)], capture_output=True, text=True, cwd=sources
    )
    assert done.returncode == 0, done.stdout + done.stderr
    # A loss has a type, as a call and as a decorator.
    for module in ("jax", "torch"):
        (sources / "losses.py").write_text(LOSSES.format(module=module))
        losses = subprocess.run([*command, "losses.py"], capture_output=True, text=True, cwd=sources)
        assert "losses.py:13" in losses.stdout and "Found 1 error" in losses.stdout, losses.stdout
    # A file with a wrong type is found: the types of the package are known to its users.
    calls = ["optimize(seed='one')", "optimize(loss=3)", "Simulator('cube', 'lay out')", "gym.WalkEnv(observation='raw')"]
    (sources / "wrong.py").write_text("import cosmic\n\n" + "".join(f"cosmic.{call}\n" for call in calls))
    wrong = subprocess.run([*command, "wrong.py"], capture_output=True, text=True, cwd=sources)
    assert re.findall(r"wrong.py:(\d+): error", wrong.stdout) == ["3", "4", "5", "6"], wrong.stdout
    # The examples of the page are right.
    blocks = re.findall(r"^```python\n(.*?)^```", PAGE.read_text(), re.DOTALL | re.MULTILINE)
    (sources / "page.py").write_text("\n".join(blocks))
    (sources / "usual.toml").write_text("[tool.mypy]\nignore_missing_imports = true\ncheck_untyped_defs = true\n")
    usual = [sys.executable, "-m", "mypy", "--config-file", "usual.toml", "--cache-dir", "usual", "--follow-imports=silent"]
    right = subprocess.run([*usual, "page.py"], capture_output=True, text=True, cwd=sources)
    assert right.returncode == 0, right.stdout
