"""Scenes as artists have them: armatures, parents, scales, modifiers, two scenes, names."""

import math

import bpy
import numpy as np
import pytest
from mathutils import Matrix
from mathutils.kdtree import KDTree


def rig(world, chain=(("hips", 0.0, 0.2), ("spine", 0.2, 0.7))):
    armature = bpy.data.armatures.new("rig")
    one = bpy.data.objects.new("rig", armature)
    world.scene.collection.objects.link(one)
    bpy.context.view_layer.objects.active = one
    bpy.ops.object.mode_set(mode="EDIT")
    parent = None
    for name, head, tail in chain:
        bone = armature.edit_bones.new(name)
        bone.head, bone.tail, bone.parent = (0, 0, head), (0, 0, tail), parent
        parent = bone
    bpy.ops.object.mode_set(mode="OBJECT")
    return one


def skin(one, armature, of):
    for name in ("hips", "spine"):
        one.vertex_groups.new(name=name)
    for vertex in one.data.vertices:
        upper = of(vertex.co)
        one.vertex_groups["hips"].add([vertex.index], 1 - upper, "REPLACE")
        one.vertex_groups["spine"].add([vertex.index], upper, "REPLACE")
    one.modifiers.new("Armature", "ARMATURE").object = armature


def tube(world, name, radius, low, high, around=48, rings=20):
    """An open tube about the z axis, of quads."""
    angles = 2 * np.pi * np.arange(around) / around
    heights = np.linspace(low, high, rings)
    points = [(radius * np.cos(angle), radius * np.sin(angle), height) for height in heights for angle in angles]
    quads = [
        (ring * around + i, ring * around + (i + 1) % around, (ring + 1) * around + (i + 1) % around, (ring + 1) * around + i)
        for ring in range(rings - 1)
        for i in range(around)
    ]
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(points, [], quads)
    one = bpy.data.objects.new(name, mesh)
    world.scene.collection.objects.link(one)
    one.taffeta.role = "CLOTH"
    return one


def test_a_shirt_follows_an_animated_armature(world):
    """Pinned vertices are where the armature has them, in each frame, and the body never comes through the shirt."""
    armature = rig(world)
    body = world.ball("body", radius=0.25, detail=4)
    body.data.transform(Matrix.Diagonal((1, 1, 2.4, 1)))
    shirt = tube(world, "shirt", 0.29, -0.3, 0.45)
    for one in (body, shirt):
        skin(one, armature, lambda x: min(max(x.z / 0.4, 0.0), 1.0))
    world.pin(shirt, lambda x: x.z > 0.40)
    bone = armature.pose.bones["spine"]
    bone.rotation_mode = "XYZ"
    for frame, angle in ((1, 0.0), (8, 0.5), (16, -0.3)):
        bone.rotation_euler = (angle, 0.2 * angle, 0)
        bone.keyframe_insert("rotation_euler", frame=frame)
    armature.location.x = 0.0
    armature.keyframe_insert("location", frame=1)
    armature.location.x = 0.3
    armature.keyframe_insert("location", frame=16)
    world.scene.frame_end = 16
    goal = [world.at(shirt, frame) for frame in range(1, 17)]
    inside = [world.at(body, frame) for frame in range(1, 17)]
    world.bake()
    held = np.array([vertex.co.z > 0.40 for vertex in shirt.data.vertices])
    assert [modifier.name for modifier in shirt.modifiers] == ["Armature", "Taffeta"]
    for frame in range(1, 17):
        now = world.at(shirt, frame)
        assert np.abs(now[held] - goal[frame - 1][held]).max() < 2e-6, frame
        # The free ones lag behind the motion, but not far.
        assert np.abs(now - goal[frame - 1]).max() < 0.5
        tree = KDTree(len(inside[frame - 1]))
        for index, point in enumerate(inside[frame - 1]):
            tree.insert(point, index)
        tree.balance()
        nearest = min(tree.find(point)[2] for point in now)
        assert nearest > 1e-3, (frame, nearest)
    assert np.abs(world.at(shirt, 16) - goal[15]).max() > 0.01, "cloth does more than its armature"


def test_weights_between_pull_more_the_larger_they_are(world):
    curtain = world.grid("curtain", location=(0, 0, 1))
    world.pin(curtain, lambda x: x.y > 0.49)
    world.scene.frame_end = 40
    sags = []
    for weight in (0.1, 0.5, 0.9):
        world.pin(curtain, lambda x: x.y < -0.49, weight=weight)
        world.bake()
        start, end = world.at(curtain, 1), world.at(curtain, 40)
        sags.append((start - end)[:, 2].max())
    assert sags[0] > sags[1] + 0.01 > sags[2] + 0.02, sags


