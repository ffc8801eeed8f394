#!/usr/bin/env python3
"""Hides fabrics, measures them in three experiments with noise, and fits them again.

pip install target/wheels/taffeta-*.whl[fit]
python3 scripts/fit_fabric.py --out out/fits
"""

import argparse
import time
from pathlib import Path

import numpy as np
import taffeta
from taffeta.fitting import Target

FABRIC = "body.cloth.material."
DENSITY = 0.15
NAMES = ("stretch", "shear", "bending")
UNITS = ("N/m", "N/m", "N·m")
RANGES = {f"{FABRIC}stretch": (20.0, 5000.0), f"{FABRIC}shear": (5.0, 200.0), f"{FABRIC}bending": (1e-6, 2e-4)}
# A jersey, a ponte and a plain weave, about.
HIDDEN = ((60.0, 15.0, 6e-6), (300.0, 40.0, 2.5e-5), (1200.0, 60.0, 1.6e-5))
# Standard deviation of a scan [m].
NOISE = {"hanging": 2e-4, "cantilever": 2e-4, "drape": 5e-4}


def experiment(rows, cols, size, **options):
    """A cloth that comes to rest, with drag that has it do so soon."""
    drag = 10.0 * DENSITY * size[0] * size[1] / (rows * cols)
    scene = taffeta.Scene().time(dt=1 / 60, max_step=1 / 60, frames=200).world(drag=drag)
    scene = scene.solver("ice", form="primal", tolerance=1e-5, max_iterations=2000, newton_steps=12)
    material = {"density": DENSITY, "stretch": 100.0, "shear": 20.0, "bending": 1e-5, "poisson": 0.2}
    return scene.grid("cloth", rows=rows, cols=cols, size=size, material=material, **options)


def experiments():
    """A square that hangs by two corners, a strip in a clamp, and a square that is held in its middle."""
    hanging = experiment(13, 13, (0.5, 0.5), rotation=((1, 0, 0), 90.0)).pin("cloth", nodes=[0]).pin("cloth", nodes=[12])
    cantilever = experiment(4, 13, (0.06, 0.015)).pin("cloth", cols=(0, 2))
    line = np.linspace(-0.12, 0.12, 15)
    held = [row * 15 + col for row in range(15) for col in range(15) if np.hypot(line[row], line[col]) < 0.07]
    drape = experiment(15, 15, (0.24, 0.24)).pin("cloth", nodes=held)
    return {"hanging": hanging, "cantilever": cantilever, "drape": drape}


def positions(simulation):
    """What a scanner sees [m]."""
    return simulation.positions("cloth")


def target(name, scene, hidden, random):
    """A scan of the real fabric."""
    real = scene.copy()
    for path, value in zip(RANGES, hidden):
        real.set(path, value)
    simulation = taffeta.Simulation(real, backend="cpu", precision="f64")
    simulation.step(200)
    scan = positions(simulation)
    return Target(positions, scan + random.normal(0.0, NOISE[name], scan.shape), NOISE[name], scene=scene, rest=1e-5, name=name)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=Path("out/fits"))
    parser.add_argument("--jobs", type=int, default=2)
    args = parser.parse_args()
    lines = ["| fabric | | hidden | found | 95 % | off by |", "|---|---|---|---|---|---|"]
    for number, hidden in enumerate(HIDDEN):
        random = np.random.default_rng(number)
        targets = [target(name, scene, hidden, random) for name, scene in experiments().items()]
        start = time.perf_counter()
        fit = taffeta.fit(None, targets, RANGES, out=args.out / str(number), jobs=args.jobs)
        print(f"{fit}\n{time.perf_counter() - start:.0f} s")
        for name, unit, real, found in zip(NAMES, UNITS, hidden, fit.estimates.values()):
            interval = f"{found.low:.4g} to {found.high:.4g}"
            lines.append(f"| {number + 1} | {name} [{unit}] | {real:g} | {found.value:.4g} | {interval} | {found.value / real - 1:+.1%} |")
    print("\n".join(lines))


if __name__ == "__main__":
    main()
