"""What the user makes of objects: cloth, a soft body, a collider, or nothing."""

import bpy

from . import bake, caches, roles, settings


def forget(one):
    """Leaves nothing of taffeta on an object."""
    caches.hide(one)
    one.property_unset("taffeta")
    if "taffeta" in one.keys():
        del one["taffeta"]


class TAFFETA_OT_add(bpy.types.Operator):
    """Has selected meshes take part"""

    bl_idname = "taffeta.add"
    bl_label = "Add to Taffeta"
    bl_options = {"REGISTER", "UNDO"}

    role: bpy.props.EnumProperty(name="Role", items=settings.ROLES[1:])

    @classmethod
    def poll(cls, context):
        return context.mode == "OBJECT" and any(one.type == "MESH" for one in context.selected_objects)

    def execute(self, context):
        for one in context.selected_objects:
            if one.type != "MESH":
                continue
            if not one.is_editable:
                self.report({"ERROR"}, f"{one.name} is linked from another file; make a library override of it first")
                return {"CANCELLED"}
            one.taffeta.role = self.role
        return {"FINISHED"}


class TAFFETA_OT_remove(bpy.types.Operator):
    """Leaves nothing of Taffeta on objects: no settings, and no cache. Files of caches stay"""

    bl_idname = "taffeta.remove"
    bl_label = "Remove Taffeta"
    bl_options = {"REGISTER", "UNDO"}

    everywhere: bpy.props.BoolProperty(name="From All Objects", default=False)

    def execute(self, context):
        for one in bpy.data.objects if self.everywhere else context.selected_objects:
            if one.is_editable:
                forget(one)
        if self.everywhere:
            for scene in bpy.data.scenes:
                scene.property_unset("taffeta")
                if "taffeta" in scene.keys():
                    del scene["taffeta"]
        return {"FINISHED"}


class TAFFETA_OT_free(bpy.types.Operator):
    """Deletes the frames that were baked, and has objects show themselves again"""

    bl_idname = "taffeta.free"
    bl_label = "Delete Bake"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, _context):
        return not bake.is_running()

    def execute(self, context):
        folder, freed = caches.folder_of(context.scene), roles.simulated(context.scene, "CLOTH", "SOFT")
        shown_elsewhere = {caches.file_of(one) for one in bpy.data.objects if one not in freed}
        for one in freed:
            path = caches.file_of(one)
            caches.hide(one)
            # Files of another scene or file may be shown there.
            if path is not None and path.parent == folder and path not in shown_elsewhere:
                path.unlink(missing_ok=True)
        for name in bake.LEFT:
            (folder / name).unlink(missing_ok=True)
        context.scene.taffeta.baked = ""
        return {"FINISHED"}


CLASSES = (TAFFETA_OT_add, TAFFETA_OT_remove, TAFFETA_OT_free)


def register():
    for one in CLASSES:
        bpy.utils.register_class(one)


def unregister():
    for one in reversed(CLASSES):
        bpy.utils.unregister_class(one)
