"""Sweeps: what they leave, and that they lose nothing and repeat nothing."""

from __future__ import annotations

import functools
import json
import os
import subprocess
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import taffeta
import taffeta.sweeps
from taffeta.sweeps._identity import of_function

pytest.importorskip("pyarrow")

BENDING = "body.cloth.material.bending"
VALUES = [1e-6, 1e-5, 1e-4, 1e-3]

Measure = Callable[[taffeta.Simulation], Mapping[str, Any]]


@pytest.fixture
def hanging(cloth: taffeta.Scene) -> taffeta.Scene:
    """The cloth, for a few frames."""
    return cloth.time(frames=5)


def logging_to(path: Path) -> Measure:
    """Measures, and writes down that it did."""

    def measure(simulation: taffeta.Simulation) -> dict[str, Any]:
        stiffness = simulation.scene.overrides[0]
        with path.open("a") as file:
            file.write(f"{stiffness}\n")
        return {"lowest": float(simulation.positions()[:, 1].min()), "first": simulation.positions()[0]}

    return measure


def swept(scene: taffeta.Scene, out: Path, values: list[float] | None = None, **options: Any) -> Any:
    """A sweep on two processes that says nothing."""
    options = {"jobs": 2, "progress": False, **options}
    return taffeta.sweep(scene, grid={BENDING: VALUES if values is None else values}, out=out, **options)


def test_a_row_has_the_values_and_the_bits_of_a_run_by_hand(hanging: taffeta.Scene, tmp_path: Path) -> None:
    found = swept(hanging, tmp_path / "out", measure=logging_to(tmp_path / "log"), arrays=["positions"])
    assert found.table.column("run").to_pylist() == [0, 1, 2, 3]
    for run, value in enumerate(VALUES):
        by_hand = taffeta.Simulation(hanging.copy().set(BENDING, value), threads=2)
        report = by_hand.step(5)
        row = found.table.to_pylist()[run]
        assert row[BENDING] == value
        assert row["state_hash"] == by_hand.state_hash()
        assert row["energy"] == report["energy"]
        assert row["lowest"] == by_hand.positions()[:, 1].min()
        assert row["first"] == by_hand.positions()[0].tolist()
        assert np.array_equal(found.arrays(run)["positions"], by_hand.positions())


def test_arrays_of_every_few_frames_begin_with_the_start(hanging: taffeta.Scene, tmp_path: Path) -> None:
    found = swept(hanging, tmp_path / "out", [1e-5], arrays=["positions", "velocities"], every=2)
    arrays = found.arrays(0)
    assert arrays["frames"].tolist() == [0, 2, 4]
    assert arrays["velocities"].shape == (3, 64, 3)
    simulation = taffeta.Simulation(hanging.copy().set(BENDING, 1e-5))
    assert np.array_equal(arrays["positions"][0], simulation.positions())
    simulation.step(4)
    assert np.array_equal(arrays["positions"][2], simulation.positions())


def test_a_run_ends_at_rest(tmp_path: Path) -> None:
    # A pendulum that drag stops, and one that swings on; both turn back on the way.
    scene = taffeta.Scene().time(frames=400, max_step=1 / 240)
    scene = scene.chain("chain", links=1, length=0.2, node_mass=0.01, springs={"structural": {"k": 1000.0, "d": 0.1}})
    drags = [0.2, 0.0]
    found = taffeta.sweep(
        scene.pin("chain", nodes=0), grid={"world.drag": drags}, rest=1e-3, arrays=["velocities"], out=tmp_path, progress=False
    )
    calm, swinging = found.table.to_pylist()
    assert (calm["status"], calm["at_rest"], swinging["at_rest"]) == ("done", True, False)
    assert 20 < calm["frame"] < 400 == swinging["frame"]
    assert np.abs(found.arrays(0)["velocities"]).max() < 1e-3


