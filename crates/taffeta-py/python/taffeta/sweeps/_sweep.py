"""The sweep itself: it gives out runs, keeps what they leave, and tells how far it is."""

from __future__ import annotations

import contextlib
import hashlib
import inspect
import json
import os
import platform
import sys
from collections import Counter, deque
from collections.abc import Callable, Generator, Iterable, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
from datetime import datetime, timezone
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from taffeta import _native
from taffeta._errors import InputError
from taffeta._packages import package
from taffeta._scene import Scene
from taffeta.sweeps import _backends, _plan, _results, _run
from taffeta.sweeps._folder import RESULTS, Folder
from taffeta.sweeps._progress import Progress

if TYPE_CHECKING:
    from taffeta._scene import Source
    from taffeta.sweeps._backends import Backend
    from taffeta.sweeps._plan import Sample

#: Called with how many are done, how many of these failed, and how many there are.
Watch: TypeAlias = Callable[[int, int, int], None]


def sweep(
    scene: Source,
    *,
    out: str | os.PathLike[str],
    grid: Mapping[str, Iterable[Any]] | None = None,
    samples: Any = None,
    frames: int | None = None,
    rest: float | None = None,
    measure: _run.Measure | None = None,
    arrays: Sequence[str] = (),
    every: int | None = None,
    backend: str | Backend = "local",
    jobs: int | None = None,
    attempts: int = 3,
    retry_failed: bool = False,
    options: Mapping[str, Any] | None = None,
    progress: bool | Watch = True,
) -> _results.Sweep:
    """Runs a scene many times with values that differ.

    The table has a row a run, in the order of the samples: its values, the last report, ``peak_stretch`` over all frames,
    ``state_hash`` and what ``measure`` returns. It does not depend on where and in which order runs happen. A run that fails is a row
    with its message.

    A sweep that was stopped or killed goes on where it was: call it again with the same folder. Runs that are done are not run again,
    and with more samples only the new ones run.

    Args:
        scene: A ``Scene``, or what one is made of.
        out: The folder of the sweep. It is made where it is not there.
        grid: Values by paths as ``Scene.set`` takes them. All combinations run; the last path varies fastest.
        samples: Instead of a grid: a list of dicts, each of values by paths, or a pandas frame with a column a path.
        frames: How many frames a run has; those of the scene, if it is not given.
        rest: Ends a run before that, when no vertex has been faster than this [m/s] for five frames. The column ``at_rest`` says
            whether it came to that.
        measure: Is called with the ``Simulation`` at the end of each run, and returns a dict of numbers, texts or lists of numbers:
            columns of the table.
        arrays: What is kept of each run: "positions", "velocities", "normals".
        every: Keep arrays of every so many frames, from the start on, instead of the last frame alone.
        backend: "local", "ray", "dask", or one of ``taffeta.sweeps``.
        jobs: How many runs at a time on this machine.
        attempts: How often a run is tried whose worker is killed.
        retry_failed: Run those again that failed in an earlier call, such as for want of memory.
        options: For each ``Simulation``. The CPU and one thread, if nothing else is said: runs share the cores.
        progress: Whether to tell on stderr how far it is; or a function of (done, failed, all).

    Returns:
        What ``taffeta.sweeps.Sweep`` is: ``table``, ``to_pandas()``, ``arrays(run)``.

    Raises:
        SceneError: No sample can be simulated: the scene, or a path, is wrong.
        InputError: An argument cannot be, or the folder is that of another sweep.
    """
    for name in ("cloudpickle", "filelock", "loky", "pyarrow"):
        package(name)
    job = _job(scene, frames, rest, measure, arrays, every, options)
    chosen = _samples(grid, samples)
    if not 1 <= attempts:
        raise InputError(f"attempts is {attempts}; 1 or more would do")
    _plan.refuse_unfit(job.scene, chosen)
    folder = Folder(Path(out))
    experiment = _experiment(job)
    with folder.taken(experiment):
        content = _manifest(experiment, chosen)
        folder.manifest(content)
        by_key = {_plan.key(sample): sample for sample in chosen}
        rows = folder.done(list(by_key))
        if retry_failed:
            rows = {key: row for key, row in rows.items() if row["status"] == "done"}
        watch = Progress(len(rows), len(by_key)) if progress is True else progress or _unwatched
        try:
            if len(rows) < len(by_key):
                _drive(folder, job, by_key, rows, _given(backend, jobs), attempts, watch)
        finally:
            # Also where it is stopped: what is done can be read, and is not run again.
            folder.results(_results.table(chosen, rows))
            folder.manifest({**content, **_ended(folder, rows)})
    return _results.Sweep(out)


