"""PVD and VTU by pyvista (VTK's own readers, as in ParaView) and meshio."""

import xml.etree.ElementTree

import numpy as np

from check_outputs.run import counted


def check_pyvista(run):
    import pyvista

    (path,) = run.names(".pvd")
    reader = pyvista.get_reader(str(path))
    times = np.array(run.times())
    same = len(reader.time_values) == len(times) and np.abs(reader.time_values - times).max() < 1e-12
    run.demand(f"PVD: {counted(len(reader.time_values), 'time')}", same, "not those of frames.csv")
    frames = []
    for time in range(reader.number_time_points):
        reader.set_active_time_point(time)
        blocks = reader.read()
        frames.append([blocks[part] for part in range(len(blocks))])
    for body, (name, part) in enumerate(run.bodies):
        grids = [grids[body] for grids in frames]
        # Binary and in the run's own precision: nothing may differ.
        poses = ((grid.points, run.positions[frame, part]) for frame, grid in enumerate(grids))
        run.compare(f"VTU {name} by pyvista", poses, 0.0)
        precise = all(grid.points.dtype == run.stored.dtype for grid in grids)
        run.demand(f"VTU {name}: {run.stored.dtype}", precise, f"{grids[0].points.dtype}")
        same = np.array_equal([grid.field_data["TimeValue"][0] for grid in grids], reader.time_values)
        run.demand(f"VTU {name}: times in the files", same, "not those of the PVD")
        kinds = ", ".join(f"{count} {kind.name}" for kind, count in sorted(kinds_of(pyvista, grids[-1]).items()))
        run.demand(f"VTU {name}: {kinds}", grids[-1].n_cells > 0, "no cells")


def kinds_of(pyvista, grid):
    kinds, counts = np.unique(grid.celltypes, return_counts=True)
    return {pyvista.CellType(kind): count for kind, count in zip(kinds, counts)}


def check_meshio(run):
    import meshio

    (path,) = run.names(".pvd")
    sets = xml.etree.ElementTree.parse(path).getroot().findall("Collection/DataSet")
    last = sets[-len(run.bodies) :]
    for entry, (name, part) in zip(last, run.bodies, strict=True):
        points = meshio.read(path.parent / entry.get("file")).points
        run.compare(f"VTU {name} by meshio", [(points, run.positions[-1, part])], 0.0)
