"""Poses of colliders and pins."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from taffeta._errors import InputError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray


def pose(
    translate: Sequence[float] | NDArray[np.floating] = (0.0, 0.0, 0.0),
    *,
    axis: Sequence[float] | NDArray[np.floating] = (0.0, 1.0, 0.0),
    degrees: float = 0.0,
) -> NDArray[np.float64]:
    """A rigid motion as a matrix [4, 4]: first a turn about an axis through the origin, then a shift.

    Args:
        translate: Shift [m].
        axis: Direction of the axis; its length does not matter.
        degrees: Angle [°], right-handed.

    >>> pose((0.0, 0.5, 0.0))[:3, 3].tolist()
    [0.0, 0.5, 0.0]
    >>> (pose(axis=(0, 1, 0), degrees=90.0) @ [1.0, 0.0, 0.0, 1.0]).round(12).tolist()
    [0.0, 0.0, -1.0, 1.0]
    """
    direction = np.asarray(axis, dtype=float)
    length = float(np.linalg.norm(direction))
    if direction.shape != (3,) or not math.isfinite(length) or length == 0.0:
        raise InputError(f"axis is {axis!r}; three numbers with a direction would do")
    x, y, z = direction / length
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    angle = math.radians(degrees)
    matrix = np.eye(4)
    matrix[:3, :3] += math.sin(angle) * cross + (1.0 - math.cos(angle)) * (cross @ cross)
    matrix[:3, 3] = translate
    return matrix