def test_objects_may_be_scaled_turned_mirrored_and_parented(world):
    """A sheet falls the same, whatever its transform is, and its cache is in its own coordinates."""
    world.scene.taffeta.air = False
    parent = bpy.data.objects.new("parent", None)
    world.scene.collection.objects.link(parent)
    parent.rotation_euler = (0.3, 0.2, 0.9)
    parent.location = (1, 2, 0.5)
    for frame, x in ((1, 0.0), (13, 0.7)):
        parent.location.x = x
        parent.keyframe_insert("location", frame=frame)
    sheet = world.grid("sheet", location=(0, 0, 2), rotation=(0.4, 0, 0.1), scale=(1, 1, 1))
    sheet.scale = (-0.5, 2, 1)
    sheet.parent = parent
    before = world.at(sheet, 1)
    world.bake()
    after = world.at(sheet, 13)
    fallen = after - before
    # It falls freely: nothing of its parent's motion carries it.
    assert np.abs(fallen - [0, 0, fallen[:, 2].mean()]).max() < 0.02
    assert fallen[:, 2].mean() == pytest.approx(-0.5 * 9.81 * 0.25, rel=0.02)


def test_modifiers_above_work_on_the_cache_and_those_below_are_simulated(world):
    sheet = world.grid("sheet", cells=6, location=(0, 0, 1))
    mirror = sheet.modifiers.new("Mirror", "MIRROR")
    mirror.use_axis = (False, True, False)
    sheet.data.transform(Matrix.Translation((0, 0.5, 0)))
    sheet.modifiers.new("Thick", "SOLIDIFY").thickness = 0.02
    sheet.modifiers.new("Smooth", "SUBSURF").levels = 1
    world.pin(sheet, lambda x: x.y < 0.01)
    world.scene.frame_end = 20
    world.bake()
    assert [modifier.name for modifier in sheet.modifiers] == ["Mirror", "Taffeta", "Thick", "Smooth"]
    assert all(modifier.show_viewport for modifier in sheet.modifiers)
    both_halves = 2 * 49 - 7
    assert (world.folder(sheet) / "sheet.pc2").stat().st_size == 32 + 12 * both_halves * 20
    last = world.at(sheet, 20)
    assert len(last) > 4 * both_halves
    # Both halves hang down from the seam in the middle.
    assert last[:, 2].min() < 0.7 and abs(last[:, 1].min() + last[:, 1].max()) < 0.05


def test_a_pressed_soft_body_keeps_its_volume(world):
    ball = world.ball("ball", role="SOFT", radius=0.3, location=(0, 0, 0.31))
    ball.taffeta.mass = 2
    world.cube("floor", size=4, location=(0, 0, -2))
    press = world.cube("press", size=1, location=(0, 0, 1.15))
    press.keyframe_insert("location", frame=1)
    press.location.z = 0.93
    press.keyframe_insert("location", frame=20)
    world.scene.frame_end = 24
    world.bake()
    volumes = [volume(world, ball, frame) for frame in (1, 24)]
    assert volumes[1] == pytest.approx(volumes[0], rel=0.02)
    end = world.at(ball, 24)
    assert np.ptp(end[:, 2]) < 0.5 and np.ptp(end[:, 0]) > 0.62, "it is flat, and wide"


def volume(world, one, frame):
    points = world.at(one, frame)
    mesh = one.data
    mesh.calc_loop_triangles()
    corners = points[np.array([list(triangle.vertices) for triangle in mesh.loop_triangles])]
    return np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6


def test_sewing_edges_pull_their_ends_together(world):
    import bmesh

    sheet = world.grid("panels", cells=6, location=(0, 0, 1))
    mesh = bmesh.new()
    mesh.from_mesh(sheet.data)
    copy = bmesh.ops.duplicate(mesh, geom=mesh.verts[:] + mesh.edges[:] + mesh.faces[:])
    moved = [one for one in copy["geom"] if isinstance(one, bmesh.types.BMVert)]
    bmesh.ops.translate(mesh, verts=moved, vec=(0, 0, 0.2))
    mesh.verts.ensure_lookup_table()
    rim = [vertex for vertex in mesh.verts[:49] if abs(vertex.co.x) > 0.49]
    for vertex in rim:
        mesh.edges.new((vertex, mesh.verts[vertex.index + 49 if vertex.index >= 0 else 0]))
    mesh.to_mesh(sheet.data)
    mesh.free()
    sheet.taffeta.sewing = True
    world.scene.gravity = (0, 0, -0.5)
    world.scene.frame_end = 24
    pairs = [edge.vertices[:] for edge in sheet.data.edges if edge.is_loose]
    assert len(pairs) == 14
    world.bake()
    end = world.at(sheet, 24)
    apart = [np.linalg.norm(end[a] - end[b]) for a, b in pairs]
    assert max(apart) < 1e-3, max(apart)


