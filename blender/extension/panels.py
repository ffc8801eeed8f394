"""What the user sees: the settings of an object in its Physics tab, and the bake beside it and in the sidebar."""

import time

import bpy

from . import bake, caches, roles, settings

WIDTH = 52


def lines_of(text):
    """Words in lines that a panel has room for."""
    for paragraph in text.splitlines():
        line = ""
        for word in paragraph.split():
            if line and len(line) + len(word) >= WIDTH:
                yield line
                line = ""
            line = f"{line} {word}".strip()
        yield line


def say(layout, text, icon="INFO"):
    if text:
        box = layout.box().column(align=True)
        for index, line in enumerate(lines_of(text)):
            box.label(text=line, icon=icon if index == 0 else "BLANK1")


def draw_fabric(layout, kept):
    layout.prop(kept, "fabric")
    layout.prop(kept, "keeps_bends")
    column = layout.column(align=True)
    if kept.fabric == settings.CUSTOM:
        for name in ("density", "stretch", "shear", "bending"):
            column.prop(kept, name)
        return
    fabric = settings.fabrics()[kept.fabric]
    column.label(text=f"{fabric['title']}: {1e3 * fabric['density']:.0f} g/m²")
    warp, weft = fabric["stretch"]
    column.label(text=f"Stretch {warp:g} and {weft:g} N/m, shear {fabric['shear']:g} N/m")
    warp, weft = fabric["bending"]
    column.label(text=f"Bending {1e6 * warp:.3g} and {1e6 * weft:.3g} µN·m along warp and weft")


def draw_soft(layout, kept):
    layout.prop(kept, "mass")
    layout.prop(kept, "stiffness")
    layout.prop(kept, "volume")
    if kept.volume == "KEEP":
        layout.prop(kept, "volume_target")
    elif kept.volume == "PRESSURE":
        layout.prop(kept, "pressure")


def draw_pins(layout, one, kept):
    layout.prop_search(kept, "pin_group", one, "vertex_groups")
    column = layout.column()
    column.active = bool(kept.pin_group)
    column.prop(kept, "pin_stiffness")
    if kept.role == "CLOTH":
        column.prop(kept, "tethers")


class TAFFETA_PT_object(bpy.types.Panel):
    bl_label = "Taffeta"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "physics"

    @classmethod
    def poll(cls, context):
        return context.object is not None and context.object.type == "MESH"

    def draw(self, context):
        layout, one = self.layout, context.object
        layout.use_property_split = True
        layout.use_property_decorate = False
        kept = one.taffeta
        layout.prop(kept, "role")
        if kept.role == "NONE":
            return
        if kept.role == "CLOTH":
            draw_fabric(layout, kept)
        elif kept.role == "SOFT":
            draw_soft(layout, kept)
        layout.separator()
        layout.prop(kept, "thickness", text="Distance (mm)" if kept.role == "COLLIDER" else "Thickness (mm)")
        layout.prop(kept, "friction")
        if kept.role != "COLLIDER":
            layout.prop(kept, "self_contact")
            layout.separator()
            draw_pins(layout, one, kept)
        if kept.role == "CLOTH":
            layout.prop(kept, "sewing")
            if kept.sewing:
                layout.prop(kept, "sewing_time")
            if one.data.shape_keys:
                layout.prop_search(kept, "rest_key", one.data.shape_keys, "key_blocks")
        say(layout, kept.said)
        draw_bake(layout.box(), context)


def state_of(scene):
    """How many frames after the first the scene's caches have, or None, and whether they are of other settings. Panels are drawn often,
    and this looks at files."""
    known = _states.get(scene.name)
    if known is None or time.monotonic() - known[0] > 0.5:
        bodies = roles.simulated(scene, "CLOTH", "SOFT")
        done = [frames for frames in map(caches.frames_of, bodies) if frames is not None]
        is_old = bool(done and scene.taffeta.baked) and scene.taffeta.baked != bake.fingerprint(scene)
        known = _states[scene.name] = (time.monotonic(), min(done, default=None), is_old)
    return known[1:]


_states = {}


def draw_bake(layout, context):
    """Progress of the bake that runs, or what starts one."""
    scene = context.scene
    if bake.running is not None:
        now = bake.running.bake
        text = f"Frame {now.first + now.done} of {now.first + now.frames}" if now.frames else "Animation"
        layout.progress(factor=now.done / max(now.frames, 1), text=text)
        layout.operator("taffeta.stop")
        return
    kept = scene.taffeta
    row = layout.row(align=True)
    row.operator("taffeta.bake", icon="PHYSICS")
    row.operator("taffeta.bake", text="Bake and Play", icon="PLAY").plays = True
    frames, is_old = state_of(scene)
    if frames is not None:
        wanted = scene.frame_end - scene.frame_start
        if is_old:
            layout.label(text="Settings have changed since the bake", icon="ERROR")
        elif frames < wanted:
            layout.operator("taffeta.bake", text=f"Continue after Frame {scene.frame_start + frames}", icon="FRAME_NEXT").goes_on = True
        layout.operator("taffeta.free", icon="TRASH")
    say(layout, kept.said)


class TAFFETA_PT_scene(bpy.types.Panel):
    bl_label = "Taffeta"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Taffeta"

    def draw(self, context):
        layout, kept = self.layout, context.scene.taffeta
        column = layout.column(align=True)
        for role, _, _ in settings.ROLES[1:]:
            column.operator("taffeta.add", text=f"Selected: {roles.NAMES[role]}").role = role
        column.operator("taffeta.remove", text="Selected: Nothing", icon="X")
        layout.use_property_split = True
        layout.use_property_decorate = False
        for name in ("steps", "device", "air", "folder"):
            layout.prop(kept, name)
        draw_bake(layout, context)
        for one in roles.simulated(context.scene):
            if one.taffeta.said:
                layout.label(text=one.name, icon="OBJECT_DATA")
                say(layout, one.taffeta.said)
        layout.separator()
        layout.operator("taffeta.export_scene", icon="EXPORT")
        layout.operator("taffeta.import_run", icon="IMPORT")


CLASSES = (TAFFETA_PT_object, TAFFETA_PT_scene)


def register():
    for one in CLASSES:
        bpy.utils.register_class(one)


def unregister():
    for one in reversed(CLASSES):
        bpy.utils.unregister_class(one)
