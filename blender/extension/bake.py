"""A bake: samples the scene, has a process compute it, and shows its frames as they come."""

import hashlib
import json
import time

import bpy
import numpy as np

from . import caches, checks, describe, files, roles, sample, settings, space
from .job import Job
from .refused import Refused
from .words import Words

# How long a turn of a bake may keep Blender from drawing [s].
TURN = 0.05
# What a bake leaves beside frames: the state to go on from, and what it is of.
STATE, OF = "state.taffeta", "digest.txt"
LEFT = (STATE, OF)

running = None
# The bake before, for what it came to.
last = None


def is_running():
    return running is not None


def fingerprint(scene):
    """What a cache depends on of what the user sets. More frames are only more of it."""
    of = {one.name_full: settings.shown(one.taffeta) for one in roles.simulated(scene)}
    render = scene.render
    return json.dumps([
        of, settings.shown(scene.taffeta), [scene.frame_start, render.fps, render.fps_base],
        list(scene.gravity), scene.use_gravity, space.unit(scene),
    ], sort_keys=True, default=str)  # fmt: skip


def digest(described, written):
    """Of what is computed: the scene, whose number of frames may change, and the files that it names."""
    timeless = {**described, "time": {**described["time"], "frames": 0}}
    sums = hashlib.sha256(json.dumps(timeless, sort_keys=True).encode())
    for path in written:
        with open(path, "rb") as file:
            sums.update(hashlib.file_digest(file, "sha256").digest())
    return sums.hexdigest()


class Said:
    """What is said of objects and of the scene while it is baked. Names are kept, and no objects, which an undo would replace."""

    def __init__(self, scene):
        self.scene = scene.name
        self.of = {one.name_full: [] for one in roles.simulated(scene)}
        self.words = Words(files.plain_names(self.of))
        self.whole = []
        self.show()

    def add(self, text, name=None):
        """Says something of an object, or of all whose names are in the text."""
        text, names = (text, [name]) if name else self.words.of_blender(text)
        for one in names:
            self.of.setdefault(one, []).append(text)
        if not names:
            self.whole.append(text)
        self.show()

    def show(self):
        scene = bpy.data.scenes.get(self.scene)
        if scene is None:
            return
        scene.taffeta.said = "\n".join(self.whole)
        for name, lines in self.of.items():
            one = roles.find(scene, name)
            if one is not None and one.is_editable and one.taffeta.said != "\n".join(lines):
                one.taffeta.said = "\n".join(lines)


