"""Scenes: from a TOML file, its text or a dict, or built step by step."""

from __future__ import annotations

import copy
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from taffeta import _html, _native
from taffeta._errors import InputError, SceneError

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray
    from typing_extensions import Self, Unpack

    from taffeta._options import BodyOptions, ColliderOptions, Select, Vector

#: What a scene may be given as.
Source: TypeAlias = "Scene | str | os.PathLike[str] | Mapping[str, Any]"


class Scene:
    """Cloth, soft bodies and colliders, and how they are run.

    A scene is what ``docs/scenes.md`` describes, in one of four forms:

    - a TOML file: ``Scene("scenes/drape.toml")``. Files that it names are looked for beside it;
    - TOML text: a ``str`` with a line break;
    - a dict of the same keys: ``Scene({"body": [...]})``;
    - nothing: ``Scene()``, to which methods add bodies, colliders, pins and forces. Each returns the scene.

    Args:
        source: One of these, or another scene, which is copied.
        folder: Where the files lie that a text or a dict names.

    Raises:
        SceneError: Where a key, a word or a number cannot be. The message names what would do.

    >>> scene = Scene()
    >>> scene = scene.time(dt=1 / 60, max_step=1 / 240).solver("ice", form="primal")
    >>> scene = scene.grid("flag", rows=8, cols=12, size=(1.5, 1.0), material="silk").pin("flag", cols=0)
    >>> scene = scene.sphere("ball", radius=0.3, center=(0.0, -1.0, 0.0), friction=0.4)
    >>> scene
    <taffeta.Scene of flag and ball>
    """

    __module__ = "taffeta"

    def __init__(self, source: Source | None = None, *, folder: str | os.PathLike[str] | None = None) -> None:
        self._text: str | None = None
        self._data: dict[str, Any] = {}
        self._name = "scene.toml"
        self._folder = Path(os.path.abspath(folder if folder is not None else "."))
        self._overrides: list[str] = []
        if source is None:
            return
        if isinstance(source, Scene):
            self.__dict__.update(copy.deepcopy(source.__dict__))
            return
        if isinstance(source, Mapping):
            self._data = copy.deepcopy(dict(source))
        elif isinstance(source, str) and "\n" in source:
            self._text = source
        else:
            path = _path(source)
            self._text, self._name = _native.read_text(path), str(path)
            self._folder = Path(os.path.abspath(path.parent))
        _native.check(self, arrays=True)

    # What it is.

    def to_dict(self) -> dict[str, Any]:
        """What is written, as a dict of its own. Overrides are not in it."""
        return copy.deepcopy(self._document())

    def to_toml(self) -> str:
        """What is written, as TOML. Meshes of arrays have no text.

        >>> print(Scene().plane("floor", friction=0.5).to_toml())
        [[collider]]
        friction = 0.5
        name = "floor"
        <BLANKLINE>
        [collider.plane]
        <BLANKLINE>
        """
        return self._text if self._text is not None else _native.format_toml(self._data)

    @property
    def overrides(self) -> list[str]:
        """What ``set`` has changed, each ``PATH=VALUE`` as the program's ``--set`` takes it."""
        return list(self._overrides)

    @property
    def frames(self) -> int | None:
        """How many frames a run of it has, where that is written or set."""
        frames = self._document().get("time", {}).get("frames")
        for override in self._overrides:
            path, _, value = override.partition("=")
            frames = value if path.strip() == "time.frames" else frames
        return None if frames is None else int(frames)

    @property
    def folder(self) -> Path:
        """Where the files lie that it names."""
        return self._folder

    def copy(self) -> Scene:
        """Another scene with the same content."""
        return Scene(self)

    def set(self, path: str, value: Any) -> Self:
        """Changes one value by its path, as ``--set`` of the program does.

        >>> scene = Scene().grid("flag", rows=8, cols=12, size=(1.5, 1.0), material="silk")
        >>> scene.set("body.flag.material.preset", "denim").overrides
        ['body.flag.material.preset="denim"']
        """
        before = list(self._overrides)
        self._overrides.append(f"{path}={_native.format_value(value)}")
        try:
            _native.check(self)
        except BaseException:
            self._overrides = before
            raise
        return self

    # The whole.

    def title(self, title: str) -> Self:
        """A line for people."""
        return self._replace(self._document_to_edit(), "title", title)

    def time(
        self, *, dt: float | None = None, max_step: float | None = None, frames: int | None = None
    ) -> Self:
        """Frames and steps.

        Args:
            dt: Length of a frame [s].
            max_step: Longest sub-step [s].
            frames: Number of frames of a run by the program.
        """
        return self._table("time", dt=dt, max_step=max_step, frames=frames)

    def world(
        self,
        *,
        gravity: Vector | None = None,
        drag: float | None = None,
        wind_force: Vector | None = None,
        air: Mapping[str, Any] | None = None,
    ) -> Self:
        """What acts everywhere.

        Args:
            gravity: Acceleration [m/s²].
            drag: Drag of every node [kg/s].
            wind_force: Force on every node [N].
            air: Air around all triangles: ``{"velocity": (3, 0, 0)}`` [m/s].
        """
        return self._table("world", gravity=gravity, drag=drag, wind_force=wind_force, air=air)

    def solver(self, method: str, **options: Any) -> Self:
        """How springs are solved.

        Args:
            method: ``"springs"``, ``"ice"``, ``"xpbd"`` or ``"acad"``.
            **options: Keys of the method's own table: ``solver("ice", form="primal")`` takes any step, which fabrics need.
        """
        return self._table("solver", method=method, **({method: options} if options else {}))

    def sleep(self, *, speed: float | None = None, after: float | None = None) -> Self:
        """Lets bodies at rest fall asleep.

        Args:
            speed: Speed that no node of a body at rest exceeds [m/s].
            after: How long a body is at rest before it falls asleep [s].
        """
        return self._table("sleep", speed=speed, after=after)

    # Bodies.

    def body(self, name: str, mesh: Mapping[str, Any] | Any, **options: Unpack[BodyOptions]) -> Self:
        """Cloth or a soft body.

        Args:
            name: What it is called by pins, forces and ``Simulation``.
            mesh: A shape as in scenes (``{"icosphere": {"radius": 0.2, "subdivisions": 3}}``), ``{"file": "shirt.ply"}``, arrays
                (``{"vertices": ..., "faces": ...}``), or an object with ``vertices`` and ``faces``, such as a mesh of trimesh.
            **options: See ``BodyOptions``.

        >>> ball = {"icosphere": {"radius": 0.2, "subdivisions": 2}}
        >>> springs = {"structural": {"k": 500.0, "d": 0.5}}
        >>> scene = Scene().body("ball", ball, kind="soft", density=200.0, springs=springs, volume={})
        """
        entry: dict[str, Any] = {"name": name, "mesh": mesh, **_placed(dict(options))}
        if isinstance(entry.get("material"), str):
            entry["material"] = {"preset": entry["material"]}
        if isinstance(entry.get("self_collision"), bool):
            entry["self_collision"] = {} if entry["self_collision"] else None
        return self._append("body", entry)

    def grid(
        self, name: str, *, rows: int, cols: int, size: Sequence[float], **options: Unpack[BodyOptions]
    ) -> Self:
        """A rectangle of nodes in the xz plane: row 0 at -z, column 0 at -x, node = row * cols + column.

        Args:
            name: Name of the body.
            rows: Nodes along z.
            cols: Nodes along x.
            size: Extent along x and z [m].
            **options: See ``BodyOptions``.
        """
        return self.body(name, {"grid": {"rows": rows, "cols": cols, "size": size}}, **options)

    def sheet(
        self,
        name: str,
        *,
        size: Sequence[float],
        edge: float | None = None,
        pattern: str | None = None,
        **options: Unpack[BodyOptions],
    ) -> Self:
        """A rectangle of triangles in the xz plane, made for fabrics.

        Args:
            name: Name of the body.
            size: Extent along x and z [m].
            edge: Length of edges [m].
            pattern: ``"equilateral"`` or ``"grid"``.
            **options: See ``BodyOptions``.
        """
        return self.body(name, {"sheet": {"size": size, "edge": edge, "pattern": pattern}}, **options)

    def disc(
        self, name: str, *, radius: float, edge: float | None = None, **options: Unpack[BodyOptions]
    ) -> Self:
        """A disc of triangles in the xz plane.

        Args:
            name: Name of the body.
            radius: Radius [m].
            edge: Length of edges [m].
            **options: See ``BodyOptions``.
        """
        return self.body(name, {"disc": {"radius": radius, "edge": edge}}, **options)

    def chain(self, name: str, *, links: int, length: float, **options: Unpack[BodyOptions]) -> Self:
        """Nodes in a row along x.

        Args:
            name: Name of the body.
            links: Number of links; there is one node more.
            length: Length of the whole chain [m].
            **options: See ``BodyOptions``.
        """
        return self.body(name, {"chain": {"links": links, "length": length}}, **options)

    def mesh(
        self,
        name: str,
        vertices: ArrayLike,
        faces: ArrayLike,
        *,
        uvs: ArrayLike | None = None,
        groups: Mapping[str, ArrayLike] | None = None,
        **options: Unpack[BodyOptions],
    ) -> Self:
        """A mesh of arrays. All arrays of the simulation have its vertices in their order, also those that are in no face.

        Args:
            name: Name of the body.
            vertices: Places [n, 3] [m].
            faces: Vertices of triangles or quads [m, 3] or [m, 4], or lists of different lengths.
            uvs: Texture coordinates [n, 2], which say where warp and weft of a fabric are.
            groups: Lists of vertices by name, for ``pin(..., group=...)``.
            **options: See ``BodyOptions``.

        >>> vertices = [[0, 0, 0], [1, 0, 0], [1, 0, 1], [0, 0, 1]]
        >>> scene = Scene().mesh("patch", vertices, [[0, 3, 2], [0, 2, 1]], material="cotton", groups={"hem": [0, 1]})
        >>> scene = scene.pin("patch", group="hem")
        """
        return self.body(name, _arrays(vertices, faces, uvs, groups), **options)

    def pin(
        self,
        body: str,
        *,
        motion: Sequence[Mapping[str, Any]] | None = None,
        movable: bool = False,
        poses: Mapping[str, Any] | None = None,
        collider: str | None = None,
        break_force: float | None = None,
        **select: Unpack[Select],
    ) -> Self:
        """Holds nodes of a body. Vertices are also pinned and freed while it runs, by ``Simulation.pin``.

        Args:
            body: Name of the body.
            motion: Keyframes: ``[{"t": 1.0, "translate": (0, 0.1, 0)}]``, t in s and translate in m.
            movable: Whether ``Simulation.move_pin`` may move it.
            poses: Poses of the body's mesh that they follow: ``{"file": "walk.pc2", "interval": 1 / 24}``.
            collider: Name of the collider that carries the nodes.
            break_force: Force at which it releases a node [N].
            **select: Which nodes, see ``Select``.
        """
        if movable and not motion:
            motion = [{"t": 0.0}]
        pin = {"motion": motion, "poses": poses, "collider": collider, "break_force": break_force, "select": _select(select)}
        self._document_to_edit()
        entry = self._body(body)
        return self._replace(entry, "pin", [*entry.get("pin", []), pin])

    def force(
        self,
        body: str,
        *,
        force: Vector | None = None,
        torque: Mapping[str, Any] | None = None,
        motion: Sequence[Mapping[str, Any]] | None = None,
        **select: Unpack[Select],
    ) -> Self:
        """A force or a torque on nodes. ``Simulation.apply_force`` applies one for a frame.

        Args:
            body: Name of the body.
            force: Force on each node [N].
            torque: Torque on all together: ``{"axis": (0, 1, 0), "value": 1.0}`` [N·m].
            motion: Factors over time: ``[{"t": 0.0, "scale": 1.0}]``, t in s.
            **select: Which nodes, see ``Select``.
        """
        entry = {"body": body, "select": _select(select), "force": force, "torque": torque, "motion": motion}
        return self._append("force", entry)

    def seam(
        self, one: str | Mapping[str, Any], other: str | Mapping[str, Any], **options: Any
    ) -> Self:
        """Sews nodes of two bodies, or of one.

        Args:
            one: Name of a body, or ``{"body": "front", "select": {"cols": [0, 0]}}``.
            other: The other side.
            **options: Keys of ``[[seam]]``: ``pairs``, ``reach`` [m], ``length`` [m], ``close`` [s], ``k`` [N/m], ``break_force`` [N].
        """
        sides = [{"body": side} if isinstance(side, str) else side for side in (one, other)]
        return self._append("seam", {"from": sides[0], "to": sides[1], **options})

    def friction(self, one: str, other: str, value: float) -> Self:
        """The Coulomb coefficient of two bodies, or of a body and a collider, by their names."""
        return self._append("friction", {"between": [one, other], "value": value})

    # Colliders.

    def collider(self, name: str, shape: Mapping[str, Any], **options: Unpack[ColliderOptions]) -> Self:
        """What bodies cannot enter.

        Args:
            name: What it is called by pins and ``Simulation``.
            shape: A shape as in scenes: ``{"box": {"half": (0.1, 0.1, 0.1)}}`` [m], ``{"mesh": {"file": "human.ply"}}``.
            **options: See ``ColliderOptions``.
        """
        return self._append("collider", {"name": name, **shape, **_placed(dict(options))})

    def sphere(
        self, name: str, *, radius: float, center: Vector | None = None, **options: Unpack[ColliderOptions]
    ) -> Self:
        """A ball as a collider: radius [m] about a centre [m]. A soft ball is a body."""
        return self.collider(name, {"sphere": {"radius": radius, "center": center}}, **options)

    def plane(
        self,
        name: str,
        *,
        point: Vector | None = None,
        normal: Vector | None = None,
        **options: Unpack[ColliderOptions],
    ) -> Self:
        """A half-space as a collider, solid on the side away from its normal; a floor at y = 0 without arguments. Its point is in [m]."""
        return self.collider(name, {"plane": {"point": point, "normal": normal}}, **options)

    def box(
        self, name: str, *, half: Vector, center: Vector | None = None, **options: Unpack[ColliderOptions]
    ) -> Self:
        """A box as a collider: half of its extent along each axis [m], about a centre [m]."""
        return self.collider(name, {"box": {"half": half, "center": center}}, **options)

    def capsule(
        self, name: str, *, a: Vector, b: Vector, radius: float, **options: Unpack[ColliderOptions]
    ) -> Self:
        """A bar with round ends about two points [m] as a collider, with a radius [m]."""
        return self.collider(name, {"capsule": {"a": a, "b": b, "radius": radius}}, **options)

    def cylinder(
        self, name: str, *, a: Vector, b: Vector, radius: float, **options: Unpack[ColliderOptions]
    ) -> Self:
        """A bar with flat ends between two points [m] as a collider, with a radius [m]."""
        return self.collider(name, {"cylinder": {"a": a, "b": b, "radius": radius}}, **options)

    def mesh_collider(
        self, name: str, vertices: ArrayLike, faces: ArrayLike, **options: Unpack[ColliderOptions]
    ) -> Self:
        """A mesh of arrays as a collider: vertices [n, 3] [m] and faces. A closed one is solid, an open one a sheet with two sides."""
        return self.collider(name, {"mesh": _arrays(vertices, faces, None, None)}, **options)

    def heightfield(
        self, name: str, *, size: Sequence[float], heights: ArrayLike, **options: Unpack[ColliderOptions]
    ) -> Self:
        """Ground as a collider: extent along x and z [m], and heights [rows, columns] [m], row 0 at -z."""
        shape = {"heightfield": {"size": size, "heights": heights}}
        return self.collider(name, shape, **options)

    # How it is kept.

    def _document(self) -> dict[str, Any]:
        return self._data if self._text is None else _native.parse_toml(self._text)

    def _document_to_edit(self) -> dict[str, Any]:
        """From now on it is a dict."""
        self._data, self._text = self._document(), None
        return self._data

    def _replace(self, table: dict[str, Any], key: str, value: Any) -> Self:
        """Puts a value into a table of the document, unless that cannot be."""
        missing = object()
        before = table.get(key, missing)
        table[key] = value
        try:
            _native.check(self)
        except BaseException:
            if before is missing:
                del table[key]
            else:
                table[key] = before
            raise
        return self

    def _table(self, key: str, **values: Any) -> Self:
        """Puts values into a table."""
        given = copy.deepcopy({name: value for name, value in values.items() if value is not None})
        document = self._document_to_edit()
        return self._replace(document, key, {**document.get(key, {}), **given})

    def _append(self, key: str, entry: Mapping[str, Any]) -> Self:
        """Adds an entry to a list of tables."""
        given = copy.deepcopy({name: value for name, value in entry.items() if value is not None})
        document = self._document_to_edit()
        there: list[Any] = document.get(key, [])
        for name in ("mesh", "convex"):
            if name in given:
                _native.check_mesh(given[name], f"{key}[{len(there)}].{name}")
        return self._replace(document, key, [*there, given])

    def _body(self, name: str) -> dict[str, Any]:
        bodies: list[dict[str, Any]] = self._data.get("body", [])
        names = [body.get("name") or f"body{index}" for index, body in enumerate(bodies)]
        if name not in names:
            raise SceneError(f"there is no body `{name}`; there are: {', '.join(names) or 'none'}")
        return bodies[names.index(name)]

    def __repr__(self) -> str:
        document = self._document()
        things = [*document.get("body", []), *document.get("collider", [])]
        names = [thing.get("name", "one without a name") for thing in things]
        return f"<taffeta.Scene of {' and '.join(names) or 'nothing'}>"

    def _repr_html_(self) -> str:
        document = self._document()
        return _html.of_scene(document.get("title", "") or "Scene", document)