def test_a_run_that_fails_is_a_row_with_its_message(hanging: taffeta.Scene, tmp_path: Path) -> None:
    found = swept(hanging, tmp_path / "out", [1e-5, -1.0, 1e-4])
    assert (found.done, found.failed) == (2, 1)
    row = found.table.to_pylist()[1]
    assert (row["status"], row["error"], row["energy"]) == ("failed", "SceneError", None)
    assert "-1 N·m, 0 or more would do" in row["message"]


def test_a_run_that_diverges_is_a_row_with_its_message(tmp_path: Path) -> None:
    scene = taffeta.Scene().time(frames=200, max_step=1 / 60)
    scene = scene.grid("cloth", rows=8, cols=8, size=(1.0, 1.0), mass=0.1, springs={"structural": {"k": 1.0}})
    found = taffeta.sweep(
        scene.pin("cloth", rows=0), grid={"body.cloth.springs.structural.k": [1.0, 1e6]}, out=tmp_path, progress=False
    )
    statuses = found.table.column("status").to_pylist()
    assert statuses == ["done", "failed"]
    row = found.table.to_pylist()[1]
    assert (row["error"], "body `cloth`, vertex" in row["message"]) == ("DivergedError", True)


def test_what_measures_fails_by_its_own_words(hanging: taffeta.Scene, tmp_path: Path) -> None:
    def broken(_simulation: taffeta.Simulation) -> dict[str, Any]:
        raise KeyError("height")

    def of_a_known_name(_simulation: taffeta.Simulation) -> dict[str, Any]:
        return {"energy": 1.0}

    one = swept(hanging, tmp_path / "one", [1e-5], measure=broken)
    assert one.table.to_pylist()[0]["error"] == "KeyError"
    other = swept(hanging, tmp_path / "other", [1e-5], measure=of_a_known_name)
    assert "`energy`, which is a column" in other.table.to_pylist()[0]["message"]


def test_wrong_arguments_are_refused_before_anything_runs(hanging: taffeta.Scene, tmp_path: Path) -> None:
    def refused(match: str, **options: Any) -> None:
        kind = (taffeta.SceneError, taffeta.InputError)
        with pytest.raises(kind, match=match):
            taffeta.sweep(hanging, out=tmp_path / "out", progress=False, **options)
        assert not (tmp_path / "out" / "runs").exists()

    refused("did you mean `bending`", grid={"body.cloth.material.bendin": [1.0]})
    refused("called `clth`; did you mean `cloth`", grid={"body.clth.material.bending": [1.0]})
    refused("has no values", grid={BENDING: []})
    refused("a list of values", grid={BENDING: 1.0})
    refused("either a grid or samples", grid={BENDING: [1.0]}, samples=[{BENDING: 1.0}])
    refused("no samples", samples=[])
    refused(r"samples\[0\] is 3", samples=[3])
    refused("frames is 0", grid={BENDING: [1.0]}, frames=0)
    refused("one of cotton, silk", samples=[{"body.cloth.material.preset": "sikl"}, {"body.cloth.material.preset": "slk"}])
    refused("no array `colours`", grid={BENDING: [1.0]}, arrays=["colours"])
    refused("frames is 2.5; a whole number", grid={BENDING: [1.0]}, frames=2.5)
    refused("measure is 5; a function", grid={BENDING: [1.0]}, measure=5)
    refused("a list of names", grid={BENDING: [1.0]}, arrays="positions")
    refused("f16", grid={BENDING: [1e-5]}, options={"precision": "f16"})
    refused("samples are a int", samples=3)
    refused("rest is 0.0 m/s", grid={BENDING: [1.0]}, rest=0.0)
    refused("every is 0", grid={BENDING: [1.0]}, every=0)
    refused("attempts is 0", grid={BENDING: [1.0]}, attempts=0)
    with pytest.raises(taffeta.InputError, match="there is no backend `slurm`"):
        swept(hanging, tmp_path / "other", backend="slurm")


