"""What a sweep leaves: a table, and arrays of each run."""

from __future__ import annotations

import html
import json
import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

from taffeta._errors import InputError
from taffeta._packages import package
from taffeta.sweeps import _plan
from taffeta.sweeps._folder import Folder

if TYPE_CHECKING:
    import pandas as pd
    from numpy.typing import NDArray

    from taffeta.sweeps._plan import Sample


class Sweep:
    """The results of a sweep, in its folder.

    Args:
        folder: The folder of a sweep that has been run, or of one that was stopped: its table has what was done then.
    """

    __module__ = "taffeta.sweeps"

    def __init__(self, folder: str | os.PathLike[str]) -> None:
        self._folder = Folder(Path(folder))
        #: A row a run, in the order of the samples: a table of pyarrow.
        self.table: Any = self._folder.read_results()
        self._paths: list[str] = self._folder.read_manifest().get("paths", [])

    @property
    def folder(self) -> Path:
        """Where it lies."""
        return self._folder.path

    @property
    def done(self) -> int:
        """How many runs came to their end."""
        return self._count("done")

    @property
    def failed(self) -> int:
        """How many runs did not; their column ``message`` says why."""
        return self._count("failed")

    def _count(self, status: str) -> int:
        statuses: list[str] = self.table.column("status").to_pylist()
        return statuses.count(status)

    def to_pandas(self) -> pd.DataFrame:
        """The table as a pandas frame, by the numbers of the runs. It needs ``pip install taffeta[pandas]``."""
        frame: pd.DataFrame = self.table.to_pandas().set_index("run")
        return frame

    def arrays(self, run: int) -> dict[str, NDArray[Any]]:
        """The arrays that were kept of a run: [vertices, 3] of its end, or [frames, vertices, 3] and `frames`, their numbers."""
        if not 0 <= run < self.table.num_rows:
            raise InputError(f"there is no run {run}; there are {self.table.num_rows}, from 0")
        return self._folder.arrays(self.table.column("key")[run].as_py())

    def __len__(self) -> int:
        return int(self.table.num_rows)

    def __repr__(self) -> str:
        return f"<taffeta.Sweep of {len(self)} runs in {self.folder}: {self.done} done, {self.failed} failed>"

    def _repr_html_(self) -> str:
        columns = ["run", *self._paths, "status", "message", "peak_stretch"]
        chosen = self.table.select([name for name in columns if name in self.table.column_names]).slice(0, 20)
        heads = "".join(f"<th>{html.escape(name)}</th>" for name in chosen.column_names)
        cells = ("".join(f"<td>{html.escape(str(value))}</td>" for value in row.values()) for row in chosen.to_pylist())
        rows = "".join(f"<tr>{row}</tr>" for row in cells)
        return f"<p>{html.escape(repr(self))}</p><table><tr>{heads}</tr>{rows}</table>"


def table(samples: list[Sample], rows: dict[str, dict[str, Any]]) -> Any:
    """The table of all samples; those without a row have not run."""
    arrow = package("pyarrow")
    lines: list[dict[str, Any]] = []
    for run, sample in enumerate(samples):
        key = _plan.key(sample)
        lines.append({"run": run, "key": key, **sample, **rows.get(key, {"status": "waiting"})})
    names = list(dict.fromkeys(name for line in lines for name in line))
    columns = {name: _column([line.get(name) for line in lines]) for name in names}
    return arrow.table({name: _array(arrow, column) for name, column in columns.items()})


def _array(arrow: Any, values: list[Any]) -> Any:
    try:
        return arrow.array(values)
    except (arrow.ArrowException, OverflowError, UnicodeError):
        # Lists that have no type in common.
        return arrow.array([None if value is None else json.dumps(value) for value in values])


def _column(values: list[Any]) -> list[Any]:
    """Values that have one type: numbers stay numbers, and else what differs becomes text."""
    kinds: set[type[Any]] = {type(value) for value in values if value is not None}
    if kinds == {int, float}:
        return [None if value is None else float(value) for value in values]
    if len(kinds) > 1 or dict in kinds:
        return [value if value is None or isinstance(value, str) else json.dumps(value) for value in values]
    return values
