"""Opens a run's outputs with programs that are not ours, and compares every position with positions.npy.

    python3.11 -m venv venv                                                    (bpy 5.0 needs Python 3.11)
    venv/bin/pip install numpy scipy usd-core bpy==5.0.1 pyvista meshio trimesh
    npm install --prefix venv gltf-validator
    taffeta run scenes/drape.toml --out out/drape --format npy,pc2,usda,ply,obj,vtu,glb
    venv/bin/python scripts/check_outputs.py out/drape

USD is opened by usd-core, with all its validators, and Blender; PC2 by Blender's Mesh Cache modifier; OBJ and PLY by
Blender and trimesh; GLB by Khronos' validator, trimesh and Blender; PVD and VTU by pyvista, which is VTK as ParaView
is, and meshio. What is not installed or not in the run is said and skipped. Exit status 1 if anything differs.
"""

import pathlib
import sys

from check_outputs import blender, gltf, obj_ply, usd, vtk
from check_outputs.run import Run


def main():
    if len(sys.argv) != 2:
        sys.exit(f"usage: {sys.argv[0]} FOLDER_OF_A_RUN")
    run = Run(pathlib.Path(sys.argv[1]).resolve())
    checks = [
        usd.check_usd,
        vtk.check_pyvista,
        vtk.check_meshio,
        gltf.check_validator,
        gltf.check_trimesh,
        obj_ply.check_trimesh,
        blender.check_poses,
        blender.check_pc2,
        blender.check_glb,
        blender.check_usd,
    ]
    for check in checks:
        name = f"{check.__module__.split('.')[-1]}.{check.__name__}"
        try:
            check(run)
        except (ImportError, FileNotFoundError) as missing:
            print(f"skipped {name}: {missing}", flush=True)
        # Whatever a program raises, it could not read the file.
        except Exception as error:
            run.demand(name, False, f"{type(error).__name__}: {error}")
    print(f"{run.failures} of {run.comparisons} comparisons failed")
    sys.exit(1 if run.failures or not run.comparisons else 0)


if __name__ == "__main__":
    main()
