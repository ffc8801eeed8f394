"""The mistakes that are made most: each is said where it was made, with what would do."""

import os
from pathlib import Path

import bpy
import pytest


def sheet_of(world, **where):
    return world.grid("sheet", location=(0, 0, 1), **where)


def nothing_simulated(world):
    world.ball("ball")
    return "no object of the scene is cloth"


def no_frames(world):
    sheet_of(world)
    world.scene.frame_start = world.scene.frame_end = 7
    return "ends in frame 7 and starts in frame 7"


def in_edit_mode(world):
    bpy.context.view_layer.objects.active = sheet_of(world)
    bpy.ops.object.mode_set(mode="EDIT")
    return "sheet: is in Edit Mode"


def hidden(world):
    sheet_of(world)
    world.ball("ball").hide_set(True)
    return "ball: is hidden"


def excluded(world):
    sheet_of(world)
    aside = bpy.data.collections.new("aside")
    world.scene.collection.children.link(aside)
    ball = world.ball("ball")
    world.scene.collection.objects.unlink(ball)
    aside.objects.link(ball)
    bpy.context.view_layer.layer_collection.children["aside"].exclude = True
    return "ball: is in no collection of the view layer"


def stretched_time(world):
    sheet_of(world)
    world.scene.render.frame_map_new = 200
    return "time is stretched from 100 to 200"


def no_such_group(world):
    sheet_of(world).taffeta.pin_group = "waist"
    return "pinned by the vertex group 'waist', which it has not"


def two_solvers(world):
    sheet_of(world).modifiers.new("Cloth", "CLOTH")
    return "also cloth of Blender's own (modifier Cloth)"


def no_faces(world):
    sheet = sheet_of(world)
    mesh = bpy.data.meshes.new("points")
    mesh.from_pydata([(0, 0, 0), (1, 0, 0)], [(0, 1)], [])
    sheet.data = mesh
    return "sheet: has no faces"


def no_size(world):
    sheet_of(world).scale = (1, 0, 0)
    return "sheet: has a scale of 0"


def animated_modifier(world):
    build = world.pin(sheet_of(world), lambda x: x.y > 0.49)
    cut = build.modifiers.new("Cut", "ARRAY")
    cut.count = 1
    cut.keyframe_insert("count", frame=1)
    cut.count = 3
    cut.keyframe_insert("count", frame=5)
    return "vertices at the start and"


def no_rest_shape(world):
    sheet_of(world).taffeta.rest_key = "pattern"
    return "has no shape key 'pattern'"


def soft_with_a_hole(world):
    world.grid("sheet", role="SOFT", location=(0, 0, 1))
    return "sheet: a soft body needs a closed surface, and this one has 1 hole"


def no_place_for_the_cache(world):
    sheet_of(world)
    world.scene.taffeta.folder = str(Path(__file__) / "cache")
    return "the cache cannot be kept in"


REFUSED = [
    nothing_simulated, no_frames, in_edit_mode, hidden, excluded, stretched_time, no_such_group, two_solvers, no_faces, no_size, animated_modifier,
    no_rest_shape, soft_with_a_hole, no_place_for_the_cache,
]  # fmt: skip


@pytest.mark.parametrize("mistake", REFUSED)
def test_what_cannot_be_is_refused(world, mistake):
    words = mistake(world)
    said = world.refused()
    assert words in said, said
    assert "Traceback" not in said
    for one in bpy.data.objects:
        assert all(modifier.show_viewport for modifier in one.modifiers), "what was hidden to sample is shown again"


def no_gravity(world):
    sheet_of(world)
    world.scene.use_gravity = False
    return None, "nothing falls"


def gravity_of_another_unit(world):
    sheet_of(world, size=100)
    world.scene.unit_settings.scale_length = 0.01
    return None, "on Earth Scene > Gravity would be -981 along Z"


def too_large(world):
    sheet_of(world, size=180, cells=16)
    return "sheet", "is 180 m large"


def a_hurricane(world):
    sheet_of(world)
    bpy.ops.object.effector_add(type="WIND")
    bpy.context.object.field.strength = 500
    return None, "the wind has 500 m/s"


def a_field_that_does_nothing(world):
    sheet_of(world)
    bpy.ops.object.effector_add(type="TURBULENCE")
    bpy.context.object.name = "Eddies"
    return None, "the force field Eddies does nothing"


