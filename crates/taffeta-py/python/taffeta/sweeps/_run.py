"""One run of a sweep, in whatever process it is."""

from __future__ import annotations

import os
import socket
import time
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from taffeta._errors import InputError, SceneWarning
from taffeta._kinds import is_mapping
from taffeta._native import Simulation
from taffeta._packages import package
from taffeta._reports import row as row_of
from taffeta.sweeps import _plan

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from taffeta._scene import Scene

#: What is measured at the end of a run: numbers, texts or lists of numbers by their names.
Measure: TypeAlias = Callable[[Simulation], Mapping[str, Any]]

#: Arrays that can be kept.
ARRAYS = ("positions", "velocities", "normals")


#: For how many frames nothing moves where cloth is at rest, and not just where it turns back.
_CALM = 5


@dataclass(frozen=True)
class Job:
    """What all runs of a sweep share."""

    scene: Scene
    #: How many frames each has; those of its scene, if there is no number.
    frames: int | None
    rest: float | None = None
    measure: Measure | None = None
    arrays: tuple[str, ...] = ()
    every: int | None = None
    options: dict[str, Any] = field(default_factory=lambda: {})

    def packed(self) -> bytes:
        """It as bytes, also with functions of a script or a notebook."""
        return bytes(package("cloudpickle").dumps(self))


@dataclass
class Outcome:
    """What a run leaves."""

    #: What the sample gives, the same wherever and whenever it runs.
    row: dict[str, Any]
    arrays: dict[str, NDArray[Any]] = field(default_factory=lambda: {})
    #: How it ran.
    seconds: float = 0.0
    host: str = ""
    process: int = 0
    #: What is known of it beside its message.
    detail: str | None = None


def execute(packed: bytes, sample: _plan.Sample) -> Outcome:
    """Runs a sample. What goes wrong in it is its outcome."""
    start = time.perf_counter()
    try:
        job: Job = package("cloudpickle").loads(packed)
        outcome = _run(job, sample)
    except BaseException as error:
        # Also what would end a program: it ends this run alone.
        outcome = failed(type(error).__name__, _text(error))
    outcome.seconds = time.perf_counter() - start
    outcome.host, outcome.process = socket.gethostname(), os.getpid()
    return outcome


def failed(kind: str, message: str) -> Outcome:
    """The outcome of a run that has no other."""
    return Outcome({"status": "failed", "error": kind, "message": message})


def _run(job: Job, sample: _plan.Sample) -> Outcome:
    scene = _plan.of_scene(job.scene, sample)
    frames = scene.frames if job.frames is None else job.frames
    if frames is None:
        raise InputError("this sample has no `time.frames`")
    simulation = quiet_simulation(scene, job.options)
    kept = _Kept(job, simulation)
    peak = simulation.report["max_stretch"]
    calm = 0
    for _ in range(frames):
        peak = max(peak, simulation.step()["max_stretch"])
        kept.look(simulation)
        calm = calm + 1 if job.rest is not None and _speed(simulation) < job.rest else 0
        if calm == _CALM:
            break
    row: dict[str, Any] = {"status": "done", "error": None, "message": None, "warnings": "\n".join(simulation.warnings) or None}
    if job.rest is not None:
        row["at_rest"] = calm == _CALM
    row["state_hash"] = simulation.state_hash()
    row["peak_stretch"] = peak
    row.update(row_of(simulation.report))
    if job.measure is not None:
        row.update(_measured(job.measure(simulation), {*row, *sample, *_plan.COLUMNS}))
    return Outcome(row, kept.arrays(simulation))


def _speed(simulation: Simulation) -> float:
    """Speed of the fastest vertex [m/s]."""
    return float(np.linalg.norm(simulation.velocities(), axis=1).max(initial=0.0))


def quiet_simulation(scene: Scene, options: dict[str, Any]) -> Simulation:
    """A simulation whose warnings are not printed: they are part of what a run leaves."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SceneWarning)
        return Simulation(scene, **options)


def _text(error: BaseException) -> str:
    try:
        return _plan.text(str(error))
    except Exception:
        return "it has no text"


def _measured(found: Any, taken: set[str]) -> dict[str, Any]:
    """What is measured, as JSON has it."""
    if not is_mapping(found):
        raise InputError(f"measure returned a {type(found).__name__}; a dict of numbers by their names would do")
    for name in found:
        if not isinstance(name, str):
            raise InputError(f"measure returned {name!r} for a name; a text would do")
        if name in taken:
            raise InputError(f"measure returned `{name}`, which is a column of the sweep: another name would do")
    return {_plan.text(name): _plan.plain(value, f"measure: `{name}`") for name, value in found.items()}


class _Kept:
    """Arrays that are kept of a run: of its end, or of every few frames."""

    def __init__(self, job: Job, simulation: Simulation) -> None:
        self._job = job
        self._frames: list[int] = []
        self._rows: dict[str, list[NDArray[Any]]] = {name: [] for name in job.arrays}
        self.look(simulation)

    def look(self, simulation: Simulation) -> None:
        """Copies what is wanted of this frame."""
        if self._job.every is None or simulation.frame % self._job.every != 0:
            return
        self._frames.append(simulation.frame)
        for name, rows in self._rows.items():
            rows.append(getattr(simulation, name)())

    def arrays(self, simulation: Simulation) -> dict[str, NDArray[Any]]:
        """All of it: [vertices, 3], or [frames, vertices, 3] with the numbers of the frames."""
        if self._job.every is None or not self._rows:
            return {name: getattr(simulation, name)() for name in self._rows}
        stacked = {name: np.stack(rows) for name, rows in self._rows.items()}
        return {"frames": np.array(self._frames), **stacked}