def _path(source: str | os.PathLike[str]) -> Path:
    """The path of a scene's file."""
    try:
        return Path(source)
    except TypeError:
        kind = type(source).__name__
        what = f"a scene is a path, TOML text, a dict or a Scene; this is of type {kind}"
        raise SceneError(what) from None


def _placed(options: dict[str, Any]) -> dict[str, Any]:
    """Options with those of the place in a table of their own."""
    place = {key: options.pop(key) for key in ("position", "rotation", "scale", "fit") if key in options}
    rotation = place.get("rotation")
    if rotation is not None and not isinstance(rotation, Mapping):
        try:
            axis, degrees = rotation
        except (TypeError, ValueError):
            what = f"a rotation is an axis and an angle in degrees, ((0, 1, 0), 90.0), and not {rotation!r}"
            raise SceneError(what) from None
        place["rotation"] = {"axis": axis, "degrees": degrees}
    return {**options, "place": place} if place else options


def _select(select: Mapping[str, Any]) -> dict[str, Any]:
    """A selection as scenes have it."""
    chosen = dict(select)
    for key in ("rows", "cols"):
        if isinstance(chosen.get(key), int):
            chosen[key] = [chosen[key], chosen[key]]
    if isinstance(chosen.get("nodes"), (int, np.integer)):
        chosen["nodes"] = [chosen["nodes"]]
    box = chosen.get("box")
    if box is not None and not isinstance(box, Mapping):
        try:
            least, largest = box
        except (TypeError, ValueError):
            raise SceneError(f"a box is its least and its largest corner, and not {box!r}") from None
        chosen["box"] = {"min": least, "max": largest}
    return chosen


