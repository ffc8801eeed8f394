"""The animation, sampled: where objects and their vertices are in each frame."""

from contextlib import contextmanager
from dataclasses import dataclass, field

import numpy as np

from . import caches, files, space
from .refused import Refused


@dataclass
class Sampled:
    """An object as it was sampled."""

    name: str
    points: np.ndarray  # at the start, in the engine's world [m]
    faces: list
    uvs: np.ndarray | None = None
    weights: dict = field(default_factory=dict)  # of the vertex group, by vertex
    loose: list = field(default_factory=list)  # edges without faces
    rest: np.ndarray | None = None
    matrices: list = field(default_factory=list)  # one for each frame
    poses: files.Poses | None = None


@contextmanager
def up_to_the_cache(context, objects):
    """Has objects evaluated up to where their cache is in the stack of modifiers: what comes after it acts on the cache. Gives a function
    that goes to a frame."""
    hidden = []

    def hide():
        shown = [modifier for one in objects for modifier in list(one.modifiers)[caches.place(one) :] if modifier.show_viewport]
        for modifier in shown:
            hidden.append(modifier)
            modifier.show_viewport = False
        return bool(shown)

    def go_to(frame, subframe=0.0):
        context.scene.frame_set(frame, subframe=subframe)
        # Where that is animated the frame has shown it again.
        if hide():
            context.view_layer.update()

    try:
        hide()
        yield go_to
    finally:
        for modifier in hidden:
            modifier.show_viewport = True


def evaluated(one, depsgraph):
    """The evaluated object and its mesh; `to_mesh_clear` gives it back."""
    result = one.evaluated_get(depsgraph)
    return result, result.to_mesh()


def coordinates(mesh):
    points = np.empty(3 * len(mesh.vertices), np.float32)
    mesh.vertices.foreach_get("co", points)
    return points.reshape(-1, 3)


def faces_of(mesh):
    """Faces as lists of vertices."""
    corners = np.empty(len(mesh.loops), np.int32)
    mesh.loops.foreach_get("vertex_index", corners)
    starts = np.empty(len(mesh.polygons), np.int32)
    mesh.polygons.foreach_get("loop_start", starts)
    if len(starts) == 0:
        return []
    sizes = np.diff(starts, append=len(corners))
    if (sizes == sizes[0]).all():
        return corners.reshape(-1, sizes[0]).tolist()
    corners, ends = corners.tolist(), (starts + sizes).tolist()
    return [corners[start:end] for start, end in zip(starts.tolist(), ends, strict=True)]


def uvs_of(mesh):
    layer = mesh.uv_layers.active
    if layer is None:
        return None
    uvs = np.empty(2 * len(mesh.loops), np.float32)
    layer.uv.foreach_get("vector", uvs)
    return uvs.reshape(-1, 2)


def weights_of(one, mesh, group):
    """Weights in a vertex group, by vertex, where they are not 0."""
    index = one.vertex_groups[group].index
    all_of = ((vertex.index, member) for vertex in mesh.vertices for member in vertex.groups)
    return {vertex: member.weight for vertex, member in all_of if member.group == index and member.weight > 0}


def loose_edges(mesh):
    edges = np.empty(2 * len(mesh.edges), np.int32)
    mesh.edges.foreach_get("vertices", edges)
    loose = np.empty(len(mesh.edges), bool)
    mesh.edges.foreach_get("is_loose", loose)
    pairs = {tuple(sorted(pair)) for pair in edges.reshape(-1, 2)[loose].tolist()}
    return sorted(pairs)


def first_look(one, depsgraph, metres, folder, plain):
    """An object at the start."""
    kept, result = one.taffeta, Sampled(one.name_full, None, [])
    copy, mesh = evaluated(one, depsgraph)
    try:
        points = coordinates(mesh)
        result.points = space.to_engine(points, copy.matrix_world, metres)
        result.faces = faces_of(mesh)
        if not result.faces:
            raise Refused("has no faces; a mesh with faces would do", one.name_full)
        is_body = kept.role in ("CLOTH", "SOFT")
        if is_body:
            result.uvs = uvs_of(mesh)
            if kept.pin_group:
                result.weights = weights_of(one, mesh, kept.pin_group)
            result.loose = loose_edges(mesh)
            if kept.rest_key:
                result.rest = rest_shape(one, len(points), metres)
        if result.weights or not is_body:
            result.poses = files.Poses(folder / f"{plain}.poses.pc2")
    finally:
        copy.to_mesh_clear()
    return result


def rest_shape(one, count, metres):
    """The places of a shape key, as large as the object is."""
    keys = one.data.shape_keys
    key = keys.key_blocks.get(one.taffeta.rest_key) if keys else None
    if key is None:
        raise Refused(f"has no shape key {one.taffeta.rest_key!r} for its rest shape; choose another one, or none", one.name_full)
    if len(key.data) != count:
        raise Refused(
            f"has a rest shape of {len(key.data)} vertices, and {count} where Taffeta is in the stack of modifiers: one above it adds or "
            "removes vertices; move it below",
            one.name_full,
        )
    points = np.empty(3 * count, np.float32)
    key.data.foreach_get("co", points)
    return space.to_engine(points.reshape(-1, 3), one.matrix_world, metres)


def look(one, sampled, depsgraph, metres, frame):
    """Adds a frame."""
    copy = one.evaluated_get(depsgraph)
    matrix = np.array(copy.matrix_world, np.float64)
    if abs(np.linalg.det(matrix[:3, :3])) < 1e-12:
        raise Refused(f"has a scale of 0 along an axis in frame {frame}; another scale would do", one.name_full)
    sampled.matrices.append(matrix)
    if sampled.poses is None:
        return
    mesh = copy.to_mesh()
    try:
        points = coordinates(mesh)
    finally:
        copy.to_mesh_clear()
    if len(points) != len(sampled.points):
        raise Refused(
            f"has {len(sampled.points)} vertices at the start and {len(points)} in frame {frame}; a mesh that keeps its vertices would "
            "do: look for animated modifiers",
            one.name_full,
        )
    sampled.poses.add(space.to_engine(points, matrix, metres))


def sample(context, objects, folder, plain, note):
    """Samples objects over the frames of the scene: a generator of the fraction that is done, which returns them in their order. `note` is
    called in each frame."""
    scene = context.scene
    metres, first, last = space.unit(scene), scene.frame_start, scene.frame_end
    now, subframe = scene.frame_current, scene.frame_subframe
    bodies = [one for one in objects if one.taffeta.role in ("CLOTH", "SOFT")]
    all_of = []
    with up_to_the_cache(context, bodies) as go_to:
        try:
            for frame in range(first, last + 1):
                go_to(frame)
                note(frame)
                depsgraph = context.evaluated_depsgraph_get()
                for index, one in enumerate(objects):
                    if frame == first:
                        all_of.append(first_look(one, depsgraph, metres, folder, plain[one.name_full]))
                    look(one, all_of[index], depsgraph, metres, frame)
                yield (frame - first + 1) / (last - first + 1)
        finally:
            go_to(now, subframe)
    return all_of