class Bake:
    """A bake of a scene. `turns` does the work, and yields what is to be said in the status bar."""

    def __init__(self, context, goes_on=False, stops_after=0, folder=None):
        scene = context.scene
        self.name, self.first, self.of = scene.name, scene.frame_start, fingerprint(scene)
        self.folder, self.goes_on, self.stops_after, self.stops = folder, goes_on, stops_after, False
        self.said = Said(scene)
        self.done, self.frames, self.result = 0, 0, None
        # While it samples, nobody else may change the frame or undo.
        self.samples = True
        self.shows = {}

    @property
    def scene(self):
        """The scene, which an undo may have replaced."""
        scene = bpy.data.scenes.get(self.name)
        if scene is None:
            raise Refused(f"the scene {self.name} is gone or has another name now; bake again")
        return scene

    def stop(self):
        self.stops = True

    def say_all(self, pairs):
        for one, words in pairs:
            self.said.add(words, one.name_full if one else None)

    def sampled(self):
        """Samples all objects, and the world: returns both, unless it was stopped."""
        scene, worlds = self.scene, []

        def note(frame):
            world = describe.world_of(scene, space.unit(scene))
            if not worlds:
                worlds.append(world)
                self.say_all((None, words) for words in checks.advice_of_world(world))
            elif len(worlds) == 1 and not same_world(world, worlds[0]):
                worlds.append(world)
                self.said.add(f"gravity or wind changes in frame {frame}; those of the first frame act throughout")

        all_of = roles.simulated(scene)
        sampling = sample.sample(bpy.context, all_of, self.folder, self.said.words.names, note)
        while True:
            try:
                part = next(sampling)
            except StopIteration as end:
                return end.value, worlds[0]
            if self.stops:
                sampling.close()
                return None
            yield f"Taffeta: animation, {part:.0%}"

    def describe(self):
        """Samples and writes the scene: returns bodies as they were sampled, and a digest; nothing if it was stopped."""
        scene = self.scene
        found = next(checks.problems(scene, bpy.context.view_layer), None)
        if found:
            one, words = found
            raise Refused(words, one.name_full if one else None)
        self.folder = self.folder or caches.folder_of(scene)
        self.say_all(checks.advice(scene))
        self.folder.mkdir(parents=True, exist_ok=True)
        both = yield from self.sampled()
        if both is None:
            return None
        all_of, (sampled, world) = roles.simulated(scene), both
        for one, seen in zip(all_of, sampled, strict=True):
            self.say_all((one, words) for words in checks.advice_of_sampled(one, seen))
        writing = describe.write(scene, sampled, world, self.folder, self.said.words)
        described, written = yield from with_words(writing, "Taffeta: meshes")
        self.samples = False
        bodies = [seen for one, seen in zip(all_of, sampled, strict=True) if one.taffeta.role != "COLLIDER"]
        return bodies, digest(described, written)

    def turns(self):
        both = yield from self.describe()
        if both is None:
            return
        bodies, now = both
        names, of, state = self.said.words.names, self.folder / OF, self.folder / STATE
        same = of.exists() and of.read_text() == now
        if self.goes_on and not same:
            self.said.add("the scene has changed since the last bake, which so starts again")
        if not (self.goes_on and same):
            state.unlink(missing_ok=True)
        for body in bodies:
            np.save(self.folder / f"{names[body.name]}.matrices.npy", np.array(body.matrices))
        of.write_text(now)
        self.frames = describe.time_of(self.scene)["frames"]
        self.shows = {body.name: self.folder / f"{names[body.name]}.pc2" for body in bodies}
        job = Job({
            "scene": str(self.folder / "scene.toml"),
            "state": str(state),
            "goes_on": self.goes_on and same,
            "frames": self.frames,
            "metres": space.unit(self.scene),
            "device": self.scene.taffeta.device,
            "bodies": [{
                "name": names[body.name], "points": len(body.points), "cache": str(self.shows[body.name]),
                "matrices": str(self.folder / f"{names[body.name]}.matrices.npy"),
            } for body in bodies],
        }, self.folder)  # fmt: skip
        try:
            yield from self.listen(job)
        finally:
            status, log = job.end()
        if self.result is None:
            raise Refused(f"the process that computes ended with status {status}: {log or 'it has said nothing'}")
        self.show()
        self.scene.taffeta.baked = self.of

    def show(self):
        """Has objects show what there is."""
        for name, path in self.shows.items():
            one = roles.find(self.scene, name)
            if one is None:
                self.said.add(f"the object {name} is gone or has another name now: its frames are in {path}")
            else:
                caches.show(one, path, self.first)

    def listen(self, job):
        """Hears what the process says until it ends."""
        shown, failed = False, None
        while True:
            for event in job.events():
                if event is None:
                    if failed:
                        raise failed
                    return
                if event["what"] == "error":
                    text, about = self.said.words.of_blender(event["text"])
                    failed = Refused(text, about[0] if about else None)
                    self.result = event
                elif event["what"] == "frame":
                    self.done = event["frame"]
                    if not shown:
                        self.show()
                        shown = True
                else:
                    self.hear(event)
            if self.stops or 0 < self.stops_after <= self.done:
                job.stop()
            yield f"Taffeta: frame {self.first + self.done} of {self.first + self.frames}. Esc stops it, and keeps what there is"

    def hear(self, event):
        if event["what"] == "crossing":
            self.said.add(
                f"starts with {event['pairs']} places where surfaces pass through each other ({event['first']}); they are pulled apart, "
                "and a start without them is surer"
            )
        elif event["what"] in ("warning", "note"):
            self.said.add(event["text"])
        elif event["what"] == "end":
            self.result = event
            if event["stretch"] > 1.5:
                self.said.add(
                    f"something is stretched to {event['stretch']:.2f} times its length: look for pins that move too far, for a "
                    "collider that pinches, or for what is too soft"
                )
            if event["crossings"]:
                self.said.add(f"ends with {event['crossings']} places where surfaces pass through each other")


def with_words(working, words):
    """The turns of a generator, with words for them."""
    while True:
        try:
            next(working)
        except StopIteration as end:
            return end.value
        yield words


def same_world(one, other):
    """Whether gravity and wind are the same but for rounding."""
    numbers = [np.array([*world["gravity"], *world.get("air", {}).get("velocity", ())]) for world in (one, other)]
    return numbers[0].shape == numbers[1].shape and np.allclose(*numbers, atol=1e-6)


class Running:
    """A bake that is driven turn by turn."""

    def __init__(self, bake):
        self.bake, self.turns, self.status = bake, bake.turns(), ""

    def turn(self):
        """Works for a moment. False when it is done."""
        end = time.monotonic() + TURN
        while time.monotonic() < end:
            try:
                self.status = next(self.turns)
            except StopIteration:
                return False
            except ReferenceError as error:
                raise Refused("something that takes part was deleted meanwhile; bake again") from error
            except OSError as error:
                raise Refused(f"the cache cannot be kept in {self.bake.folder}: {error.strerror}; choose another folder") from error
            if not self.bake.samples:
                return True
        return True


