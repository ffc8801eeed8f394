"""Simulations: what happens is physics, and what a program asks for happens."""

from __future__ import annotations

import copy
import math
import os
import pickle
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import taffeta

GRAVITY = 9.81


def falling(precision: str) -> taffeta.Simulation:
    scene = taffeta.Scene().time(dt=0.01, max_step=0.001)
    scene.grid("cloth", rows=4, cols=4, size=(1, 1), mass=0.3, springs={"structural": {"k": 10.0}})
    return taffeta.Simulation(scene, precision=precision, threads=1)


# 500 roundings of half of the last digit, at most.
@pytest.mark.parametrize(("precision", "tolerance"), [("f32", 3e-5), ("f64", 6e-14)])
def test_cloth_falls_as_symplectic_euler_has_it(precision: str, tolerance: float) -> None:
    simulation = falling(precision)
    report = simulation.advance(0.5)
    steps, step = 500, 0.001
    depth = 0.5 * GRAVITY * step**2 * steps * (steps + 1)
    assert report["frame"] == 50
    assert math.isclose(simulation.time, 0.5)
    np.testing.assert_allclose(simulation.positions()[:, 1], -depth, atol=tolerance)
    np.testing.assert_allclose(simulation.velocities()[:, 1], -GRAVITY * 0.5, atol=4 * tolerance)
    # Which is half g t^2, but for half a step.
    assert abs(depth - 0.5 * GRAVITY * 0.5**2) < 0.5 * GRAVITY * 0.5 * step * 1.01
    assert math.isclose(report["momentum"][1], -0.3 * GRAVITY * 0.5, rel_tol=1e-5)
    assert math.isclose(report["energy"], report["kinetic"] + report["gravitational"] + report["springs"], abs_tol=1e-9)


def test_advance_runs_whole_frames_that_last_so_long() -> None:
    simulation = falling("f32")
    for seconds, frame in [(0.0, 0), (0.01, 1), (0.001, 2), (0.1, 12), (0.3, 42)]:
        simulation.advance(seconds)
        assert simulation.frame == frame
    assert simulation.step(0)["frame"] == 42


def test_a_moved_pin_moves_the_cloth_and_a_freed_one_lets_it_fall(cloth: taffeta.Scene) -> None:
    simulation = taffeta.Simulation(cloth, threads=1)
    still = taffeta.Simulation(cloth, threads=1)
    corner = simulation.positions()[63]
    for frame in range(1, 16):
        simulation.pin("cloth", 63, corner + [0.0, 0.01 * frame, 0.0])
        simulation.step()
        still.step()
    moved = simulation.positions()
    np.testing.assert_allclose(moved[63], corner + [0.0, 0.15, 0.0], atol=1e-6)
    assert moved[54, 1] > still.positions()[54, 1] + 0.1, "its neighbour comes along"
    simulation.unpin("cloth", [63])
    simulation.step(10)
    assert simulation.positions()[63, 1] < corner[1] + 0.1


def test_pins_hold_many_vertices_where_they_are_or_at_places(simulation: taffeta.Simulation) -> None:
    simulation.step(3)
    before = simulation.positions()
    simulation.pin("cloth", np.array([60, 61]))
    simulation.pin("cloth", [62, 63], [[0.4, -0.1, 0.5], [0.5, -0.1, 0.5]])
    simulation.step()
    after = simulation.positions()
    np.testing.assert_array_equal(after[[60, 61]], before[[60, 61]])
    np.testing.assert_array_equal(after[[62, 63]], np.float32([[0.4, -0.1, 0.5], [0.5, -0.1, 0.5]]))


