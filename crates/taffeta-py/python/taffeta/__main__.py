"""``python -m taffeta``: which version this is and what it runs on; and sweeps."""

from __future__ import annotations

import argparse
import sys

import taffeta
from taffeta.sweeps import _command


def main() -> int:
    """Do what is asked for."""
    parser = argparse.ArgumentParser(prog="python -m taffeta", description="Cloth and soft bodies.")
    parser.add_argument("--version", action="version", version=f"taffeta {taffeta.__version__}")
    commands = parser.add_subparsers(dest="command", title="commands")
    commands.add_parser("info", help="print the version and what the machine has (as without a command)")
    sweep = commands.add_parser("sweep", help="run a scene many times with values that differ")
    _command.add_arguments(sweep)
    arguments = parser.parse_args()
    return _command.run(arguments) if arguments.command == "sweep" else _info()


def _info() -> int:
    facts = taffeta.info()
    gpus: list[str] = facts.pop("gpus")
    for name, value in facts.items():
        print(f"{name}: {value}")
    print(f"gpus: {', '.join(gpus) or 'none'}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
