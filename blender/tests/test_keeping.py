"""What is kept stays what it is: caches of other files, scenes and objects, states to go on from, settings, names."""

import importlib
import os
import signal
from pathlib import Path

import bpy
import numpy as np
import pytest
from test_bake import Event, Window, operator_of


def module(name):
    return importlib.import_module(f"bl_ext.user_default.taffeta.{name}")


def workers():
    """Processes that compute, by number."""
    all_of = [int(folder.name) for folder in Path("/proc").iterdir() if folder.name.isdigit()]

    def is_ours(process):
        try:
            parent = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[1]
            return int(parent) == os.getpid() and b"worker.py" in Path(f"/proc/{process}/cmdline").read_bytes()
        except OSError:
            return False

    return [process for process in all_of if is_ours(process)]


def hanging(world, name="sheet", **where):
    return world.pin(world.grid(name, location=(0, 0, 1), **where), lambda x: x.y > 0.49)


def test_a_killed_process_leaves_nothing_wrong_to_go_on_from(world):
    sheet = hanging(world)
    world.scene.frame_end = 41
    world.bake()
    whole = (world.folder(sheet) / "sheet.pc2").read_bytes()
    window, operator = Window(), operator_of()
    operator.invoke(window, None)
    result = {"PASS_THROUGH"}
    while result == {"PASS_THROUGH"}:
        if not module("bake").running.bake.samples:
            for process in workers():
                os.kill(process, signal.SIGKILL)
        result = operator.modal(window, Event("TIMER"))
    assert result == {"CANCELLED"} and "ended with status -9" in operator.said[-1][1]
    world.bake(goes_on=True)
    assert "there is nothing to go on from" in world.scene.taffeta.said
    assert (world.folder(sheet) / "sheet.pc2").read_bytes() == whole


def test_modifiers_that_stay_last_stay_last(world):
    sheet = hanging(world)
    bpy.context.view_layer.objects.active = sheet
    with bpy.context.temp_override(object=sheet, selected_editable_objects=[sheet]):
        bpy.ops.object.shade_auto_smooth()
    sheet.modifiers.new("Smooth", "SUBSURF")
    world.bake()
    assert [modifier.type for modifier in sheet.modifiers] == ["MESH_CACHE", "SUBSURF", "NODES"]
    assert world.at(sheet, 13)[:, 2].min() < 0.8


def test_overrides_keep_their_settings(world, tmp_path):
    hanging(world).taffeta.role = "NONE"
    path = tmp_path / "library.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    world.__init__()
    with bpy.data.libraries.load(str(path), link=True) as (_, wanted):
        wanted.objects = ["sheet"]
    linked = wanted.objects[0]
    world.scene.collection.objects.link(linked)
    local = linked.override_hierarchy_create(world.scene, bpy.context.view_layer)
    local.taffeta.role, local.taffeta.fabric, local.taffeta.thickness = "CLOTH", "denim", 7
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "shot.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "shot.blend"), load_ui=False)
    kept = next(one for one in bpy.data.objects if one.override_library).taffeta
    assert (kept.role, kept.fabric, kept.thickness) == ("CLOTH", "denim", 7)


def test_a_cache_comes_along_when_the_file_is_first_saved(world, tmp_path):
    sheet = hanging(world)
    world.bake()
    before = world.folder(sheet)
    end = world.at(sheet, 13)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "a.blend"))
    assert sheet.modifiers["Taffeta"].filepath == "//taffeta_a/Scene/sheet.pc2" and not before.exists()
    assert np.array_equal(world.at(sheet, 13), end)
    world.__init__()
    hanging(world).taffeta.fabric = "denim"
    world.bake()
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "a.blend"), load_ui=False)
    assert np.array_equal(world.at(bpy.data.objects["sheet"], 13), end)


def test_files_in_one_folder_keep_their_own_frames(world, tmp_path):
    ends = {}
    for name, fabric in (("a", "silk"), ("b", "denim")):
        world.__init__()
        sheet = hanging(world)
        sheet.taffeta.fabric, world.scene.taffeta.folder = fabric, "//cache"
        assert "save it first" in world.refused()
        bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / f"{name}.blend"))
        world.bake()
        ends[name] = world.at(sheet, 13)
        bpy.ops.wm.save_mainfile()
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "a.blend"), load_ui=False)
    assert np.array_equal(world.at(bpy.data.objects["sheet"], 13), ends["a"])
    # A new version of the file shows the old one's frames, and leaves them there.
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "a2.blend"))
    bpy.ops.taffeta.free()
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "a.blend"), load_ui=False)
    assert np.array_equal(world.at(bpy.data.objects["sheet"], 13), ends["a"])