def test_what_is_done_is_not_run_again_and_new_samples_are(hanging: taffeta.Scene, tmp_path: Path) -> None:
    log = tmp_path / "log"
    first = swept(hanging, tmp_path / "out", VALUES[:2], measure=logging_to(log))
    whole = swept(hanging, tmp_path / "out", VALUES, measure=logging_to(log))
    again = swept(hanging, tmp_path / "out", VALUES, measure=logging_to(log))
    ran = log.read_text().splitlines()
    assert len(ran) == len(set(ran)) == len(VALUES)
    assert len(first) == 2
    assert again.table.equals(whole.table)
    assert taffeta.sweeps.Sweep(tmp_path / "out").table.equals(whole.table)


def test_what_failed_is_run_again_where_that_is_asked_for(hanging: taffeta.Scene, tmp_path: Path) -> None:
    marker = tmp_path / "full"
    marker.touch()

    def measure(_simulation: taffeta.Simulation) -> dict[str, Any]:
        if marker.exists():
            raise MemoryError("no room")
        return {"there": True}

    assert swept(hanging, tmp_path / "out", [1e-5], measure=measure).failed == 1
    marker.unlink()
    assert swept(hanging, tmp_path / "out", [1e-5], measure=measure).failed == 1
    assert swept(hanging, tmp_path / "out", [1e-5], measure=measure, retry_failed=True).failed == 0


def test_a_folder_is_of_one_experiment(hanging: taffeta.Scene, tmp_path: Path) -> None:
    swept(hanging, tmp_path / "out", [1e-5])
    with pytest.raises(taffeta.InputError, match="`frames` was 5 and is now 6"):
        swept(hanging, tmp_path / "out", [1e-5], frames=6)
    with pytest.raises(taffeta.InputError, match="`scene` was"):
        swept(hanging.copy().world(drag=0.5), tmp_path / "out", [1e-5])
    with pytest.raises(taffeta.InputError, match="`options` was"):
        swept(hanging, tmp_path / "out", [1e-5], options={"precision": "f64"})
    (tmp_path / "out" / "manifest.json").write_text("{")
    with pytest.raises(taffeta.InputError, match="it is damaged"):
        swept(hanging, tmp_path / "out", [1e-5])


def test_a_mesh_that_changed_is_another_experiment(tmp_path: Path) -> None:
    def scene(height: float) -> taffeta.Scene:
        vertices = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, height, 1.0]])
        return taffeta.Scene().mesh("patch", vertices, [[0, 2, 1], [1, 2, 3]], mass=0.1).time(frames=2)

    grid = {"world.drag": [0.0]}
    taffeta.sweep(scene(0.0), grid=grid, out=tmp_path / "out", jobs=1, progress=False)
    taffeta.sweep(scene(0.0), grid=grid, out=tmp_path / "out", jobs=1, progress=False)
    with pytest.raises(taffeta.InputError, match="`scene` was"):
        taffeta.sweep(scene(0.1), grid=grid, out=tmp_path / "out", jobs=1, progress=False)


def test_a_function_that_measures_something_else_is_another_experiment(hanging: taffeta.Scene, tmp_path: Path) -> None:
    def closure(node: int) -> Measure:
        return lambda simulation: {"height": float(simulation.positions()[node, 1])}

    class Height:
        def __init__(self, node: int) -> None:
            self.node = node

        def __call__(self, simulation: taffeta.Simulation) -> dict[str, Any]:
            return {"height": float(simulation.positions()[self.node, 1])}

    def of_node(simulation: taffeta.Simulation, node: int) -> dict[str, Any]:
        return {"height": float(simulation.positions()[node, 1])}

    makers: list[Callable[[int], Measure]] = [closure, Height, lambda node: functools.partial(of_node, node=node)]
    for number, make in enumerate(makers):
        out = tmp_path / str(number)
        first = swept(hanging, out, [1e-5], measure=make(63))
        assert swept(hanging, out, [1e-5], measure=make(63)).table.equals(first.table)
        with pytest.raises(taffeta.InputError, match="`measure` was"):
            swept(hanging, out, [1e-5], measure=make(60))


