#!/usr/bin/env python3
"""Measures many worlds at once from Python: a sheet of 30 × 30 nodes falls on a ball and a floor.

    pip install target/wheels/taffeta-*.whl
    python3 scripts/worlds.py --worlds 1,32,512,2048,8192

Each row is a process of its own. It builds the worlds, then runs the same frames again and again from the start and prints the
median of these runs, with the least and the most. A frame is 1/60 s. CPU time is that of all threads; where other programs use
the same cores it says more than the rate.
"""

from __future__ import annotations

import argparse
import json
import resource
import subprocess
import sys
import time
from statistics import median
from typing import Any

import taffeta

FRAME = 1 / 60
#: Springs of a method, and its sub-steps in a frame.
METHODS: dict[str, tuple[dict[str, float], dict[str, float], int]] = {
    "springs": ({"k": 200.0, "d": 0.01}, {"k": 50.0, "d": 0.01}, 36),
    "xpbd": ({"k": 10_000.0, "d": 0.0}, {"k": 100.0, "d": 0.0}, 4),
}
#: Frames before the timed ones: the sheet falls freely.
BEFORE = 5


def scene(method: str) -> taffeta.Scene:
    """The sheet above a ball."""
    structural, shear, substeps = METHODS[method]
    made = taffeta.Scene().time(dt=FRAME, max_step=FRAME / substeps).solver(method)
    springs = {"structural": structural, "shear": shear}
    made = made.grid(
        "sheet", rows=30, cols=30, size=(1.0, 1.0), mass=0.2, position=(0.0, 0.4, 0.0), springs=springs
    )
    return made.sphere("ball", radius=0.25, friction=0.4).plane("floor", point=(0.0, -0.4, 0.0))


def resident() -> float:
    """The most memory that this process has had [kB]."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / (1024 if sys.platform == "darwin" else 1)


def measure(method: str, count: int, frames: int, runs: int, threads: int | None) -> dict[str, Any]:
    """Builds worlds and steps them."""
    made, before = scene(method), resident()
    start, cpu = time.perf_counter(), time.process_time()
    worlds = taffeta.Worlds(made, count, threads=threads)
    build, build_cpu = time.perf_counter() - start, time.process_time() - cpu
    # Short runs are put together to one that can be timed.
    repeats = max(1, 512 // count)
    rates: list[float] = []
    cpus: list[float] = []
    for _ in range(runs):
        wall = used = 0.0
        for _ in range(repeats):
            worlds.reset()
            worlds.step(BEFORE)
            start, cpu = time.perf_counter(), time.process_time()
            diverged = worlds.step(frames)
            wall, used = wall + time.perf_counter() - start, used + time.process_time() - cpu
            assert not diverged.any()
        rates.append(count * frames * repeats / wall)
        cpus.append(used / (count * frames * repeats) * 1e6)
    return {
        "rates": rates,
        "cpus": cpus,
        "build": build / count * 1e3,
        "build_cpu": build_cpu / count * 1e3,
        "resident": (resident() - before) / count,
        "counted": worlds.memory / count / 1024,
    }


def spread(values: list[float], digits: int) -> str:
    """The median, and the least and the most."""
    return f"{median(values):,.{digits}f} ({min(values):,.{digits}f} to {max(values):,.{digits}f})"


def main() -> None:
    """Reads the command line, and prints a table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--worlds", default="1,32,512")
    parser.add_argument("--methods", default=",".join(METHODS))
    parser.add_argument("--frames", type=int, default=10, help="timed frames of a run")
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--threads", type=int, help="worlds that are stepped at a time")
    parser.add_argument("--one", action="store_true", help="measure the first of each here, and print JSON")
    arguments = parser.parse_args()
    methods, counts = arguments.methods.split(","), [int(count) for count in arguments.worlds.split(",")]
    if arguments.one:
        one = measure(methods[0], counts[0], arguments.frames, arguments.runs, arguments.threads)
        print(json.dumps(one))
        return
    print("| method | sub-steps a frame | worlds | frames of worlds a second | CPU time a frame of a world [µs]", end="")
    print(" | build, CPU time a world [ms] | memory a world, resident; counted [kB] |")
    print("|---|---|---|---|---|---|---|")
    for method in methods:
        for count in counts:
            words = [sys.executable, __file__, "--one", "--methods", method, "--worlds", str(count)]
            words += ["--frames", str(arguments.frames), "--runs", str(arguments.runs)]
            words += ["--threads", str(arguments.threads)] if arguments.threads else []
            row = json.loads(subprocess.run(words, check=True, stdout=subprocess.PIPE).stdout)
            print(
                f"| {method} | {METHODS[method][2]} | {count:,} | {spread(row['rates'], 0)} | {spread(row['cpus'], 0)}"
                f" | {row['build_cpu']:.2f} | {row['resident']:,.0f}; {row['counted']:,.0f} |",
                flush=True,
            )


if __name__ == "__main__":
    main()