def _drive(
    folder: Folder,
    job: _run.Job,
    by_key: dict[str, Sample],
    rows: dict[str, dict[str, Any]],
    opened: contextlib.AbstractContextManager[Backend],
    attempts: int,
    watch: Watch,
) -> None:
    """Runs what has not run."""
    packed = job.packed()
    waiting = deque(key for key in by_key if key not in rows)
    tries: Counter[str] = Counter()
    with opened as backend:
        flights: dict[Future[_run.Outcome], str] = {}
        while waiting or flights:
            while waiting and len(flights) < backend.slots:
                key = waiting.popleft()
                tries[key] += 1
                flights[backend.submit(packed, by_key[key])] = key
            landed, _ = wait(flights, return_when=FIRST_COMPLETED)
            for future in landed:
                key = flights.pop(future)
                try:
                    outcome = future.result()
                except backend.lost as error:
                    if tries[key] < attempts:
                        waiting.appendleft(key)
                        continue
                    what = f"its worker was lost {attempts} times, the last time by: {_first_line(error)}"
                    outcome = _run.failed("WorkerLost", what)
                folder.keep(key, by_key[key], outcome)
                rows[key] = outcome.row
                watch(len(rows), sum(row["status"] == "failed" for row in rows.values()), len(by_key))


def _job(
    scene: Source,
    frames: int | None,
    rest: float | None,
    measure: _run.Measure | None,
    arrays: Sequence[str],
    every: int | None,
    options: Mapping[str, Any] | None,
) -> _run.Job:
    """What all runs share, checked."""
    scene = Scene(scene)
    frames = scene.frames if frames is None else frames
    if frames is None:
        raise InputError("the scene has no `time.frames`, and no frames are given; one of the two would do")
    if frames < 1:
        raise InputError(f"frames is {frames}; 1 or more would do")
    if rest is not None and not rest > 0.0:
        raise InputError(f"rest is {rest} m/s; above 0 would do")
    if every is not None and every < 1:
        raise InputError(f"every is {every}; 1 or more would do")
    for name in arrays:
        if name not in _run.ARRAYS:
            raise InputError(f"there is no array `{name}`; there are: {', '.join(_run.ARRAYS)}")
    chosen = {"backend": "cpu", "threads": 1, **(options or {})}
    return _run.Job(scene, frames, rest, measure, tuple(arrays), every, chosen)


def _samples(grid: Mapping[str, Iterable[Any]] | None, samples: Any) -> list[Sample]:
    if (grid is None) == (samples is None):
        raise InputError("a sweep has either a grid or samples")
    chosen = _plan.of_grid(grid) if grid is not None else _plan.of_samples(samples)
    if not chosen:
        raise InputError("there are no samples to run")
    return chosen


@contextlib.contextmanager
def _given(backend: str | Backend, jobs: int | None) -> Generator[Backend]:
    """The backend; one that was named ends with the sweep."""
    opened, is_own = _backends.named(backend, jobs)
    try:
        yield opened
    finally:
        if is_own:
            opened.close()


def _experiment(job: _run.Job) -> dict[str, Any]:
    """What must be the same for runs to belong together."""
    return {
        "taffeta": _native.__version__,
        "scene": _digest(job.scene),
        "frames": job.frames,
        "rest": job.rest,
        "measure": _code(job.measure),
        "arrays": list(job.arrays),
        "every": job.every,
        "options": job.options,
    }


def _digest(scene: Scene) -> str:
    """A hash of a scene, and of the files that it names as they are now."""
    text = json.dumps([scene.to_dict(), scene.overrides], default=_array)
    hashed = hashlib.sha256(text.encode())
    with contextlib.suppress(Exception):
        # Where only samples make it whole, it has no start of its own.
        hashed.update(_run.quiet_simulation(scene, {"backend": "cpu", "threads": 1}).state_hash().encode())
    return hashed.hexdigest()


def _array(value: Any) -> Any:
    """An array as JSON has it: by what it is and a hash of its numbers."""
    array = np.ascontiguousarray(value)
    return [str(array.dtype), array.shape, hashlib.sha256(array.tobytes()).hexdigest()]


def _code(measure: _run.Measure | None) -> str | None:
    """A function by its name and a hash of its source."""
    if measure is None:
        return None
    name = getattr(measure, "__qualname__", type(measure).__name__)
    try:
        source = inspect.getsource(measure)
    except (OSError, TypeError):
        source = ""
    return f"{name} {hashlib.sha256(source.encode()).hexdigest()[:16]}"


def _manifest(experiment: dict[str, Any], samples: list[Sample]) -> dict[str, Any]:
    paths = list(dict.fromkeys(path for sample in samples for path in sample))
    versions = {"python": platform.python_version(), "numpy": np.__version__, "machine": platform.platform()}
    return {
        "experiment": experiment,
        "versions": versions,
        "command": sys.argv,
        "started": _now(),
        "paths": paths,
        "runs": len(samples),
    }


def _ended(folder: Folder, rows: dict[str, dict[str, Any]]) -> dict[str, Any]:
    states = Counter(row["status"] for row in rows.values())
    digest = hashlib.sha256((folder.path / RESULTS).read_bytes()).hexdigest()
    return {"ended": _now(), "done": states["done"], "failed": states["failed"], "results_sha256": digest}


def _now() -> str:
    return datetime.now(timezone.utc).isoformat(timespec="seconds")


def _first_line(error: BaseException) -> str:
    return next(iter(str(error).splitlines()), type(error).__name__).strip()


def _unwatched(_done: int, _failed: int, _all: int) -> None:
    pass
