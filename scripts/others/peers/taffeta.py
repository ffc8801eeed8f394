"""taffeta, by its program: a scene file in, positions.npy out."""

import math
import subprocess
import tempfile
from pathlib import Path

import numpy as np

import programs
import sheet

NAME = "taffeta"

SCENE = """
[time]
dt = {frame!r}
max_step = {step!r}

[solver]
{solver}

[[body]]
name = "sheet"
mass = {mass}
mesh.grid = {{ rows = {n}, cols = {n}, size = [{size}, {size}] }}
place.rotation = {{ axis = [1.0, 0.0, 0.0], degrees = 45.0 }}
place.position = {middle}
springs.structural = {{ k = {k}, d = {d} }}
springs.shear = {{ k = {shear}, d = {d} }}
springs.bend = {{ k = {bend}, d = {d} }}
{tethers}[[body.pin]]
select = {{ nodes = {pins} }}
"""


def methods(n):
    return {"implicit springs (`primal`)": implicit(n), "explicit springs": explicit(n), "explicit springs on tethers": tethered(n),
            "position constraints (`xpbd`)": positions(n)}


def implicit(n):
    """Newton steps and iterations of 0 and 200 are the defaults: as many as needed. One is too few for a fine mesh that folds."""
    few, stiffnesses = ([(1, 6), (1, 12)], (500, 1000, 2500, 5000)) if n < 100 else ([], (2500, 5000, 20000))
    for steps in (1, 2, 3, 4):
        for newton, iterations in (*few, (2, 12), (0, 200)):
            for order in (1, 2):
                for k in stiffnesses:
                    yield {"steps": steps, "newton": newton, "iterations": iterations, "order": order, "k": k, "shear": k}


def explicit(n):
    """Steps around the longest that are stable, which springs and masses of nodes decide."""
    few = n >= 100  # where runs are long
    for k in (500, 2500, 3500) if few else (300, 400, 500, 700, 1000, 1500, 2000, 2500, 3500, 5000):
        for shear in (0.25,) if few else (0.25, 1.0):
            for close in (0.8, 0.9, 1.0, 1.1):
                yield {"steps": math.ceil(close * 250 * n / 40 * math.sqrt(k / 5000)), "k": k, "shear": k * shear}


def tethered(n):
    """Tethers bear the load, so springs may be so soft that a frame needs few steps. Softer ones need less damping to be stable."""
    for k in (20, 50, 100, 200) if n >= 100 else (12, 16, 20, 25, 30, 40, 50, 66, 85, 110, 150, 200):
        for shear in (0.25, 1.0):
            for close in (0.9, 1.0, 1.1):
                steps = math.ceil(close * 250 * n / 40 * math.sqrt(k / 5000))
                yield {"steps": steps, "k": k, "shear": k * shear, "damping": 0.06 * math.sqrt(k / 5000), "tethers": 1}


def positions(n):
    """Any stiffness beyond what the step can show does: steps and sweeps say how far cloth stretches."""
    for steps in (1, 2, 3, 4, 5, 6, 8, 10, 12, 16):
        for sweeps in (1, 2):
            yield {"steps": steps, "sweeps": sweeps, "k": 10000, "shear": 100, "bend": 1, "damping": 0}


def scene(n, settings):
    solver = 'method = "springs"'
    if "newton" in settings:
        solver = (f'method = "ice"\nice.form = "primal"\nice.newton_steps = {settings["newton"]}\n'
                  f'ice.max_iterations = {settings["iterations"]}\nice.order = {settings["order"]}')
    if "sweeps" in settings:
        solver = f'method = "xpbd"\nxpbd.sweeps = {settings["sweeps"]}'
    middle = [float(x) for x in sheet.start(n).mean(axis=0)]
    return SCENE.format(
        frame=sheet.FRAME, step=sheet.FRAME / settings["steps"], solver=solver, mass=sheet.MASS, n=n, size=sheet.SIZE,
        middle=middle, k=float(settings["k"]), shear=float(settings["shear"]), bend=float(settings.get("bend", settings["k"] / 10)),
        d=settings.get("damping", 0.02) * (40 / n) ** 2, tethers="tethers = {}\n" if "tethers" in settings else "",
        pins=sheet.pins(n))


def swing(run, settings, limit, options):
    with tempfile.TemporaryDirectory() as folder:
        file, out = Path(folder) / "sheet.toml", Path(folder) / "out"
        file.write_text(scene(run.n, settings))

        def frames(count):
            folder = out / str(count)
            return programs.cpu_of([options["taffeta"], "run", file, "--out", folder, "--frames", str(count),
                                    "--threads", "1", "--backend", "cpu", "--quiet"], limit)

        cpu, wall = programs.frames_alone(frames)
        return sheet.recorded(run, np.load(out / str(sheet.FRAMES) / "positions.npy"), cpu, wall, limit)


def version(options):
    return subprocess.run([options["taffeta"], "--version"], capture_output=True, text=True).stdout.split()[-1]