def test_a_movable_pin_goes_where_a_pose_says(cloth: taffeta.Scene) -> None:
    scene = taffeta.Scene().grid("cloth", rows=4, cols=4, size=(1, 1), material="cotton")
    simulation = taffeta.Simulation(scene.pin("cloth", rows=0, movable=True))
    before = simulation.positions()[:4].astype(float)
    pose = taffeta.pose((0.0, 0.02, 0.01), axis=(0, 1, 0), degrees=3.0)
    simulation.move_pin("cloth", 0, pose)
    simulation.step()
    np.testing.assert_allclose(simulation.positions()[:4], before @ pose[:3, :3].T + pose[:3, 3], atol=1e-6)
    simulation.move_pin("cloth", 0, (0.0, 0.0, 0.0))
    simulation.step()
    np.testing.assert_allclose(simulation.positions()[:4], before, atol=1e-6)
    with pytest.raises(taffeta.InputError, match="pin 0 of body `cloth` never moves"):
        taffeta.Simulation(cloth).move_pin("cloth", 0, pose)


def test_a_pin_carries_the_weight_of_what_hangs() -> None:
    scene = taffeta.Scene().solver("ice", form="primal").world(drag=0.02)
    scene.grid("cloth", rows=8, cols=8, size=(1.0, 1.0), material="cotton", rotation=((1, 0, 0), 90.0))
    simulation = taffeta.Simulation(scene.pin("cloth", rows=0), threads=1)
    assert simulation.reaction("cloth") is None
    report = simulation.step(60)
    force = simulation.reaction("cloth", 0)
    assert force is not None
    weight = simulation.bodies["cloth"].mass * GRAVITY
    np.testing.assert_allclose(force, [0.0, weight, 0.0], atol=1e-3 * weight)
    assert report["reactions"]["cloth"][0] == force.tolist()


def test_a_force_accelerates_what_it_acts_on_for_one_frame() -> None:
    simulation = falling("f64")
    mass = 0.3 / 16 * 1.0
    simulation.apply_force("cloth", range(16), [0.0, 0.3 * GRAVITY / 16, 0.0])
    simulation.apply_force("cloth", np.arange(16), np.tile([0.1, 0.0, 0.0], (16, 1)))
    report = simulation.step()
    assert math.isclose(report["momentum"][0], 16 * 0.1 * simulation.dt, rel_tol=1e-9)
    assert abs(report["momentum"][1]) < 1e-12 < mass
    assert math.isclose(simulation.step()["momentum"][1], -0.3 * GRAVITY * simulation.dt, rel_tol=1e-9)


def test_a_collider_is_moved_and_pushes_what_lies_on_it() -> None:
    scene = taffeta.Scene().solver("ice", form="primal")
    scene.grid("cloth", rows=6, cols=6, size=(0.3, 0.3), material="cotton", position=(0, 0.011, 0))
    scene.box("table", half=(0.5, 0.1, 0.5), center=(0, -0.1, 0))
    simulation = taffeta.Simulation(scene, threads=1)
    start = simulation.positions()[:, 1].mean()
    for frame in range(1, 31):
        simulation.move_collider("table", (0.0, 0.005 * frame, 0.0))
        simulation.step()
    assert math.isclose(simulation.positions()[:, 1].mean() - start, 0.15, abs_tol=0.005)
    np.testing.assert_allclose(simulation.collider_pose("table")[:3, 3], [0, 0.15, 0], atol=1e-12)
    np.testing.assert_allclose(simulation.collider_pose("table", 0.5)[:3, 3], [0, 0.1475, 0], atol=1e-12)
    linear, angular = simulation.collider_velocity("table")
    np.testing.assert_allclose(linear, [0, 0.005 / simulation.dt, 0], atol=1e-9)
    assert not angular.any()
    near = simulation.collider_distances(1.0)
    assert near.shape == (36,)
    assert (np.abs(near) < 0.003).all()


def test_gravity_is_changed_while_it_runs() -> None:
    simulation = falling("f64")
    simulation.set_world(gravity=(0.0, 0.0, 2.0))
    simulation.step()
    assert math.isclose(simulation.report["momentum"][2], 0.3 * 2.0 * simulation.dt)
    assert simulation.world == {"gravity": [0.0, 0.0, 2.0], "drag": 0.0, "wind_force": [0.0, 0.0, 0.0]}


