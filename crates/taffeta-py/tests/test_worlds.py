"""Worlds: many at once, and each as if it were alone."""

from __future__ import annotations

import os
import signal
import threading

import numpy as np
import pytest
import taffeta

FABRICS = ["silk", "cotton", "denim", "jersey", "linen"]


@pytest.fixture
def scene() -> taffeta.Scene:
    scene = taffeta.Scene().time(max_step=1 / 120).solver("ice", form="primal")
    scene.grid("cloth", rows=8, cols=8, size=(0.4, 0.4), material="cotton", self_collision=True)
    scene.sphere("ball", radius=0.1, center=(0, -0.12, 0)).plane("floor", point=(0, -0.3, 0))
    return scene


def alone(scene: taffeta.Scene, fabric: str, frames: int, threads: int = 1) -> taffeta.Simulation:
    simulation = taffeta.Simulation(taffeta.Scene(scene).set("body.cloth.material.preset", fabric), threads=threads)
    simulation.step(frames)
    return simulation


@pytest.mark.parametrize("threads", [1, 2, 3])
@pytest.mark.parametrize("order", [[0], [2, 1, 0], [0, 1, 2, 3, 4, 0, 2]])
def test_a_world_has_the_same_bits_as_alone(scene: taffeta.Scene, order: list[int], threads: int) -> None:
    fabrics = [FABRICS[index] for index in order]
    worlds = taffeta.Worlds(scene, len(order), vary={"body.cloth.material.preset": fabrics}, threads=threads)
    assert not worlds.step(12).any()
    positions, velocities = worlds.positions(), worlds.velocities("cloth")
    for index, fabric in enumerate(fabrics):
        single = alone(scene, fabric, 12, threads=2)
        assert worlds[index].state_hash() == single.state_hash()
        np.testing.assert_array_equal(positions[index], single.positions())
        np.testing.assert_array_equal(velocities[index], single.velocities())
    assert len({world.state_hash() for world in worlds}) == len(set(order))


def test_arrays_are_worlds_by_vertices_by_three_and_are_written_in_place(scene: taffeta.Scene) -> None:
    worlds = taffeta.Worlds(scene, 4, precision="f64")
    out = np.full((4, 64, 3), np.nan)
    assert worlds.positions(out=out) is out
    np.testing.assert_array_equal(out, np.stack([world.positions() for world in worlds]))
    assert worlds.normals("cloth").shape == (4, 64, 3)
    with pytest.raises(taffeta.InputError, match=r"out: has the shape \[3, 64, 3\]; \[4, 64, 3\] would do"):
        worlds.positions(out=out[:3])
    with pytest.raises(taffeta.InputError, match="there is no body `sheet`"):
        worlds.positions("sheet")


def test_masks_choose_worlds_that_step_and_that_start_again(scene: taffeta.Scene) -> None:
    worlds = taffeta.Worlds(scene, 3)
    start = worlds[0].state_hash()
    worlds.step(3, mask=np.array([True, False, True]))
    assert worlds.frames.tolist() == [3, 0, 3]
    worlds[0].set_world(gravity=(0, 0, 0))
    worlds[0].pin("cloth", 0)
    worlds.reset([True, False, False])
    assert worlds.frames.tolist() == [0, 0, 3]
    assert worlds[0].state_hash() == start
    worlds.step(5, mask=[True, True, False])
    assert worlds[0].state_hash() == worlds[1].state_hash() == alone(scene, "cotton", 5).state_hash()
    for mask in ([True, False], [1.5, 2, 3], "yes"):
        with pytest.raises(taffeta.InputError, match="mask is no array or list of 3 booleans"):
            worlds.step(mask=mask)


