"""Packages that only some of taffeta needs."""

from __future__ import annotations

import importlib
from typing import Any

#: What `pip install taffeta[EXTRA]` installs a package with.
_EXTRAS = {"ray": "ray", "distributed": "dask", "cma": "fit", "matplotlib": "fit"}


def package(name: str) -> Any:
    """A package, or words where it is not installed. Most of these have no types."""
    try:
        return importlib.import_module(name)
    except ModuleNotFoundError as error:
        missing = error.name or name
        extra = _EXTRAS.get(missing.partition(".")[0], "sweep")
        what = f"this needs the package {missing}: pip install taffeta[{extra}]"
        raise ModuleNotFoundError(what, name=missing) from None
