"""The search: CMA-ES over the whole range, and Gauss-Newton steps from where it has come to."""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from taffeta._errors import InputError
from taffeta._packages import package
from taffeta.fitting import _confidence
from taffeta.fitting._model import Compared, Model, Parameter, Target, experiments
from taffeta.fitting._result import Fit
from taffeta.sweeps._backends import named, refuse_unknown
from taffeta.sweeps._folder import locked

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from taffeta._scene import Source
    from taffeta.fitting._model import Changes
    from taffeta.sweeps import Backend

#: CMA-ES ends where its spread is this share of each range.
_NEAR = 0.02
#: With this spread nothing better is left around a point that explains the targets.
_AROUND = 0.1
#: After so many generations, Gauss-Newton steps are tried from the best point.
_GENERATIONS = 2
#: Most of these steps, and the share of a range from which one counts as none.
_STEPS, _NONE = 8, 2e-4
#: The search ends where targets are missed by their noise and no more, and derivatives promise less than two standard deviations.
_FOUND, _PROMISED = 1.2, 4.0


def fit(
    scene: Source | None,
    targets: Target | Sequence[Target],
    parameters: Mapping[str, Parameter | tuple[float, float]],
    *,
    out: str | os.PathLike[str],
    changes: Changes | None = None,
    backend: str | Backend = "local",
    jobs: int | None = None,
    seed: int = 1,
    population: int | None = None,
    max_points: int = 1000,
    options: Mapping[str, Any] | None = None,
    progress: bool = True,
) -> Fit:
    """Finds parameters with which simulations come nearest to what was measured.

    It minimises the squares of the differences by their noise. CMA-ES searches the whole range and needs no good start. Every few
    generations, Gauss-Newton steps are tried from its best point; they end the search where the differences come down to the
    noise. Their derivatives say how well each parameter is known. A parameter that the targets do not show is named so.

    Every simulation is a run of a sweep in ``out``. A fit that was stopped or killed goes on where it was, if it is called again.

    Args:
        scene: The experiment of targets that have no scene of their own, or ``None``.
        targets: What was measured.
        parameters: Ranges by names: a ``Parameter``, or (low, high) on a logarithmic scale. Names are paths as ``Scene.set`` takes
            them, if ``changes`` is not given.
        out: The folder of the fit.
        changes: Turns a dict of the parameters' values into a dict of values by paths, for instance where two parameters are parts
            of one value.
        backend: Where simulations run, as in ``taffeta.sweep``.
        jobs: How many run at a time on this machine.
        seed: Of CMA-ES, 1 or more. The same seed gives the same fit, for any number of jobs.
        population: Points of a generation of CMA-ES; by default what suits the number of parameters: 8 for up to three. More jobs
            than that do nothing, if a target is all there is to simulate.
        max_points: No generation begins that goes past so many points.
        options: For each ``Simulation``. "f64" does derivatives good, and is what is taken if nothing is said.
        progress: Whether to tell on stderr how far it is.

    Returns:
        A ``taffeta.fitting.Fit``: ``values``, ``estimates`` with intervals, ``str(fit)`` in words, ``plot()``.

    Raises:
        InputError: An argument cannot be, or no simulation came to its end.
        SceneError: A scene cannot take the parameters.
    """
    package("cma")
    if seed < 1:
        raise InputError(f"seed is {seed}; 1 or more would do")
    given = [targets] if isinstance(targets, Target) else list(targets)
    model = Model(
        experiments(scene, given),
        _ranges(parameters),
        changes,
        {"precision": "f64", **(options or {})},
        Path(out),
    )
    search = _Search(model, progress, max_points)
    size = search.population(population)
    folder = Path(out).absolute()
    refuse_unknown(backend)
    folder.mkdir(parents=True, exist_ok=True)
    with locked(folder, "fit"):
        model.backend, is_own = named(backend, jobs)
        try:
            jacobian = search.run(seed, size)
        finally:
            if is_own:
                model.backend.close()
        found = _confidence.result(model, search.point, search.best, jacobian, search.history)
        found.write(folder)
    return found


def _ranges(parameters: Mapping[str, Parameter | tuple[float, float]]) -> dict[str, Parameter]:
    if not parameters:
        raise InputError("there are no parameters to fit")
    made: dict[str, Parameter] = {}
    for name, given in parameters.items():
        try:
            if isinstance(given, Parameter):
                made[name] = given
            else:
                low, high = map(float, given)
                made[name] = Parameter(low, high)
        except (TypeError, ValueError):
            raise InputError(f"parameter `{name}` is {given!r}; (low, high) would do, or a Parameter") from None
        made[name].refuse_unfit(name)
    return made