def only_an_instance(world):
    sheet_of(world)
    aside = bpy.data.collections.new("aside")
    ball = world.ball("ball")
    world.scene.collection.objects.unlink(ball)
    aside.objects.link(ball)
    bpy.ops.object.collection_instance_add(collection="aside")
    return None, "ball is only there as an instance of a collection"


def rendered_otherwise(world):
    mirror = sheet_of(world).modifiers.new("Mirror", "MIRROR")
    mirror.show_viewport = False
    return "sheet", "its modifier Mirror is on in one of the viewport and the render alone"


def tethers_to_nothing(world):
    sheet_of(world).taffeta.tethers = True
    return "sheet", "has tethers and nothing that is pinned"


def wind_without_air(world):
    sheet_of(world)
    world.scene.taffeta.air = False
    bpy.ops.object.effector_add(type="WIND")
    return None, "the scene has wind, and Air is off"


def empty_group(world):
    sheet = sheet_of(world)
    sheet.vertex_groups.new(name="rail")
    sheet.taffeta.pin_group = "rail"
    return "sheet", "nothing is pinned"


def all_pinned(world):
    world.pin(sheet_of(world), lambda x: True)
    return "sheet", "is pinned as a whole"


def nothing_to_sew(world):
    sheet_of(world).taffeta.sewing = True
    return "sheet", "has no edges without faces to sew"


def sewing_is_off(world):
    import bmesh

    sheet = sheet_of(world)
    mesh = bmesh.new()
    mesh.from_mesh(sheet.data)
    mesh.verts.ensure_lookup_table()
    mesh.edges.new((mesh.verts[0], mesh.verts[12]))
    mesh.to_mesh(sheet.data)
    mesh.free()
    return "sheet", "1 edge without a face"


def few_vertices(world):
    sheet_of(world, cells=1)
    return "sheet", "has only 4 vertices"


def armature_above(world):
    sheet = sheet_of(world)
    world.bake()
    armature = bpy.data.objects.new("rig", bpy.data.armatures.new("rig"))
    world.scene.collection.objects.link(armature)
    sheet.modifiers.new("Armature", "ARMATURE").object = armature
    return "sheet", "moves twice"


def starts_through_something(world):
    sheet_of(world)
    world.ball("ball", location=(0.05, 0, 1.0))
    return "sheet", "surfaces pass through each other"


SAID = [
    no_gravity, gravity_of_another_unit, too_large, a_hurricane, a_field_that_does_nothing, only_an_instance, rendered_otherwise,
    tethers_to_nothing, wind_without_air, empty_group, all_pinned, nothing_to_sew,
    sewing_is_off, few_vertices, armature_above, starts_through_something,
]  # fmt: skip


@pytest.mark.parametrize("mistake", SAID)
def test_what_is_likely_not_meant_is_said(world, mistake):
    name, words = mistake(world)
    world.scene.frame_end = 3
    world.bake()
    said = bpy.data.objects[name].taffeta.said if name else world.scene.taffeta.said
    assert words in said, said


def test_nothing_is_said_of_a_scene_that_is_right(world):
    sheet = world.pin(sheet_of(world), lambda x: x.y > 0.49)
    ball = world.ball("ball", location=(0, 0, 0.5))
    world.bake()
    assert [sheet.taffeta.said, ball.taffeta.said, world.scene.taffeta.said] == ["", "", ""]


def test_a_linked_object_is_refused_until_it_is_overridden(world, tmp_path):
    sheet_of(world)
    path = tmp_path / "library.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    world.__init__()
    with bpy.data.libraries.load(str(path), link=True) as (found, wanted):
        wanted.objects = ["sheet"]
    linked = wanted.objects[0]
    world.scene.collection.objects.link(linked)
    assert "is linked from another file" in world.refused()
    local = linked.override_create(remap_local_usages=True)
    assert local.is_editable
    world.bake()
    assert world.at(local, 13)[:, 2].mean() < 0.6


def test_a_process_that_dies_is_no_riddle(world, monkeypatch):
    import importlib

    job = importlib.import_module("bl_ext.user_default.taffeta.job")
    broken = Path(os.environ["BLENDER_USER_RESOURCES"]) / "broken.py"
    broken.write_text("raise SystemExit('the disk is on fire')")
    monkeypatch.setattr(job, "WORKER", broken)
    sheet_of(world)
    said = world.refused()
    assert "the process that computes ended with status 1" in said and "the disk is on fire" in said
