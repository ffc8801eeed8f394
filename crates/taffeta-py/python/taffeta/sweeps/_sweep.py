"""The sweep itself: it gives out runs, keeps what they leave, and tells how far it is."""

from __future__ import annotations

import contextlib
import hashlib
import operator
import os
import platform
import sys
from collections import Counter, deque
from collections.abc import Callable, Generator, Iterable, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
from dataclasses import dataclass
from datetime import datetime, timezone
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from taffeta import _native
from taffeta._errors import InputError
from taffeta._packages import package
from taffeta._scene import Scene
from taffeta.sweeps import _backends, _identity, _plan, _results, _run
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
    chosen = _samples(grid, samples, job)
    attempts = _whole("attempts", attempts)
    _backends.refuse_unknown(backend)
    _refuse_unfit(job, chosen)
    packed, experiment = job.packed(), _experiment(job)
    folder = Folder(Path(out))
    with folder.taken(experiment):
        before = folder.read_manifest()
        content = _manifest(job, experiment, chosen, before)
        folder.manifest(content)
        by_key = {_plan.key(sample): sample for sample in chosen}
        rows = folder.done(list(by_key), experiment)
        if retry_failed:
            rows = {key: row for key, row in rows.items() if row["status"] == "done"}
        watch = Progress(len(rows), len(by_key)) if progress is True else progress or _unwatched
        try:
            if len(rows) < len(by_key):
                runs = _Runs(folder, experiment, packed, by_key, rows, attempts, watch)
                with _given(backend, jobs) as opened:
                    runs.run(opened)
        finally:
            # Also where it is stopped: what is done can be read, and is not run again.
            folder.results(_results.table(chosen, rows))
            folder.manifest({**content, **_ended(folder, rows, list(by_key))})
    return _results.Sweep(folder.path)


@dataclass
class _Runs:
    """What runs, and what has run."""

    folder: Folder
    experiment: dict[str, Any]
    packed: bytes
    by_key: dict[str, Sample]
    rows: dict[str, dict[str, Any]]
    attempts: int
    watch: Watch

    def run(self, backend: Backend) -> None:
        """Runs what has not run."""
        waiting = deque(key for key in self.by_key if key not in self.rows)
        failed = sum(row["status"] == "failed" for row in self.rows.values())
        tries: Counter[str] = Counter()
        pending: dict[Future[_run.Outcome], str] = {}
        while waiting or pending:
            while waiting and len(pending) < backend.slots:
                key = waiting.popleft()
                tries[key] += 1
                pending[backend.submit(self.packed, self.by_key[key])] = key
            finished, _ = wait(pending, return_when=FIRST_COMPLETED)
            for future in finished:
                key = pending.pop(future)
                try:
                    outcome = future.result()
                except backend.lost as error:
                    if tries[key] < self.attempts:
                        waiting.appendleft(key)
                        continue
                    outcome = _run.failed("WorkerLost", f"its worker was lost {self.attempts} times")
                    outcome.detail = str(error)
                self.folder.keep(key, self.by_key[key], outcome, self.experiment)
                self.rows[key] = outcome.row
                failed += outcome.row["status"] == "failed"
                self.watch(len(self.rows), failed, len(self.by_key))


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
    frames = None if frames is None else _whole("frames", frames)
    every = None if every is None else _whole("every", every)
    if measure is not None and not callable(measure):
        raise InputError(f"measure is {measure!r}; a function of a Simulation would do")
    if isinstance(arrays, str):
        raise InputError(f"arrays is {arrays!r}; a list of names would do: [{arrays!r}]")
    if rest is not None and not rest > 0.0:
        raise InputError(f"rest is {rest} m/s; above 0 would do")
    for name in arrays:
        if name not in _run.ARRAYS:
            raise InputError(f"there is no array `{name}`; there are: {', '.join(_run.ARRAYS)}")
    chosen = {"backend": "cpu", "threads": 1, **(options or {})}
    return _run.Job(scene, frames, rest, measure, tuple(arrays), every, chosen)


def _whole(name: str, value: Any) -> int:
    """A whole number from 1 on."""
    try:
        number = operator.index(value)
    except TypeError:
        raise InputError(f"{name} is {value!r}; a whole number would do") from None
    if number < 1:
        raise InputError(f"{name} is {number}; 1 or more would do")
    return number


def _samples(grid: Mapping[str, Iterable[Any]] | None, samples: Any, job: _run.Job) -> list[Sample]:
    if (grid is None) == (samples is None):
        raise InputError("a sweep has either a grid or samples")
    chosen = _plan.of_grid(grid) if grid is not None else _plan.of_samples(samples)
    if not chosen:
        raise InputError("there are no samples to run")
    lengths = sum("time.frames" in sample for sample in chosen)
    if job.frames is not None and lengths:
        raise InputError("frames are given, and also as `time.frames` of samples; one of the two would do")
    if job.frames is None and job.scene.frames is None and lengths < len(chosen):
        raise InputError("the scene has no `time.frames`, and no frames are given; one of the two would do")
    return chosen


def _refuse_unfit(job: _run.Job, samples: list[Sample]) -> None:
    """Refuses samples with none of which the scene can be built, and options that no simulation takes.

    Where it can be built with some samples, the others become rows that say why.
    """
    first: Exception | None = None
    for sample in samples:
        try:
            _run.quiet_simulation(_plan.of_scene(job.scene, sample), job.options)
        except (TypeError, InputError):
            raise
        except Exception as error:
            first = first or error
        else:
            return
    if first is not None:
        raise first


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
        "scene": _identity.of_scene(job.scene),
        "frames": job.scene.frames if job.frames is None else job.frames,
        "rest": job.rest,
        "measure": _identity.of_function(job.measure),
        "arrays": list(job.arrays),
        "every": job.every,
        "options": _plan.plain(job.options, "options"),
    }


def _manifest(
    job: _run.Job, experiment: dict[str, Any], samples: list[Sample], before: dict[str, Any]
) -> dict[str, Any]:
    """What runs. Calls that have gone before stay written down."""
    paths = list(dict.fromkeys(path for sample in samples for path in sample))
    versions = {name: package(name).__version__ for name in ("numpy", "pyarrow", "cloudpickle", "loky")}
    versions = {"taffeta": _native.__version__, "python": platform.python_version(), **versions}
    try:
        text: str | None = job.scene.to_toml()
    except Exception:
        # A mesh of arrays has no text.
        text = None
    call = {"started": _now(), "command": sys.argv, "machine": platform.platform(), "versions": versions}
    return {
        "experiment": experiment,
        "scene": text,
        "overrides": job.scene.overrides,
        "paths": paths,
        "samples": len(samples),
        "calls": [*before.get("calls", []), call],
    }


def _ended(folder: Folder, rows: dict[str, dict[str, Any]], keys: list[str]) -> dict[str, Any]:
    states = Counter(rows[key]["status"] for key in keys if key in rows)
    digest = hashlib.sha256((folder.path / RESULTS).read_bytes()).hexdigest()
    return {"ended": _now(), "runs": len(keys), "done": states["done"], "failed": states["failed"], "results_sha256": digest}


def _now() -> str:
    return datetime.now(timezone.utc).isoformat(timespec="seconds")


def _unwatched(_done: int, _failed: int, _all: int) -> None:
    pass
