"""The native part of taffeta. Written by write_stub.py: change the types there, and the words in src/."""

import os
from collections.abc import Mapping, Sequence
from typing import Any, TypeVar, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from taffeta._scene import Scene, Source

_T = TypeVar("_T", np.float32, np.float64)

__version__: str

def check(parts: Scene, /, *, arrays: bool = False) -> None:
    """Whether a scene can be read; files that it names are not looked for, and its arrays only if that is asked for."""

def check_mesh(mesh: Any, path: str) -> None:
    """Whether a mesh is one, if it is given as arrays; `path` is its place in the scene."""

def format_toml(data: Mapping[str, Any]) -> str:
    """A dict as TOML. Meshes of arrays have no text."""

def format_value(value: Any) -> str:
    """A value as TOML, on one line if it has no text of several."""

def info() -> dict[str, Any]:
    """What this build and this machine are."""

def materials() -> dict[str, dict[str, Any]]:
    """Fabrics by name, those that `material` may be: for each a dict of its numbers, `title` and `source`.

    The keys are those of `[body.material]`: `density` [kg/m²], `stretch` and `shear` [N/m], `bending` [N·m], and others.

    >>> import taffeta
    >>> fabrics = taffeta.materials()
    >>> fabrics["denim"]["density"] > fabrics["silk"]["density"]
    True
    """

def parse_toml(text: str) -> dict[str, Any]:
    """What a TOML text says, as a dict."""

def read_text(path: str | os.PathLike[str]) -> str:
    """The text of a scene file."""

class Body:
    """A body of a running scene, as it was when the scene was built."""
    @property
    def name(self) -> str:
        ...
    @property
    def first(self) -> int:
        """Where its first vertex is among those of all bodies."""
    @property
    def vertices(self) -> int:
        ...
    @property
    def nodes(self) -> int:
        ...
    @property
    def triangles(self) -> int:
        ...
    @property
    def springs(self) -> int:
        ...
    @property
    def pins(self) -> int:
        ...
    @property
    def pinned(self) -> int:
        ...
    @property
    def mass(self) -> float:
        ...
    @property
    def rest_volume(self) -> float | None:
        ...
    @property
    def repairs(self) -> list[str]:
        ...
    @property
    def rows(self) -> slice[int, int, int]:
        """Its rows among those of all bodies."""

class Collider:
    """A collider of a running scene."""
    @property
    def name(self) -> str:
        ...
    @property
    def shape(self) -> str:
        ...
    @property
    def keyframes(self) -> int:
        ...
    @property
    def repairs(self) -> list[str]:
        ...

