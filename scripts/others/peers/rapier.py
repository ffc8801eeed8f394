"""The engines of this folder's Rust program: rapier3d and rapier-cloth-core."""

import re
import tempfile
from pathlib import Path

import numpy as np

import programs
import sheet

NAME = "Rapier, rapier-cloth"


def methods(n):
    return {"rapier3d: springs as constraints": springs(), "rapier-cloth-core: XPBD": positions()}


def springs():
    """`iterations` are those within a step; `material` is the frequency [Hz] of each spring with the mass at its ends."""
    for steps, iterations in ((4, 1), (4, 4), (8, 1), (8, 4), (12, 1), (12, 4), (16, 1), (16, 4), (24, 1), (24, 4), (32, 1), (48, 1),
                              (64, 1)):
        for hertz in (300, 1000, 3000):
            yield {"engine": "rapier3d", "steps": steps, "iterations": iterations, "material": hertz}


def positions():
    """`material` is the compliance of edges [m/N]."""
    for steps, iterations in ((4, 8), (8, 2), (8, 8), (12, 1), (12, 2), (12, 4), (16, 1), (16, 2), (16, 4), (24, 1), (24, 2), (32, 1),
                              (32, 2), (48, 1), (24, 4), (16, 8), (64, 1)):
        for compliance in (0.0, 1e-5):
            yield {"engine": "rapier-cloth-core", "steps": steps, "iterations": iterations, "material": compliance}


def swing(run, settings, limit, options):
    with tempfile.TemporaryDirectory() as folder:

        def frames(count):
            command = ["swing", settings["engine"], run.n, count, settings["steps"], settings["iterations"], settings["material"]]
            return programs.cpu_of([options["others"], *map(str, command), f"{folder}/{count}"], limit)

        cpu, wall = programs.frames_alone(frames)
        positions = np.fromfile(f"{folder}/{sheet.FRAMES}", "<f4").reshape(sheet.FRAMES + 1, -1, 3)
        return sheet.recorded(run, positions, cpu, wall, limit)


def version(options):
    lock = (Path(__file__).parents[1] / "Cargo.lock").read_text()
    return ", ".join(re.search(f'name = "{name}"\nversion = "(.*)"', lock)[1] for name in ("rapier3d", "rapier-cloth-core"))
