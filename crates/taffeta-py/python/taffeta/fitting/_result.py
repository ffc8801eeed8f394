"""The result of a fit: in numbers, in words and as a picture."""

from __future__ import annotations

import html
import json
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from taffeta._packages import package

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from taffeta.fitting._model import Parameter


@dataclass(frozen=True)
class Estimate:
    """A parameter that was fitted."""

    __module__ = "taffeta.fitting"

    value: float
    #: Ends of its 95 % interval.
    low: float
    high: float
    #: Whether the targets show it: its interval reaches no further than a factor of 2, or half of a linear range, and says more than
    #: the range does.
    identifiable: bool
    #: "low" or "high" where it is at an end of its range.
    at_bound: str | None
    #: By how many times the noise the targets move at most where it doubles, or goes through a linear range.
    sensitivity: float


@dataclass(frozen=True)
class Fit:
    """What a fit has found. ``print(fit)`` shows it."""

    __module__ = "taffeta.fitting"

    estimates: dict[str, Estimate]
    #: Root of the mean square of the differences, by the noise: about 1 where all is as it is said.
    misfit: float
    #: Parameters that are not known each, but would be if the others were.
    entangled: list[str]
    #: Targets that should have come to rest and had not.
    restless: list[str]
    #: By target: what was measured, what is simulated with the fitted values, and the noise.
    targets: dict[str, tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]]
    #: Their ranges.
    parameters: dict[str, Parameter]
    #: How many points were tried, and the least sum of squares until then.
    history: list[tuple[int, float]]
    #: How many points were tried in all.
    points: int
    #: Of the parameters, as shares of their ranges.
    covariance: NDArray[np.float64]

    @property
    def values(self) -> dict[str, float]:
        """The fitted values by their names."""
        return {name: estimate.value for name, estimate in self.estimates.items()}

    def warnings(self) -> list[str]:
        """What should be known of it."""
        said: list[str] = []
        for name, estimate in self.estimates.items():
            if not estimate.identifiable and name not in self.entangled:
                moved = "doubling it" if self.parameters[name].scale == "log" else "its whole range"
                why = f"{moved} moves them by {estimate.sensitivity:.2g} times their noise at most"
                said.append(f"`{name}` cannot be seen from these targets: {why}")
            if estimate.at_bound is not None:
                said.append(f"`{name}` is at the {estimate.at_bound} end of its range; a wider one may fit better")
        if self.entangled:
            names = " and ".join(f"`{name}`" for name in self.entangled)
            said.append(f"{names} cannot be told apart by these targets; another experiment is needed, or one of them given")
        for name in self.restless:
            said.append(f"target `{name}` had not come to rest after its frames: more frames, or more drag, would do")
        count = sum(measured.size for measured, _, _ in self.targets.values())
        if self.misfit > 2.0:
            what = "the model, an experiment or the noise is not what it is given as"
            said.append(f"the targets are missed by {self.misfit:.3g} times their noise: {what}")
        if self.misfit < 0.5 and count >= len(self.estimates) + 10:
            what = "the noise is less than it is given as, and intervals are wider than need be"
            said.append(f"the targets are met to {self.misfit:.2g} of their noise: {what}")
        return said

    def to_dict(self) -> dict[str, Any]:
        """Its numbers and words, as JSON takes them."""
        return {
            "estimates": {name: vars(estimate) for name, estimate in self.estimates.items()},
            "misfit": self.misfit,
            "warnings": self.warnings(),
            "points": self.points,
            "entangled": self.entangled,
            "restless": self.restless,
            "covariance": self.covariance.tolist(),
        }

    def write(self, folder: Path) -> None:
        """Writes ``fit.json``, and ``fit.png`` where matplotlib is installed."""
        (folder / "fit.json").write_text(json.dumps(self.to_dict(), indent=2))
        try:
            package("matplotlib.figure")
        except ModuleNotFoundError:
            return
        self.plot().savefig(folder / "fit.png", dpi=120)

    def plot(self) -> Any:
        """A figure of matplotlib: the search, the parameters with their intervals in their ranges, and each target."""
        figure: Any = package("matplotlib.figure").Figure(figsize=(4.0 * (2 + len(self.targets)), 3.6), layout="constrained")
        axes = figure.subplots(1, 2 + len(self.targets))
        self._plot_search(axes[0])
        self._plot_parameters(axes[1])
        for axis, (name, numbers) in zip(axes[2:], self.targets.items(), strict=True):
            _plot_target(axis, name, *numbers)
        return figure

    def _plot_search(self, axis: Any) -> None:
        count = sum(measured.size for measured, _, _ in self.targets.values())
        points, costs = zip(*self.history, strict=True)
        axis.semilogy(points, np.sqrt(np.maximum(costs, 1e-12) / count))
        axis.set(title="search", xlabel="points tried", ylabel="misfit by noise")

    def _plot_parameters(self, axis: Any) -> None:
        rows = list(enumerate(self.estimates.items()))
        for row, (name, estimate) in rows:
            share = self.parameters[name].share
            ends = [share(max(end, self.parameters[name].low)) for end in (estimate.low, estimate.high)]
            axis.plot(np.clip(ends, 0.0, 1.0), [row, row], linewidth=5, alpha=0.4)
            axis.plot([share(estimate.value)], [row], "o", color="black")
        axis.set(title="parameters, 95 %", xlabel="share of the range", xlim=(0.0, 1.0), ylim=(-0.5, len(rows) - 0.5))
        axis.set_yticks([row for row, _ in rows], [_label(name, estimate) for _, (name, estimate) in rows])

    def __str__(self) -> str:
        lines = [f"fitted to {len(self.targets)} targets with {self.points} points; misfit {self.misfit:.3g} times the noise"]
        for name, estimate in self.estimates.items():
            lines.append(f"  {name} = {estimate.value:.4g}  (95 %: {estimate.low:.4g} to {estimate.high:.4g})")
        return "\n".join([*lines, *self.warnings()])

    def _repr_html_(self) -> str:
        return f"<pre>{html.escape(str(self))}</pre>"


def _label(name: str, estimate: Estimate) -> str:
    return f"{name.rpartition('.')[2]}\n{estimate.value:.3g}"


def _plot_target(
    axis: Any, name: str, measured: NDArray[np.float64], simulated: NDArray[np.float64], noise: NDArray[np.float64]
) -> None:
    axis.plot(measured, (simulated - measured) / noise, ".", markersize=4, alpha=0.6)
    axis.axhspan(-2.0, 2.0, alpha=0.15)
    axis.set(title=name, xlabel="measured", ylabel="difference by noise")