def test_a_statue_keeps_its_shape_when_the_bake_is_deleted(world):
    sheet = hanging(world)
    world.bake()
    end = world.at(sheet, 13)
    statue = sheet.copy()
    world.scene.collection.objects.link(statue)
    statue.taffeta.role = "NONE"
    bpy.ops.taffeta.free()
    assert "Taffeta" not in sheet.modifiers and np.array_equal(world.at(statue, 13), end)
    world.bake(goes_on=True)
    assert "Taffeta" in sheet.modifiers


def test_objects_of_one_name_from_two_files_are_two(world, tmp_path):
    world.ball("thing", radius=0.2)
    path = tmp_path / "library.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    world.__init__()
    sheet = world.grid("thing", location=(0, 0, 0.4))
    with bpy.data.libraries.load(str(path), link=True) as (_, wanted):
        wanted.objects = ["thing"]
    world.scene.collection.objects.link(wanted.objects[0])
    world.scene.frame_end = 24
    world.bake()
    end = world.at(sheet, 24)
    assert len(end) == 169 and 0.19 < end[:, 2].max() < 0.25, "the sheet lies on the ball"


def test_names_that_look_like_files_are_no_trouble(world):
    for index, name in enumerate(("cloth", "cloth-pinned", "cloth_rest", "cloth.rest", "walk", "walk_poses", "walk.poses")):
        one = world.grid(name, cells=6, location=(2 * index, 0, 1))
        world.pin(one, lambda x: x.y > 0.49)
        world.pin(one, lambda x: x.y < -0.49, weight=0.4)
        one.keyframe_insert("location", frame=1)
        one.location.y = 0.2
        one.keyframe_insert("location", frame=9)
    world.bake()
    for one in world.scene.objects:
        end = world.at(one, 13)
        assert abs(end[:, 1].max() - 0.7) < 1e-3 and abs(end[:, 0].mean() - one.location.x) < 0.01, one.name


def test_wind_and_gravity_are_those_of_the_first_frame(world):
    sheet = world.grid("sheet", location=(0, 0, 1))
    world.scene.keyframe_insert("gravity", frame=1)
    world.scene.gravity = (0, 0, 0)
    world.scene.keyframe_insert("gravity", frame=13)
    ends = []
    for now in (1, 13):
        world.scene.frame_set(now, subframe=0.5)
        world.bake()
        assert world.scene.frame_current == now and world.scene.frame_subframe == pytest.approx(0.5)
        assert "gravity or wind changes in frame" in world.scene.taffeta.said
        ends.append(world.at(sheet, 13))
    assert np.array_equal(*ends) and ends[0][:, 2].mean() < 0.6


def test_a_change_while_it_is_baked_makes_the_bake_old(world):
    sheet = hanging(world)
    window, operator = Window(), operator_of()
    operator.invoke(window, None)
    result, changed = {"PASS_THROUGH"}, False
    while result == {"PASS_THROUGH"}:
        result = operator.modal(window, Event("TIMER"))
        if not changed and module("bake").running and not module("bake").running.bake.samples:
            sheet.taffeta.fabric, world.scene.frame_start, changed = "denim", 5, True
    assert result == {"FINISHED"}
    assert world.scene.taffeta.baked != module("bake").fingerprint(world.scene)
    assert sheet.modifiers["Taffeta"].frame_start == 1


def test_a_cache_that_cannot_be_written_is_said_and_bakes_go_on(world, tmp_path):
    sheet = hanging(world)
    world.scene.taffeta.folder = str(tmp_path)
    (tmp_path / "Scene" / "scene.toml").mkdir(parents=True)
    assert "cannot be kept in" in world.refused()
    (tmp_path / "Scene" / "scene.toml").rmdir()
    world.bake()
    assert world.at(sheet, 13)[:, 2].min() < 0.8


def test_switching_the_extension_off_ends_its_process(world):
    hanging(world)
    world.scene.frame_end = 200
    window, operator = Window(), operator_of()
    operator.invoke(window, None)
    while not module("bake").running.bake.done:
        operator.modal(window, Event("TIMER"))
    bpy.ops.preferences.addon_disable(module="bl_ext.user_default.taffeta")
    try:
        assert not workers()
    finally:
        bpy.ops.preferences.addon_enable(module="bl_ext.user_default.taffeta")


def test_modifiers_that_are_switched_by_the_animation_stay_off_while_it_is_sampled(world):
    sheet = hanging(world)
    smooth = sheet.modifiers.new("Smooth", "SUBSURF")
    smooth.show_viewport = True
    smooth.keyframe_insert("show_viewport", frame=1)
    world.bake()
    assert (world.folder(sheet) / "sheet.pc2").stat().st_size == 32 + 13 * 12 * 169
    assert world.at(sheet, 13)[:, 2].min() < 0.8 and smooth.show_viewport


