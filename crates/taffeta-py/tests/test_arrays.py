"""Arrays: their types and shapes, and those of the user that are written to."""

from __future__ import annotations

import tracemalloc

import numpy as np
import pytest
import taffeta

READS = ("positions", "velocities", "normals")


@pytest.fixture
def two() -> taffeta.Simulation:
    scene = taffeta.Scene().grid("first", rows=3, cols=4, size=(1, 1), area_density=0.2, position=(0, 1, 0))
    ball = {"icosphere": {"radius": 0.5, "subdivisions": 2}}
    springs = {"structural": {"k": 100.0, "d": 0.1}}
    scene.body("second", ball, kind="soft", density=100.0, springs=springs, velocity=(0, 0, 1), position=(0, -2, 0))
    return taffeta.Simulation(scene, threads=1)


@pytest.mark.parametrize(("precision", "dtype"), [("f32", np.float32), ("f64", np.float64)])
@pytest.mark.parametrize("read", READS)
def test_arrays_are_vertices_by_three_in_the_precision_of_the_run(
    cloth: taffeta.Scene, read: str, precision: str, dtype: type
) -> None:
    array = getattr(taffeta.Simulation(cloth, precision=precision), read)()
    assert array.shape == (64, 3)
    assert array.dtype == dtype
    assert array.flags.c_contiguous and array.flags.writeable


def test_in_64_bits_all_digits_are_there(cloth: taffeta.Scene) -> None:
    simulation = taffeta.Simulation(cloth, precision="f64", threads=1)
    simulation.step(2)
    for read in READS:
        array = getattr(simulation, read)()
        assert (array != array.astype(np.float32)).any(), read


@pytest.mark.parametrize("read", READS)
def test_bodies_are_slices_of_all(two: taffeta.Simulation, read: str) -> None:
    two.step(2)
    everything = getattr(two, read)()
    assert [body.rows for body in two.bodies.values()] == [slice(0, 12, 1), slice(12, 174, 1)]
    for name, body in two.bodies.items():
        np.testing.assert_array_equal(getattr(two, read)(name), everything[body.rows])


def test_normals_of_a_ball_point_outwards_and_faces_go_round_them(two: taffeta.Simulation) -> None:
    outwards = two.positions("second") - [0, -2, 0]
    radial = outwards / np.linalg.norm(outwards, axis=1, keepdims=True)
    assert (np.sum(two.normals("second") * radial, axis=1) > 0.99).all()
    faces = two.faces("second")
    assert faces.dtype == np.uint32
    assert faces.shape == (two.bodies["second"].triangles, 3)
    a, b, c = (outwards[faces[:, corner]] for corner in range(3))
    assert (np.sum(np.cross(b - a, c - a) * (a + b + c), axis=1) > 0).all()
    np.testing.assert_array_equal(two.faces()[-len(faces) :], faces + 12)


@pytest.mark.parametrize("read", READS)
def test_out_is_written_and_returned_and_nothing_is_allocated(two: taffeta.Simulation, read: str) -> None:
    two.step()
    method = getattr(two, read)
    wanted = method()
    out = np.full((174, 3), np.nan, np.float32)
    assert method(out=out) is out
    np.testing.assert_array_equal(out, wanted)
    part = np.full((200, 3), np.nan, np.float32)
    method("second", out=part[10:172])
    np.testing.assert_array_equal(part[10:172], wanted[12:])
    assert np.isnan(part[:10]).all() and np.isnan(part[172:]).all()
    tracemalloc.start()
    for _ in range(10):
        method(out=out)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    # Numpy says what it allocates: an array has 2,088 bytes.
    assert peak < 1000


@pytest.mark.parametrize(
    ("out", "words"),
    [
        (np.zeros((64, 3)), "out: has the dtype float64; float32 would do"),
        (np.zeros((64, 3), ">f4"), "out: has the dtype >f4; float32 would do"),
        (np.zeros((63, 3), np.float32), r"out: has the shape \[63, 3\]; \[64, 3\] would do"),
        (np.zeros(192, np.float32), r"out: has the shape \[192\]; \[64, 3\] would do"),
        (np.zeros((64, 6), np.float32)[:, ::2], "out: is not contiguous"),
        (np.zeros((3, 64), np.float32).T, "out: is not contiguous"),
        (np.zeros((128, 3), np.float32)[::2], "out: is not contiguous"),
        ([[0.0] * 3] * 64, "out: is no numpy array but list"),
    ],
)
def test_an_array_that_does_not_fit_is_refused_and_not_touched(
    simulation: taffeta.Simulation, out: object, words: str
) -> None:
    with pytest.raises(taffeta.InputError, match=words):
        simulation.positions(out=out)  # type: ignore[call-overload]
    if isinstance(out, np.ndarray):
        assert not out.any()


def test_an_array_that_is_read_only_is_refused(simulation: taffeta.Simulation) -> None:
    out = np.zeros((64, 3), np.float32)
    out.flags.writeable = False
    with pytest.raises(taffeta.InputError, match="out: cannot be written to"):
        simulation.positions(out=out)


def test_arrays_stay_what_they_were_when_the_simulation_goes_on(simulation: taffeta.Simulation) -> None:
    before = simulation.positions()
    copied = before.copy()
    simulation.step(5)
    del simulation
    np.testing.assert_array_equal(before, copied)


def test_arrays_are_shared_by_dlpack(simulation: taffeta.Simulation) -> None:
    positions = simulation.positions()
    shared = np.from_dlpack(positions)
    np.testing.assert_array_equal(shared, positions)
    assert np.shares_memory(shared, positions)