class Simulation:
    """A scene that runs.

    Args:
        scene: A `Scene`, or what one is made of: the path of a TOML file, TOML text, a dict.
        backend: "cpu", "gpu", or "auto": a GPU where the scene gains by it; `backend_reason` says why.
        threads: Threads of the CPU; as many as help where it is not given. No bit depends on it.
        precision: Arithmetic: "f32", or "f64" for a reference. Arrays are float32 or float64 accordingly.
        on_divergence: What becomes of a body that diverges: "stop" raises `DivergedError`, "freeze" has it stand still while the
            others go on.

    Raises:
        SceneError: The scene cannot be simulated. The message names the place, and what would do.
        DeviceError: There is no such device, or it cannot run the scene.

    >>> import taffeta
    >>> scene = taffeta.Scene().grid("cloth", rows=8, cols=8, size=(1.0, 1.0), material="cotton").solver("ice", form="primal").pin("cloth", rows=0)
    >>> simulation = taffeta.Simulation(scene, threads=1)
    >>> simulation
    <taffeta.Simulation of cloth: frame 0, cpu, 1 thread, ...>

    Threads of Python may share a simulation: each call has it to itself. While frames run, other threads of Python do, too. It can
    be pickled, with its state.
    """
    def __new__(cls, scene: Source, *, backend: str = 'auto', threads: int | None = None, precision: str = 'f32', on_divergence: str = 'stop') -> Simulation: ...
    def step(self, frames: int = 1) -> dict[str, Any]:
        """Runs frames, and reports the last.

        Ctrl-C stops it, and leaves the state of the last whole frame. On the CPU also a long frame is given up on its way, and with it
        what was asked for that frame, such as forces.

        Args:
            frames: How many.

        Returns:
            A dict: `frame`, `time` [s], energies [J] by kind and their sum `energy`, `momentum` [kg·m/s], `angular_momentum`
            [kg·m²/s], `max_stretch`, `contacts`, `iterations` of the solver, `volumes` [m³] and `reactions` of pins [N] by body, and
            what else `docs/outputs.md` has of frames.

        Raises:
            DivergedError: A body diverged. The state is that of the last good frame.
            DeviceError: A GPU does not answer any more.

        >>> import taffeta
        >>> scene = taffeta.Scene().grid("cloth", rows=8, cols=8, size=(1.0, 1.0), material="cotton").solver("ice", form="primal")
        >>> simulation = taffeta.Simulation(scene)
        >>> report = simulation.step(30)
        >>> report["frame"], round(report["time"], 3)
        (30, 0.5)
        """
    def advance(self, seconds: float) -> dict[str, Any]:
        """Runs as many whole frames as last `seconds` [s], or the first number that lasts longer; as `step` otherwise."""
    def snapshot(self) -> bytes:
        """The state as bytes, in the format of the program's checkpoints.

        Pinned vertices, poses of colliders and pins, and the world are part of it. What was asked for the frame to come is not.

        >>> import taffeta
        >>> scene = taffeta.Scene().grid("cloth", rows=8, cols=8, size=(1.0, 1.0), material="cotton").solver("ice", form="primal")
        >>> simulation = taffeta.Simulation(scene)
        >>> start = simulation.snapshot()
        >>> before = simulation.step(5)
        >>> simulation.restore(start)
        >>> simulation.step(5) == before
        True
        """
    def restore(self, snapshot: bytes) -> None:
        """Takes up the state of a snapshot of the same scene. From there it goes on bit by bit as the other one did.

        The bytes of a checkpoint of the program do as well.

        Raises:
            SnapshotError: The snapshot is damaged, or of another version or scene; the message says what differs.
        """
    def adopt_state(self, other: Simulation) -> None:
        """Goes on where a simulation of another scene is: takes its time, and positions and velocities of bodies with the same name and
        as many nodes.

        So materials and all else change while cloth runs: change the scene, build it, and adopt the state. Pins and poses by the
        program do not come along.

        >>> import taffeta
        >>> scene = taffeta.Scene().grid("cloth", rows=8, cols=8, size=(1.0, 1.0), material="cotton").solver("ice", form="primal").pin("cloth", rows=0)
        >>> cotton = taffeta.Simulation(scene)
        >>> report = cotton.step(10)
        >>> denim = taffeta.Simulation(cotton.scene.set("body.cloth.material.preset", "denim"))
        >>> denim.adopt_state(cotton)
        >>> denim.frame, bool((denim.positions() == cotton.positions()).all())
        (10, True)
        """
    def state_hash(self) -> str:
        """64-bit hash of positions and velocities as 16 hexadecimal digits, as the program prints it. Equal states have equal hashes, on
        any number of threads.
        """
    @overload
    def positions(self, body: str | None = None, *, out: None = None) -> NDArray[np.floating[Any]]:
        """Positions of all vertices [m], [vertices, 3], bodies one after the other in the scene's order, vertices in the order of the mesh.

        Args:
            body: Name of the body whose vertices are meant; all where it is not given.
            out: An array to write to, of that shape and of the precision of the run. It is returned, and nothing is allocated.

        >>> import numpy, taffeta
        >>> simulation = taffeta.Simulation(taffeta.Scene().grid("cloth", rows=2, cols=3, size=(2.0, 1.0), material="silk"))
        >>> positions = simulation.positions("cloth")
        >>> positions[0].tolist(), positions.dtype
        ([-1.0, 0.0, -0.5], dtype('float32'))
        >>> positions is simulation.positions(out=positions)
        True
        >>> numpy.from_dlpack(positions).shape
        (6, 3)
        """
    @overload
    def positions(self, body: str | None = None, *, out: NDArray[_T]) -> NDArray[_T]: ...
    @overload
    def velocities(self, body: str | None = None, *, out: None = None) -> NDArray[np.floating[Any]]:
        """Velocities of all vertices [m/s], as `positions`. A vertex that is in no face has none."""
    @overload
    def velocities(self, body: str | None = None, *, out: NDArray[_T]) -> NDArray[_T]: ...
    @overload
    def normals(self, body: str | None = None, *, out: None = None) -> NDArray[np.floating[Any]]:
        """Unit normals of all vertices, area-weighted, as `positions`."""
    @overload
    def normals(self, body: str | None = None, *, out: NDArray[_T]) -> NDArray[_T]: ...
    def faces(self, body: str | None = None) -> NDArray[np.uint32]:
        """Triangles by their vertices, uint32 [triangles, 3]: those of a body, counted from its first vertex, or those of all.

        Faces with more corners are cut as they are simulated.
        """
    def collider_distances(self, reach: float) -> NDArray[np.float32]:
        """Distances of all vertices from colliders [m], less the colliders' offsets, float32 [vertices]: 0 in contact, below 0 inside, and
        `reach` [m] where nothing is nearer.
        """
    def intersections(self) -> dict[str, Any]:
        """Counts where bodies pass through themselves, each other and colliders made of triangles, by exact arithmetic.

        Returns:
            A dict: `pairs` of an edge and a triangle, the `first` of them in words or None, and whether the count is `complete`.
        """
    def reaction(self, body: str, pin: int = 0) -> NDArray[np.float64] | None:
        """Force with which a pin of the scene holds its nodes in the last sub-step [N], float64 [3].

        None at the start, and for pins that break.

        Args:
            body: Name of the body.
            pin: Number of the pin among those of its body in the scene, from 0.
        """
    def collider_pose(self, collider: str, fraction: float = 1.0) -> NDArray[np.float64]:
        """Where a collider has been brought from its start: a matrix [4, 4] that moves points [m], as `move_collider` takes it.

        Args:
            collider: Name of the collider.
            fraction: The part of the last frame that has gone by, 0 to 1.
        """
    def collider_velocity(self, collider: str) -> NDArray[np.float64]:
        """How a collider moved in the last frame, float64 [2, 3]: the velocity of what starts at the origin [m/s], and the angular velocity
        [rad/s].
        """
    def pin(self, body: str, vertices: ArrayLike, to: ArrayLike | None = None) -> None:
        """Pins vertices, and moves them to places during the next frame, in straight lines; there they stay until `unpin`.

        Args:
            body: Name of the body.
            vertices: One vertex, or a list or array of them, in the order of the mesh.
            to: Places [m], [3] or one for each vertex, [n, 3]; where they are, if it is not given.

        >>> import taffeta
        >>> scene = taffeta.Scene().grid("cloth", rows=8, cols=8, size=(1.0, 1.0), material="cotton").solver("ice", form="primal")
        >>> simulation = taffeta.Simulation(scene)
        >>> simulation.pin("cloth", [0, 7])
        >>> simulation.pin("cloth", 7, (0.5, 0.01, -0.5))
        >>> report = simulation.step()
        >>> simulation.positions()[7].round(6).tolist()
        [0.5, 0.009999999776482582, -0.5]
        """
    def unpin(self, body: str, vertices: ArrayLike) -> None:
        """Frees vertices that `pin` has pinned, with the velocity that they were moved with. What a pin of the scene holds stays pinned."""
    def apply_force(self, body: str, vertices: ArrayLike, force: ArrayLike) -> None:
        """Applies forces to vertices during the next frame. Those on one vertex add up.

        Args:
            body: Name of the body.
            vertices: One vertex, or a list or array of them, in the order of the mesh.
            force: Force on each vertex [N], [3] or [n, 3].
        """
    def move_pin(self, body: str, pin: int, pose: ArrayLike) -> None:
        """Brings the nodes of a pin of the scene to a pose during the next frame, evenly; there they stay.

        Args:
            body: Name of the body.
            pin: Number of the pin among those of its body in the scene, from 0. It must be movable and follow no keyframes.
            pose: Motion from the start: a shift [3] [m], or a rigid matrix [4, 4], as `taffeta.pose` makes it.

        >>> import taffeta
        >>> scene = taffeta.Scene().grid("cloth", rows=8, cols=8, size=(1.0, 1.0), material="cotton").solver("ice", form="primal")
        >>> simulation = taffeta.Simulation(scene.pin("cloth", rows=0, movable=True))
        >>> simulation.move_pin("cloth", 0, taffeta.pose((0.0, 0.02, 0.0), axis=(0, 1, 0), degrees=2.0))
        >>> report = simulation.step()
        """
    def move_collider(self, collider: str, pose: ArrayLike) -> None:
        """Brings a collider to a pose during the next frame, evenly, so that it has the velocity of that motion; there it stays.

        Args:
            collider: Name of the collider. It must follow no keyframes any more.
            pose: Motion from the start: a shift [3] [m], or a rigid matrix [4, 4], as `taffeta.pose` makes it.

        >>> import taffeta
        >>> scene = taffeta.Scene().grid("cloth", rows=8, cols=8, size=(1.0, 1.0), material="cotton").solver("ice", form="primal")
        >>> simulation = taffeta.Simulation(scene.sphere("ball", radius=0.2, center=(0.0, -0.5, 0.0)))
        >>> simulation.move_collider("ball", (0.0, simulation.dt * 0.6, 0.0))
        >>> report = simulation.step()
        >>> simulation.collider_velocity("ball")[0].round(9).tolist()
        [0.0, 0.6, 0.0]
        """
    def set_world(self, **changes: Any) -> None:
        """Changes gravity, drag, wind and air from the next frame on.

        Args:
            **changes: Keys of `[world]`: `gravity` [m/s²], `drag` [kg/s], `wind_force` [N], `air`, a dict. What is not given stays. Air
                cannot be added to a scene that was built without.

        >>> import taffeta
        >>> scene = taffeta.Scene().grid("cloth", rows=8, cols=8, size=(1.0, 1.0), material="cotton").solver("ice", form="primal")
        >>> simulation = taffeta.Simulation(scene)
        >>> simulation.set_world(gravity=(0.0, -1.62, 0.0))
        >>> simulation.world["gravity"]
        [0.0, -1.62, 0.0]
        """
    def disturb(self, amplitude: float, seed: int = 1) -> None:
        """Moves every free node by up to `amplitude` [m] along each axis, at random but the same for the same seed."""
    def limit_threads(self, most: int) -> None:
        """Has at most so many threads work from now on, and never more than at the start. No bit depends on it."""
    @property
    def report(self) -> dict[str, Any]:
        """Report of the last frame, or of the start, as `step` returns it."""
    @property
    def world(self) -> dict[str, Any]:
        """Gravity, drag, wind and air as they are now, as a dict with the keys of `[world]`."""
    @property
    def bodies(self) -> dict[str, Body]:
        """The bodies by name, in the scene's order: counts, mass, and `rows`, the slice of a body's vertices among all.

        >>> import taffeta
        >>> simulation = taffeta.Simulation(taffeta.Scene().grid("cloth", rows=2, cols=3, size=(2.0, 1.0), mass=0.5))
        >>> simulation.bodies["cloth"]
        <taffeta.Body cloth: 6 vertices, 0 pins, 0.500000 kg>
        >>> simulation.positions()[simulation.bodies["cloth"].rows].shape
        (6, 3)
        """
    @property
    def colliders(self) -> dict[str, Collider]:
        """The colliders by name, in the scene's order."""
    @property
    def frame(self) -> int:
        """Number of frames done."""
    @property
    def time(self) -> float:
        """Time since the start [s]."""
    @property
    def dt(self) -> float:
        """Length of a frame [s]."""
    @property
    def scene(self) -> Scene:
        """A copy of the scene that it was built from."""
    @property
    def precision(self) -> str:
        """"f32" or "f64"."""
    @property
    def backend(self) -> str:
        """"cpu" or "gpu"."""
    @property
    def backend_reason(self) -> str:
        """Why it runs there."""
    @property
    def device(self) -> str:
        """The device in words: "cpu, 2 threads, avx512"."""
    @property
    def threads(self) -> int:
        """Threads of the CPU."""
    @property
    def memory(self) -> int:
        """Memory that state, springs and lists of contacts take [byte]."""
    @property
    def warnings(self) -> list[str]:
        """What should be known before it runs, such as a step that is too long. Each was a `SceneWarning` when this was built."""
    @property
    def frozen(self) -> list[str]:
        """Names of bodies that diverged and stand still."""

