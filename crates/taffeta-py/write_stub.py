"""Writes python/taffeta/_native.pyi: the types of the native module, with the documentation that the module has.

    python crates/taffeta-py/write_stub.py [--check]

It needs the built package. Types are below; words are in the Rust.
"""

from __future__ import annotations

import inspect
import sys
import textwrap
from pathlib import Path
from typing import Any

from taffeta import _native

HEAD = '''\
"""The native part of taffeta. Written by write_stub.py: change the types there, and the words in src/."""

import os
from collections.abc import Mapping, Sequence
from typing import Any, TypeVar, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from taffeta._scene import Scene, Source

_T = TypeVar("_T", np.float32, np.float64)

__version__: str
'''

READ = """\
@overload
def {name}(self, body: str | None = None, *, out: None = None) -> NDArray[np.floating[Any]]: ...
@overload
def {name}(self, body: str | None = None, *, out: NDArray[_T]) -> NDArray[_T]: ..."""

FUNCTIONS = {
    "check": "(parts: Scene, /, *, arrays: bool = False) -> None",
    "check_mesh": "(mesh: Any, path: str) -> None",
    "format_toml": "(data: Mapping[str, Any]) -> str",
    "format_value": "(value: Any) -> str",
    "info": "() -> dict[str, Any]",
    "materials": "() -> dict[str, dict[str, Any]]",
    "parse_toml": "(text: str) -> dict[str, Any]",
    "read_text": "(path: str | os.PathLike[str]) -> str",
}

CLASSES: dict[str, dict[str, str]] = {
    "Body": {
        "name": "str",
        "first": "int",
        "vertices": "int",
        "nodes": "int",
        "triangles": "int",
        "springs": "int",
        "pins": "int",
        "pinned": "int",
        "mass": "float",
        "rest_volume": "float | None",
        "repairs": "list[str]",
        "rows": "slice[int, int, int]",
    },
    "Collider": {"name": "str", "shape": "str", "keyframes": "int", "repairs": "list[str]"},
    "Simulation": {
        "__new__": "(cls, scene: Source, *, backend: str = 'auto', threads: int | None = None, precision: str = 'f32', "
        "on_divergence: str = 'stop') -> Simulation",
        "step": "(self, frames: int = 1) -> dict[str, Any]",
        "advance": "(self, seconds: float) -> dict[str, Any]",
        "snapshot": "(self) -> bytes",
        "restore": "(self, snapshot: bytes) -> None",
        "adopt_state": "(self, other: Simulation) -> None",
        "state_hash": "(self) -> str",
        "positions": "READ",
        "velocities": "READ",
        "normals": "READ",
        "faces": "(self, body: str | None = None) -> NDArray[np.uint32]",
        "collider_distances": "(self, reach: float) -> NDArray[np.float32]",
        "intersections": "(self) -> dict[str, Any]",
        "reaction": "(self, body: str, pin: int = 0) -> NDArray[np.float64] | None",
        "collider_pose": "(self, collider: str, fraction: float = 1.0) -> NDArray[np.float64]",
        "collider_velocity": "(self, collider: str) -> NDArray[np.float64]",
        "pin": "(self, body: str, vertices: ArrayLike, to: ArrayLike | None = None) -> None",
        "unpin": "(self, body: str, vertices: ArrayLike) -> None",
        "apply_force": "(self, body: str, vertices: ArrayLike, force: ArrayLike) -> None",
        "move_pin": "(self, body: str, pin: int, pose: ArrayLike) -> None",
        "move_collider": "(self, collider: str, pose: ArrayLike) -> None",
        "set_world": "(self, **changes: Any) -> None",
        "disturb": "(self, amplitude: float, seed: int = 1) -> None",
        "limit_threads": "(self, most: int) -> None",
        "report": "dict[str, Any]",
        "world": "dict[str, Any]",
        "bodies": "dict[str, Body]",
        "colliders": "dict[str, Collider]",
        "frame": "int",
        "time": "float",
        "dt": "float",
        "scene": "Scene",
        "precision": "str",
        "backend": "str",
        "backend_reason": "str",
        "device": "str",
        "threads": "int",
        "memory": "int",
        "warnings": "list[str]",
        "frozen": "list[str]",
    },
    "Worlds": {
        "__new__": "(cls, scene: Source, n: int, *, vary: Mapping[str, Sequence[Any] | NDArray[Any]] | None = None, "
        "threads: int | None = None, precision: str = 'f32') -> Worlds",
        "step": "(self, frames: int = 1, *, mask: ArrayLike | None = None) -> NDArray[np.bool_]",
        "reset": "(self, mask: ArrayLike | None = None) -> None",
        "positions": "READ",
        "velocities": "READ",
        "normals": "READ",
        "apply_force": "(self, body: str, vertices: ArrayLike, force: ArrayLike) -> None",
        "pin": "(self, body: str, vertices: ArrayLike, to: ArrayLike | None = None) -> None",
        "move_collider": "(self, collider: str, shifts: ArrayLike) -> None",
        "reports": "(self) -> dict[str, NDArray[Any]]",
        "frames": "NDArray[np.int64]",
        "threads": "int",
        "memory": "int",
        "__len__": "(self) -> int",
        "__getitem__": "(self, index: int) -> Simulation",
    },
}


def docstring(thing: object, indent: str) -> str:
    """What a thing says of itself, as the body of its stub."""
    words = inspect.getdoc(thing)
    if not words:
        return f"{indent}...\n"
    words = words.replace("\\", "\\\\")
    return textwrap.indent(f'"""{words}\n"""' if "\n" in words else f'"""{words}"""', indent) + "\n"


def member(name: str, kind: str, thing: object) -> str:
    """A method or an attribute of a class."""
    if name in ("__new__", "__len__"):
        # The class has its words, and Python has the others.
        return f"    def {name}{kind}: ...\n"
    if kind == "READ":
        # Documentation stands on the first of the overloads.
        first, second = READ.format(name=name).split(": ...\n@overload")
        return f"{textwrap.indent(first, '    ')}:\n{docstring(thing, ' ' * 8)}" + textwrap.indent(
            f"@overload{second}\n", "    "
        )
    if kind.startswith("("):
        return f"    def {name}{kind}:\n{docstring(thing, ' ' * 8)}"
    return f"    @property\n    def {name}(self) -> {kind}:\n{docstring(thing, ' ' * 8)}"


def stub() -> str:
    """The whole file."""
    parts = [HEAD]
    for name, signature in FUNCTIONS.items():
        parts.append(f"def {name}{signature}:\n{docstring(getattr(_native, name), '    ')}")
    for name, members in CLASSES.items():
        kind: Any = getattr(_native, name)
        text = f"class {name}:\n{docstring(kind, '    ')}"
        parts.append(text + "".join(member(one, of, getattr(kind, one)) for one, of in members.items()))
    return "\n".join(parts)


def main() -> None:
    """Write the stub, or see whether it is as it would be written."""
    path = Path(__file__).parent / "python/taffeta/_native.pyi"
    if sys.argv[1:] == ["--check"]:
        sys.exit(None if path.read_text() == stub() else f"{path} is not up to date: run write_stub.py")
    path.write_text(stub())


if __name__ == "__main__":
    main()