def _arrays(
    vertices: ArrayLike, faces: ArrayLike, uvs: ArrayLike | None, groups: Mapping[str, ArrayLike] | None
) -> dict[str, Any]:
    """A mesh of arrays."""
    mesh = {"vertices": vertices, "faces": faces, "uvs": uvs, "groups": groups}
    return {key: value for key, value in mesh.items() if value is not None}


def copy_of(source: Source) -> Scene:
    """A scene of its own, for ``Simulation``."""
    return Scene(source)


def varied(source: Source, n: int, vary: Mapping[str, Sequence[Any] | NDArray[Any]] | None) -> list[Scene]:
    """A scene for each of n worlds, for ``Worlds``."""
    first = Scene(source)
    # What is changed by paths stands beside the document, which they can share.
    scenes = [copy.copy(first) for _ in range(n)]
    for scene in scenes:
        vars(scene)["_overrides"] = first.overrides
    for path, values in (vary or {}).items():
        if len(values) != n:
            raise InputError(f"vary: `{path}` has {len(values)} values; {n} would do")
        for scene, value in zip(scenes, values, strict=True):
            scene.set(path, value)
    return scenes


def restored(scene: Scene, options: dict[str, Any], snapshot: bytes) -> _native.Simulation:
    """What a simulation was when it was pickled."""
    simulation = _native.Simulation(scene, **options)
    simulation.restore(snapshot)
    return simulation
