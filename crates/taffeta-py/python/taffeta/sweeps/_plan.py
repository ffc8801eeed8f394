"""What a sweep runs: samples of values by their paths."""

from __future__ import annotations

import hashlib
import itertools
import json
import math
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, TypeAlias, cast

import numpy as np

from taffeta import _native
from taffeta._errors import InputError
from taffeta._kinds import is_mapping, is_sequence

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from taffeta._scene import Scene

#: Values by the paths that `Scene.set` takes.
Sample: TypeAlias = "dict[str, Any]"


#: Columns that every sweep has beside those of reports.
COLUMNS = ("run", "key", "status", "error", "message", "warnings", "state_hash", "peak_stretch", "at_rest")


def of_grid(grid: Mapping[str, Iterable[Any]]) -> list[Sample]:
    """Every combination; the last path varies fastest.

    >>> of_grid({"a": [1, 2], "b": ["x", "y"]})
    [{'a': 1, 'b': 'x'}, {'a': 1, 'b': 'y'}, {'a': 2, 'b': 'x'}, {'a': 2, 'b': 'y'}]
    """
    values = [[plain(value, f"grid: `{path}`") for value in _several(path, values)] for path, values in grid.items()]
    return [dict(zip(grid, chosen, strict=True)) for chosen in itertools.product(*values)]


def of_samples(samples: Any) -> list[Sample]:
    """A list of dicts, or a data frame of pandas or Polars with a row for each sample.

    >>> of_samples([{"a": np.float64(0.5)}])
    [{'a': 0.5}]
    """
    try:
        if hasattr(samples, "to_dicts"):
            # A frame of Polars.
            every: list[Any] = list(samples.to_dicts())
        else:
            every = list(samples.to_dict("records") if hasattr(samples, "to_dict") else samples)
    except TypeError:
        raise InputError(f"samples are a {type(samples).__name__}; a list of dicts or a data frame would do") from None
    return [_sample(index, row) for index, row in enumerate(every)]


def _sample(index: int, row: Any) -> Sample:
    if not is_mapping(row):
        raise InputError(f"samples[{index}] is {row!r}; a dict of values by their paths would do")
    return {str(path): plain(value, f"samples[{index}]: `{path}`") for path, value in row.items()}


def parse(given: str) -> tuple[str, list[Any]]:
    """What `--grid` of the program takes: a path, and a range or a list of values.

    >>> parse("world.drag=0:1:3")
    ('world.drag', [0.0, 0.5, 1.0])
    >>> parse("body.flag.material.bending=1e-6:1e-4:log:3")
    ('body.flag.material.bending', [1e-06, 1e-05, 0.0001])
    >>> parse("body.flag.material.preset=silk,denim")
    ('body.flag.material.preset', ['silk', 'denim'])
    """
    path, equals, values = given.partition("=")
    if not (path and equals and values):
        raise InputError(f"`{given}`: PATH=FIRST:LAST:COUNT, PATH=FIRST:LAST:log:COUNT or PATH=ONE,OTHER,… would do")
    parts = values.split(":")
    if len(parts) in (3, 4):
        return path, _range(given, parts)
    if len(parts) == 2 and all(_is_number(part) for part in parts):
        raise InputError(f"`{given}`: a range needs a count: {values}:8, or {parts[0]}:{parts[1]}:log:8")
    listed = _split(values)
    if not all(part.strip() for part in listed):
        raise InputError(f"`{given}`: a value between its commas is missing")
    return path, [_value(part) for part in listed]


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def key(sample: Sample) -> str:
    """The name of a run: the same for the same values, wherever they stand in a sweep."""
    return hashlib.sha256(json.dumps(sample, sort_keys=True).encode()).hexdigest()[:16]


def of_scene(scene: Scene, sample: Sample) -> Scene:
    """The scene with the values of a sample."""
    changed = scene.copy()
    for path, value in sample.items():
        changed.set(path, value)
    return changed


def _several(path: str, values: Any) -> list[Any]:
    if isinstance(values, (str, bytes)) or not hasattr(values, "__iter__"):
        raise InputError(f"grid: `{path}` has {values!r}; a list of values would do")
    all_of_it: list[Any] = list(values)
    if not all_of_it:
        raise InputError(f"grid: `{path}` has no values")
    return all_of_it


def text(value: str) -> str:
    """A text as files take it."""
    return value.encode("utf-8", "replace").decode("utf-8")


def plain(value: Any, what: str) -> Any:
    """A value as JSON has it; `what` names it where it is none."""
    if isinstance(value, (np.generic, np.ndarray)):
        return plain(cast("NDArray[Any]", value).tolist(), what)
    if is_mapping(value):
        return {str(name): plain(inner, what) for name, inner in value.items()}
    if is_sequence(value):
        return [plain(inner, what) for inner in value]
    if isinstance(value, str):
        return text(value)
    if isinstance(value, int) and not -(2**63) <= value < 2**63:
        raise InputError(f"{what} is {value}; a number of 64 bits would do")
    if value is None or isinstance(value, (bool, int, float)):
        return value
    raise InputError(f"{what} is a {type(value).__name__}; numbers, texts, lists and dicts would do")


def _range(text: str, parts: list[str]) -> list[float]:
    try:
        first, last, count = float(parts[0]), float(parts[1]), int(parts[-1])
    except ValueError:
        raise InputError(f"`{text}`: FIRST and LAST are numbers, and COUNT is a whole one") from None
    spacing = parts[2] if len(parts) == 4 else "lin"
    if spacing not in ("lin", "log"):
        raise InputError(f"`{text}`: `{spacing}` is neither `lin` nor `log`")
    if not 1 <= count <= 1_000_000:
        raise InputError(f"`{text}`: a count of {count}; 1 to 1000000 would do")
    if not (math.isfinite(first) and math.isfinite(last)) or (spacing == "log" and min(first, last) <= 0.0):
        raise InputError(f"`{text}`: from {first} to {last}; finite numbers would do, and above 0 with `log`")
    made = np.linspace(first, last, count) if spacing == "lin" else np.geomspace(first, last, count)
    # Rounded to what a person would write, and with the ends as they are given.
    inner = [float(f"{value:.12g}") for value in made.tolist()]
    return [first] if count == 1 else [first, *inner[1:-1], last]


def _split(values: str) -> list[str]:
    """At commas, but not at those in brackets or quotes."""
    parts, depth, quoted = [""], 0, ""
    for letter in values:
        if quoted:
            quoted = "" if letter == quoted else quoted
        elif letter in "\"'":
            quoted = letter
        else:
            depth += (letter in "[{") - (letter in "]}")
        if letter == "," and depth == 0 and not quoted:
            parts.append("")
        else:
            parts[-1] += letter
    return parts


def _value(text: str) -> Any:
    """A value of TOML, or else a word."""
    try:
        return plain(_native.parse_toml(f"value = {text}")["value"], text)
    except ValueError:
        return text.strip()
