#!/usr/bin/env python3
"""What a run of a sweep costs beside its simulation, here and on Ray and Dask, with one worker and with two.

pip install target/wheels/taffeta-*.whl[sweep,ray,dask]
python3 scripts/scale.py
"""

import argparse
import statistics
import tempfile
import time
from pathlib import Path

import taffeta
from taffeta.sweeps import Dask, Local, Ray

KINDS = {"local": Local, "ray": lambda jobs: Ray(jobs=jobs), "dask": lambda jobs: Dask(jobs=jobs)}


def scene(frames):
    """A cloth whose frames take about a millisecond."""
    made = taffeta.Scene().solver("ice", form="primal").time(frames=frames)
    return made.grid("cloth", rows=24, cols=24, size=(1.0, 1.0), material="cotton").pin("cloth", rows=0)


def timed(backend, frames, runs):
    """Seconds of a sweep."""
    with tempfile.TemporaryDirectory() as folder:
        values = [0.1 + 0.001 * run for run in range(runs)]
        grid = {"body.cloth.material.density": values}
        start = time.perf_counter()
        taffeta.sweep(scene(frames), grid=grid, out=Path(folder) / "out", backend=backend, progress=False)
        return time.perf_counter() - start


def alone(frames, runs):
    """Seconds of the same simulations in one process, without a sweep."""
    start = time.perf_counter()
    for run in range(runs):
        made = scene(frames).set("body.cloth.material.density", 0.1 + 0.001 * run)
        taffeta.Simulation(made, backend="cpu", threads=1).step(frames)
    return time.perf_counter() - start


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=64)
    parser.add_argument("--turns", type=int, default=5)
    args = parser.parse_args()
    print("| backend | workers | ready after [s] | a run of 1 frame [ms] | runs of 300 frames: speed of one process |")
    print("|---|---|---|---|---|")
    simulations = statistics.median(alone(300, args.runs // 4) for _ in range(args.turns))
    for name, kind in KINDS.items():
        for jobs in (1, 2):
            start = time.perf_counter()
            backend = kind(jobs)
            timed(backend, 1, 2 * jobs)
            ready = time.perf_counter() - start
            short = [timed(backend, 1, args.runs) / args.runs * 1e3 for _ in range(args.turns)]
            long = [simulations / timed(backend, 300, args.runs // 4) for _ in range(args.turns)]
            backend.close()
            spread = f"{statistics.median(short):.1f} ({min(short):.1f}–{max(short):.1f})"
            gain = f"{statistics.median(long):.2f} ({min(long):.2f}–{max(long):.2f})"
            print(f"| {name} | {jobs} | {ready:.1f} | {spread} | {gain} |", flush=True)


if __name__ == "__main__":
    main()
