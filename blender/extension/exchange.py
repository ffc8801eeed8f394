"""Scenes for the program `taffeta` and runs from it."""

import json
import math
from pathlib import Path

import bpy
import numpy as np

from . import bake, caches, describe, files, roles, sample, space
from .refused import Refused


class TAFFETA_OT_export_scene(bpy.types.Operator):
    """Writes the scene as a folder for `taffeta run`: scene.toml, meshes and poses. It gives the same result as a bake"""

    bl_idname = "taffeta.export_scene"
    bl_label = "Export Scene"

    directory: bpy.props.StringProperty(subtype="DIR_PATH")

    def invoke(self, context, _event):
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context):
        # In a folder of its own: files of the user may have the same names.
        folder = Path(bpy.path.abspath(self.directory)) / files.plain_names([context.scene.name])[context.scene.name]
        try:
            for _ in bake.Bake(context, folder=folder).describe():
                pass
        except Refused as error:
            self.report({"ERROR"}, f"{error.name}: {error}" if error.name else str(error))
            return {"CANCELLED"}
        except OSError as error:
            self.report({"ERROR"}, f"the scene cannot be written into {folder}: {error.strerror}; choose another folder")
            return {"CANCELLED"}
        self.report({"INFO"}, f"the scene is in {folder}: taffeta run scene.toml --format pc2")
        return {"FINISHED"}


class TAFFETA_OT_import_run(bpy.types.Operator):
    """Shows the frames of a run of `taffeta run --format pc2` on the objects that its bodies are named after"""

    bl_idname = "taffeta.import_run"
    bl_label = "Import Run"
    bl_options = {"REGISTER", "UNDO"}

    directory: bpy.props.StringProperty(subtype="DIR_PATH")

    def invoke(self, context, _event):
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context):
        try:
            shown, left_out = show_run(context, Path(bpy.path.abspath(self.directory)))
        except Refused as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        except (KeyError, TypeError, ValueError) as error:
            self.report({"ERROR"}, f"{self.directory} has no whole run of taffeta: {error!r}")
            return {"CANCELLED"}
        if left_out:
            self.report({"WARNING"}, f"no objects are named {', '.join(left_out)}: they are left out")
        self.report({"INFO"}, f"{', '.join(shown)}: shown")
        return {"FINISHED"}


def show_run(context, folder):
    """Gives objects caches of a run; returns the names of objects that show one, and of bodies that have none."""
    try:
        summary = json.loads((folder / "summary.json").read_text("utf-8"))
    except (OSError, ValueError) as error:
        raise Refused(f"{folder} has no summary.json of a run: {error}") from error
    dt = describe.time_of(context.scene)["dt"]
    if not math.isclose(summary["dt"], dt, rel_tol=1e-3):
        raise Refused(f"the run has {1 / summary['dt']:.3g} frames a second, and the scene {1 / dt:.3g}; the same rate would do (Output tab)")
    found, left_out = [], []
    of_plain = by_plain_name(context.scene)
    for body in summary["bodies"]:
        one = of_plain.get(body["name"])
        if one is not None:
            found.append((one, frames_of(folder, summary, body)))
        elif not body["name"].endswith(describe.PULLING):
            left_out.append(body["name"])
    if not found:
        raise Refused(f"no object of this scene is named as a body of the run: {', '.join(left_out)}")
    for one, path in convert(context, found):
        caches.show(one, path, context.scene.frame_start)
    return [one.name for one, _ in found], left_out


def by_plain_name(scene):
    """Objects by what scenes call them: those that take part, and by their own names all."""
    meshes = {one.name_full: one for one in scene.objects if one.type == "MESH"}
    taking_part = [one.name_full for one in roles.simulated(scene)]
    plain = {called: meshes[name] for names in (sorted(meshes), taking_part) for name, called in files.plain_names(names).items()}
    return {**plain, **{one.name: one for one in meshes.values() if one.name not in plain}}


def frames_of(folder, summary, body):
    """Places of a body's vertices in all frames [frames, vertices, 3] [m]."""
    names = [name for name in summary["files"] if name.endswith(".pc2")]
    index = [one["name"] for one in summary["bodies"]].index(body["name"])
    if len(names) != len(summary["bodies"]):
        raise Refused(f"{folder} has no frames in PC2; run with --format pc2")
    data = (folder / names[index]).read_bytes()
    points, samples = files.read_header(data)
    return np.frombuffer(data, "<f4", 3 * points * samples, files.HEADER.size).reshape(samples, points, 3)


def convert(context, found):
    """Writes frames in the coordinates of objects, and returns their files. Nothing is changed where one does not fit."""
    scene, bodies = context.scene, [one for one, _ in found]
    now, subframe = scene.frame_current, scene.frame_subframe
    folder, plain = caches.folder_of(scene), files.plain_names([one.name_full for one in bodies])
    folder.mkdir(parents=True, exist_ok=True)
    done = []
    with sample.up_to_the_cache(context, bodies) as go_to:
        try:
            for one, frames in found:
                path = folder / f"{plain[one.name_full]}.pc2"
                convert_one(context, go_to, (one, frames), path.with_suffix(".part"))
                done.append((one, path))
        finally:
            go_to(now, subframe)
    for _, path in done:
        path.with_suffix(".part").replace(path)
    return done


def convert_one(context, go_to, both, path):
    (one, frames), scene = both, context.scene
    with open(path, "wb") as file:
        file.write(files.header(frames.shape[1], len(frames)))
        for frame, points in enumerate(frames):
            go_to(scene.frame_start + frame)
            copy, mesh = sample.evaluated(one, context.evaluated_depsgraph_get())
            count = len(mesh.vertices)
            copy.to_mesh_clear()
            if count != len(points):
                raise Refused(f"{one.name} has {count} vertices, and the body of the run {len(points)}; the same mesh would do")
            local = space.to_object(points, copy.matrix_world, space.unit(scene))
            file.write(np.ascontiguousarray(local, "<f4").tobytes())


CLASSES = (TAFFETA_OT_export_scene, TAFFETA_OT_import_run)


def register():
    for one in CLASSES:
        bpy.utils.register_class(one)


def unregister():
    for one in reversed(CLASSES):
        bpy.utils.unregister_class(one)