class Worlds:
    """Many independent copies of a scene, stepped at once.

    Each world is a `Simulation` of its own on one thread, `worlds[i]`, with its own pins, forces, colliders and parameters. It has the
    same bits as alone, whatever the others are and on any number of threads.

    Args:
        scene: A `Scene`, or what one is made of.
        n: Number of worlds.
        vary: What differs: paths as `Scene.set` takes them, each with n values.
        threads: How many worlds are stepped at a time; as many as the machine runs, if it is not given.
        precision: "f32" or "f64".

    >>> import numpy, taffeta
    >>> scene = taffeta.Scene().solver("ice", form="primal").sphere("ball", radius=0.2, center=(0.0, -0.3, 0.0))
    >>> scene = scene.grid("cloth", rows=8, cols=8, size=(1.0, 1.0), material="cotton")
    >>> worlds = taffeta.Worlds(scene, 3, vary={"body.cloth.material.preset": ["silk", "cotton", "denim"]})
    >>> worlds.step(5).tolist()           # none has diverged
    [False, False, False]
    >>> worlds.positions("cloth").shape
    (3, 64, 3)
    >>> worlds[2].move_collider("ball", (0.0, 0.01, 0.0))
    >>> worlds.reset([True, False, True])
    >>> worlds.frames.tolist()
    [0, 5, 0]
    """
    def __new__(cls, scene: Source, n: int, *, vary: Mapping[str, Sequence[Any] | NDArray[Any]] | None = None, threads: int | None = None, precision: str = 'f32') -> Worlds: ...
    def step(self, frames: int = 1, *, mask: ArrayLike | None = None) -> NDArray[np.bool_]:
        """Runs frames of the chosen worlds, all at once.

        A world that diverges keeps its last good frame and is not stepped any more until `reset`; the others go on. Ctrl-C stops all
        after the same whole frame.

        Args:
            frames: How many.
            mask: Which worlds, a boolean for each; all, if it is not given.

        Returns:
            Which of the chosen worlds have diverged, bool [n].
        """
    def reset(self, mask: ArrayLike | None = None) -> None:
        """Has the chosen worlds start again: with the pins, poses and world that their scene describes.

        Args:
            mask: Which worlds, a boolean for each; all, if it is not given.
        """
    @overload
    def positions(self, body: str | None = None, *, out: None = None) -> NDArray[np.floating[Any]]:
        """Positions of all vertices [m], [n, vertices, 3], as `Simulation.positions` has them.

        Args:
            body: Name of the body whose vertices are meant; all where it is not given.
            out: An array to write to, of that shape and of the precision of the run. Every world writes its own part.
        """
    @overload
    def positions(self, body: str | None = None, *, out: NDArray[_T]) -> NDArray[_T]: ...
    @overload
    def velocities(self, body: str | None = None, *, out: None = None) -> NDArray[np.floating[Any]]:
        """Velocities of all vertices [m/s], as `positions`."""
    @overload
    def velocities(self, body: str | None = None, *, out: NDArray[_T]) -> NDArray[_T]: ...
    @overload
    def normals(self, body: str | None = None, *, out: None = None) -> NDArray[np.floating[Any]]:
        """Unit normals of all vertices, as `positions`."""
    @overload
    def normals(self, body: str | None = None, *, out: NDArray[_T]) -> NDArray[_T]: ...
    def apply_force(self, body: str, vertices: ArrayLike, force: ArrayLike) -> None:
        """Applies forces to vertices of all worlds during the next frame.

        Args:
            body: Name of the body.
            vertices: One vertex, or a list or array of them; the same in all worlds.
            force: Force on each vertex [N]: [3], [n, 3], or [n, vertices, 3].
        """
    def pin(self, body: str, vertices: ArrayLike, to: ArrayLike | None = None) -> None:
        """Pins vertices of all worlds, and moves them to places during the next frame.

        Args:
            body: Name of the body.
            vertices: One vertex, or a list or array of them; the same in all worlds.
            to: Places [m]: [3], [n, 3], or [n, vertices, 3]; where they are, if it is not given.
        """
    def move_collider(self, collider: str, shifts: ArrayLike) -> None:
        """Brings a collider of all worlds to poses during the next frame.

        Args:
            collider: Name of the collider.
            shifts: Shifts from the start [m], [3] or [n, 3]. `worlds[i].move_collider` also turns one.
        """
    def reports(self) -> dict[str, NDArray[Any]]:
        """The last frames in numbers, a dict of arrays [n]: `frame`, `time` [s], `kinetic`, `gravitational`, `springs` and `energy` [J],
        `max_stretch` and `contacts`. `worlds[i].report` has all of one.
        """
    @property
    def frames(self) -> NDArray[np.int64]:
        """Number of frames done by each world, int64 [n]."""
    @property
    def threads(self) -> int:
        """How many worlds are stepped at a time."""
    @property
    def memory(self) -> int:
        """Memory of all worlds [byte]."""
    def __len__(self) -> int: ...
    def __getitem__(self, index: int) -> Simulation:
        """Return self[key]."""
