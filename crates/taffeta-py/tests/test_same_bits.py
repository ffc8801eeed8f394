"""The same bits as the program `taffeta`, on any number of threads."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import pytest
import taffeta

#: Springs, fabric with contact and air, a soft body with moved pins, constraints, seams, and joints that break.
SCENES = {"hanging": 4, "drape": 4, "twist_pins": 4, "hanging_ice": 3, "sewn": 3, "torn": 3, "trampoline": 3, "skirt": 2}


def by_program(program: str, arguments: list[str], out: Path) -> dict[str, object]:
    command = [program, "run", *arguments, "--quiet", "--backend", "cpu", "--out", str(out)]
    subprocess.run(command, check=True)
    summary: dict[str, object] = json.loads((out / "summary.json").read_text())
    return summary


@pytest.mark.parametrize("name", SCENES)
def test_python_and_the_program_give_the_same_bits(name: str, program: str, scenes: Path, tmp_path: Path) -> None:
    file, frames = scenes / f"{name}.toml", SCENES[name]
    summary = by_program(program, [str(file), "--frames", str(frames), "--threads", "2"], tmp_path)
    for threads in (1, 2, 3):
        simulation = taffeta.Simulation(file, backend="cpu", threads=threads)
        simulation.step(frames)
        assert simulation.state_hash() == summary["state_hash"], f"{threads} threads"
        assert sum(body.vertices for body in simulation.bodies.values()) == summary["vertices"]


def test_in_64_bits_and_with_overrides_the_bits_are_the_same(program: str, scenes: Path, tmp_path: Path) -> None:
    file = scenes / "flag.toml"
    sets = ["--set", "body.flag.material.preset=silk", "--set", "time.max_step=0.01"]
    summary = by_program(program, [str(file), "--frames", "2", "--precision", "f64", *sets], tmp_path)
    scene = taffeta.Scene(file).set("body.flag.material.preset", "silk").set("time.max_step", 0.01)
    simulation = taffeta.Simulation(scene, precision="f64", threads=2)
    simulation.step(2)
    assert simulation.state_hash() == summary["state_hash"]


def test_a_checkpoint_of_the_program_is_taken_up(program: str, scenes: Path, tmp_path: Path) -> None:
    file = scenes / "hanging.toml"
    arguments = [str(file), "--frames", "3", "--checkpoint-every", "3"]
    summary = by_program(program, arguments, tmp_path)
    simulation = taffeta.Simulation(file)
    simulation.restore((tmp_path / "checkpoint.taffeta").read_bytes())
    assert simulation.frame == 3
    assert simulation.state_hash() == summary["state_hash"]


def test_frames_in_one_call_or_in_many_give_the_same_bits(cloth: taffeta.Scene) -> None:
    one, many = taffeta.Simulation(cloth, threads=1), taffeta.Simulation(cloth, threads=2)
    report = one.step(12)
    for _ in range(12):
        many.step()
        many.positions()
        many.report
    assert many.state_hash() == one.state_hash()
    assert many.report == report
