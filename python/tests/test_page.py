"""The code blocks of docs/python.md run, one after the other."""

from __future__ import annotations

import importlib.util
import re
import shutil
import warnings
from pathlib import Path
from typing import Any

import pytest
from common import why_no_gpu

PAGE = Path(__file__).resolve().parents[2] / "docs/python.md"
#: Packages that a block may need.
PACKAGES = {
    "cosmic.gym": "gymnasium",
    "cosmic.jax": "jax",
    "cosmic.sb3": "stable_baselines3",
    "cosmic.torch": "torch",
}


@pytest.mark.filterwarnings("ignore::UserWarning")
def test_the_page_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    blocks = re.findall(r"^```python\n(.*?)^```", PAGE.read_text(), re.DOTALL | re.MULTILINE)
    missing = [
        module
        for module, package in PACKAGES.items()
        if importlib.util.find_spec(package) is None
    ]
    if why_no_gpu():
        missing.append('device="gpu"')
    names: dict[str, Any] = {}
    with warnings.catch_warnings():
        # The first robot is no example of a mistake.
        warnings.simplefilter("error")
        exec(compile(blocks[0], str(PAGE), "exec"), names)
    shutil.rmtree("walker")
    done = 0
    for block in blocks:
        if not any(module in block for module in missing):
            exec(compile(block, str(PAGE), "exec"), names)
            done += 1
    # The blocks before those of JAX, torch and gymnasium need nothing else.
    assert done >= 4
    assert (tmp_path / "walker/report.html").exists()
