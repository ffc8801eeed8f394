"""What taffeta raises. All of it is an ``Error``."""

from __future__ import annotations

from typing import Any


class Error(Exception):
    """What every exception of taffeta is."""

    __module__ = "taffeta"

    def __init__(self, message: str, **facts: Any) -> None:
        super().__init__(message)
        self.__dict__.update(facts)


class SceneError(Error, ValueError):
    """A scene that cannot be read or simulated.

    The message names what was written, what it was and what would do. Where the scene is a text, it begins with file, line and
    column.
    """

    __module__ = "taffeta"

    #: The file, as it was named; ``None`` where the scene is no text.
    file: str | None = None
    #: Line, from 1.
    line: int | None = None
    #: Column in characters, from 1.
    column: int | None = None


class InputError(Error, ValueError):
    """What was asked of a simulation cannot be: a name, a number or an array. Nothing is changed."""

    __module__ = "taffeta"


class SnapshotError(InputError):
    """A snapshot that is damaged, of another version or of another scene."""

    __module__ = "taffeta"


class DivergedError(Error, ArithmeticError):
    """A body diverged. The simulation has the state of the last good frame; ``restore`` takes it back to a snapshot."""

    __module__ = "taffeta"

    #: The frame after which that was seen.
    frame: int = 0
    #: The first frame that may have failed.
    first: int = 0
    #: Name of the body.
    body: str = ""
    #: The vertex, in the mesh's own order.
    vertex: int = 0
    #: What was seen.
    what: str = ""
    #: The likely cause, and what to change.
    cause: str = ""


class DeviceError(Error, RuntimeError):
    """There is no such device, it cannot run the scene, or it does not answer any more."""

    __module__ = "taffeta"


class InternalError(Error, RuntimeError):
    """A mistake in taffeta. Please report it."""

    __module__ = "taffeta"


class SceneWarning(UserWarning):
    """What should be known of a scene before it runs, such as a step that is too long."""

    __module__ = "taffeta"
