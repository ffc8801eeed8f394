"""Blender without a window, with the packed extension installed as a user would: TAFFETA_ZIP names it."""

import os
import tempfile
from pathlib import Path

RESOURCES = Path(tempfile.mkdtemp(prefix="taffeta_blender_"))
os.environ["BLENDER_USER_RESOURCES"] = str(RESOURCES)

import bpy  # noqa: E402
import numpy as np  # noqa: E402
import pytest  # noqa: E402

ZIP = os.environ["TAFFETA_ZIP"]


@pytest.fixture(scope="session", autouse=True)
def _installed():
    bpy.ops.extensions.package_install_files(filepath=ZIP, repo="user_default", enable_on_install=True)
    assert "bl_ext.user_default.taffeta" in bpy.context.preferences.addons


class World:
    """A new file, and what tests do in it."""

    def __init__(self):
        bpy.ops.wm.read_homefile(use_empty=True, load_ui=False)
        self.scene.frame_start, self.scene.frame_end = 1, 13

    @property
    def scene(self):
        return bpy.context.scene

    def grid(self, name, cells=12, size=1.0, role="CLOTH", **where):
        bpy.ops.mesh.primitive_grid_add(x_subdivisions=cells, y_subdivisions=cells, size=size, calc_uvs=True, **where)
        return self._named(name, role)

    def ball(self, name, radius=0.3, role="COLLIDER", detail=3, **where):
        bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=detail, radius=radius, calc_uvs=True, **where)
        return self._named(name, role)

    def cube(self, name, size=1.0, role="COLLIDER", **where):
        bpy.ops.mesh.primitive_cube_add(size=size, **where)
        return self._named(name, role)

    def _named(self, name, role):
        one = bpy.context.object
        one.name = one.data.name = name
        one.taffeta.role = role
        return one

    def pin(self, one, chosen, weight=1.0, group="pinned"):
        """Pins vertices by a function of their places in the object."""
        found = one.vertex_groups.get(group) or one.vertex_groups.new(name=group)
        found.add([vertex.index for vertex in one.data.vertices if chosen(vertex.co)], weight, "REPLACE")
        one.taffeta.pin_group = group
        return one

    def bake(self, **how):
        return bpy.ops.taffeta.bake(**how)

    def refused(self, **how):
        """What a bake that is refused says."""
        with pytest.raises(RuntimeError) as error:
            self.bake(**how)
        return str(error.value)

    def at(self, one, frame, world=True):
        """Places of an object's vertices in a frame [vertices, 3]."""
        self.scene.frame_set(frame)
        copy = one.evaluated_get(bpy.context.evaluated_depsgraph_get())
        mesh = copy.to_mesh()
        points = np.empty(3 * len(mesh.vertices), np.float32)
        mesh.vertices.foreach_get("co", points)
        copy.to_mesh_clear()
        points = points.reshape(-1, 3).astype(np.float64)
        if not world:
            return points
        matrix = np.array(copy.matrix_world)
        return points @ matrix[:3, :3].T + matrix[:3, 3]

    def folder(self, one):
        """Where the cache of an object is."""
        return Path(bpy.path.abspath(one.modifiers["Taffeta"].filepath)).parent


@pytest.fixture
def world():
    return World()
