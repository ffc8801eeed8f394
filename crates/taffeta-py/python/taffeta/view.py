"""Pictures of a simulation, by pyvista or rerun. They need ``pip install taffeta[view]``."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from taffeta._native import Simulation


def pyvista(simulation: Simulation, plotter: Any = None) -> Any:
    """Draws the bodies with pyvista, a mesh for each, named as the body.

    Args:
        simulation: What is drawn.
        plotter: A ``pyvista.Plotter``, or one that this has returned: its meshes go to where the bodies are now. A new one if it is
            not given. If nobody has set its camera, it comes to see all bodies, with y up.

    Returns:
        The plotter. ``plotter.show()`` opens a window, ``plotter.screenshot("cloth.png")`` writes a picture.
    """
    pv: Any = import_module("pyvista")

    if plotter is None:
        plotter = pv.Plotter()
    for name in simulation.bodies:
        points = simulation.positions(name)
        actor = plotter.actors.get(name)
        if actor is not None:
            actor.mapper.dataset.points = points
            continue
        faces = simulation.faces(name)
        if len(faces):
            mesh = pv.PolyData.from_regular_faces(points, faces.astype(np.int64))
        else:
            mesh = pv.lines_from_points(points)
        plotter.add_mesh(mesh, name=name, color="lightsteelblue", smooth_shading=False)
    if not plotter.camera_set:
        # Y is up, and all bodies are seen.
        plotter.view_vector((2.0, 1.5, 3.0), viewup=(0.0, 1.0, 0.0))
    return plotter


def rerun(simulation: Simulation, path: str = "taffeta") -> None:
    """Logs the bodies with rerun at the frame where the simulation is, each as an entity below ``path``.

    Call ``rerun.init("cloth", spawn=True)`` once before, and this after each step.
    """
    rr: Any = import_module("rerun")

    rr.set_time("frame", sequence=simulation.frame)
    rr.set_time("time", duration=simulation.time)
    rr.log(path, rr.ViewCoordinates.RIGHT_HAND_Y_UP, static=True)
    for name in simulation.bodies:
        points, faces = simulation.positions(name), simulation.faces(name)
        if len(faces):
            normals = simulation.normals(name)
            rr.log(
                f"{path}/{name}", rr.Mesh3D(vertex_positions=points, triangle_indices=faces, vertex_normals=normals)
            )
        else:
            rr.log(f"{path}/{name}", rr.LineStrips3D([points]))
