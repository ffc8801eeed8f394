"""What tests share: the repository, its scenes, the program, and a small cloth."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest
import taffeta

ROOT = Path(__file__).resolve().parents[3]


@pytest.fixture(scope="session")
def scenes() -> Path:
    """The folder of scenes."""
    return ROOT / "scenes"


@pytest.fixture(scope="session")
def program() -> str:
    """The program `taffeta` that was built with the package."""
    path = os.environ.get("TAFFETA_PROGRAM")
    if path is None:
        pytest.skip("TAFFETA_PROGRAM names no program to compare with")
    return path


@pytest.fixture
def cloth() -> taffeta.Scene:
    """A cloth of cotton that hangs by a row, solved for implicitly."""
    scene = taffeta.Scene().solver("ice", form="primal")
    return scene.grid("cloth", rows=8, cols=8, size=(1.0, 1.0), material="cotton").pin("cloth", rows=0)


@pytest.fixture
def simulation(cloth: taffeta.Scene) -> taffeta.Simulation:
    """It runs on one thread."""
    return taffeta.Simulation(cloth, threads=1)


@pytest.fixture(autouse=True)
def heard() -> Iterator[None]:
    """Programs that are started in the background have Ctrl-C ignored, and Python leaves it so."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)
