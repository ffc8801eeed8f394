"""How well parameters are known: intervals by derivatives of the residuals at the best point."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from taffeta.fitting._result import Estimate, Fit

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from taffeta.fitting._model import Compared, Model, Parameter

#: A parameter is identifiable where its 95 % interval reaches no further than this factor, or this part of a linear range, and where
#: targets say more of it than its range does.
_FACTOR, _PART, _OF_RANGE = 2.0, 0.5, 0.14
#: What a range says by itself: a share of it that is as likely anywhere has a variance of 1/12.
RANGE = 12.0
#: The factor of a two-sided 95 % interval where the noise is known.
_NORMAL = 1.959964
#: The same with noise that is estimated with so few degrees of freedom (Student).
_STUDENT = (12.706, 4.303, 3.182, 2.776, 2.571)


def result(
    model: Model,
    point: NDArray[np.float64],
    best: Compared,
    jacobian: NDArray[np.float64],
    history: list[tuple[int, float]],
) -> Fit:
    """The fit, with intervals.

    The covariance is that of least squares with a weak prior, (JᵀJ/s² + 12 I)⁻¹ in shares of the ranges. s² is the mean square of the
    differences by their noise, or 1 if that is less: targets that are missed by more than their noise make no parameter better known.
    """
    freedom = max(1, best.residuals.size - point.size)
    spread = max(1.0, best.cost / freedom)
    information = jacobian.T @ jacobian / spread
    covariance = np.linalg.inv(information + RANGE * np.eye(point.size)).astype(np.float64)
    deviations = np.sqrt(covariance.diagonal())
    # The noise is known as long as the misfit does not say otherwise; then it is estimated from that.
    reach = _NORMAL if spread <= 1.0 else _student(freedom)
    estimates: dict[str, Estimate] = {}
    alone: set[str] = set()
    for index, (name, value) in enumerate(model.values(point).items()):
        parameter = model.parameters[name]
        half = float(reach * deviations[index])
        known = deviations[index] < _OF_RANGE and _is_narrow(parameter, half)
        # What would be known of it if all others were given.
        own = 1.0 / np.sqrt(information[index, index] + RANGE)
        if own < _OF_RANGE and _is_narrow(parameter, float(reach * own)):
            alone.add(name)
        ends = [parameter.value(end) for end in (point[index] - half, point[index] + half)]
        if not known:
            ends = [max(ends[0], parameter.low), min(ends[1], parameter.high)]
        bound = "low" if point[index] <= 1e-3 else "high" if point[index] >= 1.0 - 1e-3 else None
        sensitivity = _sensitivity(jacobian[:, index], parameter)
        estimates[name] = Estimate(value, ends[0], ends[1], bool(known), bound, sensitivity)
    entangled = [name for name, estimate in estimates.items() if not estimate.identifiable and name in alone]
    assert best.simulated is not None, "a fit has a best point whose simulations came to their end"
    compared = {
        experiment.name: (experiment.measured, simulated, experiment.noise)
        for experiment, simulated in zip(model.experiments, best.simulated, strict=True)
    }
    misfit = math.sqrt(best.cost / best.residuals.size)
    return Fit(
        estimates, misfit, entangled, list(best.restless), compared, model.parameters, history, model.tried, covariance
    )


def _is_narrow(parameter: Parameter, half: float) -> bool:
    """Whether an interval says something, by half of it as a share of the range."""
    if parameter.scale == "log":
        return half * parameter.width <= math.log(_FACTOR)
    return half <= _PART


def _sensitivity(column: NDArray[np.float64], parameter: Parameter) -> float:
    """By how many times their noise targets move, at most, where a parameter doubles or goes through its range."""
    share = math.log(2.0) / parameter.width if parameter.scale == "log" else 1.0
    return float(np.abs(column).max() * share)


def _student(freedom: int) -> float:
    """The factor of a two-sided 95 % interval with so many degrees of freedom (Cornish-Fisher expansion of Student's t).

    >>> [round(_student(freedom), 2) for freedom in (1, 6, 10, 1000)]
    [12.71, 2.45, 2.23, 1.96]
    """
    if freedom <= len(_STUDENT):
        return _STUDENT[freedom - 1]
    z = _NORMAL
    first = (z**3 + z) / 4.0
    second = (5.0 * z**5 + 16.0 * z**3 + 3.0 * z) / 96.0
    third = (3.0 * z**7 + 19.0 * z**5 + 17.0 * z**3 - 15.0 * z) / 384.0
    return z + first / freedom + second / freedom**2 + third / freedom**3
