"""Bakes: what is computed is what is shown, in the object's own coordinates."""

import json
import os
import subprocess

import bpy
import numpy as np
import pytest


def test_a_free_sheet_falls_as_gravity_has_it(world):
    world.scene.taffeta.air = False
    sheet = world.grid("sheet", location=(0, 0, 2))
    world.bake()
    start, end = world.at(sheet, 1), world.at(sheet, 13)
    time, steps = 12 / 24, 120
    # Symplectic Euler falls by half a step more.
    fallen = 0.5 * 9.81 * time**2 * (1 + 1 / steps)
    assert np.abs(end - start - [0, 0, -fallen]).max() < 2e-4


def test_the_first_frame_is_the_mesh_and_the_last_stays(world):
    sheet = world.grid("sheet", location=(0, 0, 2))
    places = world.at(sheet, 1)
    world.bake()
    assert np.abs(world.at(sheet, 1) - places).max() < 1e-6
    assert np.array_equal(world.at(sheet, 13), world.at(sheet, 50))
    modifier = sheet.modifiers["Taffeta"]
    assert (modifier.frame_start, modifier.cache_format) == (1, "PC2")


def test_pinned_vertices_stay_and_the_others_hang_below(world):
    curtain = world.pin(world.grid("curtain", location=(0, 0, 1)), lambda x: x.y > 0.49)
    world.scene.frame_end = 60
    world.bake()
    start, end = world.at(curtain, 1), world.at(curtain, 60)
    held = start[:, 1] > 0.49
    assert np.abs(end[held] - start[held]).max() < 1e-6
    # It has swung down, and cotton hardly stretches.
    lowest = end[:, 2].min()
    assert -0.03 < lowest < 0.3, lowest


def test_cloth_keeps_its_distance_from_a_collider(world):
    world.grid("sheet", cells=24, location=(0, 0, 0.35))
    ball = world.ball("ball", detail=4)
    ball.taffeta.thickness = 8
    world.scene.frame_end = 30
    world.bake()
    sheet = bpy.data.objects["sheet"]
    for frame in range(1, 31, 5):
        nearest = np.linalg.norm(world.at(sheet, frame), axis=1).min()
        assert nearest > 0.3 + 0.004, (frame, nearest)


def test_the_scene_is_what_the_program_runs(world, tmp_path):
    """The same hash from the exported scene, by `taffeta run`."""
    program = os.environ.get("TAFFETA_PROGRAM")
    if not program:
        pytest.skip("TAFFETA_PROGRAM names the program")
    sheet = world.pin(world.grid("sheet with é", location=(0, 0, 0.5)), lambda x: x.x < -0.3, weight=1.0)
    world.pin(sheet, lambda x: x.x > 0.4, weight=0.5)
    ball = world.ball("ball")
    ball.keyframe_insert("location", frame=1)
    ball.location.z = 0.2
    ball.keyframe_insert("location", frame=10)
    bpy.ops.taffeta.export_scene(directory=str(tmp_path))
    run = [program, "run", "Scene/scene.toml", "--out", "out", "--format", "pc2", "--backend", "cpu"]
    subprocess.run(run, cwd=tmp_path, check=True, capture_output=True)
    summary = json.loads((tmp_path / "out/summary.json").read_text())
    world.bake()
    by_bake = [world.at(sheet, frame) for frame in range(1, 14)]
    assert bake_result()["hash"] == summary["state_hash"]
    bpy.ops.taffeta.free()
    bpy.ops.taffeta.import_run(directory=str(tmp_path / "out"))
    by_run = [world.at(sheet, frame) for frame in range(1, 14)]
    assert np.abs(np.array(by_run) - by_bake).max() < 1e-6


def bake_result():
    """The last thing that the process said."""
    import importlib

    return importlib.import_module("bl_ext.user_default.taffeta.bake").last.result


def test_a_stopped_bake_goes_on_bit_by_bit(world):
    sheet = world.pin(world.grid("sheet", location=(0, 0, 1)), lambda x: x.y > 0.49)
    world.scene.frame_end = 31
    world.bake()
    whole = (world.folder(sheet) / "sheet.pc2").read_bytes()
    bpy.ops.taffeta.bake(stops_after=9)
    cut = (world.folder(sheet) / "sheet.pc2").read_bytes()
    assert len(cut) < len(whole)
    assert whole[32 : len(cut)] == cut[32:]
    world.bake(goes_on=True)
    assert (world.folder(sheet) / "sheet.pc2").read_bytes() == whole