def begin(context, **how):
    """Starts a bake; only one runs at a time."""
    global running
    running = Running(Bake(context, **how))
    return running


def abandon():
    """Ends a bake that nobody drives any more, and its process."""
    global running
    if running is not None:
        now, running = running, None
        now.bake.stop()
        now.turns.close()


def finish(operator, error=None):
    """Ends it, and says how."""
    global last, running
    bake, running = running.bake, None
    last = bake
    if error is not None:
        bake.said.add(str(error), error.name)
        operator.report({"ERROR"}, f"{error.name}: {error}" if error.name else str(error))
        return {"CANCELLED"}
    if bake.result is None:
        operator.report({"WARNING"}, "stopped before the first frame")
    elif bake.done < bake.frames:
        operator.report({"WARNING"}, f"stopped after frame {bake.first + bake.done}; Continue goes on from there")
    else:
        operator.report({"INFO"}, f"{bake.frames + 1} frames are baked")
    return {"FINISHED"}


class TAFFETA_OT_bake(bpy.types.Operator):
    """Computes all frames of cloth and soft bodies, in the background"""

    bl_idname = "taffeta.bake"
    bl_label = "Bake"
    # To be run again with other values it would have to hold Blender up.
    bl_options = {"UNDO"}

    goes_on: bpy.props.BoolProperty(options={"HIDDEN", "SKIP_SAVE"}, description="Goes on where a bake was stopped")
    stops_after: bpy.props.IntProperty(options={"HIDDEN", "SKIP_SAVE"}, description="Frames to compute now; 0: all")
    plays: bpy.props.BoolProperty(options={"HIDDEN", "SKIP_SAVE"}, description="Plays frames as they come")

    @classmethod
    def poll(cls, _context):
        if running is not None:
            cls.poll_message_set("a bake is running")
        return running is None

    def execute(self, context):
        """All at once, as in scripts."""
        now = begin(context, goes_on=self.goes_on, stops_after=self.stops_after)
        try:
            while now.turn():
                time.sleep(0.002)
        except Refused as error:
            return finish(self, error)
        except BaseException:
            abandon()
            raise
        return finish(self)

    def invoke(self, context, _event):
        begin(context, goes_on=self.goes_on, stops_after=self.stops_after)
        self._timer = context.window_manager.event_timer_add(TURN, window=context.window)
        self._played = not self.plays
        context.window_manager.progress_begin(0, 100)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if running is None:
            # The extension was switched off meanwhile.
            self.close(context)
            return {"CANCELLED"}
        if event.type == "ESC" and event.value == "PRESS":
            running.bake.stop()
            return {"RUNNING_MODAL"}
        if event.type != "TIMER":
            return {"RUNNING_MODAL"} if running.bake.samples else {"PASS_THROUGH"}
        error = None
        try:
            if running.turn():
                self.show(context, running)
                return {"PASS_THROUGH"}
        except Refused as refused:
            error = refused
        except BaseException:
            abandon()
            self.close(context)
            raise
        self.close(context)
        return finish(self, error)

    def show(self, context, now):
        context.workspace.status_text_set(now.status)
        context.window_manager.progress_update(100 * now.bake.done / max(now.bake.frames, 1))
        for area in context.screen.areas:
            if area.type in ("PROPERTIES", "VIEW_3D"):
                area.tag_redraw()
        if not self._played and now.bake.done > 2:
            self._played = True
            context.scene.frame_set(context.scene.frame_start)
            bpy.ops.screen.animation_play()

    def cancel(self, context):
        """Blender closes, or opens another file."""
        abandon()
        self.close(context)

    def close(self, context):
        context.window_manager.event_timer_remove(self._timer)
        context.window_manager.progress_end()
        context.workspace.status_text_set(None)


class TAFFETA_OT_stop(bpy.types.Operator):
    """Stops the bake after its current frame; what there is stays, and Continue goes on from there"""

    bl_idname = "taffeta.stop"
    bl_label = "Stop"

    @classmethod
    def poll(cls, _context):
        return running is not None

    def execute(self, _context):
        running.bake.stop()
        return {"FINISHED"}


CLASSES = (TAFFETA_OT_bake, TAFFETA_OT_stop)


def register():
    for one in CLASSES:
        bpy.utils.register_class(one)


def unregister():
    abandon()
    for one in reversed(CLASSES):
        bpy.utils.unregister_class(one)
