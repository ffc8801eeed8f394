"""Pictures by other packages, where these are installed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import taffeta
from taffeta import view


def test_pyvista_draws_the_bodies_where_they_are(simulation: taffeta.Simulation) -> None:
    pv = pytest.importorskip("pyvista")
    plotter = view.pyvista(simulation, pv.Plotter(off_screen=True))
    mesh = plotter.actors["cloth"].mapper.dataset
    assert mesh.n_cells == 98
    simulation.step(5)
    assert view.pyvista(simulation, plotter) is plotter
    np.testing.assert_array_equal(mesh.points, simulation.positions())
    assert list(plotter.actors) == ["cloth"], "none is drawn twice"


def test_pyvista_sees_all_bodies_with_y_up_unless_its_camera_is_set(simulation: taffeta.Simulation) -> None:
    pv = pytest.importorskip("pyvista")
    plotter = view.pyvista(simulation, pv.Plotter(off_screen=True))
    _, focus, up = plotter.camera_position
    np.testing.assert_allclose(focus, simulation.positions().mean(0), atol=1e-3)
    assert tuple(up) == (0.0, 1.0, 0.0)
    plotter.camera_position = [(0.0, 5.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 1.0)]
    view.pyvista(simulation, plotter)
    assert tuple(plotter.camera_position[2]) == (0.0, 0.0, 1.0)


def test_rerun_logs_the_bodies(simulation: taffeta.Simulation, tmp_path: Path) -> None:
    rr = pytest.importorskip("rerun")
    file = tmp_path / "cloth.rrd"
    rr.init("taffeta_test")
    rr.save(file)
    for _ in range(2):
        view.rerun(simulation)
        simulation.step()
    rr.disconnect()
    assert b"taffeta/cloth" in file.read_bytes() or file.stat().st_size > 2 * 64 * 24
