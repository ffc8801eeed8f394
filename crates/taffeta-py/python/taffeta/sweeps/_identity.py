"""What things are, as texts that can be compared: so that a sweep that goes on is the one that was begun."""

from __future__ import annotations

import functools
import hashlib
import inspect
import json
import types
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from taffeta._kinds import is_mapping, is_sequence, is_set
from taffeta._packages import package

if TYPE_CHECKING:
    from taffeta._scene import Scene


def of_scene(scene: Scene) -> str:
    """A hash of a scene, of its arrays, and of the files that it names as they are now."""
    document = scene.to_dict()
    files = {name: _of_bytes(path.read_bytes()) for name, path in sorted(_files(document, scene.folder).items())}
    return _of_text(json.dumps([document, scene.overrides, files], default=_of_mesh))


def of_function(function: Any) -> str | None:
    """A function by its name, and a hash of its code, of what it has captured and of the functions that it calls.

    Functions of other packages count by their names.
    """
    if function is None:
        return None
    name = getattr(function, "__qualname__", type(function).__name__)
    home = (getattr(inspect.unwrap(function), "__module__", None) or "").partition(".")[0]
    return f"{name} {_of_text(json.dumps(_Description(home).of(function)))[:16]}"


def _of_text(text: str) -> str:
    return _of_bytes(text.encode("utf-8", "surrogatepass"))


def _of_bytes(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


def _of_array(array: Any) -> list[Any]:
    array = np.ascontiguousarray(array)
    return [str(array.dtype), list(array.shape), _of_bytes(array.tobytes())]


def _of_mesh(value: Any) -> Any:
    """Arrays of a scene, and objects that are meshes."""
    if hasattr(value, "vertices") and hasattr(value, "faces"):
        return [_of_array(value.vertices), [_of_array(face) for face in value.faces]]
    return _of_array(value)


def _files(value: Any, folder: Path) -> dict[str, Path]:
    """Files that a document names, wherever in it."""
    if isinstance(value, str):
        path = folder / value
        return {value: path} if 0 < len(value) < 1024 and "\n" not in value and path.is_file() else {}
    found: dict[str, Path] = {}
    for one in value.values() if is_mapping(value) else value if is_sequence(value) else ():
        found.update(_files(one, folder))
    return found


class _Description:
    """Describes functions, and what they refer to, by lists of texts."""

    def __init__(self, home: str) -> None:
        #: The package of the function that is described: others count by their names.
        self._homes = {home, "__main__"}
        #: Numbers of what was described, and that itself, so that no other has its identity.
        self._seen: dict[int, tuple[int, Any]] = {}

    def of(self, value: Any) -> Any:
        """What JSON takes: the same for the same."""
        if value is None or isinstance(value, (bool, int, float, str, bytes, complex)) or value is Ellipsis:
            return repr(value)
        if id(value) in self._seen:
            return ["again", self._seen[id(value)][0]]
        self._seen[id(value)] = (len(self._seen), value)
        if isinstance(value, (np.ndarray, np.generic)):
            return _of_array(value)
        return self._of_function(value) if callable(value) or inspect.iscode(value) else self._of_data(value)

    def _of_data(self, value: Any) -> Any:
        if isinstance(value, types.ModuleType):
            return value.__name__
        if is_mapping(value):
            return [[self.of(name), self.of(inner)] for name, inner in value.items()]
        if is_sequence(value):
            return [self.of(inner) for inner in value]
        if is_set(value):
            return sorted(json.dumps(self.of(inner)) for inner in value)
        return _of_bytes(package("cloudpickle").dumps(value))

    def _of_function(self, value: Any) -> Any:
        if type(value) is functools.partial:
            return [self.of(value.func), self.of(value.args), self.of(value.keywords)]
        if inspect.iscode(value):
            return [value.co_code.hex(), [self.of(one) for one in value.co_consts], value.co_names, value.co_freevars]
        if inspect.ismethod(value):
            return [self.of(value.__func__), self.of(value.__self__)]
        module = (getattr(value, "__module__", None) or "").partition(".")[0]
        if inspect.isfunction(value):
            return self._of_python(value) if module in self._homes else [value.__module__, value.__qualname__]
        if inspect.isclass(value):
            own = {name: one for name, one in vars(value).items() if inspect.isfunction(one)}
            return [value.__module__, value.__qualname__, self.of(own) if module in self._homes else None]
        if inspect.isbuiltin(value) or not hasattr(value, "__dict__"):
            return [module, getattr(value, "__qualname__", type(value).__qualname__)]
        return [self.of(type(value)), self.of(vars(value))]

    def _of_python(self, function: types.FunctionType) -> Any:
        code, around = function.__code__, function.__globals__
        used = {name: around[name] for name in sorted(_names(code)) if name in around}
        captured = dict(zip(code.co_freevars, map(_content, function.__closure__ or ()), strict=True))
        given = [function.__defaults__, function.__kwdefaults__, captured, used]
        return [self.of(code), *(self.of(one) for one in given)]


def _names(code: types.CodeType) -> set[str]:
    """Names that code uses, and functions within it."""
    inner = (_names(one) for one in code.co_consts if inspect.iscode(one))
    return set(code.co_names).union(*inner)


def _content(cell: types.CellType) -> Any:
    try:
        return cell.cell_contents
    except ValueError:
        return None
