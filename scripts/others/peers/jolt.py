"""Jolt's soft bodies: by its build for JavaScript in node (jolt.mjs), and native where there is a program of jolt.cpp."""

import json
import subprocess
import tempfile
from pathlib import Path

import numpy as np

import programs
import sheet

NAME = "Jolt"


def methods(n):
    return {"soft body, WebAssembly": soft("wasm"), "soft body, native": soft("native")}


def soft(build):
    """Compliances are of edges and of diagonals [m/N]; tethers keep nodes no farther from the pins than along the sheet."""
    for iterations in (15, 20, 25, 30, 40, 50, 60, 80, 120, 160, 240, 320):
        for compliance in (0.0, 1e-4):
            for shear in (1e-3, 1e-2):
                yield {"build": build, "iterations": iterations, "compliance": compliance, "shear": shear, "tethers": 1}
    for iterations in (40, 60, 80, 120):
        yield {"build": build, "iterations": iterations, "compliance": 0.0, "shear": 1e-2, "tethers": 0}


def swing(run, settings, limit, options):
    with tempfile.TemporaryDirectory() as folder:
        sheet.start(run.n).astype("<f4").tofile(f"{folder}/start.f32")
        sheet.triangles(run.n).astype("<u4").tofile(f"{folder}/faces.u32")
        words = [folder, sheet.FRAMES, sheet.FRAME, sheet.GRAVITY, sheet.MASS / run.n**2, *sheet.pins(run.n)]
        words += [settings["iterations"], settings["compliance"], settings["shear"], settings["tethers"]]
        programs.cpu_of(program(settings["build"], options) + [str(word) for word in words], limit)
        times = json.loads(Path(folder, "times.json").read_text())
        frames = np.fromfile(f"{folder}/frames.f32", "<f4").reshape(sheet.FRAMES + 1, -1, 3)
        return sheet.recorded(run, frames, times["cpu"], times["wall"], limit)


def program(build, options):
    if build == "wasm":
        return ["node", Path(__file__).with_suffix(".mjs"), options["node_modules"]]
    if "jolt" not in options:
        raise sheet.Missing("no program of jolt.cpp (--jolt)")
    return [options["jolt"]]


def version(options):
    package = Path(options["node_modules"], "jolt-physics/package.json")
    node = subprocess.run(["node", "--version"], capture_output=True, text=True).stdout.strip()
    return f"jolt-physics {json.loads(package.read_text())['version']}, node {node}"
