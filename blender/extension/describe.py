"""A scene of Blender in taffeta's own format: a folder with scene.toml, meshes and poses, which `taffeta run` takes as well."""

import math

import numpy as np

from . import files, roles, settings, space
from .refused import Refused

# A weight of so much is held, and one of so little is free.
HELD, FREE = 0.99, 0.01
# Springs of weights between are of so many kinds.
LEVELS = 10
# Stable at any step, for whatever is stiff or light.
IMPLICIT = {"method": "ice", "ice": {"form": "primal"}}
# The name of a body that pulls another one ends so.
PULLING = "-pinned"
# Gusts by the noise of a wind: a noise of 1 makes them half as fast as the wind.
GUST = 0.5
# A soft body's springs along edges and across them: stiffness times its largest extent [N], damping by stiffness [s].
SOFT_FORCE, SOFT_DAMPING = 5_000.0, 1e-3
# Struts inside it: at most, and their stiffness by that of the others, which keep the surface smooth.
STRUTS, SOFT_INSIDE = 10_000, 0.2


def plain(value):
    """Numbers of numpy and Blender as Python's."""
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    return value.item() if isinstance(value, np.generic) else value


def time_of(scene):
    dt = scene.render.fps_base / scene.render.fps
    return {"dt": dt, "max_step": dt / scene.taffeta.steps, "frames": max(scene.frame_end - scene.frame_start, 1)}


def winds(scene):
    """Wind force fields of a scene."""
    fields = [one for one in scene.objects if one.field is not None and one.field.type == "WIND" and one.visible_get()]
    return sorted(fields, key=lambda one: one.name)


def world_of(scene, metres):
    """Gravity and air, as they are in the frame that the scene is at."""
    gravity = scene.gravity if scene.use_gravity else (0.0, 0.0, 0.0)
    world = {"gravity": [metres * part for part in space.direction(gravity)]}
    if scene.taffeta.air:
        velocity, gusts = np.zeros(3), []
        for one in winds(scene):
            field = one.field
            along = np.array(one.matrix_world, np.float64)[:3, 2]
            velocity += field.strength * along / max(np.linalg.norm(along), 1e-12)
            if field.noise > 0:
                gusts.append((GUST * field.noise * abs(field.strength), field.seed))
        air = {"velocity": space.direction(velocity)}
        if gusts:
            speed, seed = max(gusts)
            air["gust"] = {"speed": speed, "seed": max(seed, 1)}
        world["air"] = air
    return world


def material_of(kept):
    bends = {"rest_curvature": "mesh"} if kept.keeps_bends else {}
    if kept.fabric != settings.CUSTOM:
        return {"preset": kept.fabric, **bends}
    return {
        **bends,
        "density": kept.density,
        "stretch": list(kept.stretch),
        "shear": kept.shear,
        "bending": [1e-6 * part for part in kept.bending],
    }


def contact_of(kept, name):
    contact = {"thickness": kept.thickness / 1e3, "friction": kept.friction}
    return contact if kept.self_contact else {**contact, "without": [name]}


def soft_of(kept, points, count):
    """A soft body: springs, struts if there is room for so many, and its volume."""
    largest = float(np.ptp(points, axis=0).max())
    k = kept.stiffness * SOFT_FORCE / max(largest, 1e-6)
    spring, strut = ({"k": stiffness, "d": SOFT_DAMPING * stiffness} for stiffness in (k, SOFT_INSIDE * k))
    body = {"kind": "soft", "node_mass": kept.mass / len(points), "springs": {"structural": spring, "bend": spring}}
    if count:
        body["springs"]["internal"] = {"count": count, **strut}
    if kept.volume == "KEEP":
        body["volume"] = {"form": "projected", "target": kept.volume_target}
    elif kept.volume == "PRESSURE":
        body["volume"] = {"pressure": kept.pressure}
    return body


