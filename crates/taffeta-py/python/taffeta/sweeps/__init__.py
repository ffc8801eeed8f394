"""Sweeps: many runs of one scene, with values that differ, on this machine or on a cluster.

>>> import taffeta
>>> scene = taffeta.Scene().grid("flag", rows=6, cols=9, size=(1.5, 1.0), material="silk").pin("flag", cols=0)
>>> scene = scene.solver("ice", form="primal").time(frames=20)
>>> found = taffeta.sweep(scene, grid={"body.flag.material.bending": [1e-6, 1e-5, 1e-4]}, out="flags", jobs=1, progress=False)
>>> found.table.num_rows
3
"""

from taffeta.sweeps._backends import Backend, Dask, Local, Ray
from taffeta.sweeps._results import Sweep
from taffeta.sweeps._sweep import sweep

__all__ = ["Backend", "Dask", "Local", "Ray", "Sweep", "sweep"]
