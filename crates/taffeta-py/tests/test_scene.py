"""Scenes: the same one from a file, from text, from a dict and built step by step."""

from __future__ import annotations

import copy
import pickle
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
import taffeta

TEXT = """
[solver]
method = "ice"
ice.form = "primal"

[[body]]
name = "cloth"
mesh.grid = { rows = 8, cols = 8, size = [1.0, 1.0] }
material.preset = "cotton"
place = { position = [0.0, 0.2, 0.0], rotation = { axis = [0.0, 1.0, 0.0], degrees = 30.0 } }
[[body.pin]]
select = { rows = [0, 0] }

[[collider]]
name = "ball"
sphere = { center = [0.0, -0.3, 0.0], radius = 0.2 }
"""


def built() -> taffeta.Scene:
    scene = taffeta.Scene().solver("ice", form="primal")
    place = {"position": np.array([0.0, 0.2, 0.0]), "rotation": ((0, 1, 0), 30)}
    scene.grid("cloth", rows=8, cols=np.int64(8), size=(1, 1), material="cotton", **place)
    return scene.pin("cloth", rows=0).sphere("ball", radius=0.2, center=np.float32([0.0, -0.3, 0.0]).astype(float).round(6))


def end(scene: taffeta.Scene | str | dict) -> str:
    simulation = taffeta.Simulation(scene, threads=1)
    simulation.step(5)
    return simulation.state_hash()


def test_a_scene_is_the_same_from_text_dict_file_and_builder(tmp_path: Path) -> None:
    file = tmp_path / "scene.toml"
    file.write_text(TEXT)
    data = taffeta.Scene(TEXT).to_dict()
    assert data["body"][0]["pin"] == [{"select": {"rows": [0, 0]}}]
    hashes = {end(TEXT), end(str(file)), end(taffeta.Scene(file)), end(data), end(built())}
    assert len(hashes) == 1


def test_toml_of_a_dict_is_the_same_scene() -> None:
    text = built().to_toml()
    assert end(text) == end(TEXT)
    assert taffeta.Scene(TEXT).to_toml() == TEXT, "as it was written"


def test_a_text_scene_can_be_built_on() -> None:
    scene = taffeta.Scene(TEXT.split("[[collider]]")[0])
    scene.sphere("ball", radius=0.2, center=(0.0, -0.3, 0.0))
    assert end(scene) == end(TEXT)


def test_set_changes_a_value_by_its_path_and_refuses_what_is_not_there() -> None:
    scene = taffeta.Scene(TEXT).set("body.cloth.material.preset", "denim").set("world.gravity", (0, -1.62, 0))
    assert scene.overrides == ['body.cloth.material.preset="denim"', "world.gravity=[0, -1.62, 0]"]
    by_hand = TEXT.replace("cotton", "denim") + "\n[world]\ngravity = [0.0, -1.62, 0.0]\n"
    assert end(scene) == end(by_hand)
    with pytest.raises(taffeta.SceneError, match=r"body\.sheet\.mass=1.*no `body` is called `sheet`"):
        scene.set("body.sheet.mass", 1)
    assert len(scene.overrides) == 2, "it is as before"


def test_a_builder_that_is_refused_leaves_the_scene_as_it_was() -> None:
    scene = taffeta.Scene(TEXT)
    before = scene.to_dict()
    with pytest.raises(taffeta.SceneError, match="unknown key `frictoin`.*did you mean `friction`"):
        scene.plane("floor", frictoin=0.5)  # type: ignore[call-arg]
    with pytest.raises(taffeta.SceneError, match=r"there is no body `sheet`; there are: cloth"):
        scene.pin("sheet", nodes=0)
    assert scene.to_dict() == before
    assert end(scene) == end(TEXT)


def test_a_scene_keeps_copies_of_what_it_is_given() -> None:
    data = taffeta.Scene(TEXT).to_dict()
    vertices = np.array([[0.0, 0, 0], [1, 0, 0], [1, 0, 1]])
    scene = taffeta.Scene(data).mesh("patch", vertices, [[0, 2, 1]], mass=0.1, position=(0, 5, 0))
    data["body"][0]["mesh"]["grid"]["rows"] = 3
    vertices[:] = 0.0
    simulation = taffeta.Simulation(scene)
    assert simulation.bodies["cloth"].vertices == 64
    assert simulation.positions("patch")[1].tolist() == [1.0, 5.0, 0.0]
    scene.to_dict()["body"].clear()
    assert len(scene.to_dict()["body"]) == 2


