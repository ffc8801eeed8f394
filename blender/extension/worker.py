"""Runs a scene and writes its frames: a process of its own, which knows nothing of Blender.

    python worker.py JOB.json

It prints an event a line as JSON. It stops after the current frame when its standard input says so, or ends as the program that
started it does.
"""

import json
import sys
import threading
import traceback
import warnings
from pathlib import Path

# Frames between two states to go on from, should the machine or the program fail.
KEEP_EVERY = 25


def say(**event):
    print(json.dumps(event), flush=True)


class Cache:
    """The frames of a body, in the coordinates of its object."""

    def __init__(self, body, metres, going_on):
        import files
        import numpy as np

        self.name, self.metres, self.points = body["name"], metres, body["points"]
        self.matrices = np.load(body["matrices"])
        path = Path(body["cache"])
        path.parent.mkdir(parents=True, exist_ok=True)
        self.file = open(path, "r+b" if going_on else "w+b")
        self.header = files.header

    def write(self, frame, points):
        """Adds a frame; those after it, if there were some, are gone."""
        import numpy as np
        import space

        local = space.to_object(points, self.matrices[min(frame, len(self.matrices) - 1)], self.metres)
        self.file.seek(len(self.header(0, 0)) + 12 * self.points * frame)
        self.file.write(np.ascontiguousarray(local, "<f4").tobytes())
        self.file.truncate()
        # Only now do readers know of it.
        self.file.flush()
        self.file.seek(0)
        self.file.write(self.header(self.points, frame + 1))
        self.file.flush()


class Stop:
    """Whether the program that started this one wants it to stop, or is gone."""

    def __init__(self):
        self.asked = threading.Event()
        threading.Thread(target=self._wait, daemon=True).start()

    def _wait(self):
        sys.stdin.read(1)
        self.asked.set()


def run(job):
    import taffeta

    say(what="building")
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        simulation = taffeta.Simulation(job["scene"], backend=job["device"])
    for one in caught:
        say(what="warning", text=str(one.message))
    shown = {body["name"] for body in job["bodies"]}
    for body in simulation.bodies.values():
        for repair in body.repairs if body.name in shown else ():
            say(what="note", text=f"`{body.name}`: {repair}")
    going_on = job["goes_on"] and went_on(simulation, job)
    if not going_on:
        found = simulation.intersections()
        if found["pairs"]:
            say(what="crossing", pairs=found["pairs"], first=found["first"])
    state = Path(job["state"])
    caches = [Cache(body, job["metres"], going_on) for body in job["bodies"]]
    stop, frames = Stop(), job["frames"]
    say(what="frame", frame=simulation.frame, frames=frames, device=simulation.device)
    stretch = 1.0
    while True:
        for cache in caches:
            cache.write(simulation.frame, simulation.positions(cache.name))
        frame = simulation.frame
        done = frame >= frames or stop.asked.is_set()
        if frame:
            stretch = max(stretch, simulation.report["max_stretch"])
            say(what="frame", frame=frame, frames=frames, stretch=simulation.report["max_stretch"])
        if done or (frame and frame % KEEP_EVERY == 0):
            keep(simulation, state)
        if done:
            break
        simulation.step()
    end = simulation.intersections()["pairs"] if frame else 0
    say(what="end", frame=frame, stretch=stretch, crossings=end, hash=simulation.state_hash())


def went_on(simulation, job):
    """Takes up the state that a bake of this scene left, if its frames are there as well."""
    import files
    import taffeta

    start = simulation.snapshot()
    try:
        simulation.restore(Path(job["state"]).read_bytes())
        for body in job["bodies"]:
            with open(body["cache"], "rb") as file:
                found = files.read_header(file.read(files.HEADER.size))
            if found is None or found[0] != body["points"] or found[1] <= simulation.frame:
                raise OSError
    except (OSError, taffeta.SnapshotError):
        simulation.restore(start)
        say(what="note", text="there is nothing to go on from, so the bake starts again")
        return False
    return True


def keep(simulation, path):
    part = path.with_name(path.name + ".part")
    part.write_bytes(simulation.snapshot())
    part.replace(path)


def main():
    job = json.loads(Path(sys.argv[1]).read_text("utf-8"))
    sys.path[:0] = [str(Path(__file__).parent), *job["paths"]]
    try:
        run(job)
    except Exception as error:
        import taffeta

        if not isinstance(error, taffeta.Error | OSError | MemoryError):
            traceback.print_exc()
        say(what="error", kind=type(error).__name__, text=str(error), body=getattr(error, "body", None))
        sys.exit(1)


if __name__ == "__main__":
    main()
