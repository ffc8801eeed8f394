"""Mistakes: each is an exception of taffeta whose words name what was written and what would do."""

from __future__ import annotations

import pickle
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import taffeta

GRID = {"grid": {"rows": 4, "cols": 5, "size": [0.4, 0.3]}}


def body(**keys: Any) -> dict[str, Any]:
    return {"body": [{"name": "cloth", "mesh": GRID, "area_density": 0.2, **keys}]}


TRIANGLE = {"vertices": np.eye(3), "faces": [[0, 1, 2]]}
HEIGHTS: list[Any] = []
HEIGHTS.append(HEIGHTS)

SCENES: list[tuple[Any, str]] = [
    # Keys, words and types.
    (body(mas=1.0), "unknown key `mas` in `body[0]`; did you mean `mass`?"),
    ({"bodies": []}, "unknown key `bodies`; did you mean `body`?"),
    ({"solver": {"method": "icy"}}, "`solver.method` cannot be `icy`; did you mean `ice`?"),
    (body(mesh={"grid": {"rows": 4, "cols": 5}}), "missing key `size` in `body[0].mesh.grid`"),
    (body(mesh={"gird": {}}), "unknown key `gird` in `body[0].mesh`; did you mean `grid`?"),
    (body(mesh=3), "`body[0].mesh` is 3"),
    (body(area_density="heavy"), "`body[0].area_density` is the text \"heavy\"; expected a number"),
    (body(velocity=[1.0, 2.0]), "`body[0].velocity` has 2 entries; expected a list of 3 entries"),
    (body(material={"preset": "coton"}), "cotton"),
    # Numbers.
    (body(area_density=-0.2), "`body[0].area_density`: is -0.2 kg/m²"),
    (body(area_density=float("nan")), "nan is not a finite number"),
    (body(area_density=np.inf), "inf is not a finite number"),
    (body(area_density=10**30), "does not fit 64 bits"),
    (body(area_density=None), "`body[0]`: "),
    # Python's own.
    (body(area_density=object()), "of type object; a number, text, list, dict or array would do"),
    (body(name=b"cloth"), "`body[0].name` is b'cloth', of type bytes"),
    (body(velocity=[0, None, 0]), "`body[0].velocity[1]` is None"),
    ({1: 2}, "the key 1 is no text"),
    ({"collider": [{"heightfield": {"size": [1, 1], "heights": HEIGHTS}}]}, "nested more than 32 deep"),
    ({"title": "\ud800"}, "is not Unicode"),
    # Meshes of arrays.
    (body(mesh={"vertices": np.eye(3)}), "`body[0].mesh` has no `faces`"),
    (body(mesh={**TRIANGLE, "uv": 1}), "unknown key `uv` in `body[0].mesh`. Valid beside arrays: vertices, faces, uvs, groups"),
    (body(mesh={**TRIANGLE, "vertices": np.zeros((3, 2))}), "`body[0].mesh.vertices` has the shape [3, 2]; [n, 3] would do"),
    (body(mesh={**TRIANGLE, "vertices": "abc"}), "`body[0].mesh.vertices` is no array of numbers"),
    (body(mesh={**TRIANGLE, "vertices": np.full((3, 3), np.nan)}), "vertex 0 is at [NaN, NaN, NaN]; coordinates must be finite"),
    (body(mesh={**TRIANGLE, "vertices": np.zeros((3, 3))}), "no triangles: the only face has no area"),
    (body(mesh={**TRIANGLE, "faces": [[0, 1, 3]]}), "`body[0].mesh`: "),
    (body(mesh={**TRIANGLE, "faces": [[0, 1, -1]]}), "`body[0].mesh.faces[0]` names vertex -1"),
    (body(mesh={**TRIANGLE, "faces": [[0, 1]]}), "`body[0].mesh.faces` has the shape [1, 2]"),
    (body(mesh={**TRIANGLE, "faces": [[0, 1, 2], [0, 1]]}), "`body[0].mesh.faces[1]` has 2 corners; 3 or more would do"),
    (body(mesh={**TRIANGLE, "faces": [[0.0, 1.5, 2.0]]}), "`body[0].mesh.faces` is no array of whole numbers"),
    (body(mesh={**TRIANGLE, "uvs": np.zeros((2, 2))}), "`body[0].mesh.uvs` has 2 rows; one for each of 3 vertices would do"),
    (body(mesh={**TRIANGLE, "groups": [1]}), "`body[0].mesh.groups` is no dict of names with lists of vertices"),
    (body(mesh={**TRIANGLE, "groups": {"hem": [7]}}), "group `hem` has a vertex that is not there"),
    # What cannot be.
    (body(mesh={"file": "../../etc/passwd"}), "is not a path inside the scene's folder"),
    (body(mesh={"grid": {"rows": 4_000_000, "cols": 4_000_000, "size": [1, 1]}}), "`body[0].mesh.grid`: makes about 16000000000000 nodes, 2147483648 are the limit"),
    (body(mesh={"grid": {"rows": 40_000, "cols": 40_000, "size": [1, 1]}}), "of memory"),
    (body(pin=[{"select": {"nodes": [20]}}]), "`body[0].pin[0]"),
    ({}, "body"),
]