def test_tethers_keep_rubber_from_stretching(world):
    curtain = world.pin(world.grid("curtain", location=(0, 0, 2)), lambda x: x.y > 0.49)
    kept = curtain.taffeta
    kept.fabric, kept.stretch, kept.shear = "custom", (5, 5), 1
    world.scene.frame_end = 36
    lowest = []
    for tethers in (False, True):
        kept.tethers = tethers
        world.bake()
        lowest.append(min(world.at(curtain, frame)[:, 2].min() for frame in range(1, 37)))
    # The rail is at 2 m and the sheet 1 m long, lying: its rail is 0.5 m from its middle.
    assert lowest[1] > 0.99 and lowest[0] < 0.9, lowest


def test_wind_blows_along_its_own_axis(world):
    flag = world.pin(world.grid("flag", location=(0, 0, 1), rotation=(math.pi / 2, 0, 0)), lambda x: x.y > 0.49)
    bpy.ops.object.effector_add(type="WIND", rotation=(-math.pi / 2, 0, 0))
    wind = bpy.context.object
    wind.field.strength, wind.field.noise = 6, 0.5
    world.scene.frame_end = 30
    world.bake()
    assert world.at(flag, 30)[:, 1].mean() > 0.15
    wind.field.strength = -6
    world.bake()
    assert world.at(flag, 30)[:, 1].mean() < -0.15


def test_two_scenes_have_caches_of_their_own(world):
    first = world.scene
    sheet = world.grid("sheet", location=(0, 0, 1))
    world.bake()
    bpy.ops.scene.new(type="FULL_COPY")
    second = world.scene
    assert second is not first
    copy = next(one for one in second.objects if one.taffeta.role == "CLOTH")
    second.gravity = (0, 0, 3)
    second.frame_start, second.frame_end = 5, 17
    world.bake()
    assert world.folder(copy) != world.folder(sheet)
    assert world.at(copy, 17)[:, 2].mean() > 1.2
    bpy.context.window.scene = first
    assert world.at(sheet, 13)[:, 2].mean() < 0.6


def test_objects_may_share_a_mesh_and_have_any_name(world):
    sheet = world.grid("my sheet/№ 1", location=(0, 0, 1))
    twin = sheet.copy()
    twin.name = "MY SHEET/№ 1"
    twin.location = (3, 0, 2)
    world.scene.collection.objects.link(twin)
    twin.taffeta.fabric = "denim"
    quoted = world.grid("\"quoted\" `back` 'x'\\", location=(0, 3, 1))
    world.bake()
    paths = {one.modifiers["Taffeta"].filepath for one in (sheet, twin, quoted)}
    assert len({path.lower() for path in paths}) == 3
    for one in (sheet, twin, quoted):
        assert world.at(one, 13)[:, 2].mean() < one.location.z - 0.4


def test_a_mesh_that_is_no_manifold_is_cloth_all_the_same(world):
    import bmesh

    sheet = world.grid("fins", cells=6, location=(0, 0, 1))
    mesh = bmesh.new()
    mesh.from_mesh(sheet.data)
    mesh.edges.ensure_lookup_table()
    rim = [edge for edge in mesh.edges if all(abs(vertex.co.x) < 0.01 for vertex in edge.verts)]
    fin = bmesh.ops.extrude_edge_only(mesh, edges=rim)
    bmesh.ops.translate(mesh, verts=[one for one in fin["geom"] if isinstance(one, bmesh.types.BMVert)], vec=(0, 0, 0.3))
    mesh.verts.new((2, 2, 2))
    mesh.to_mesh(sheet.data)
    mesh.free()
    world.ball("ball", radius=0.2, location=(0, 0, 0.6))
    world.bake()
    assert "edges with more than two triangles" in sheet.taffeta.said or "bend" in sheet.taffeta.said
    end = world.at(sheet, 13)
    assert np.isfinite(end).all() and np.allclose(end[-1], [2, 2, 3]), "a vertex without a face stays"


def test_units_are_those_of_the_scene(world):
    """The same sheet in centimetres, with the gravity of Earth in that unit, falls as far."""
    world.scene.taffeta.air = False
    world.scene.unit_settings.scale_length = 0.01
    world.scene.gravity = (0, 0, -981)
    sheet = world.grid("sheet", size=100, location=(0, 0, 200))
    world.bake()
    fallen = world.at(sheet, 1)[:, 2] - world.at(sheet, 13)[:, 2]
    assert fallen.mean() == pytest.approx(100 * 0.5 * 9.81 * 0.25, rel=0.02)
    assert not world.scene.taffeta.said
