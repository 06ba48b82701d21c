"""Fixtures for several test files."""

from __future__ import annotations

import os

import cosmic
import pytest
from common import SCENE, SEED, SHORT

# Windows of pygame are not shown. A test machine may have no display.
os.environ.setdefault("SDL_VIDEODRIVER", "dummy")


@pytest.fixture(scope="session")
def sim() -> cosmic.Simulator:
    """A simulator of a lattice with six nodes and eleven edges."""
    return cosmic.Simulator(SHORT)


@pytest.fixture(scope="session")
def run(tmp_path_factory: pytest.TempPathFactory) -> cosmic.Run:
    """A finished run in its own folder."""
    out = tmp_path_factory.mktemp("runs") / "walker"
    return cosmic.optimize(SCENE, SEED, out=out, progress=False)
