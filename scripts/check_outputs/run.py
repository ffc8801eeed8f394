"""A run's folder, and what its outputs are compared with."""

import csv
import json

import numpy as np


def counted(count, what):
    """A number and a word, the latter as the former wants it."""
    return f"{count} {what}" if count == 1 else f"{count} {what}s"


class Run:
    """Positions of a run by frame and body, and how many comparisons there were."""

    def __init__(self, out):
        self.out = out
        summary = json.loads((out / "summary.json").read_text())
        self.listed = summary["files"]
        self.stored = np.load(out / "positions.npy")
        self.positions = self.stored.astype(np.float64)
        self.comparisons = self.failures = 0
        self.bodies, first = [], 0
        for body in summary["bodies"]:
            self.bodies.append((body["name"], slice(first, first + body["vertices"])))
            first += body["vertices"]
        if not len(self.stored):
            raise SystemExit("positions.npy has no frames: there is nothing to compare")
        expected = (summary["frames"] + 1, first, 3)
        self.demand(f"npy: shape {self.stored.shape}", self.stored.shape == expected, f"instead of {expected}")
        self.demand("npy: all finite", np.isfinite(self.stored).all(), "not all finite")

    def names(self, ending):
        """Files of this ending, one a body or one for all; bodies' files need not be named as they are."""
        names = [name for name in self.listed if name.endswith(ending)]
        if not names:
            raise FileNotFoundError(f"no {ending} in this run")
        return [self.out / name for name in names]

    def times(self):
        """Times of the frames [s]."""
        with open(self.out / "frames.csv", newline="") as table:
            later = [float(row["time"]) for row in csv.DictReader(table)]
        return later if len(later) == len(self.positions) else [0.0, *later]

    def demand(self, what, good, otherwise=""):
        """Reports a fact."""
        self.comparisons += 1
        self.failures += not good
        print(f"ok   {what}" if good else f"FAIL {what}: {otherwise}", flush=True)

    def compare(self, what, pairs, tolerance=1e-6):
        """Reports the largest difference between places read and places expected [m]. The tolerance is for each metre
        away from the origin: the default is a few units in the last place of 32 bits, for formats in text and programs
        that turn axes.
        """
        error, excess, count = 0.0, 0.0, 0
        for read, expected in pairs:
            read, count = np.asarray(read, dtype=np.float64), count + 1
            if read.shape != expected.shape:
                self.demand(what, False, f"{read.shape} instead of {expected.shape}")
                return
            pose = np.abs(read - expected).max()
            # Unlike Python's, this maximum keeps a NaN, which is no match.
            error = np.maximum(error, pose)
            excess = np.maximum(excess, pose - tolerance * max(1.0, np.abs(expected).max()))
        self.demand(f"{what}: {counted(count, 'pose')}, largest difference {error:.3g} m", excess <= 0.0, "too much")