@pytest.mark.parametrize(("data", "words"), SCENES, ids=[words[:50] for _, words in SCENES])
def test_what_is_no_scene_is_refused_in_words(data: dict[Any, Any], words: str) -> None:
    with pytest.raises(taffeta.SceneError) as raised:
        taffeta.Simulation(data)
    assert words in str(raised.value)
    assert raised.value.line is None, "nobody has written lines"
    assert isinstance(raised.value, (taffeta.Error, ValueError))


def test_a_text_is_refused_with_file_line_and_column(tmp_path: Path) -> None:
    text = "[[body]]\nmesh.grid = { rows = 4, cols = 5, size = [0.4, 0.3] }\nmas = 1.0\n"
    file = tmp_path / "flag.toml"
    file.write_text(text)
    with pytest.raises(taffeta.SceneError) as raised:
        taffeta.Scene(file)
    assert str(raised.value).startswith(f"{file}:3:1: unknown key `mas` in `body[0]`; did you mean `mass`?")
    again = pickle.loads(pickle.dumps(raised.value))
    assert (again.file, again.line, again.column) == (str(file), 3, 1)
    assert str(again) == str(raised.value)
    # Also where the engine finds it, and in a text.
    with pytest.raises(taffeta.SceneError, match=r"^scene.toml:3:8: `body\[0\]\.mass`: is -1 kg"):
        taffeta.Simulation(text.replace("mas = 1.0", "mass = -1"))
    with pytest.raises(taffeta.SceneError, match=r"^scene.toml:1:8: not valid TOML"):
        taffeta.Scene("[[body]\n")
    with pytest.raises(taffeta.SceneError, match="flga.toml: cannot be read: No such file"):
        taffeta.Scene("flga.toml")
    with pytest.raises(taffeta.SceneError, match="bunny.ply: is a mesh and not a scene"):
        taffeta.Scene("bunny.ply")
    with pytest.raises(taffeta.SceneError, match="a scene is a path, TOML text, a dict or a Scene; this is of type int"):
        taffeta.Simulation(3)  # type: ignore[arg-type]