def test_friction_is_the_mean_of_cloth_and_collider(world):
    """On a slope of 20° cloth slides below a friction of tan 20° = 0.36."""
    plate = world.grid("plate", size=4, cells=1, role="COLLIDER", rotation=(0, np.radians(20), 0))
    plate.taffeta.friction = 0.1
    sheet = world.grid("sheet", size=0.4, cells=6, location=(0, 0, 0.01), rotation=(0, np.radians(20), 0))
    world.scene.frame_end = 24
    world.scene.taffeta.air = False
    ways = []
    for friction in (0.1, 4.0):
        sheet.taffeta.friction = friction
        world.bake()
        ways.append(np.linalg.norm(world.at(sheet, 24).mean(0) - world.at(sheet, 1).mean(0)))
    # Down the slope with g (sin 20° - 0.1 cos 20°) for 23/24 s; with √(0.1 · 4) = 0.63 it stays.
    assert ways[0] == pytest.approx(0.5 * 9.81 * (np.sin(0.349) - 0.1 * np.cos(0.349)) * (23 / 24) ** 2, rel=0.06)
    assert ways[1] < 0.01


def test_a_run_that_does_not_fit_changes_nothing(world, tmp_path):
    program = os.environ.get("TAFFETA_PROGRAM")
    if not program:
        pytest.skip("TAFFETA_PROGRAM names the program")
    import json
    import subprocess

    sheet = hanging(world)
    bpy.ops.taffeta.export_scene(directory=str(tmp_path))
    run = [program, "run", "Scene/scene.toml", "--out", "out", "--format", "pc2"]
    subprocess.run(run, cwd=tmp_path, check=True, capture_output=True)
    world.bake()
    end = world.at(sheet, 13)
    world.scene.frame_set(7)
    world.scene.render.fps = 48
    with pytest.raises(RuntimeError, match="24 frames a second, and the scene 48"):
        bpy.ops.taffeta.import_run(directory=str(tmp_path / "out"))
    world.scene.render.fps = 24
    mesh = sheet.data
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=3, y_subdivisions=3)
    other = bpy.context.object
    sheet.data = other.data
    with pytest.raises(RuntimeError, match="the same mesh would do"):
        bpy.ops.taffeta.import_run(directory=str(tmp_path / "out"))
    assert world.scene.frame_current == 7
    sheet.data = mesh
    assert np.array_equal(world.at(sheet, 13), end)
    summary = tmp_path / "out/summary.json"
    summary.write_text(json.dumps({"dt": 1 / 24}))
    with pytest.raises(RuntimeError, match="has no whole run"):
        bpy.ops.taffeta.import_run(directory=str(tmp_path / "out"))


def test_an_export_leaves_other_files_alone(world, tmp_path):
    hanging(world)
    for name in ("hero_poses.pc2", "sheet.obj"):
        (tmp_path / name).write_text("mine")
    bpy.ops.taffeta.export_scene(directory=str(tmp_path))
    assert (tmp_path / "hero_poses.pc2").read_text() == (tmp_path / "sheet.obj").read_text() == "mine"
    assert (tmp_path / "Scene/scene.toml").exists()


def test_more_frames_go_on_from_those_there_are(world):
    sheet = hanging(world)
    world.bake()
    first = (world.folder(sheet) / "sheet.pc2").read_bytes()
    world.scene.frame_end = 20
    assert world.scene.taffeta.baked == module("bake").fingerprint(world.scene)
    world.bake(goes_on=True)
    more = (world.folder(sheet) / "sheet.pc2").read_bytes()
    assert "starts again" not in world.scene.taffeta.said and more[32 : len(first)] == first[32:]
    assert len(more) == 32 + 20 * 12 * 169


def test_fabrics_have_numbers_that_never_change():
    """What a file keeps. A fabric may be added with a number of its own; none may be changed."""
    numbers = module("settings").NUMBERS
    assert numbers == {
        "custom": 0, "cotton": 1, "silk": 2, "wool": 3, "linen": 4, "denim": 5, "jersey": 6, "ponte": 7, "rib": 8, "polyester": 9,
        "blanket": 10,
    }  # fmt: skip
    assert set(module("settings").fabrics()) == set(numbers) - {"custom"}


def test_a_modifier_of_the_users_own_stays_what_it_is(world):
    sheet = hanging(world)
    own = sheet.modifiers.new("Taffeta", "SOLIDIFY")
    for _ in range(2):
        world.bake()
    assert [modifier.type for modifier in sheet.modifiers] == ["MESH_CACHE", "SOLIDIFY"]
    bpy.ops.taffeta.free()
    assert list(sheet.modifiers) == [own]