@dataclass
class _Search:
    """The best point so far. Points are shares of the ranges, 0 to 1."""

    model: Model
    progress: bool
    max_points: int
    point: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0))
    best: Compared = field(default_factory=lambda: Compared(None, None, np.zeros(0)))
    message: str | None = None
    #: How many points were tried, and the least cost so far.
    history: list[tuple[int, float]] = field(default_factory=lambda: [])

    def compare(self, points: list[NDArray[np.float64]]) -> list[Compared]:
        """Simulates, and keeps the best."""
        found = self.model.compare(points)
        for point, compared in zip(points, found, strict=True):
            self.message = compared.message or self.message
            if compared.cost < self.best.cost or not self.point.size:
                self.point, self.best = point, compared
        self.history.append((self.model.tried, self.best.cost))
        if self.progress:
            values = ", ".join(f"{name} {value:.4g}" for name, value in self.model.values(self.point).items())
            print(f"fit: {self.model.tried} points, misfit {self.misfit:.3g} times the noise: {values}", file=sys.stderr)
        return found

    @property
    def misfit(self) -> float:
        """Root of the mean square of the residuals."""
        return float(np.sqrt(self.best.cost / max(1, self.best.residuals.size)))

    @property
    def dimensions(self) -> int:
        """Of CMA-ES, which asks for two at least: the second one of a single parameter does nothing."""
        return max(2, len(self.model.parameters))

    def population(self, given: int | None) -> int:
        """Points of a generation: an even number, so that two cores have the same to do."""
        size = 2 * -(-(4 + int(3 * np.log(self.dimensions))) // 2) if given is None else given
        if size < 4:
            raise InputError(f"population is {size}; 4 or more would do")
        if self.max_points < size:
            raise InputError(f"max_points is {self.max_points}; {size} or more would do: a generation of CMA-ES")
        return size

    def run(self, seed: int, size: int) -> NDArray[np.float64]:
        """Searches; returns derivatives of the residuals at the best point, by shares of the ranges."""
        count, dimensions = len(self.model.parameters), self.dimensions
        settings: dict[str, Any] = {"bounds": [0.0, 1.0], "popsize": size, "verbose": -9, "tolx": 0.0, "tolfun": 0.0}
        # Random numbers of its own: those of numpy are the user's.
        random = np.random.default_rng(seed)

        def normal(*shape: int) -> NDArray[np.float64]:
            return random.standard_normal(shape)

        settings.update(seed=np.nan, randn=normal)
        strategy = package("cma").CMAEvolutionStrategy(dimensions * [0.5], 0.25, settings)
        polished = self.point
        jacobian: NDArray[np.float64] | None = None
        while self.model.tried + size <= self.max_points:
            asked: list[NDArray[np.float64]] = strategy.ask()
            found = self.compare([np.asarray(point[:count]) for point in asked])
            strategy.tell(asked, [compared.cost if np.isfinite(compared.cost) else 1e300 for compared in found])
            spread: NDArray[np.float64] = strategy.sigma * np.sqrt(strategy.C.diagonal())
            if spread[:count].max() < _NEAR or strategy.stop():
                break
            if strategy.countiter % _GENERATIONS != 0 or self.best.simulated is None:
                continue
            if jacobian is None or not np.array_equal(polished, self.point):
                jacobian = self.gauss_newton()
                polished = self.point
                strategy.inject([np.append(self.point, np.full(dimensions - count, 0.5))])
            # Where folds snap nearby, derivatives promise what no step keeps; then it is enough that nothing better is near.
            if self.misfit < _FOUND and (self.promised(jacobian) < _PROMISED or spread[:count].max() < _AROUND):
                return jacobian
        if self.best.simulated is None:
            raise InputError(f"no simulation came to its end; the last one: {self.message}")
        return self.gauss_newton()

    def gauss_newton(self) -> NDArray[np.float64]:
        """Goes downhill from the best point; returns derivatives where it ends."""
        jacobian = self.derivatives()
        for _ in range(_STEPS):
            step = self.step(jacobian)
            # No further than where the derivatives may still hold.
            step *= min(1.0, 0.1 / max(np.abs(step).max(), 1e-300))
            at, before = self.point, self.best.cost
            self.compare([np.clip(at + share * step, 0.0, 1.0) for share in (1.0, 0.3, 0.1)])
            if self.best.cost >= before:
                break
            jacobian = self.derivatives()
            if np.abs(self.point - at).max() < _NONE:
                break
        return jacobian

    def promised(self, jacobian: NDArray[np.float64]) -> float:
        """How much of the sum of squares a further step would take, if derivatives held."""
        return float(-self.step(jacobian) @ (jacobian.T @ self.best.residuals))

    def step(self, jacobian: NDArray[np.float64]) -> NDArray[np.float64]:
        """A Gauss-Newton step; what targets do not show stays where it is."""
        normal = jacobian.T @ jacobian + _confidence.RANGE * np.eye(self.point.size)
        return np.linalg.solve(normal, -(jacobian.T @ self.best.residuals)).astype(np.float64)

    def derivatives(self) -> NDArray[np.float64]:
        """Derivatives of the residuals by each parameter at the best point, by steps of 5 percent on a logarithmic scale."""
        at, centre = self.point, self.best
        points: list[NDArray[np.float64]] = []
        for index, parameter in enumerate(self.model.parameters.values()):
            step = 0.05 / parameter.width if parameter.scale == "log" else 0.02
            for side in (-step, step):
                moved = at.copy()
                moved[index] = np.clip(at[index] + side, 0.0, 1.0)
                points.append(moved)
        found = self.compare(points)
        columns: list[NDArray[np.float64]] = []
        for index in range(at.size):
            slopes = [
                (compared.residuals - centre.residuals) / (point[index] - at[index])
                for point, compared in zip(points[2 * index : 2 * index + 2], found[2 * index : 2 * index + 2], strict=True)
                if compared.simulated is not None and point[index] != at[index]
            ]
            columns.append(_slope(slopes) if slopes else np.zeros_like(centre.residuals))
        return np.stack(columns, axis=1)


def _slope(slopes: list[NDArray[np.float64]]) -> NDArray[np.float64]:
    """The mean of the slopes on both sides; where they differ much, the smaller one, and none where they differ in sign.

    Folds of cloth snap from one shape to another at some values of a parameter. On the side of such a jump the slope says nothing of
    how well the parameter is known.
    """
    one, other = slopes[0], slopes[-1]
    smaller = np.where(one * other > 0.0, np.sign(one) * np.minimum(np.abs(one), np.abs(other)), 0.0)
    return np.where(np.abs(one - other) <= 0.5 * np.abs(one + other), 0.5 * (one + other), smaller)
