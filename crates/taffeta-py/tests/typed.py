"""What a program with types looks like. It is checked by mypy and pyright, and never run."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import taffeta
from numpy.typing import NDArray

if TYPE_CHECKING:
    from typing_extensions import assert_type


def use() -> None:
    """Arrays keep their type, options are known by name, and reports are dicts."""
    scene = taffeta.Scene().grid("cloth", rows=8, cols=8, size=(1.0, 1.0), material="cotton", position=(0, 1, 0))
    scene.pin("cloth", rows=0, movable=True).sphere("ball", radius=0.2, friction=0.4)
    scene.mesh("patch", np.zeros((3, 3)), [[0, 1, 2]], density=1.0)
    simulation = taffeta.Simulation(scene, backend="cpu", threads=2, precision="f64")
    assert_type(simulation.step(3), dict[str, Any])
    out = np.zeros((64, 3), np.float32)
    assert_type(simulation.positions("cloth", out=out), NDArray[np.float32])
    assert_type(simulation.positions(), NDArray[np.floating[Any]])
    assert_type(simulation.bodies["cloth"].mass, float)
    simulation.pin("cloth", [0, 1], np.zeros(3))
    simulation.move_collider("ball", taffeta.pose((0, 0, 1), degrees=90.0))
    try:
        simulation.restore(simulation.snapshot())
    except taffeta.SceneError as error:
        assert_type(error.line, int | None)
