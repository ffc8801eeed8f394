"""How well parameters are known: intervals by derivatives of the residuals at the best point."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from taffeta.fitting._result import Estimate, Fit

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from taffeta.fitting._model import Compared, Model

#: A parameter is not seen where its 95 % interval reaches further than this factor, or this share of a linear range.
_FACTOR, _SHARE = 2.0, 0.5
#: The factor of a two-sided 95 % interval where the noise is known.
_NORMAL = 1.959964
#: From this correlation on, only two parameters together are known.
_TOGETHER = 0.98


def result(
    model: Model,
    point: NDArray[np.float64],
    best: Compared,
    jacobian: NDArray[np.float64],
    history: list[tuple[int, float]],
) -> Fit:
    """The fit, with intervals.

    Covariance of least squares, s² (JᵀJ)⁻¹, where s² is the misfit or 1, whichever is larger: targets that are missed by more than
    their noise make no parameter better known.
    """
    freedom = max(1, best.residuals.size - point.size)
    spread = max(1.0, best.cost / freedom)
    covariance = spread * _inverse(jacobian.T @ jacobian)
    deviations = np.sqrt(np.maximum(covariance.diagonal(), 0.0))
    correlation = covariance / np.maximum(np.outer(deviations, deviations), 1e-300)
    estimates: dict[str, Estimate] = {}
    values = model.values(point)
    # The noise is known as long as the misfit does not say otherwise; then it is estimated from that.
    reach = _NORMAL if spread <= 1.0 else _student(freedom)
    for index, (name, parameter) in enumerate(model.parameters.items()):
        half = float(reach * deviations[index] * parameter.width)
        value = values[name]
        if parameter.scale == "log":
            factor = math.exp(min(half, 700.0))
            low, high, seen = value / factor, value * factor, factor <= _FACTOR
        else:
            low, high, seen = value - half, value + half, half <= _SHARE * parameter.width
        at = "low" if point[index] <= 1e-3 else "high" if point[index] >= 1.0 - 1e-3 else None
        change = _change(jacobian[:, index], parameter.scale, parameter.width)
        estimates[name] = Estimate(value, low, high, seen, at, change)
    names = list(model.parameters)
    together = [
        (names[one], names[other])
        for one in range(len(names))
        for other in range(one)
        if abs(correlation[one, other]) > _TOGETHER
    ]
    assert best.simulated is not None, "a fit has a best point whose simulations came to their end"
    compared = {
        experiment.name: (experiment.measured, simulated, experiment.noise)
        for experiment, simulated in zip(model.experiments, best.simulated, strict=True)
    }
    misfit = math.sqrt(best.cost / best.residuals.size)
    return Fit(estimates, misfit, together, compared, model.parameters, history, model.tried, covariance)


def _change(column: NDArray[np.float64], scale: str, width: float) -> float:
    """By how many times their noise targets move, at most, where a parameter doubles or goes through its range."""
    share = math.log(2.0) / width if scale == "log" else 1.0
    return float(np.abs(column).max() * share)


def _inverse(normal: NDArray[np.float64]) -> NDArray[np.float64]:
    """Its inverse; a direction that changes nothing has a huge variance, and not an infinite one."""
    values, vectors = np.linalg.eigh(normal)
    least = max(float(values[-1]), 1e-300) * 1e-12
    inverse: NDArray[np.float64] = (vectors / np.maximum(values, least)) @ vectors.T
    return inverse


def _student(freedom: int) -> float:
    """The factor of a two-sided 95 % interval with so many degrees of freedom (Cornish-Fisher expansion of Student's t).

    >>> [round(_student(freedom), 2) for freedom in (3, 10, 1000)]
    [3.16, 2.23, 1.96]
    """
    z = _NORMAL
    first = (z**3 + z) / 4.0
    second = (5.0 * z**5 + 16.0 * z**3 + 3.0 * z) / 96.0
    third = (3.0 * z**7 + 19.0 * z**5 + 17.0 * z**3 - 15.0 * z) / 384.0
    return z + first / freedom + second / freedom**2 + third / freedom**3
