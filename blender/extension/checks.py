"""What can be said of a scene before anything is computed: what stands in the way, and what is likely not meant."""

import bpy
import numpy as np

from . import caches, describe, roles, space

HURRICANE = 33.0
BLENDERS = {"CLOTH": "Cloth", "SOFT_BODY": "Soft Body", "COLLISION": "Collision"}


def problems(scene, view_layer):
    """What stands in the way: pairs of an object, or None, and words."""
    bodies = roles.simulated(scene, "CLOTH", "SOFT")
    if not bodies:
        yield None, "no object of the scene is cloth or a soft body; select a mesh and choose Cloth in its Physics tab"
    if scene.frame_end <= scene.frame_start:
        yield None, f"the scene ends in frame {scene.frame_end} and starts in frame {scene.frame_start}; a later end would do"
    render = scene.render
    if render.frame_map_old != render.frame_map_new:
        yield None, f"time is stretched from {render.frame_map_old} to {render.frame_map_new} (Output > Time Stretching); none would do"
    evaluated = {one.name_full for one in view_layer.objects}
    for one in roles.simulated(scene):
        yield from ((one, words) for words in problems_of(one, evaluated))


def problems_of(one, evaluated):
    kept = one.taffeta
    if one.name_full not in evaluated:
        yield "is in no collection of the view layer, so Blender does not evaluate it; tick its collection in the Outliner"
    if one.mode == "EDIT":
        yield "is in Edit Mode, where Blender keeps changes to itself; leave it with Tab"
    if not one.visible_get():
        yield "is hidden, and Blender does not evaluate what is hidden; show it (Viewport Display > As: Bounds keeps it out of sight)"
    if kept.role == "COLLIDER":
        return
    if not one.is_editable:
        yield "is linked from another file; make a library override of it (Object > Relations)"
    if kept.pin_group and kept.pin_group not in one.vertex_groups:
        yield f"is pinned by the vertex group {kept.pin_group!r}, which it has not; choose another one, or none"
    for modifier in one.modifiers:
        if modifier.type in BLENDERS and modifier.show_viewport and modifier.type != "COLLISION":
            yield f"is also cloth of Blender's own (modifier {modifier.name}); remove one of both"


def advice(scene):
    """What is likely not meant, before it is sampled."""
    metres = space.unit(scene)
    strength = np.linalg.norm(np.asarray(scene.gravity)) * metres
    if not scene.use_gravity or strength < 1e-6:
        yield None, "nothing falls: the scene has no gravity (Scene > Gravity)"
    elif not 1.0 < strength < 100.0:
        yield None, (
            f"gravity is {strength:.3g} m/s², as a unit of the scene is {metres:g} m: on Earth Scene > Gravity would be "
            f"{-9.81 / metres:.4g} along Z"
        )
    yield from ((None, words) for words in advice_of_fields(scene))
    for one in bpy.data.objects:
        if one.type == "MESH" and one.taffeta.role != "NONE" and not one.users_scene and one.users_collection:
            yield None, f"{one.name} is only there as an instance of a collection, and does not take part; make instances real (Object > Apply)"
    for one in roles.simulated(scene):
        yield from ((one, words) for words in advice_of(one, metres))


def advice_of_fields(scene):
    if not scene.taffeta.air:
        if describe.winds(scene):
            yield "the scene has wind, and Air is off"
        return
    for one in scene.objects:
        kind = one.field.type if one.field is not None else "NONE"
        if kind not in ("NONE", "WIND") and one.visible_get():
            yield f"the force field {one.name} does nothing: of force fields only wind acts"


def advice_of_world(world):
    """Of gravity and air at the start."""
    speed = np.linalg.norm(world["air"]["velocity"]) if "air" in world else 0.0
    if speed > HURRICANE:
        yield f"the wind has {speed:.3g} m/s, where a hurricane begins at {HURRICANE:.0f}: the strength of a wind is its speed"


def advice_of(one, metres):
    kept = one.taffeta
    size = metres * max(one.dimensions)
    if kept.role != "COLLIDER" and not 0.01 < size < 50.0:
        yield (
            f"is {size:.3g} m large, as a unit of the scene is {metres:g} m; check Scene > Units > Unit Scale, "
            "or whether it is to be so large"
        )
    modifiers = list(one.modifiers)
    place = caches.place(one) if kept.role != "COLLIDER" else len(modifiers)
    for modifier in modifiers[:place]:
        if modifier.show_viewport != modifier.show_render:
            yield f"is not rendered as it is baked: its modifier {modifier.name} is on in one of the viewport and the render alone"
    if kept.role != "COLLIDER":
        if kept.tethers and kept.role == "CLOTH" and not kept.pin_group:
            yield "has tethers and nothing that is pinned, which they would lead to"
        for modifier in modifiers[place:]:
            if modifier.type == "ARMATURE" and modifier.show_viewport:
                yield f"moves twice: its armature ({modifier.name}) is below Taffeta in the stack of modifiers; move it above"
    elif any(modifier.type in ("CLOTH", "SOFT_BODY") for modifier in modifiers):
        yield "is cloth of Blender's own and a collider: where Blender has baked it"


def advice_of_sampled(one, sampled):
    """What is likely not meant of a body, once it is sampled."""
    kept = one.taffeta
    if kept.role == "COLLIDER":
        return
    if kept.pin_group and not sampled.weights:
        yield f"has no weights in its vertex group {kept.pin_group!r}: nothing is pinned"
    if len(sampled.weights) == len(sampled.points) and min(sampled.weights.values()) >= describe.HELD:
        yield f"is pinned as a whole by {kept.pin_group!r}: it only follows its animation"
    if kept.sewing and not sampled.loose:
        yield "has no edges without faces to sew"
    if sampled.loose and not kept.sewing:
        edges = "1 edge without a face" if len(sampled.loose) == 1 else f"{len(sampled.loose)} edges without faces"
        yield f"has {edges}, which do nothing while Sewing is off"
    count = len(sampled.points)
    if count > 300_000:
        yield f"has {count:,} vertices where Taffeta is in the stack of modifiers: is a Subdivision modifier above it?"
    edge = np.linalg.norm(np.ptp(sampled.points, axis=0)) / max(count, 1) ** 0.5
    if count < 100 and edge > 0.05:
        yield f"has only {count} vertices, and bends nowhere between them: subdivide it"
