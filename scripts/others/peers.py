#!/usr/bin/env python3
"""Times the cloth of several engines at equal quality: see README.md, "A sheet that swings".

python3 scripts/others/peers.py --install --out peers.json
"""

import argparse
import datetime
import json
import os
import subprocess
import sys
import tempfile
import venv
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
ENGINES = ["taffeta", "jolt", "rapier", "bullet", "mujoco_flex", "newton_warp"]
LEVELS = ("0.025", "0.1")
JOLT = "jolt-physics@1.1.0"
# One thread for all libraries that have threads of their own.
THREADS = {f"{name}_NUM_THREADS": "1" for name in ("OMP", "OPENBLAS", "MKL", "NUMEXPR")}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, required=True, help="results as JSON; what a file has of other engines stays")
    parser.add_argument("--engines", default=",".join(ENGINES), help="of " + ", ".join(ENGINES))
    parser.add_argument("--n", default="40", help="nodes of a side, several with commas")
    parser.add_argument("--seconds", type=float, default=300, help="of CPU time for the search of one method")
    parser.add_argument("--install", action="store_true", help="first install the packages, from PyPI and npm")
    parser.add_argument("--packages", type=Path, default=ROOT / "target/peers", help="where they are")
    parser.add_argument("--taffeta", type=Path, default=ROOT / "target/release/taffeta", help="its program")
    parser.add_argument("--others", type=Path, default=HERE / "target/release/others", help="the program of this folder")
    parser.add_argument("--jolt", type=Path, help="jolt.cpp, compiled with Jolt: see README.md")
    args = parser.parse_args()
    if args.install:
        install(args.packages)
    results = json.loads(args.out.read_text()) if args.out.exists() else []
    for n in map(int, args.n.split(",")):
        for engine in args.engines.split(","):
            result = {"module": engine, "date": str(datetime.date.today()), "machine": processor(), **measured(engine, n, args)}
            results = [other for other in results if (other["module"], other["n"]) != (engine, n)] + [result]
            args.out.write_text(json.dumps(results, indent=1) + "\n")
    print(table(sorted(results, key=lambda result: (result["n"], ENGINES.index(result["module"])))))


def install(folder):
    venv.create(folder, with_pip=True)
    subprocess.run([folder / "bin/pip", "install", "--quiet", "-r", HERE / "requirements.txt"], check=True)
    subprocess.run(["npm", "install", "--silent", "--prefix", folder, JOLT], check=True)


def measured(engine, n, args):
    """What a process of its own found out, or why it could not."""
    options = {"taffeta": args.taffeta, "others": args.others, "jolt": args.jolt, "node_modules": args.packages / "node_modules"}
    options = {name: str(path.resolve()) for name, path in options.items() if path}
    with tempfile.NamedTemporaryFile("r") as file:
        command = [args.packages / "bin/python", HERE / "peers/one.py", engine, str(n), str(args.seconds), json.dumps(options), file.name]
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, env=os.environ | THREADS)
        last = ""
        for last in process.stderr:
            sys.stderr.write(last)
        if process.wait():
            return {"engine": engine, "version": "", "n": n, "methods": [], "failure": last.strip()}
        return json.load(file)


def processor():
    lines = Path("/proc/cpuinfo").read_text().splitlines()
    return next((line.split(": ", 1)[1] for line in lines if line.startswith("model name")), "unknown")


def table(results):
    """A row for each engine, method and level."""
    rows = ["| n | engine | method | stretch at most | CPU time [ms] | wall-clock time [ms] | stretch reached | mean height off by | settings |",
            "|---|---|---|---|---|---|---|---|---|"]
    for result in results:
        name = f"{result['engine']} {result['version']}".strip()
        if "failure" in result:
            rows.append(f"| {result['n']} | {result['module']} | | not run: {result['failure']} | | | | | |")
        for method in result["methods"]:
            if "failure" in method:
                rows.append(f"| {result['n']} | {name} | {method['method']} | not run: {method['failure']} | | | | | |")
                continue
            for level in LEVELS:
                start = f"| {result['n']} | {name} | {method['method']} | {100 * float(level):g} % |"
                best = method["levels"].get(level)
                if not best:
                    rows.append(f"{start} not reached | | | | |")
                    continue
                settings = ", ".join(f"{key} {value:g}" if not isinstance(value, (str, bool)) else f"{key} {value}"
                                     for key, value in best["settings"].items())
                rows.append(f"{start} {best['cpu_ms']:.0f} | {best['wall_ms']:.0f} | {100 * best['stretch']:.1f} % | "
                            f"{1e3 * best['off']:.0f} mm | {settings} |")
    return "\n".join(rows)


if __name__ == "__main__":
    main()
