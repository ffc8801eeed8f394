"""The process that computes: started, asked to stop, and heard."""

import json
import queue
import subprocess
import sys
import threading
from pathlib import Path

WORKER = Path(__file__).with_name("worker.py")


def paths():
    """Where the process finds taffeta and numpy, which are those of this Blender."""
    import numpy
    import taffeta

    return [str(Path(package.__file__).parent.parent) for package in (taffeta, numpy)]


class Job:
    def __init__(self, description, folder):
        path = folder / "job.json"
        path.write_text(json.dumps({**description, "paths": paths()}), "utf-8")
        self._log = open(folder / "worker.log", "w+", encoding="utf-8", errors="replace")
        self._process = subprocess.Popen(
            [sys.executable, "-I", "-B", str(WORKER), str(path)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._log,
            # No console window flashes up.
            creationflags=getattr(subprocess, "CREATE_NO_WINDOW", 0),
        )
        self._events = queue.SimpleQueue()
        threading.Thread(target=self._listen, daemon=True).start()

    def _listen(self):
        for line in self._process.stdout:
            try:
                self._events.put(json.loads(line))
            except ValueError:
                # Something of another package's.
                continue
        self._events.put(None)

    def events(self):
        """What was said since. None is the last of it."""
        while True:
            try:
                yield self._events.get_nowait()
            except queue.Empty:
                return

    def stop(self):
        """Asks it to stop after the frame that it is at."""
        try:
            self._process.stdin.close()
        except OSError:
            pass

    def end(self):
        """Waits for its end; returns its exit status, and the end of its log."""
        self.stop()
        try:
            status = self._process.wait(timeout=60)
        except subprocess.TimeoutExpired:
            self._process.kill()
            status = self._process.wait()
        self._log.seek(0)
        log = self._log.read()[-2000:]
        self._log.close()
        self._process.stdout.close()
        return status, log
