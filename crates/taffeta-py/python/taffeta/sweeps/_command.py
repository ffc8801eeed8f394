"""``python -m taffeta sweep``."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

import taffeta
from taffeta.sweeps import _backends, _plan
from taffeta.sweeps._folder import RESULTS
from taffeta.sweeps._run import ARRAYS
from taffeta.sweeps._sweep import sweep

_EXAMPLE = """example:
  python -m taffeta sweep flag.toml --grid body.flag.material.bending=1e-6:1e-4:log:8 --jobs 2

A grid is PATH=FIRST:LAST:COUNT, PATH=FIRST:LAST:log:COUNT, or PATH=ONE,OTHER,…; with several of them all combinations run.
Paths are those of `taffeta run --set`. A sweep that was stopped goes on when the same command is given again.

Exit codes: 0 if a run was done, also where others failed; 1 if all failed; 2 if nothing could be run; 130 after Ctrl-C.
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """What it takes."""
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.epilog = _EXAMPLE
    add = parser.add_argument
    add("scene", help="a scene file")
    add("--grid", action="append", required=True, metavar="PATH=VALUES", help="values of one path")
    add("--out", metavar="DIR", help="folder of results; by default the scene's name with `-sweep`")
    add("--frames", type=int, help="frames of a run; those of the scene by default")
    add("--rest", type=float, metavar="SPEED", help="end a run when no vertex is faster [m/s]")
    add("--set", action="append", default=[], metavar="PATH=VALUE", help="a value that all runs share")
    add("--jobs", type=int, help="runs at a time; as many as there are cores by default")
    add("--backend", default="local", choices=("local", "ray", "dask"), help="where runs happen (default: local)")
    add("--address", help="of a cluster of Ray or Dask")
    add("--arrays", default="", metavar="NAMES", help=f"what is kept of each run: {', '.join(ARRAYS)}")
    add("--every", type=int, metavar="FRAMES", help="keep arrays of every so many frames")
    add("--precision", default="f32", choices=("f32", "f64"), help="arithmetic (default: f32)")
    add("--retry-failed", action="store_true", help="run those again that failed before")
    add("--quiet", action="store_true", help="do not tell how far it is")


def run(arguments: argparse.Namespace) -> int:
    """Runs it; 0 where a run was done, 1 where all failed, 2 where nothing could be run."""
    out = Path(arguments.out or f"{Path(arguments.scene).stem}-sweep")
    try:
        found = sweep(
            _scene(arguments),
            out=out,
            grid=_grid(arguments.grid),
            frames=arguments.frames,
            rest=arguments.rest,
            arrays=[name.strip() for name in arguments.arrays.split(",") if name.strip()],
            every=arguments.every,
            backend=_backend(arguments),
            jobs=arguments.jobs,
            retry_failed=arguments.retry_failed,
            options={"precision": arguments.precision},
            progress=not arguments.quiet,
        )
    except (taffeta.Error, ModuleNotFoundError) as error:
        print(f"sweep: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("\nsweep: stopped; the same command goes on from here", file=sys.stderr)
        return 130
    _tell(found, out)
    return 0 if found.done else 1


def _grid(texts: list[str]) -> dict[str, list[Any]]:
    grid: dict[str, list[Any]] = {}
    for text in texts:
        path, values = _plan.parse(text)
        if path in grid:
            raise taffeta.InputError(f"--grid {text}: `{path}` has values already")
        grid[path] = values
    return grid


def _scene(arguments: argparse.Namespace) -> taffeta.Scene:
    scene = taffeta.Scene(Path(arguments.scene))
    for text in arguments.set:
        path, values = _plan.parse(text)
        if len(values) != 1:
            raise taffeta.InputError(f"--set {text}: one value would do; --grid takes several")
        scene.set(path, values[0])
    return scene


def _backend(arguments: argparse.Namespace) -> Any:
    if arguments.address is None:
        return arguments.backend
    if arguments.backend == "local":
        raise taffeta.InputError("--address is that of a cluster: --backend ray or --backend dask would do")
    if arguments.jobs is not None:
        raise taffeta.InputError("--jobs are those of this machine; a cluster with an --address has its own")
    kind = {"ray": _backends.Ray, "dask": _backends.Dask}[arguments.backend]
    return kind(arguments.address)


def _tell(found: Any, out: Path) -> None:
    runs = "1 run" if len(found) == 1 else f"{len(found)} runs"
    print(f"{runs}: {found.done} done, {found.failed} failed; results are in {out / RESULTS}")
    messages = [(row["run"], row["message"]) for row in found.table.to_pylist() if row["status"] == "failed"]
    for number, message in messages[:5]:
        print(f"run {number} failed: {message.splitlines()[0]}")
    if len(messages) > 5:
        print(f"and {len(messages) - 5} more; the column `message` has all")
