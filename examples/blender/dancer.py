"""A figure that turns, in a skirt and a cape: everything that it takes, from nothing.

In Blender, with the extension installed: Scripting tab, Open, this file, Run Script; then Bake in the sidebar's Taffeta tab. Or without a
window: `blender --background --python dancer.py -- dancer.blend` bakes it and saves it.
"""

import math
import sys

import bpy
from mathutils import Vector

FRAMES = 96


def empty_scene():
    scene = bpy.data.scenes.new("dancer")
    bpy.context.window.scene = scene
    scene.frame_start, scene.frame_end = 1, FRAMES
    scene.render.fps, scene.render.fps_base = 24, 1
    scene.gravity, scene.use_gravity = (0, 0, -9.81), True
    return scene


def rig(scene):
    """Hips and a chest, which sway as they turn."""
    armature = bpy.data.armatures.new("rig")
    one = bpy.data.objects.new("rig", armature)
    scene.collection.objects.link(one)
    bpy.context.view_layer.objects.active = one
    bpy.ops.object.mode_set(mode="EDIT")
    parent = None
    for name, low, high in (("hips", 0.9, 1.1), ("chest", 1.1, 1.5)):
        bone = armature.edit_bones.new(name)
        bone.head, bone.tail, bone.parent = (0, 0, low), (0, 0, high), parent
        parent = bone
    bpy.ops.object.mode_set(mode="OBJECT")
    for frame in range(1, FRAMES + 1, 6):
        t = (frame - 1) / 24
        turn = 1.4 * math.sin(1.6 * max(t - 0.3, 0))
        for name, angles in (("hips", (0, turn, 0.08 * math.sin(3 * t))), ("chest", (0.1 * math.sin(2 * t), 0.3 * turn, 0))):
            bone = one.pose.bones[name]
            bone.rotation_mode = "XYZ"
            bone.rotation_euler = angles
            bone.keyframe_insert("rotation_euler", frame=frame)
    return one


def figure(scene, armature):
    """A body of balls, made one by a remesh."""
    parts = [
        ((0, 0, 1.02), (0.17, 0.13, 0.14)), ((0, 0, 1.22), (0.14, 0.10, 0.20)), ((0, 0, 1.40), (0.17, 0.10, 0.10)),
        ((0, 0, 1.55), (0.05, 0.05, 0.12)), ((0, 0, 1.70), (0.09, 0.10, 0.12)),
    ]  # fmt: skip
    for side in (-1, 1):
        parts += [((side * (0.085 + 0.01 * k), 0, 0.95 - 0.09 * k), (0.085 - 0.004 * k, 0.085 - 0.004 * k, 0.09)) for k in range(10)]
        parts += [((side * (0.19 + 0.045 * k), 0, 1.41 - 0.05 * k), (0.055 - 0.002 * k, 0.05, 0.06)) for k in range(9)]
    made = []
    for place, size in parts:
        bpy.ops.mesh.primitive_uv_sphere_add(segments=20, ring_count=12, location=place)
        bpy.context.object.scale = size
        made.append(bpy.context.object)
    for one in made:
        one.select_set(True)
    bpy.context.view_layer.objects.active = made[0]
    bpy.ops.object.join()
    body = bpy.context.object
    body.name = "figure"
    bpy.ops.object.transform_apply()
    remesh = body.modifiers.new("One", "REMESH")
    remesh.mode, remesh.voxel_size, remesh.use_smooth_shade = "VOXEL", 0.022, True
    bpy.ops.object.modifier_apply(modifier="One")
    skin(body, armature, lambda x: (x.z - 1.1) / 0.2)
    body.taffeta.role = "COLLIDER"
    body.taffeta.thickness = 5
    return body


def skin(one, armature, share_of_chest):
    """Weights of the two bones by height."""
    groups = [one.vertex_groups.new(name=name) for name in ("hips", "chest")]
    for vertex in one.data.vertices:
        upper = min(max(share_of_chest(vertex.co), 0.0), 1.0)
        for group, weight in zip(groups, (1 - upper, upper), strict=True):
            group.add([vertex.index], weight, "REPLACE")
    one.modifiers.new("Armature", "ARMATURE").object = armature