CALLS: list[tuple[Callable[[taffeta.Simulation], object], str]] = [
    (lambda s: s.positions("sheet"), "there is no body `sheet`; there are: cloth"),
    (lambda s: s.faces("sheet"), "there is no body `sheet`; there are: cloth"),
    (lambda s: s.pin("sheet", 0), "there is no body `sheet`; there are: cloth"),
    (lambda s: s.pin("cloth", 64), "body `cloth` has vertices 0 to 63, not 64"),
    (lambda s: s.pin("cloth", [0, 64], (0, 0, 0)), "body `cloth` has vertices 0 to 63, not 64"),
    (lambda s: s.pin("cloth", -1), "vertices are whole numbers from 0 on"),
    (lambda s: s.pin("cloth", "all"), "vertices are whole numbers from 0 on"),
    (lambda s: s.pin("cloth", np.arange(64) < 3), "vertices are booleans; numpy.flatnonzero makes numbers of them"),
    (lambda s: s.pin("cloth", [True, False]), "vertices are booleans"),
    (lambda s: s.pin("cloth", 0, (0, 0)), "to is no array of numbers [3] or [1, 3]"),
    (lambda s: s.pin("cloth", [0, 1], np.zeros((3, 3))), "to is no array of numbers [3] or [2, 3]"),
    (lambda s: s.pin("cloth", 9, (0, 0, 2e6)), "1000000"),
    (lambda s: s.pin("cloth", 9, (0, 0, np.nan)), "NaN"),
    (lambda s: s.unpin("cloth", 99), "not 99"),
    (lambda s: s.apply_force("cloth", 9, (0, np.inf, 0)), "force"),
    (lambda s: s.apply_force("cloth", 9, "up"), "force is no array of numbers [3] or [1, 3]"),
    (lambda s: s.move_pin("cloth", 1, (0, 0, 0)), "body `cloth` has 1 pins and none with index 1"),
    (lambda s: s.move_pin("cloth", -1, (0, 0, 0)), "pin is -1; 0 or more would do"),
    (lambda s: s.move_pin("cloth", 0, (0, 0, 0)), "pin 0 of body `cloth` never moves; a keyframe at t = 0 makes a pin movable"),
    (lambda s: s.reaction("cloth", 3), "body `cloth` has 1 pins and none with index 3"),
    (lambda s: s.move_collider("ball", (0, 0, 0)), "there is no collider `ball`; there are none"),
    (lambda s: s.move_collider("ball", np.eye(3)), "a pose is an array of numbers: a shift [3], or a rigid matrix [4, 4]"),
    (lambda s: s.move_collider("ball", 2 * np.eye(4)), "the last row of a pose is [0.0, 0.0, 0.0, 2.0]"),
    (lambda s: s.move_collider("ball", np.diag([2.0, 1, 1, 1])), "are no rotation"),
    (lambda s: s.collider_pose("ball"), "there is no collider `ball`"),
    (lambda s: s.set_world(gravty=(0, 0, 0)), "unknown key `gravty` in `world`; did you mean `gravity`?"),
    (lambda s: s.set_world(drag=-1.0), "drag"),
    (lambda s: s.set_world(gravity=(0, 0)), "`world.gravity` has 2 entries"),
    (lambda s: s.set_world(air={}), "cannot be added to a scene that was built without air"),
    (lambda s: s.step(-1), "frames is -1; 0 to 4294967295 would do"),
    (lambda s: s.step(2**40), "frames is 1099511627776"),
    (lambda s: s.advance(-1.0), "seconds is -1; 0 to "),
    (lambda s: s.advance(np.nan), "seconds is NaN"),
    (lambda s: s.disturb(np.inf), "amplitude is inf; a finite number would do"),
    (lambda s: s.disturb(0.1, -1), "seed is -1"),
    (lambda s: s.limit_threads(0), "most is 0; 1 or more would do"),
    (lambda s: s.restore(b""), "not a checkpoint of taffeta"),
    (lambda s: s.restore(s.snapshot()[:-1]), "damaged"),
    (lambda s: s.restore(bytes(s.snapshot()[:-9]) + b"123456789"), "damaged: its checksum does not fit its content"),
    (lambda s: taffeta.Simulation(s.scene, backend="cuda"), 'backend is "cuda"; "auto" or "cpu" or "gpu" would do'),
    (lambda s: taffeta.Simulation(s.scene, precision="f16"), 'precision is "f16"; "f32" or "f64" would do'),
    (lambda s: taffeta.Simulation(s.scene, on_divergence="go"), 'on_divergence is "go"; "stop" or "freeze" would do'),
    (lambda s: taffeta.Simulation(s.scene, threads=0), "threads is 0; 1 to 1024 would do"),
    (lambda s: taffeta.Simulation(s.scene, threads=10**9), "threads is 1000000000; 1 to 1024 would do"),
    (lambda _: taffeta.pose(axis=(0, 0, 0)), "three numbers with a direction would do"),
]


@pytest.mark.parametrize(("call", "words"), CALLS, ids=[words[:50] for _, words in CALLS])
def test_what_cannot_be_asked_is_refused_in_words_and_nothing_changes(
    simulation: taffeta.Simulation, call: Callable[[taffeta.Simulation], object], words: str
) -> None:
    simulation.step(2)
    before = simulation.snapshot()
    with pytest.raises(taffeta.InputError) as raised:
        call(simulation)
    assert words in str(raised.value)
    assert simulation.snapshot() == before


def test_a_gpu_computes_in_32_bits(cloth: taffeta.Scene) -> None:
    with pytest.raises(taffeta.DeviceError) as raised:
        taffeta.Simulation(cloth, backend="gpu", precision="f64")
    assert "32 bits" in str(raised.value) or "no GPU was found" in str(raised.value)


def test_what_python_refuses_itself_is_a_type_error(simulation: taffeta.Simulation) -> None:
    for call in (lambda: simulation.step("a"), lambda: simulation.positions(3), lambda: simulation.restore("a")):  # type: ignore[arg-type,call-overload]
        with pytest.raises(TypeError):
            call()


def test_every_exception_is_one_of_taffeta() -> None:
    for name in ("SceneError", "InputError", "SnapshotError", "DivergedError", "DeviceError", "InternalError"):
        assert issubclass(getattr(taffeta, name), taffeta.Error)