def test_a_changed_scene_starts_again(world):
    sheet = world.pin(world.grid("sheet", location=(0, 0, 1)), lambda x: x.y > 0.49)
    bpy.ops.taffeta.bake(stops_after=4)
    sheet.taffeta.fabric = "denim"
    world.bake(goes_on=True)
    assert "starts again" in world.scene.taffeta.said
    continued = world.at(sheet, 13)
    world.bake()
    assert np.array_equal(world.at(sheet, 13), continued)


def test_a_slider_changes_what_is_baked(world):
    sheet = world.pin(world.grid("sheet", location=(0, 0, 1)), lambda x: x.y > 0.49)
    world.scene.frame_end = 30
    world.bake()
    cotton = world.at(sheet, 30)
    sheet.taffeta.fabric = "custom"
    sheet.taffeta.stretch = (20, 20)
    world.bake()
    rubber = world.at(sheet, 30)
    assert rubber[:, 2].min() < cotton[:, 2].min() - 0.02


class Window:
    """What a bake sees of a window: it counts what is asked of it."""

    def __init__(self):
        self.status, self.progress, self.timers = [], [], 0
        self.window_manager = self.workspace = self.screen = self
        self.window, self.areas, self.scene = None, [], bpy.context.scene

    def event_timer_add(self, *_args, **_how):
        self.timers += 1

    def event_timer_remove(self, _timer):
        self.timers -= 1

    def modal_handler_add(self, _operator):
        pass

    def progress_begin(self, *_range):
        pass

    progress_end = progress_begin

    def progress_update(self, percent):
        self.progress.append(percent)

    def status_text_set(self, text):
        self.status.append(text)


class Event:
    def __init__(self, kind):
        self.type, self.value = kind, "PRESS"


def operator_of(**how):
    """The operator as Blender drives it, event by event."""
    import importlib
    from types import MethodType, SimpleNamespace

    kind = importlib.import_module("bl_ext.user_default.taffeta.bake").TAFFETA_OT_bake
    reports = []
    one = SimpleNamespace(
        goes_on=False, stops_after=0, plays=False, said=reports, report=lambda kind, text: reports.append((*kind, text)), **how
    )
    for name in ("invoke", "modal", "show", "close", "cancel"):
        setattr(one, name, MethodType(getattr(kind, name), one))
    return one


def test_a_bake_goes_on_beside_the_user_and_stops_on_escape(world):
    import time

    sheet = world.pin(world.grid("sheet", cells=30, location=(0, 0, 1)), lambda x: x.y > 0.49)
    world.scene.frame_end = 200
    window, operator = Window(), operator_of()
    assert operator.invoke(window, None) == {"RUNNING_MODAL"}
    assert operator.modal(window, Event("LEFTMOUSE")) == {"RUNNING_MODAL"}, "nothing comes between while it samples"
    longest, ended, frames = 0.0, None, 0
    while ended is None:
        start = time.monotonic()
        result = operator.modal(window, Event("TIMER"))
        longest = max(longest, time.monotonic() - start)
        if result != {"PASS_THROUGH"}:
            ended = result
        elif frames > 3:
            assert operator.modal(window, Event("ESC")) == {"RUNNING_MODAL"}
            assert operator.modal(window, Event("LEFTMOUSE")) == {"PASS_THROUGH"}
        frames = max(frames, round(200 * window.progress[-1] / 100)) if window.progress else 0
    assert ended == {"FINISHED"} and window.timers == 0 and window.status[-1] is None
    assert operator.said[-1][0] == "WARNING" and "Continue goes on" in operator.said[-1][1]
    # What there is can be played, and the rest is computed later.
    done = ((world.folder(sheet) / "sheet.pc2").stat().st_size - 32) // (12 * 31 * 31) - 1
    assert 3 < done < 199
    assert any("frame" in text and "of 200" in text for text in window.status[:-1])


def test_an_undo_and_a_deleted_object_do_not_break_a_bake(world):
    world.grid("sheet", location=(0, 0, 1))
    world.grid("other", location=(3, 0, 1))
    bpy.ops.ed.undo_push(message="before")
    window, operator = Window(), operator_of()
    operator.invoke(window, None)
    results, changed = [], False
    while not results or results[-1] == {"PASS_THROUGH"}:
        results.append(operator.modal(window, Event("TIMER")))
        if not changed and any("frame" in (text or "") for text in window.status):
            changed = True
            bpy.data.objects.remove(bpy.data.objects["other"])
            bpy.ops.ed.undo_push(message="deleted")
            bpy.ops.ed.undo()
            bpy.data.objects.remove(bpy.data.objects["other"])
    assert results[-1] == {"FINISHED"}
    assert "Taffeta" in bpy.data.objects["sheet"].modifiers
    assert "the object other is gone" in world.scene.taffeta.said
