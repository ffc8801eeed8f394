"""Undo, saving, and what is left when Taffeta is removed."""

import bpy
import numpy as np


def test_undo_takes_a_bake_back_and_redo_brings_it(world):
    sheet = world.grid("sheet", location=(0, 0, 1))
    bpy.ops.ed.undo_push(message="before")
    world.bake()
    bpy.ops.ed.undo_push(message="baked")
    assert "Taffeta" in bpy.data.objects["sheet"].modifiers
    bpy.ops.ed.undo()
    sheet = bpy.data.objects["sheet"]
    assert "Taffeta" not in sheet.modifiers and sheet.taffeta.role == "CLOTH"
    assert np.abs(world.at(sheet, 13)[:, 2] - 1).max() < 1e-6
    bpy.ops.ed.redo()
    assert "Taffeta" in bpy.data.objects["sheet"].modifiers


def test_a_saved_file_shows_its_cache_from_where_it_was_moved(world, tmp_path):
    sheet = world.grid("sheet", location=(0, 0, 1))
    first = tmp_path / "one" / "scène.blend"
    first.parent.mkdir()
    bpy.ops.wm.save_as_mainfile(filepath=str(first))
    world.bake()
    assert sheet.modifiers["Taffeta"].filepath.startswith("//taffeta_")
    sheet.taffeta.fabric = "silk"
    end = world.at(sheet, 13)
    bpy.ops.wm.save_mainfile()
    bpy.ops.wm.read_homefile(use_empty=True, load_ui=False)
    second = tmp_path / "two"
    first.parent.rename(second)
    bpy.ops.wm.open_mainfile(filepath=str(second / "scène.blend"), load_ui=False)
    sheet = bpy.data.objects["sheet"]
    assert np.array_equal(world.at(sheet, 13), end)
    assert (sheet.taffeta.role, sheet.taffeta.fabric) == ("CLOTH", "silk")


def test_removing_leaves_nothing_in_the_file(world, tmp_path):
    sheet, ball = world.grid("sheet", location=(0, 0, 1)), world.ball("ball")
    world.scene.taffeta.steps, sheet.taffeta.pin_stiffness = 4, 3
    path = tmp_path / "kept.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path), compress=False)
    assert b"pin_stiffness" in path.read_bytes()
    world.bake()
    bpy.ops.taffeta.remove(everywhere=True)
    for one in (sheet, ball):
        assert one.taffeta.role == "NONE" and not one.modifiers
        assert "taffeta" not in one.keys()
    assert world.scene.taffeta.steps == 10
    path = tmp_path / "clean.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path), compress=False)
    data = path.read_bytes()
    # Of a group that was looked at Blender keeps the name, and nothing in it.
    assert b"pin_stiffness" not in data and b"Taffeta" not in data


def test_the_extension_can_be_switched_off_and_on(world):
    sheet = world.grid("sheet", location=(0, 0, 1))
    world.bake()
    end = world.at(sheet, 13)
    bpy.ops.preferences.addon_disable(module="bl_ext.user_default.taffeta")
    try:
        assert not hasattr(bpy.types.Object, "taffeta")
        # The cache is Blender's own modifier: it shows without the extension.
        assert np.array_equal(world.at(sheet, 13), end)
    finally:
        bpy.ops.preferences.addon_enable(module="bl_ext.user_default.taffeta")
    assert sheet.taffeta.role == "CLOTH"


def test_deleting_the_bake_shows_the_mesh_and_removes_its_files(world):
    sheet = world.grid("sheet", location=(0, 0, 1))
    world.bake()
    path = world.folder(sheet) / "sheet.pc2"
    assert path.exists()
    bpy.ops.taffeta.free()
    assert not path.exists() and np.abs(world.at(sheet, 13)[:, 2] - 1).max() < 1e-6


def test_panels_draw_in_every_state(world):
    """Draws all panels for what they may show; a wrong name of a property would raise."""
    import importlib

    panels = importlib.import_module("bl_ext.user_default.taffeta.panels")

    class Layout:
        """Takes whatever is drawn, and keeps the words."""

        def __init__(self, words):
            self.words = words

        def __getattr__(self, name):
            def call(*args, **kwargs):
                self.words.append(kwargs.get("text", ""))
                if name == "prop":
                    assert args[1] in args[0].bl_rna.properties, args[1]
                return self

            return call

    class Panel:
        def __init__(self):
            self.words = []
            self.layout = Layout(self.words)

    sheet = world.grid("sheet", location=(0, 0, 1))
    world.bake()
    for role in ("NONE", "CLOTH", "SOFT", "COLLIDER"):
        for fabric in ("cotton", "custom"):
            for volume in ("KEEP", "PRESSURE", "NONE"):
                sheet.taffeta.role, sheet.taffeta.fabric, sheet.taffeta.volume = role, fabric, volume
                sheet.taffeta.said = "something was said of it"
                for kind in (panels.TAFFETA_PT_object, panels.TAFFETA_PT_scene):
                    kind.draw(Panel(), bpy.context)
    sheet.taffeta.role = "CLOTH"
    sheet.taffeta.friction = 0.9
    panels._states.clear()
    panel = Panel()
    panels.TAFFETA_PT_object.draw(panel, bpy.context)
    assert "Settings have changed since the bake" in panel.words