def test_each_world_has_forces_pins_and_colliders_of_its_own(scene: taffeta.Scene) -> None:
    worlds = taffeta.Worlds(scene, 3)
    twins = [alone(scene, "cotton", 0) for _ in range(3)]
    forces = np.zeros((3, 2, 3))
    forces[:, :, 1] = [[0.1, 0.2], [0.3, 0.4], [0.5, 0.6]]
    places = worlds.positions()[:, 63].astype(float) + np.arange(3)[:, None] * [0.0, 0.01, 0.0]
    shifts = np.arange(3)[:, None] * [0.0, 0.02, 0.0]
    worlds.apply_force("cloth", [7, 9], forces)
    worlds.apply_force("cloth", 5, (0.0, 0.05, 0.0))
    worlds.pin("cloth", 63, places)
    worlds.pin("cloth", [0, 1])
    worlds.move_collider("ball", shifts)
    worlds.step(2)
    for index, twin in enumerate(twins):
        twin.apply_force("cloth", [7, 9], forces[index])
        twin.apply_force("cloth", 5, (0.0, 0.05, 0.0))
        twin.pin("cloth", 63, places[index])
        twin.pin("cloth", [0, 1])
        twin.move_collider("ball", shifts[index])
        twin.step(2)
        assert worlds[index].state_hash() == twin.state_hash()
    with pytest.raises(taffeta.InputError, match=r"force is no array of numbers \[3\], \[3, 3\] or \[3, 2, 3\]"):
        worlds.apply_force("cloth", [7, 9], np.zeros((2, 3)))


def test_a_world_that_diverges_stays_and_the_others_go_on() -> None:
    scene = taffeta.Scene().time(dt=0.01)
    scene.grid("cloth", rows=4, cols=5, size=(0.4, 0.3), node_mass=1e-3, springs={"structural": {"k": 1.0}})
    scene.pin("cloth", nodes=0)
    with pytest.warns(taffeta.SceneWarning, match="longer than the largest stable step"):
        worlds = taffeta.Worlds(scene, 3, vary={"body.cloth.springs.structural.k": [1.0, 1e6, 2.0]})
    worlds[1].disturb(1e-3)
    assert worlds.step(50).tolist() == [False, True, False]
    assert worlds.frames[0] == worlds.frames[2] == 50
    assert worlds.frames[1] < 50
    assert np.isfinite(worlds.positions()).all()
    worlds.reset(mask=[False, True, False])
    assert worlds.frames.tolist() == [50, 0, 50]
    assert not worlds.step().any()


def test_reports_are_arrays_of_worlds(scene: taffeta.Scene) -> None:
    worlds = taffeta.Worlds(scene, 3, vary={"body.cloth.material.preset": ["silk", "cotton", "denim"]})
    worlds.step(20)
    reports = worlds.reports()
    for index, world in enumerate(worlds):
        for name, values in reports.items():
            assert values.shape == (3,)
            assert values[index] == world.report[name], name
    assert worlds.memory == sum(world.memory for world in worlds)


def test_mistakes_are_refused_in_words(scene: taffeta.Scene) -> None:
    with pytest.raises(taffeta.InputError, match="n is 0; 1 to 1048576 would do"):
        taffeta.Worlds(scene, 0)
    with pytest.raises(taffeta.InputError, match="vary: `time.dt` has 2 values; 3 would do"):
        taffeta.Worlds(scene, 3, vary={"time.dt": [0.01, 0.02]})
    with pytest.raises(taffeta.SceneError, match="no `body` is called `sheet`"):
        taffeta.Worlds(scene, 1, vary={"body.sheet.mass": [1.0]})
    with pytest.raises(taffeta.SceneError, match="is -1"):
        taffeta.Worlds(scene, 2, vary={"collider.ball.friction": [0.1, -1.0]})
    with pytest.raises(taffeta.InputError, match="threads is 0; 1 or more would do"):
        taffeta.Worlds(scene, 2, threads=0)
    worlds = taffeta.Worlds(scene, 2)
    with pytest.raises(IndexError, match="there are 2 worlds and none with index 2"):
        worlds[2]
    assert worlds[-1] is worlds[1]
    assert repr(worlds).startswith("<taffeta.Worlds: 2 worlds, ")


def test_ctrl_c_stops_all_worlds_after_the_same_frame(scene: taffeta.Scene) -> None:
    worlds = taffeta.Worlds(scene, 4, threads=2)
    timer = threading.Timer(0.2, os.kill, (os.getpid(), signal.SIGINT))
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        worlds.step(100_000_000)
    timer.join()
    [frame] = set(worlds.frames.tolist())
    assert frame > 0
    assert worlds[3].state_hash() == alone(scene, "cotton", frame).state_hash()