def test_a_function_is_the_same_wherever_it_is_written() -> None:
    here = "def measure(simulation):\n    return {'a': helper(simulation)}\ndef helper(simulation):\n    return 1\n"
    identities: list[str | None] = []
    for source in (here, "\n\n" + here, here.replace("1", "2")):
        module: dict[str, Any] = {"__name__": "__main__"}
        exec(source, module)
        identities.append(of_function(module["measure"]))
    assert identities[0] == identities[1] != identities[2]


def test_a_mesh_file_that_changed_is_another_experiment(tmp_path: Path) -> None:
    lines = ["v 0 0 0", "v 1 0 0", "v 0 0 1", "v 1 0 1"]
    (tmp_path / "patch.obj").write_text("\n".join([*lines, "f 1 3 2", "f 2 3 4", ""]))
    scene = taffeta.Scene({"body": [{"mesh": {"file": "patch.obj"}, "mass": 0.1}]}, folder=tmp_path).time(frames=2)
    grid = {"world.drag": [0.0]}
    taffeta.sweep(scene, grid=grid, out=tmp_path / "out", jobs=1, progress=False)
    (tmp_path / "patch.obj").write_text("\n".join([*lines, "f 1 3 4", "f 1 4 2", ""]))
    with pytest.raises(taffeta.InputError, match="`scene` was"):
        taffeta.sweep(scene, grid=grid, out=tmp_path / "out", jobs=1, progress=False)


def test_frames_may_be_part_of_a_sample(hanging: taffeta.Scene, tmp_path: Path) -> None:
    samples = [{"time.frames": 2}, {BENDING: 1e-5}, {"time.frames": 7}]
    found = taffeta.sweep(hanging.set("time.frames", 4), samples=samples, out=tmp_path / "out", jobs=1, progress=False)
    assert found.table.column("frame").to_pylist() == [2, 4, 7]
    with pytest.raises(taffeta.InputError, match="also as `time.frames` of samples"):
        taffeta.sweep(hanging, samples=samples, frames=3, out=tmp_path / "other", progress=False)


@pytest.mark.parametrize(
    ("measured", "message"),
    [
        ({"run": 77}, "measure returned `run`, which is a column"),
        ({BENDING: 77}, f"measure returned `{BENDING}`, which is a column"),
        ({1: 2}, "measure returned 1 for a name"),
        ({"many": 2**70}, "a number of 64 bits would do"),
        ({"turned": 1j}, "is a complex"),
        ([1.0], "measure returned a list"),
    ],
)
def test_what_cannot_be_kept_fails_its_run_alone(
    measured: Any, message: str, hanging: taffeta.Scene, tmp_path: Path
) -> None:
    found = swept(hanging, tmp_path / "out", [1e-5], measure=lambda _: measured)
    assert message in found.table.to_pylist()[0]["message"]


def test_a_measure_that_ends_the_program_ends_its_run_alone(hanging: taffeta.Scene, tmp_path: Path) -> None:
    found = swept(hanging, tmp_path / "out", [1e-5], measure=lambda _: sys.exit(3))
    assert found.table.to_pylist()[0]["error"] == "SystemExit"


def test_lists_without_a_type_in_common_become_text(hanging: taffeta.Scene, tmp_path: Path) -> None:
    found = swept(hanging, tmp_path / "out", [1e-5], measure=lambda _: {"ragged": [1, [2]], "odd": "\ud800"})
    assert (found.done, found.table.to_pylist()[0]["ragged"]) == (1, "[1, [2]]")