class Writer:
    """Writes a scene into a folder."""

    def __init__(self, scene, folder, words):
        self.scene, self.folder, self.words, self.names = scene, folder, words, words.names
        self.time = time_of(scene)
        self.bodies, self.colliders, self.seams, self.frictions = [], [], [], {}
        # What the scene names.
        self.written = []

    def mesh(self, name, points, faces, uvs=None):
        path = self.folder / f"{name}.obj"
        files.write_obj(path, points, faces, uvs)
        self.written.append(path)
        return path.name

    def poses(self, sampled):
        """Poses of what moves, else nothing."""
        if sampled.poses.file is None:
            return {}
        self.written.append(sampled.poses.path)
        return {"poses": {"file": sampled.poses.path.name, "interval": self.time["dt"]}}

    def collider(self, one, sampled):
        kept = one.taffeta
        name = self.names[one.name_full]
        self.words.order["collider"].append(one.name_full)
        self.frictions[name] = kept.friction
        self.colliders.append({
            "name": name,
            "mesh": {"file": self.mesh(name, sampled.points, sampled.faces)},
            **self.poses(sampled),
            "offset": kept.thickness / 1e3,
            "friction": kept.friction,
        })  # fmt: skip

    def body(self, one, sampled):
        kept, name = one.taffeta, self.names[one.name_full]
        body = {"name": name, "mesh": {"file": self.mesh(name, sampled.points, sampled.faces, sampled.uvs)}}
        if kept.role == "SOFT":
            body |= soft_of(kept, sampled.points, room_for_struts(one, sampled, self.folder, self.words))
        else:
            body["material"] = material_of(kept)
            if sampled.rest is not None:
                body["rest_shape"] = self.mesh(f"{name}.rest", sampled.rest, sampled.faces, sampled.uvs)
        body["self_collision"] = contact_of(kept, name)
        held = sorted(vertex for vertex, weight in sampled.weights.items() if weight >= HELD)
        if held:
            body["pin"] = [{"select": {"nodes": held}, **self.poses(sampled)}]
            if kept.tethers:
                body["tethers"] = {}
        self.words.order["body"].append(one.name_full)
        self.bodies.append(body)
        self.sew(one, sampled)
        self.pull(one, sampled)

    def sew(self, one, sampled):
        if one.taffeta.sewing and sampled.loose:
            side = {"body": self.names[one.name_full]}
            close = {"start": 0.0, "end": one.taffeta.sewing_time}
            self.seams.append({"from": side, "to": side, "pairs": sampled.loose, "close": close})

    def pull(self, one, sampled):
        """Springs from vertices with weights between to where the animation has them: a second body that nothing touches."""
        kept = one.taffeta
        pulled = {vertex: weight for vertex, weight in sampled.weights.items() if FREE < weight < HELD}
        if not pulled:
            return
        name, pulling = self.names[one.name_full], self.names[one.name_full] + PULLING
        faces = [face for face in sampled.faces if any(vertex in pulled for vertex in face)]
        in_faces = {vertex for face in faces for vertex in face}
        self.words.order["body"].append(one.name_full)
        self.bodies.append({
            "name": pulling,
            "mesh": {"file": self.mesh(pulling, sampled.points, faces)},
            "node_mass": 1e-3,
            "layers": {"filter": []},
            "pin": [{"select": {"nodes": sorted(in_faces)}, **self.poses(sampled)}],
        })  # fmt: skip
        for level in range(1, LEVELS + 1):
            of_level = [vertex for vertex, weight in pulled.items() if math.ceil(weight * LEVELS) == level and vertex in in_faces]
            if of_level:
                self.seams.append({
                    "from": {"body": name},
                    "to": {"body": pulling},
                    "pairs": [[vertex, vertex] for vertex in sorted(of_level)],
                    "k": kept.pin_stiffness * level / LEVELS,
                })  # fmt: skip

    def rubs(self, name, friction):
        """Frictions of a body with colliders: the geometric mean of both, as between bodies."""
        return [{"between": [name, other], "value": math.sqrt(friction * its)} for other, its in self.frictions.items()]

    def scene_dict(self, world):
        touching = [body for body in self.bodies if "self_collision" in body]
        scene = {
            "title": self.scene.name,
            "time": self.time,
            "world": world,
            "solver": IMPLICIT,
            "body": self.bodies,
        }
        frictions = [rub for body in touching for rub in self.rubs(body["name"], body["self_collision"]["friction"])]
        for key, entries in (("collider", self.colliders), ("seam", self.seams), ("friction", frictions)):
            if entries:
                scene[key] = entries
        return plain(scene)


def room_for_struts(one, sampled, folder, words):
    """How many struts fit into a soft body: thin ones have no room for many."""
    import taffeta

    count, name = min(len(sampled.points), STRUTS), words.names[one.name_full]
    path = folder / "struts.toml"
    try:
        while count:
            body = {"name": name, "mesh": {"file": f"{name}.obj"}, **soft_of(one.taffeta, sampled.points, count)}
            path.write_text(taffeta.Scene(plain({"solver": IMPLICIT, "body": [body]})).to_toml(), "utf-8")
            try:
                taffeta.Simulation(path, threads=1)
                break
            except taffeta.SceneError as error:
                if "internal" not in str(error):
                    raise Refused(words.of_blender(str(error))[0], one.name_full) from error
                count //= 2
    finally:
        path.unlink(missing_ok=True)
    return count


def write(scene, sampled, world, folder, words):
    """Writes the scene of what was sampled, and notes in `words` in which order objects are in it: a generator, which returns the scene
    as a dict and the files that it names."""
    import taffeta

    writer, by_name = Writer(scene, folder, words), {one.name: one for one in sampled}
    for one in roles.simulated(scene):
        seen = by_name[one.name_full]
        if seen.poses is not None:
            seen.poses.close()
        if one.taffeta.role == "COLLIDER":
            writer.collider(one, seen)
        else:
            writer.body(one, seen)
        yield
    described = writer.scene_dict(world)
    try:
        text = taffeta.Scene(described).to_toml()
    except taffeta.SceneError as error:
        text, about = words.of_blender(str(error))
        raise Refused(text, about[0] if about else None) from error
    (folder / "scene.toml").write_text(text, "utf-8")
    return described, writer.written
