"""OBJ and PLY by trimesh."""

import warnings

import numpy as np


def check_trimesh(run):
    import trimesh

    for ending in [".obj", ".ply"]:
        for path, (name, part) in zip(run.names(ending), run.bodies, strict=True):
            kind, final = ending[1:].upper(), run.positions[-1, part]
            try:
                with warnings.catch_warnings(action="ignore"):
                    places = trimesh.load(path, process=False, maintain_order=True).vertices
            except ValueError as error:
                # Its reader of binary PLY takes the first face's corners for those of all.
                if "unexpected length" not in str(error):
                    raise
                print(f"skipped {kind} {name} by trimesh, which reads PLY with faces of one size only")
                continue
            if len(places) != len(final):
                # Of an OBJ it leaves out vertices of no face; those at seams of a texture it copies.
                kept = used(path) if ending == ".obj" else slice(None)
                places, final = (different(rows) for rows in (places, final[kept]))
            run.compare(f"{kind} {name} by trimesh", [(places, final)])


def used(path):
    """Vertices of an OBJ file that a face or line has."""
    lines = (line.split() for line in path.read_text().splitlines())
    corners = [corner for line in lines if line and line[0] in "fl" for corner in line[1:]]
    return np.unique([int(corner.split("/")[0]) - 1 for corner in corners])


def different(rows):
    """The different places among rows, in 32 bits as trimesh may have them, in order."""
    return np.unique(np.asarray(rows, dtype=np.float32), axis=0)