def test_a_restored_snapshot_goes_on_bit_by_bit(simulation: taffeta.Simulation) -> None:
    simulation.pin("cloth", 63, (0.5, 0.2, 0.5))
    simulation.set_world(drag=0.001)
    simulation.step(5)
    snapshot = simulation.snapshot()
    assert isinstance(snapshot, bytes)
    simulation.step(5)
    ends = simulation.state_hash(), simulation.report
    simulation.set_world(drag=0.5)
    simulation.unpin("cloth", 63)
    simulation.restore(snapshot)
    assert simulation.frame == 5
    assert simulation.world["drag"] == 0.001
    simulation.step(5)
    assert (simulation.state_hash(), simulation.report) == ends


def test_a_simulation_is_pickled_and_goes_on_the_same_in_another_process(
    simulation: taffeta.Simulation, tmp_path: Path
) -> None:
    simulation.step(4)
    file = tmp_path / "simulation.pickle"
    file.write_bytes(pickle.dumps(simulation))
    code = f"import pickle; s = pickle.load(open({str(file)!r}, 'rb')); s.step(3); print(s.frame, s.threads, s.state_hash())"
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    twin = copy.deepcopy(simulation)
    for one in (simulation, twin):
        one.step(3)
        assert said.split() == ["7", "1", one.state_hash()]


def test_a_state_is_adopted_by_a_scene_of_another_fabric(cloth: taffeta.Scene) -> None:
    simulation = taffeta.Simulation(cloth, threads=1)
    simulation.step(20)
    denim = taffeta.Simulation(simulation.scene.set("body.cloth.material.preset", "denim"), threads=1)
    denim.adopt_state(simulation)
    np.testing.assert_array_equal(denim.positions(), simulation.positions())
    np.testing.assert_array_equal(denim.velocities(), simulation.velocities())
    assert denim.frame == 20
    with pytest.raises(taffeta.SnapshotError, match=r"of another scene: `body\[0\]\.material\.preset` was \"cotton\" and is \"denim\""):
        denim.restore(simulation.snapshot())
    denim.step(5)
    simulation.step(5)
    assert denim.state_hash() != simulation.state_hash()
    denim.adopt_state(denim)


def test_a_body_that_diverges_is_named_and_the_last_good_frame_stays() -> None:
    scene = taffeta.Scene().time(dt=0.01)
    scene.grid("stiff", rows=4, cols=5, size=(0.4, 0.3), node_mass=1e-3, springs={"structural": {"k": 1e6}})
    scene.pin("stiff", nodes=0)
    with pytest.warns(taffeta.SceneWarning, match="longer than the largest stable step"):
        simulation = taffeta.Simulation(scene, threads=1)
    [warning] = simulation.warnings
    assert "longer than the largest stable step" in warning
    assert "time.max_step" in warning
    simulation.disturb(1e-3, seed=1)
    start = simulation.snapshot()
    with pytest.raises(taffeta.DivergedError) as raised:
        simulation.step(100)
    error = pickle.loads(pickle.dumps(raised.value))
    assert error.body == "stiff"
    assert error.frame == error.first == simulation.frame + 1
    assert 0 <= error.vertex < 20
    assert "time.max_step" in str(error)
    assert error.what and error.cause
    assert isinstance(error, ArithmeticError)
    assert np.isfinite(simulation.positions()).all()
    with pytest.raises(taffeta.DivergedError):
        simulation.step()
    with pytest.raises(taffeta.SnapshotError, match="diverged"):
        simulation.snapshot()
    simulation.restore(start)
    assert simulation.frame == 0

    frozen = taffeta.Simulation(scene, on_divergence="freeze")
    frozen.disturb(1e-3, seed=1)
    assert frozen.step(60)["frame"] == 60
    assert frozen.frozen == ["stiff"]


