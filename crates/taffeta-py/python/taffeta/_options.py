"""What bodies, colliders and selections may be given: keys of scenes, with their units."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, TypeAlias, TypedDict

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

#: Three numbers.
Vector: TypeAlias = "Sequence[float] | NDArray[Any]"


class Placed(TypedDict, total=False):
    """Where something starts: it is scaled, then turned, then shifted."""

    position: Vector
    """Shift [m]."""
    rotation: tuple[Vector, float] | Mapping[str, Any]
    """Axis and angle [°], right-handed: ``((0, 1, 0), 90.0)``."""
    scale: float
    """Factor on all lengths."""
    fit: float
    """Instead of ``scale``: the largest extent after scaling [m]."""


class BodyOptions(Placed, total=False):
    """What a body may be given beside its mesh. docs/scenes.md has every key; what is left out has its default there."""

    kind: str
    """``"cloth"``, or ``"soft"`` for a closed mesh with an inside."""
    mass: float
    """Mass of the whole body [kg]. Exactly one of the four masses is given, or a material."""
    node_mass: float
    """Mass of each node [kg]."""
    area_density: float
    """Mass per area [kg/m²]."""
    density: float
    """Mass per volume of a soft body [kg/m³]."""
    material: str | Mapping[str, Any]
    """Its fabric: the name of a preset, such as ``"cotton"``, or a dict with numbers in N/m, N·m and kg/m²."""
    springs: Mapping[str, Any]
    """Its springs by kind: ``{"structural": {"k": 200.0, "d": 0.1}}``, k in N/m and d in kg/s."""
    self_collision: bool | Mapping[str, Any]
    """Contact with itself and other bodies that have it: ``True``, or a dict such as ``{"thickness": 0.005}`` [m]."""
    layers: Mapping[str, Sequence[int]]
    """Which colliders and other bodies it meets: ``{"memberships": [1], "filter": [0, 1]}``, numbers from 0 to 31."""
    volume: Mapping[str, Any]
    """What keeps the volume of a soft body: ``{"form": "corrected"}``."""
    tethers: Mapping[str, Any]
    """Keeps free nodes near pinned ones."""
    velocity: Vector
    """Velocity at the start [m/s]."""
    angular_velocity: Vector
    """Angular velocity at the start [rad/s]."""
    fill_holes: bool
    """Close the holes of a mesh from a file."""
    rest_shape: str
    """A second mesh file: the shape at rest."""
    stand_in: Mapping[str, Any]
    """A shape to use where the mesh file is not there."""


class ColliderOptions(Placed, total=False):
    """What a collider may be given beside its shape."""

    offset: float
    """Distance kept between surface and nodes [m]."""
    friction: float
    """Coulomb coefficient."""
    restitution: float
    """Coefficient of restitution, 0 to 1."""
    layers: Mapping[str, Sequence[int]]
    """Which bodies it meets: ``{"memberships": [1], "filter": [0, 1]}``, numbers from 0 to 31."""
    motion: Sequence[Mapping[str, Any]]
    """Keyframes of a rigid motion: ``[{"t": 1.0, "translate": (0, 0.1, 0)}]``, t in s and translate in m."""


class Select(TypedDict, total=False):
    """Which nodes of a body. Where several keys are given, a node must meet them all."""

    nodes: ArrayLike
    """Indices in the mesh's own order."""
    rows: int | tuple[int, int]
    """A row of a grid, or the first and the last of some."""
    cols: int | tuple[int, int]
    """The same of columns."""
    box: tuple[Vector, Vector] | Mapping[str, Any]
    """Corners of a box [m], least and largest: nodes that start in it."""
    boundary: bool
    """Nodes on an open edge."""
    group: str
    """A group of the mesh."""
