"""taffeta: real-time cloth and soft bodies with numpy arrays.

>>> import taffeta
>>> scene = taffeta.Scene().grid("cloth", rows=8, cols=8, size=(1.0, 1.0), material="cotton").solver("ice", form="primal")
>>> simulation = taffeta.Simulation(scene)
>>> simulation.step(10)["frame"]
10
>>> simulation.positions().shape
(64, 3)

Units are SI, y is up, and arrays have the vertices in the order of the user's mesh.
"""

from taffeta._errors import (
    DeviceError,
    DivergedError,
    Error,
    InputError,
    InternalError,
    SceneError,
    SceneWarning,
    SnapshotError,
)
from taffeta._native import Body, Collider, Simulation, Worlds, __version__, info, materials
from taffeta._pose import pose
from taffeta._reports import Report, to_pandas
from taffeta._scene import Scene
from taffeta.fitting import fit
from taffeta.sweeps import sweep

__all__ = [
    "Body",
    "Collider",
    "DeviceError",
    "DivergedError",
    "Error",
    "InputError",
    "InternalError",
    "Report",
    "Scene",
    "SceneError",
    "SceneWarning",
    "Simulation",
    "SnapshotError",
    "Worlds",
    "__version__",
    "fit",
    "info",
    "materials",
    "pose",
    "sweep",
    "to_pandas",
]
