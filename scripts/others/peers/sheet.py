"""The scene that all engines simulate, and how a run is measured."""

import time

import numpy as np

SIZE = 1.0  # side of the sheet [m]
MASS = 0.2  # of the whole sheet [kg]
GRAVITY = 9.81  # along -y [m/s²]
FRAMES = 60  # the simulated second
FRAME = 1 / 60  # [s]
LEVELS = (0.025, 0.10)  # largest stretch of an edge that is asked for
MOTION = 0.05  # how far the mean height may be from the reference in any frame [m]


def start(n):
    """Positions [m] of n × n nodes, row by row: row 0 is level, and the sheet hangs from it at 45 degrees."""
    along = np.linspace(0.0, SIZE, n)
    x, down = np.meshgrid(along - SIZE / 2, along * np.sqrt(0.5))
    return np.stack([x, -down, down], axis=-1).reshape(-1, 3)


def pins(n):
    """The two corners of row 0."""
    return [0, n - 1]


def triangles(n):
    """Two for each cell of the grid."""
    node = np.arange(n * n).reshape(n, n)
    a, b, c, d = (cell.ravel() for cell in (node[:-1, :-1], node[:-1, 1:], node[1:, :-1], node[1:, 1:]))
    return np.concatenate([np.stack([a, c, b], axis=1), np.stack([b, c, d], axis=1)])


def stretch(positions, n):
    """Of the longest edge along a row or column, relative to its length at rest: 0.02 is 2 % too long."""
    grid = np.asarray(positions, dtype=np.float64).reshape(n, n, 3)
    edges = (np.linalg.norm(np.diff(grid, axis=axis), axis=-1).max() for axis in (0, 1))
    return max(edges) * (n - 1) / SIZE - 1.0


class Stopped(Exception):
    """A run that does not count, and why."""


class Missing(Exception):
    """A program that is not there."""


class TooSlow(Stopped):
    """A run beyond its limit of time."""

    def __init__(self, limit):
        super().__init__(f"more than {1e3 * limit:.0f} ms")


class Swing:
    """What a run did: the stretch and the mean height of each frame, and its time [s]."""

    def __init__(self, n, heights=None):
        """`heights` are those of the reference, which a run may not leave."""
        self.n, self.reference = n, heights
        self.stretch, self.heights = [], []
        self.cpu = self.wall = 0.0

    def look(self, positions):
        """Notes a frame, or ends a run that cannot count any more."""
        positions = np.asarray(positions)
        frame, longest = len(self.stretch), stretch(positions, self.n)
        if not longest <= max(LEVELS):  # or not a number
            raise Stopped(f"stretch of {100 * longest:.3g} % in frame {frame}")
        self.stretch.append(float(longest))
        self.heights.append(float(positions.reshape(-1, 3)[:, 1].mean()))
        if self.reference and abs(self.heights[-1] - self.reference[frame]) > MOTION:
            raise Stopped(f"mean height of {self.heights[-1]:.3f} m in place of {self.reference[frame]:.3f} in frame {frame}")

    def off(self):
        """How far the mean height was from the reference at most [m]."""
        return max(abs(own - other) for own, other in zip(self.heights, self.reference))


def swing(run, sheet, limit):
    """Runs a sheet of this process, for at most `limit` seconds."""
    run.look(sheet.positions())
    for _ in range(FRAMES):
        wall, cpu = time.perf_counter(), time.process_time()
        sheet.frame()
        run.cpu += time.process_time() - cpu
        run.wall += time.perf_counter() - wall
        run.look(sheet.positions())
        if run.cpu > limit:
            raise TooSlow(limit)
    return run


def recorded(run, frames, cpu, wall, limit):
    """The run of another program, from its positions [frame, node, axis]."""
    if cpu > limit:
        raise TooSlow(limit)
    for positions in frames:
        run.look(positions)
    run.cpu, run.wall = cpu, wall
    return run
