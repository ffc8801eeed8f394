"""Blender, without its window, by the Python module bpy."""

import contextlib
import os
import re

import numpy as np

from check_outputs import gltf
from check_outputs.obj_ply import used

# As positions are in the files: no turn of the axes on the way in.
AXES = {"forward_axis": "Y", "up_axis": "Z"}


@contextlib.contextmanager
def quiet():
    """Without what Blender's importers print."""
    kept, nowhere = os.dup(1), os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    try:
        yield
    finally:
        os.dup2(kept, 1)
        os.close(kept)
        os.close(nowhere)


def objects_of(importer, path, **options):
    """What a file becomes in an empty scene."""
    import bpy

    bpy.ops.wm.read_factory_settings(use_empty=True)
    with quiet():
        importer(filepath=str(path), **options)
    return {thing.name: thing for thing in bpy.context.scene.objects}


def places(thing):
    """Places of an object's points in its own axes, after its modifiers."""
    import bpy

    data = thing.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    flat = np.empty(3 * len(data.attributes["position"].data), dtype=np.float32)
    data.attributes["position"].data.foreach_get("vector", flat)
    return flat.reshape(-1, 3)


def in_the_world(thing):
    """As `places`, in the scene's axes turned back to y up."""
    matrix = np.array(thing.matrix_world)
    x, y, z = (places(thing) @ matrix[:3, :3].T + matrix[:3, 3]).T
    return np.stack([x, z, -y], axis=1)


def check_poses(run):
    import bpy

    for kind, importer in [("OBJ", bpy.ops.wm.obj_import), ("PLY", bpy.ops.wm.ply_import)]:
        for path, (name, part) in zip(run.names("." + kind.lower()), run.bodies, strict=True):
            (thing,) = objects_of(importer, path, **AXES).values()
            final = run.positions[-1, part]
            if kind == "OBJ" and len(places(thing)) < len(final):
                # Blender leaves out vertices of no face.
                final = final[used(path)]
            run.compare(f"{kind} {name} by Blender", [(places(thing), final)])


def check_pc2(run):
    import bpy

    meshes = [(path, bpy.ops.wm.obj_import) for path in run.names(".obj")]
    others = [(path, bpy.ops.wm.ply_import) for path in run.names(".ply")]
    for path, mesh, other, (name, part) in zip(run.names(".pc2"), meshes, others, run.bodies, strict=True):
        (cloth,), base = objects_of(mesh[1], mesh[0], **AXES).values(), "OBJ"
        if len(places(cloth)) != part.stop - part.start:
            # The cache needs all vertices, also those of no face, which only PLY brings along.
            (cloth,), base = objects_of(other[1], other[0], **AXES).values(), "PLY"
        cache = cloth.modifiers.new("cache", "MESH_CACHE")
        cache.cache_format, cache.filepath = "PC2", str(path)
        cache.forward_axis, cache.up_axis, cache.frame_start = "POS_Y", "POS_Z", 0
        poses = ((at_frame(frame, cloth, places), run.positions[frame, part]) for frame in range(len(run.positions)))
        run.compare(f"PC2 {name} by Blender's Mesh Cache on the {base}", poses)


def at_frame(frame, thing, read):
    import bpy

    bpy.context.scene.frame_set(frame)
    return read(thing)


def check_glb(run):
    import bpy

    (path,) = run.names(".glb")
    read = list(gltf.geometries(run))
    things = objects_of(bpy.ops.import_scene.gltf, path, loglevel=50)
    textures = {}
    for (name, part), (geometry, vertices) in zip(run.bodies, read):
        thing, final = things[name], run.positions[-1, part]
        if len(vertices) > len(places(thing)):
            # Blender leaves out vertices of no face.
            vertices = vertices[np.unique(geometry.faces)]
        run.compare(f"GLB {name} by Blender", [(in_the_world(thing), final[vertices])])
        textures[name] = corner_uvs(thing, vertices)
    for path, (name, _) in zip(run.names(".obj"), run.bodies, strict=True):
        (thing,) = objects_of(bpy.ops.wm.obj_import, path, **AXES).values()
        expected = corner_uvs(thing, used(path) if used(path)[-1] >= len(places(thing)) else None)
        if not (expected or textures[name]):
            continue
        what = f"GLB {name}: texture as Blender has it from the OBJ, places: {len(expected)}"
        run.demand(what, textures[name] == expected, f"{len(textures[name] - expected)} differ")


def corner_uvs(thing, vertices=None):
    """Texture coordinates at each of the file's vertices [1e-4]; `vertices` are those of the object."""
    if thing.data.uv_layers.active is None:
        return set()
    vertices = np.arange(len(thing.data.vertices)) if vertices is None else vertices
    uvs = np.array([corner.uv for corner in thing.data.uv_layers.active.data])
    # A quarter off, so that round numbers do not fall on a border.
    keys = np.floor(uvs * 1e4 + 0.25).astype(int)
    return {(int(vertices[loop.vertex_index]), *key) for loop, key in zip(thing.data.loops, keys.tolist())}


def check_usd(run):
    import bpy

    (path,) = run.names(".usda")
    prims = re.findall(r'def (?:Mesh|BasisCurves) "(\w+)"', path.read_text())
    things = objects_of(bpy.ops.wm.usd_import, path)
    for prim, (name, part) in zip(prims, run.bodies, strict=True):
        thing = things[prim]
        frames = range(len(run.positions))
        poses = ((at_frame(frame, thing, in_the_world), run.positions[frame, part]) for frame in frames)
        run.compare(f"USD {name} by Blender", poses)