def garment(scene, name, ring, around, rings, closed, fabric):
    """Cloth of rings of points: `ring(v, u)` has the point at a height v and an angle u, both 0 to 1."""
    count = around if closed else around + 1
    points = [ring(row / (rings - 1), column / around) for row in range(rings) for column in range(count)]
    faces = [
        (row * count + column, (row + 1) * count + column, (row + 1) * count + (column + 1) % count, row * count + (column + 1) % count)
        for row in range(rings - 1)
        for column in range(around)
    ]
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(points, [], faces)
    uvs = mesh.uv_layers.new(name="UV")
    for loop in mesh.loops:
        row, column = divmod(loop.vertex_index, count)
        uvs.data[loop.index].uv = (column / around, 1 - row / (rings - 1))
    one = bpy.data.objects.new(name, mesh)
    scene.collection.objects.link(one)
    first = one.vertex_groups.new(name="held")
    first.add(range(2 * count), 1.0, "REPLACE")
    kept = one.taffeta
    kept.role, kept.fabric, kept.pin_group, kept.thickness = "CLOTH", fabric, "held", 3
    return one


def skirt(scene, armature):
    """A skirt with a wide hem, held by its waistband."""

    def ring(v, u):
        angle = 2 * math.pi * u
        wide = 0.18 + 0.25 * v
        return (wide * math.cos(angle), (wide - 0.03 * (1 - v)) * math.sin(angle), 1.1 - 0.5 * v)

    one = garment(scene, "skirt", ring, 96, 26, True, "silk")
    skin(one, armature, lambda x: 0.0)
    return one


def cape(scene, armature):
    """A cape on the shoulders, which lies open at the back."""

    def ring(v, u):
        angle = math.pi * (0.08 + 0.84 * u)
        wide = 0.13 + 0.25 * v
        return (1.15 * wide * math.cos(angle), 0.02 + wide * math.sin(angle), 1.5 - 0.06 * (1 - math.cos(v)) - 0.75 * v)

    one = garment(scene, "cape", ring, 40, 34, False, "wool")
    skin(one, armature, lambda x: 1.0)
    return one


def look(scene, body, *clothes):
    """Colours, smooth shading, light and a camera."""
    colours = {"figure": (0.35, 0.30, 0.28), "skirt": (0.55, 0.03, 0.06), "cape": (0.02, 0.10, 0.28)}
    for one in (body, *clothes):
        material = bpy.data.materials.new(one.name)
        if bpy.app.version < (5, 0):
            material.use_nodes = True
        shader = material.node_tree.nodes["Principled BSDF"]
        shader.inputs["Base Color"].default_value = (*colours[one.name], 1)
        shader.inputs["Roughness"].default_value = 0.6
        one.data.materials.append(material)
        one.data.polygons.foreach_set("use_smooth", [True] * len(one.data.polygons))
    for one in clothes:
        smooth = one.modifiers.new("Smooth", "SUBSURF")
        smooth.levels = smooth.render_levels = 1
    bpy.ops.mesh.primitive_plane_add(size=8)
    bpy.context.object.name = "ground"
    bpy.ops.object.light_add(type="SUN", rotation=(0.8, 0.3, 0.5))
    bpy.context.object.data.energy, bpy.context.object.data.angle = 4, 0.2
    scene.world = bpy.data.worlds.new("World")
    eye, target = Vector((1.9, -3.6, 1.5)), Vector((0, 0, 0.95))
    bpy.ops.object.camera_add(location=eye, rotation=(target - eye).to_track_quat("-Z", "Y").to_euler())
    scene.camera = bpy.context.object


def main():
    scene = empty_scene()
    armature = rig(scene)
    body = figure(scene, armature)
    clothes = [skirt(scene, armature), cape(scene, armature)]
    look(scene, body, *clothes)
    if "--" in sys.argv:
        # First saved, so that frames are kept beside it.
        bpy.ops.wm.save_as_mainfile(filepath=sys.argv[sys.argv.index("--") + 1])
        bpy.ops.taffeta.bake()
        bpy.ops.wm.save_mainfile()


main()