def test_intersections_are_counted() -> None:
    scene = taffeta.Scene().grid("lies", rows=4, cols=5, size=(0.4, 0.3), area_density=0.2)
    scene.grid("hangs", rows=4, cols=5, size=(0.4, 0.3), area_density=0.2, rotation=((1, 0, 0), 80.0))
    found = taffeta.Simulation(scene).intersections()
    assert found["pairs"] > 0
    assert "body `hangs`" in found["first"]
    assert found["complete"] is True
    lies = taffeta.Scene().grid("lies", rows=4, cols=5, size=(0.4, 0.3), area_density=0.2)
    assert taffeta.Simulation(lies).intersections() == {"pairs": 0, "first": None, "complete": True}


def test_reports_become_a_table_with_the_columns_of_the_program(
    simulation: taffeta.Simulation, cloth: taffeta.Scene, program: str, tmp_path: Path
) -> None:
    pandas = pytest.importorskip("pandas")
    table = taffeta.to_pandas([simulation.step() for _ in range(4)])
    file = tmp_path / "cloth.toml"
    file.write_text(cloth.to_toml())
    command = [program, "run", str(file), "--frames", "4", "--quiet", "--threads", "1", "--out", str(tmp_path / "out")]
    subprocess.run(command, check=True)
    written = pandas.read_csv(tmp_path / "out/frames.csv", index_col="frame").drop(0)
    shared = [column for column in written.columns if column not in ("ms", "intersections")]
    assert set(shared) <= set(table.columns)
    left = table[shared].astype(float)
    right = written[shared].astype(float)
    pandas.testing.assert_frame_equal(left, right, check_exact=True, check_names=False, check_index_type=False)


def test_it_says_what_it_is_and_shows_itself(simulation: taffeta.Simulation) -> None:
    simulation.step(3)
    assert repr(simulation).startswith("<taffeta.Simulation of cloth: frame 3, cpu, 1 thread, ")
    assert (simulation.backend, simulation.precision, simulation.threads) == ("cpu", "f32", 1)
    assert simulation.backend_reason == "the scene is too small to gain by a GPU"
    assert simulation.memory > 64 * 24
    html = simulation._repr_html_()
    assert "<td>cloth</td><td>64</td><td>98</td>" in html
    assert "http" not in html
    assert simulation.scene.to_dict()["body"][0]["name"] == "cloth"
    assert repr(simulation.bodies["cloth"]).startswith("<taffeta.Body cloth: 64 vertices, 1 pins, ")


def test_the_package_and_the_machine_say_what_they_are() -> None:
    said = subprocess.run([sys.executable, "-m", "taffeta", "--version"], capture_output=True, text=True, check=True)
    assert said.stdout == f"taffeta {taffeta.__version__}\n"
    said = subprocess.run([sys.executable, "-m", "taffeta"], capture_output=True, text=True, check=True)
    assert f"simd: {taffeta.info()['simd']}\n" in said.stdout
    assert taffeta.info()["threads"] == len(os.sched_getaffinity(0))


def test_nothing_of_a_simulation_is_left_when_it_is_gone(cloth: taffeta.Scene) -> None:
    import gc
    import weakref

    simulation = taffeta.Simulation(cloth)
    seen = weakref.ref(simulation)
    del simulation
    gc.collect()
    assert seen() is None


def test_a_gpu_goes_where_the_cpu_goes(cloth: taffeta.Scene) -> None:
    try:
        simulation = taffeta.Simulation(cloth, backend="gpu")
    except taffeta.DeviceError as error:
        pytest.skip(str(error))
    simulation.step(3)
    twin = taffeta.Simulation(cloth, backend="cpu")
    twin.step(3)
    assert (simulation.backend, simulation.backend_reason) == ("gpu", "asked for")
    np.testing.assert_allclose(simulation.positions(), twin.positions(), atol=1e-5)
    simulation.pin("cloth", 63, (0.5, 0.1, 0.5))
    simulation.step()
    np.testing.assert_array_equal(simulation.positions()[63], np.float32([0.5, 0.1, 0.5]))
    ended = simulation.snapshot()
    copied = pickle.loads(pickle.dumps(simulation))
    assert copied.backend == "gpu"
    assert copied.snapshot() == ended
