"""Reports of frames, and tables of them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeAlias

if TYPE_CHECKING:
    from collections.abc import Iterable

    import pandas as pd

#: A frame in numbers: what ``Simulation.step`` returns.
Report: TypeAlias = "dict[str, Any]"

#: What a table leaves out: it is no number.
_LEFT_OUT = ("squeezed", "volume_targets")


def row(report: Report) -> dict[str, Any]:
    """A report as one row of numbers. Columns are called as in the ``frames.csv`` that the program writes."""
    flat: dict[str, Any] = {}
    for key, value in report.items():
        if key == "momentum":
            flat.update(zip(("px", "py", "pz"), value, strict=True))
        elif key == "angular_momentum":
            flat.update(zip(("lx", "ly", "lz"), value, strict=True))
        elif key == "strain":
            flat.update(_strain(value))
        elif key == "volumes":
            flat.update({f"volume_{body}": volume for body, volume in value.items()})
        elif key == "reactions":
            flat.update(_reactions(value))
        elif key not in _LEFT_OUT:
            flat[key] = value
    return flat


def _strain(strain: dict[str, Any] | None) -> dict[str, float | None]:
    names = ("warp_min", "warp_max", "weft_min", "weft_max", "shear")
    values = [None] * 5 if strain is None else [*strain["warp"], *strain["weft"], strain["shear"]]
    return dict(zip(names, values, strict=True))


def _reactions(reactions: dict[str, list[list[float] | None]]) -> dict[str, float | None]:
    return {
        f"reaction_{body}_{pin}_{axis}": None if force is None else force[index]
        for body, forces in reactions.items()
        for pin, force in enumerate(forces)
        for index, axis in enumerate("xyz")
    }


def to_pandas(reports: Iterable[Report]) -> pd.DataFrame:
    """Reports as a pandas frame: a row a frame, by the number of the frame. It needs ``pip install taffeta[pandas]``.

    >>> import taffeta
    >>> scene = taffeta.Scene().chain("chain", links=4, length=1.0, mass=0.1, springs={"structural": {"k": 100.0}})
    >>> simulation = taffeta.Simulation(scene)
    >>> table = to_pandas(simulation.step() for _ in range(3))
    >>> table.index.tolist()
    [1, 2, 3]
    >>> bool(table["kinetic"].is_monotonic_increasing)
    True
    """
    import pandas as pd

    return pd.DataFrame([row(report) for report in reports]).set_index("frame")
