"""Opens a run's outputs with programs that are not ours, and compares every position with positions.npy.

    python3 -m venv venv && venv/bin/pip install numpy usd-core bpy==5.0.1      (bpy needs Python 3.11)
    taffeta run scenes/drape.toml --out out/drape --format npy,pc2,usda,ply,obj
    venv/bin/python scripts/check_outputs.py out/drape

USD is opened by usd-core, with all its validators; PC2 by Blender's Mesh Cache modifier on the OBJ; OBJ and PLY by
Blender. What is not installed is said and skipped. Exit status 1 if anything differs.
"""

import json
import pathlib
import sys

import numpy as np


def ranges(out):
    """Vertices of each body in positions.npy."""
    first = 0
    for body in json.loads((out / "summary.json").read_text())["bodies"]:
        yield body["name"], slice(first, first + body["vertices"])
        first += body["vertices"]


def report(what, error, limit):
    print(f"{'ok  ' if error <= limit else 'FAIL'} {what}: largest difference {error:.3g} m (limit {limit:.3g})")
    return error <= limit


def check_usd(out, positions, limit):
    from pxr import Usd, UsdGeom, UsdValidation

    stage = Usd.Stage.Open(str(out / "scene.usda"))
    errors = UsdValidation.ValidationContext(UsdValidation.ValidationRegistry().GetOrLoadAllValidators()).Validate(stage)
    print(f"{'ok  ' if not errors else 'FAIL'} USD validators: {len(errors)} errors", *(e.GetMessage() for e in errors))
    good = not errors
    prims = [p for p in stage.Traverse() if p.IsA(UsdGeom.PointBased)]
    for prim, (name, part) in zip(prims, ranges(out), strict=True):
        points = UsdGeom.PointBased(prim).GetPointsAttr()
        error = max(
            float(np.abs(np.array(points.Get(t)) - positions[frame, part]).max())
            for frame, t in enumerate(points.GetTimeSamples())
        )
        good &= len(points.GetTimeSamples()) == len(positions)
        good &= report(f"USD {name}, {len(points.GetTimeSamples())} frames", error, limit)
    return good


def blender_positions(obj):
    import bpy

    mesh = obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).to_mesh()
    flat = np.empty(3 * len(mesh.vertices), dtype=np.float32)
    mesh.vertices.foreach_get("co", flat)
    return flat.reshape(-1, 3)


def check_blender(out, positions, limit):
    import bpy

    good = True
    for name, part in ranges(out):
        bpy.ops.wm.read_factory_settings(use_empty=True)
        final = positions[-1, part]
        if (out / f"{name}.ply").exists():
            bpy.ops.wm.ply_import(filepath=str(out / f"{name}.ply"), forward_axis="Y", up_axis="Z")
            good &= report(f"PLY {name}", np.abs(blender_positions(bpy.context.object) - final).max(), limit)
        if not (out / f"{name}.obj").exists():
            continue
        bpy.ops.wm.obj_import(filepath=str(out / f"{name}.obj"), forward_axis="Y", up_axis="Z")
        cloth = bpy.context.object
        good &= report(f"OBJ {name}", np.abs(blender_positions(cloth) - final).max(), limit)
        if (out / f"{name}.pc2").exists():
            cache = cloth.modifiers.new("cache", "MESH_CACHE")
            cache.cache_format = "PC2"
            cache.filepath = str(out / f"{name}.pc2")
            cache.forward_axis, cache.up_axis = "POS_Y", "POS_Z"
            cache.frame_start = 0
            error = 0.0
            for frame in range(len(positions)):
                bpy.context.scene.frame_set(frame)
                error = max(error, np.abs(blender_positions(cloth) - positions[frame, part]).max())
            good &= report(f"PC2 {name} by Mesh Cache, {len(positions)} frames", error, limit)
    return good


def main():
    out = pathlib.Path(sys.argv[1]).resolve()
    positions = np.load(out / "positions.npy").astype(np.float64)
    limit = 1e-6 * max(1.0, np.abs(positions).max())
    good = True
    for check in (check_usd, check_blender):
        try:
            good &= check(out, positions, limit)
        except ImportError as missing:
            print(f"skipped {check.__name__}: {missing}")
    sys.exit(0 if good else 1)


if __name__ == "__main__":
    main()
