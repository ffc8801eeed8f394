"""``python -m taffeta``: which version this is, and what it runs on."""

import argparse

import taffeta


def main() -> None:
    """Print what is asked for."""
    parser = argparse.ArgumentParser(prog="python -m taffeta", description="Cloth and soft bodies.")
    parser.add_argument("--version", action="version", version=f"taffeta {taffeta.__version__}")
    parser.parse_args()
    facts = taffeta.info()
    gpus: list[str] = facts.pop("gpus")
    for name, value in facts.items():
        print(f"{name}: {value}")
    print(f"gpus: {', '.join(gpus) or 'none'}")


if __name__ == "__main__":
    main()
