"""From Blender's coordinates to the engine's and back: z up in the scene's unit, and y up in metres."""

import numpy as np

# Columns are Blender's axes.
TURN = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])


def unit(scene):
    """Length of the scene's unit [m]."""
    units = scene.unit_settings
    return 1.0 if units.system == "NONE" else units.scale_length


def to_engine(points, matrix, metres):
    """Points [n, 3] of an object with a world matrix, placed in the engine's world [m]."""
    matrix = np.asarray(matrix, np.float64)
    world = np.asarray(points, np.float64) @ matrix[:3, :3].T + matrix[:3, 3]
    return (metres * world) @ TURN.T


def to_object(points, matrix, metres):
    """Points [n, 3] of the engine's world [m] in the coordinates of an object with a world matrix."""
    inverse = np.linalg.inv(np.asarray(matrix, np.float64))
    world = (np.asarray(points, np.float64) @ TURN) / metres
    return world @ inverse[:3, :3].T + inverse[:3, 3]


def direction(vector):
    """A direction of Blender's world in the engine's, as a list."""
    return (TURN @ np.asarray(vector, np.float64)).tolist()