def test_arrays_are_found_from_another_folder(
    hanging: taffeta.Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    found = swept(hanging, Path("out"), [1e-5], arrays=["positions"])
    monkeypatch.chdir("/")
    assert found.arrays(0)["positions"].shape == (64, 3)
    [kept] = (tmp_path / "out" / "runs").glob("*.npz")
    kept.unlink()
    monkeypatch.chdir(tmp_path)
    assert swept(hanging, Path("out"), [1e-5], arrays=["positions"]).arrays(0)["positions"].shape == (64, 3)


def test_a_run_whose_file_was_cut_off_is_run_again(hanging: taffeta.Scene, tmp_path: Path) -> None:
    whole = swept(hanging, tmp_path / "out")
    one = next((tmp_path / "out" / "runs").glob("*.json"))
    one.write_bytes(one.read_bytes()[:40])
    (tmp_path / "out" / "runs" / "left.part").write_bytes(b"half")
    assert swept(hanging, tmp_path / "out").table.equals(whole.table)
    assert json.loads(one.read_text())["row"]["status"] == "done"
    assert not list((tmp_path / "out" / "runs").glob("*.part"))


def test_two_sweeps_do_not_write_to_one_folder(hanging: taffeta.Scene, tmp_path: Path) -> None:
    tried: list[int] = []

    def watch(done: int, _failed: int, _all: int) -> None:
        with pytest.raises(taffeta.InputError, match="another sweep is writing"):
            swept(hanging, tmp_path / "out")
        tried.append(done)

    swept(hanging, tmp_path / "out", [1e-5], progress=watch)
    assert tried == [1]


def test_a_sweep_that_is_stopped_has_what_was_done(hanging: taffeta.Scene, tmp_path: Path) -> None:
    def stop(done: int, _failed: int, _all: int) -> None:
        if done == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        swept(hanging, tmp_path / "out", progress=stop)
    before = taffeta.sweeps.Sweep(tmp_path / "out")
    assert before.table.column("status").to_pylist().count("waiting") == 2
    assert swept(hanging, tmp_path / "out").done == 4


def test_the_program_sweeps(hanging: taffeta.Scene, tmp_path: Path) -> None:
    (tmp_path / "flag.toml").write_text(hanging.to_toml())
    command = [sys.executable, "-m", "taffeta", "sweep", "flag.toml", "--jobs", "2", "--grid"]

    def said(*words: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run([*command, *words], cwd=tmp_path, capture_output=True, text=True, env=dict(os.environ))

    ran = said(f"{BENDING}=1e-6:1e-4:log:3", "--grid", "body.cloth.material.preset=silk,denim")
    assert ran.returncode == 0, ran.stderr
    assert "6 runs: 6 done, 0 failed; results are in flag-sweep/results.parquet" in ran.stdout
    assert "sweep: 6 of 6 done" in ran.stderr
    found = taffeta.sweeps.Sweep(tmp_path / "flag-sweep").to_pandas()
    assert found[BENDING].tolist() == [1e-6, 1e-6, 1e-5, 1e-5, 1e-4, 1e-4]
    assert found["body.cloth.material.preset"].tolist() == ["silk", "denim"] * 3
    for words, message in [
        (["world.drag=0:1"], "a range needs a count: 0:1:8"),
        (["world.drag=0,"], "a value between its commas is missing"),
        (["world.drag=0", "--grid", "world.drag=1"], "`world.drag` has values already"),
        (["world.drag=0", "--set", "world.drag=0,1"], "one value would do"),
    ]:
        refused = said(*words)
        assert (refused.returncode, message in refused.stderr) == (2, True), refused.stderr
    wrong = said("nothing")
    assert (wrong.returncode, wrong.stdout) == (2, "")
    assert "PATH=FIRST:LAST:COUNT" in wrong.stderr
    missing = said("world.drag=0,1", "--frames", "0")
    assert (missing.returncode, "frames is 0" in missing.stderr) == (2, True)