def test_scenes_are_copied_and_pickled_with_their_arrays() -> None:
    scene = built().mesh("patch", [[0, 0, 0], [1, 0, 0], [1, 0, 1]], [[0, 2, 1]], mass=0.1, position=(0, 5, 0))
    for other in (scene.copy(), copy.deepcopy(scene), pickle.loads(pickle.dumps(scene))):
        assert end(other) == end(scene)


def test_arrays_become_a_mesh_whose_vertices_stay_in_order() -> None:
    # A square of two triangles, a vertex of no face, and one that is there twice, as along a seam of texture coordinates.
    vertices = np.array([[0, 0, 0], [1, 0, 0], [1, 0, 1], [9, 9, 9], [0, 0, 0], [0, 0, 1]], np.float32)
    faces = [[0, 2, 1], [4, 5, 2]]
    scene = taffeta.Scene().mesh("patch", vertices, faces, material="cotton", groups={"hem": [0, 1]})
    simulation = taffeta.Simulation(scene.pin("patch", group="hem"))
    body = simulation.bodies["patch"]
    assert (body.vertices, body.nodes, body.pinned) == (6, 4, 2)
    np.testing.assert_array_equal(simulation.positions(), vertices)
    np.testing.assert_array_equal(simulation.faces(), faces)
    simulation.step(5)
    after = simulation.positions()
    np.testing.assert_array_equal(after[[0, 1, 3, 4]], vertices[[0, 1, 3, 4]])
    assert after[5, 1] < -0.01, "what is not pinned falls"


def test_objects_with_vertices_and_faces_are_meshes() -> None:
    class Mesh:
        vertices = np.array([[0.0, 0, 0], [1, 0, 0], [1, 0, 1], [0, 0, 1]])
        faces = np.array([[0, 3, 2, 1]], np.uint32)

    scene = taffeta.Scene().body("patch", Mesh(), mass=0.1)
    scene.mesh_collider("ground", Mesh.vertices - [0, 1, 0], Mesh.faces, offset=0.02)
    simulation = taffeta.Simulation(scene)
    assert simulation.faces().tolist() == [[0, 3, 2], [0, 2, 1]]
    assert simulation.colliders["ground"].shape == "mesh"


def test_files_are_looked_for_beside_the_scene(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "kite.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 0 1\nf 1 3 2\n")
    text = "[[body]]\nmesh.file = 'kite.obj'\narea_density = 0.05\n"
    (tmp_path / "kite.toml").write_text(text)
    monkeypatch.chdir(tmp_path)
    scene = taffeta.Scene("kite.toml")
    monkeypatch.chdir("/")
    assert taffeta.Simulation(scene).bodies["body0"].vertices == 3
    assert taffeta.Simulation(taffeta.Scene(text, folder=tmp_path)).bodies["body0"].vertices == 3
    with pytest.raises(taffeta.SceneError, match="`kite.obj` was not found"):
        taffeta.Simulation(text)


def test_every_kind_of_number_is_one() -> None:
    data = taffeta.Scene(TEXT).to_dict()
    data["body"][0]["mesh"]["grid"]["rows"] = np.uint8(8)
    data["body"][0]["place"]["position"] = (0, Fraction(1, 5), np.float64(0))
    data["title"] = Path("x")
    data["sleep"] = None
    assert end(data) == end(TEXT)


def test_every_scene_of_the_repository_is_read(scenes: Path) -> None:
    files = sorted(scenes.glob("*.toml"))
    assert len(files) > 30
    for file in files:
        scene = taffeta.Scene(file)
        assert scene.to_toml() == file.read_text()
        again = taffeta.Scene(scene.to_dict(), folder=scenes)
        assert again.to_dict() == scene.to_dict()
        assert scene.frames == scene.to_dict()["time"].get("frames")


def test_a_scene_shows_itself_without_anything_from_elsewhere() -> None:
    html = built().title("a <b>")._repr_html_()
    assert "<td>cloth</td><td>cloth</td><td>grid, cotton</td>" in html
    assert "a &lt;b&gt;" in html
    assert "http" not in html
    assert repr(built()) == "<taffeta.Scene of cloth and ball>"
