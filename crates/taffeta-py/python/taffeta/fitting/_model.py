"""What is searched and what it is compared with: parameters, targets, and residuals between them."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from taffeta._errors import InputError
from taffeta._kinds import is_mapping
from taffeta._scene import Scene
from taffeta.sweeps import sweep

if TYPE_CHECKING:
    from pathlib import Path

    from numpy.typing import ArrayLike, NDArray

    from taffeta._native import Simulation
    from taffeta._scene import Source
    from taffeta.sweeps import Backend

#: Values of parameters by their names.
Values: TypeAlias = "dict[str, float]"
#: Turns values of parameters into values by paths, as `Scene.set` takes them.
Changes: TypeAlias = "Callable[[Values], Mapping[str, Any]]"

_COLUMN, _SHAPE = "measured_by_target", "shape_of_target"


@dataclass(frozen=True)
class Parameter:
    """A number that is searched.

    Args:
        low: Least that it can be.
        high: Most that it can be.
        scale: "log" where factors matter, as for stiffnesses; or "linear".
    """

    __module__ = "taffeta.fitting"

    low: float
    high: float
    scale: str = "log"

    def refuse_unfit(self, name: str) -> None:
        """Refuses what is no range."""
        if self.scale not in ("log", "linear"):
            raise InputError(f"parameter `{name}`: scale is `{self.scale}`; log or linear would do")
        if not (math.isfinite(self.low) and math.isfinite(self.high) and self.low < self.high):
            raise InputError(f"parameter `{name}`: from {self.low} to {self.high}; two numbers that rise would do")
        if self.scale == "log" and self.low <= 0.0:
            raise InputError(f"parameter `{name}`: from {self.low}; above 0 would do, or scale=\"linear\"")

    @property
    def width(self) -> float:
        """Its range in the coordinate that is searched: a logarithm or itself."""
        return math.log(self.high / self.low) if self.scale == "log" else self.high - self.low

    def value(self, share: float) -> float:
        """Its value at a share of the range, 0 to 1."""
        if self.scale == "log":
            return self.low * math.exp(share * self.width)
        return self.low + share * self.width

    def share(self, value: float) -> float:
        """The share of the range at a value."""
        if self.scale == "log":
            return math.log(value / self.low) / self.width
        return (value - self.low) / self.width


@dataclass(frozen=True)
class Target:
    """What was measured in one experiment.

    Args:
        measure: Measures the same of a ``Simulation`` at its end: a number, or an array of numbers.
        measured: What was measured: as many numbers.
        noise: Their standard deviation, in their own unit. One number for all of them, or one for each.
        scene: The experiment; the scene of the fit, if it is not given.
        frames: How many frames it has; those of the scene, if it is not given.
        rest: Ends it before, when no vertex is faster than this [m/s] any more.
        name: What it is called in what is said and drawn.
    """

    __module__ = "taffeta.fitting"

    measure: Callable[[Simulation], ArrayLike]
    measured: ArrayLike
    noise: ArrayLike
    scene: Source | None = None
    frames: int | None = None
    rest: float | None = None
    name: str = ""


@dataclass(frozen=True)
class Experiment:
    """A target that was checked."""

    name: str
    scene: Scene
    #: In one row; `shape` is how they were given.
    measured: NDArray[np.float64]
    noise: NDArray[np.float64]
    shape: tuple[int, ...]
    target: Target


@dataclass(frozen=True)
class Compared:
    """What simulations with some values of the parameters have come to."""

    #: What each target measured, or why it could not be.
    simulated: tuple[NDArray[np.float64], ...] | None
    message: str | None
    #: Differences from what was measured, by the noise.
    residuals: NDArray[np.float64]
    #: Targets that should have come to rest and had not.
    restless: tuple[str, ...] = ()

    @property
    def cost(self) -> float:
        """Sum of their squares; infinite where a simulation failed."""
        return math.inf if self.simulated is None else float(self.residuals @ self.residuals)


class Model:
    """Compares simulations with targets. Each is a sweep: what has run is not run again."""

    def __init__(
        self,
        experiments: list[Experiment],
        parameters: Mapping[str, Parameter],
        changes: Changes | None,
        options: dict[str, Any],
        out: Path,
    ) -> None:
        self.experiments = experiments
        self.parameters = dict(parameters)
        self._changes = changes
        self._options = options
        self._out = out
        self.backend: str | Backend = "local"
        #: How many points were tried.
        self.tried = 0
        #: What was simulated so far, which is in the tables of all sweeps.
        self._samples: list[dict[str, Any]] = []

    def values(self, shares: NDArray[np.float64]) -> Values:
        """Values of the parameters at shares of their ranges. They have seven digits, so that equal ones are found again."""
        pairs = zip(self.parameters.items(), shares.tolist(), strict=True)
        return {name: float(f"{parameter.value(share):.7g}") for (name, parameter), share in pairs}

    def compare(self, points: list[NDArray[np.float64]]) -> list[Compared]:
        """Simulates at points of the search, all of them at once."""
        all_values = [self.values(point) for point in points]
        self._samples.extend(self._sample(values) for values in all_values)
        self.tried += len(points)
        columns = [self._simulate(experiment)[-len(points) :] for experiment in self.experiments]
        return [self._compared([column[index] for column in columns]) for index in range(len(points))]

    def _sample(self, values: Values) -> dict[str, Any]:
        if self._changes is None:
            return dict(values)
        changed: Any = self._changes(values)
        if not is_mapping(changed):
            raise InputError(f"changes returned a {type(changed).__name__}; a dict of values by paths would do")
        return dict(changed)

    def _simulate(self, experiment: Experiment) -> list[dict[str, Any]]:
        measure = experiment.target.measure

        def measured(simulation: Simulation) -> dict[str, Any]:
            numbers = np.asarray(measure(simulation), np.float64)
            return {_COLUMN: numbers.ravel(), _SHAPE: list(numbers.shape)}

        # Its name and source are those of the user's function: the sweep tells experiments apart by them.
        functools.update_wrapper(measured, measure)
        found = sweep(
            experiment.scene,
            samples=self._samples,
            frames=experiment.target.frames,
            rest=experiment.target.rest,
            measure=measured,
            out=self._out / experiment.name,
            backend=self.backend,
            options=self._options,
            progress=False,
        )
        rows: list[dict[str, Any]] = found.table.to_pylist()
        return rows

    def _compared(self, rows: list[dict[str, Any]]) -> Compared:
        """The outcome of the experiments with the same values."""
        simulated: list[NDArray[np.float64]] = []
        residuals: list[NDArray[np.float64]] = []
        restless: list[str] = []
        for experiment, row in zip(self.experiments, rows, strict=True):
            if row["status"] != "done":
                return Compared(None, f"{experiment.name}: {row['message']}", np.zeros(0))
            numbers = np.asarray(row[_COLUMN], np.float64)
            if numbers.size != experiment.measured.size or tuple(row[_SHAPE]) not in (experiment.shape, (), (1,)):
                what = f"measure returned {row[_SHAPE]} numbers; {list(experiment.shape)} were measured"
                raise InputError(f"target `{experiment.name}`: {what}")
            if row.get("at_rest") is False:
                restless.append(experiment.name)
            if not np.isfinite(numbers).all():
                return Compared(None, f"{experiment.name}: measure returned a number that is not finite", np.zeros(0))
            simulated.append(numbers)
            residuals.append((numbers - experiment.measured) / experiment.noise)
        return Compared(tuple(simulated), None, np.concatenate(residuals), tuple(restless))


def experiments(scene: Source | None, targets: list[Any]) -> list[Experiment]:
    """Targets, checked."""
    if not targets or not all(isinstance(target, Target) for target in targets):
        raise InputError(f"targets are {targets!r}; a Target, or a list of them, would do")
    made: list[Experiment] = []
    for index, target in enumerate(targets):
        name = target.name or f"target{index}"
        if not name.isidentifier() or name in (other.name for other in made):
            raise InputError(f"targets[{index}] is called `{name}`; a word of its own would do")
        source = target.scene if target.scene is not None else scene
        if source is None:
            raise InputError(f"target `{name}` has no scene, and no scene is given to the fit")
        measured = _numbers(target.measured, f"target `{name}`: measured")
        shape, measured = measured.shape, measured.ravel()
        if measured.size == 0 or not np.isfinite(measured).all():
            raise InputError(f"target `{name}`: measured has {measured.size} numbers; some that are finite would do")
        made.append(Experiment(name, Scene(source), measured, _noise(target, name, measured.size), shape, target))
    return made


def _numbers(given: ArrayLike, what: str) -> NDArray[np.float64]:
    try:
        return np.asarray(given, np.float64)
    except (TypeError, ValueError):
        raise InputError(f"{what} is {given!r}; numbers would do") from None


def _noise(target: Target, name: str, count: int) -> NDArray[np.float64]:
    noise = _numbers(target.noise, f"target `{name}`: noise").ravel()
    if noise.size not in (1, count):
        raise InputError(f"target `{name}`: noise has {noise.size} numbers; one would do, or {count}")
    if not (np.isfinite(noise).all() and (noise > 0.0).all()):
        raise InputError(f"target `{name}`: noise is a standard deviation; above 0 would do")
    return np.broadcast_to(noise, (count,)).copy()
