"""What is searched and what it is compared with: parameters, targets, and residuals between them."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from taffeta._errors import InputError
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

_COLUMN = "measured_by_target"


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
    measured: NDArray[np.float64]
    noise: NDArray[np.float64]
    target: Target


@dataclass(frozen=True)
class Compared:
    """What simulations with some values of the parameters have come to."""

    #: What each target measured, or why it could not be.
    simulated: tuple[NDArray[np.float64], ...] | None
    message: str | None
    #: Differences from what was measured, by the noise.
    residuals: NDArray[np.float64]

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
        #: How many values were tried.
        self.tried = 0

    def values(self, shares: NDArray[np.float64]) -> Values:
        """Values of the parameters at shares of their ranges. They have seven digits, so that equal ones are found again."""
        pairs = zip(self.parameters.items(), shares.tolist(), strict=True)
        return {name: float(f"{parameter.value(share):.7g}") for (name, parameter), share in pairs}

    def compare(self, points: list[NDArray[np.float64]]) -> list[Compared]:
        """Simulates at points of the search, all of them at once."""
        all_values = [self.values(point) for point in points]
        samples = [dict(self._changes(values) if self._changes else values) for values in all_values]
        self.tried += len(points)
        columns = [self._simulate(experiment, samples) for experiment in self.experiments]
        return [self._compared([column[index] for column in columns]) for index in range(len(points))]

    def _simulate(self, experiment: Experiment, samples: list[dict[str, Any]]) -> list[dict[str, Any]]:
        measure = experiment.target.measure

        def measured(simulation: Simulation) -> dict[str, Any]:
            return {_COLUMN: np.asarray(measure(simulation), np.float64).ravel()}

        # Its name and source are those of the user's function: the sweep tells experiments apart by them.
        functools.update_wrapper(measured, measure)
        found = sweep(
            experiment.scene,
            samples=samples,
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
        for experiment, row in zip(self.experiments, rows, strict=True):
            if row["status"] != "done":
                return Compared(None, f"{experiment.name}: {row['message']}", np.zeros(0))
            numbers = np.asarray(row[_COLUMN], np.float64)
            if numbers.shape != experiment.measured.shape:
                what = f"measure returned {numbers.size} numbers; {experiment.measured.size} were measured"
                raise InputError(f"target `{experiment.name}`: {what}")
            if not np.isfinite(numbers).all():
                return Compared(None, f"{experiment.name}: measure returned a number that is not finite", np.zeros(0))
            simulated.append(numbers)
            residuals.append((numbers - experiment.measured) / experiment.noise)
        return Compared(tuple(simulated), None, np.concatenate(residuals))


def experiments(scene: Source | None, targets: list[Target]) -> list[Experiment]:
    """Targets, checked."""
    if not targets:
        raise InputError("there are no targets to fit to")
    made: list[Experiment] = []
    for index, target in enumerate(targets):
        name = target.name or f"target{index}"
        if not name.isidentifier() or name in (other.name for other in made):
            raise InputError(f"targets[{index}] is called `{name}`; a word of its own would do")
        source = target.scene if target.scene is not None else scene
        if source is None:
            raise InputError(f"target `{name}` has no scene, and no scene is given to the fit")
        measured = np.asarray(target.measured, np.float64).ravel()
        if measured.size == 0 or not np.isfinite(measured).all():
            raise InputError(f"target `{name}`: measured has {measured.size} numbers; some that are finite would do")
        made.append(Experiment(name, Scene(source), measured, _noise(target, name, measured.size), target))
    return made


def _noise(target: Target, name: str, count: int) -> NDArray[np.float64]:
    noise = np.asarray(target.noise, np.float64).ravel()
    if noise.size not in (1, count):
        raise InputError(f"target `{name}`: noise has {noise.size} numbers; one would do, or {count}")
    if not (np.isfinite(noise).all() and (noise > 0.0).all()):
        raise InputError(f"target `{name}`: noise is a standard deviation; above 0 would do")
    return np.broadcast_to(noise, (count,)).copy()
