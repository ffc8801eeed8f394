"""Sweeps whose driver, workers or nodes are killed: nothing is lost, and nothing runs again that was done.

TAFFETA_KILLS is how often each is tried, each time at another moment.
"""

from __future__ import annotations

import importlib.util
import json
import os
import random
import signal
import subprocess
import sys
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
import taffeta
import taffeta.sweeps

pytest.importorskip("pyarrow")

ROUNDS = range(int(os.environ.get("TAFFETA_KILLS", "1")))
DENSITY = "body.cloth.material.density"
VALUES = [index / 64 for index in range(4, 16)]
needs_ray = pytest.mark.skipif(importlib.util.find_spec("ray") is None, reason="Ray is not installed")
needs_dask = pytest.mark.skipif(importlib.util.find_spec("distributed") is None, reason="Dask is not installed")

#: A sweep as a program of its own.
DRIVER = """
import sys
import taffeta
from pathlib import Path

out, log = Path(sys.argv[1]), Path(sys.argv[2])
scene = taffeta.Scene().solver("ice", form="primal").time(frames=60)
scene = scene.grid("cloth", rows=16, cols=16, size=(1.0, 1.0), material="cotton").pin("cloth", rows=0)

def measure(simulation):
    with log.open("a") as file:
        file.write(f"{simulation.scene.overrides[-1]}\\n")
    return {}

def watch(done, failed, everything):
    print(done, flush=True)

taffeta.sweep(scene, grid={"body.cloth.material.density": [index / 64 for index in range(4, 16)]}, out=out, measure=measure, jobs=2, progress=watch)
"""


def scene_of_a_while() -> taffeta.Scene:
    """A cloth that takes a fraction of a second."""
    scene = taffeta.Scene().solver("ice", form="primal").time(frames=60)
    return scene.grid("cloth", rows=16, cols=16, size=(1.0, 1.0), material="cotton").pin("cloth", rows=0)


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a sweep that nothing happened to."""
    out = tmp_path_factory.mktemp("undisturbed") / "out"
    found = taffeta.sweep(scene_of_a_while(), grid={DENSITY: VALUES}, out=out, jobs=2, progress=False)
    assert found.done == len(VALUES)
    return out


@pytest.fixture(scope="module")
def cluster() -> Iterator[Any]:
    """Two nodes of Ray on this machine, one of which may be killed."""
    ray: Any = pytest.importorskip("ray")
    from ray.cluster_utils import Cluster

    made: Any = Cluster(initialize_head=True, head_node_args={"num_cpus": 1, "include_dashboard": False})
    ray.init(address=made.address, log_to_driver=False)
    yield made
    ray.shutdown()
    made.shutdown()


@pytest.fixture
def backend(request: pytest.FixtureRequest) -> str:
    """The name of a backend, with what it needs."""
    name: str = request.param
    if name == "ray":
        second_node(request.getfixturevalue("cluster"))
    return name


def second_node(cluster: Any) -> Any:
    """The node beside the head; one that was killed is replaced."""
    there = [node for node in cluster.worker_nodes if node.any_processes_alive()]
    return there[0] if there else cluster.add_node(num_cpus=1)


on_backends = pytest.mark.parametrize(
    "backend", ["local", pytest.param("ray", marks=needs_ray), pytest.param("dask", marks=needs_dask)], indirect=True
)


def rows(folder: Path) -> list[dict[str, Any]]:
    """The table."""
    found: list[dict[str, Any]] = taffeta.sweeps.Sweep(folder).table.to_pylist()
    return found


def done_in(folder: Path) -> list[str]:
    """What has been kept, as the log has it."""
    runs = [json.loads(path.read_text()) for path in (folder / "runs").glob("*.json")]
    return [scene_of_a_while().set(DENSITY, run["sample"][DENSITY]).overrides[0] for run in runs]


@pytest.mark.parametrize("turn", ROUNDS)
def test_a_killed_driver_loses_nothing(turn: int, undisturbed: Path, tmp_path: Path) -> None:
    out, log = tmp_path / "out", tmp_path / "log"
    program = tmp_path / "driver.py"
    program.write_text(DRIVER)
    command = [sys.executable, str(program), str(out), str(log)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as driver:
        assert driver.stdout is not None
        for _ in range(random.Random(turn).randint(1, 10)):
            driver.stdout.readline()
        driver.kill()
    before = done_in(out)
    assert 0 < len(before) < len(VALUES)
    # It may find that the workers of the first are not gone yet: nothing that they do counts any more.
    again = subprocess.run(command, capture_output=True, text=True)
    assert again.returncode == 0, again.stderr
    assert rows(out) == rows(undisturbed)
    times = Counter(log.read_text().splitlines())
    assert all(times[density] == 1 for density in before)
    assert len(times) == len(VALUES)


def killing_once(folder: Path, rate: float, turn: int) -> Callable[[taffeta.Simulation], dict[str, Any]]:
    """Kills its own process for some samples, once each."""

    def measure(simulation: taffeta.Simulation) -> dict[str, Any]:
        density = simulation.scene.overrides[-1]
        if random.Random(f"{turn}{density}").random() < rate:
            try:
                (folder / density).touch(exist_ok=False)
            except FileExistsError:
                pass
            else:
                os.kill(os.getpid(), signal.SIGKILL)
        with (folder / "log").open("a") as file:
            file.write(f"{density}\n")
        return {}

    return measure


@pytest.mark.parametrize("turn", ROUNDS)
@on_backends
def test_killed_workers_lose_nothing(backend: str, turn: int, undisturbed: Path, tmp_path: Path) -> None:
    measure = killing_once(tmp_path, 0.3, turn)
    scene, grid = scene_of_a_while(), {DENSITY: VALUES}
    taffeta.sweep(scene, grid=grid, out=tmp_path / "out", measure=measure, backend=backend, jobs=2, progress=False)
    assert rows(tmp_path / "out") == rows(undisturbed)
    times = Counter((tmp_path / "log").read_text().splitlines())
    # A worker of Dask that is killed takes results with it that were not fetched yet.
    assert set(times.values()) == {1} or backend == "dask"
    assert len(times) == len(VALUES)


def test_a_sample_that_kills_every_worker_is_a_row_and_takes_no_other_with_it(tmp_path: Path) -> None:
    def measure(simulation: taffeta.Simulation) -> dict[str, Any]:
        if simulation.scene.overrides[-1].endswith("=0.125"):
            os.kill(os.getpid(), signal.SIGKILL)
        return {}

    scene = scene_of_a_while()
    found = taffeta.sweep(
        scene, grid={DENSITY: VALUES[3:6]}, out=tmp_path / "out", frames=2, measure=measure, jobs=2, progress=False
    )
    assert found.table.column("status").to_pylist() == ["done", "failed", "done"]
    row = found.table.to_pylist()[1]
    assert row["error"] == "WorkerLost"
    assert row["message"].startswith("its worker was lost 3 times")


@on_backends
def test_results_are_the_same_bytes_on_every_backend(backend: str, undisturbed: Path, tmp_path: Path) -> None:
    scene = scene_of_a_while()
    taffeta.sweep(scene, grid={DENSITY: VALUES}, out=tmp_path / "out", backend=backend, jobs=2, progress=False)
    written = [(folder / "results.parquet").read_bytes() for folder in (tmp_path / "out", undisturbed)]
    assert written[0] == written[1]


@needs_ray
@pytest.mark.parametrize("turn", ROUNDS)
def test_a_killed_node_loses_nothing(turn: int, cluster: Any, undisturbed: Path, tmp_path: Path) -> None:
    out, log = tmp_path / "out", tmp_path / "log"
    node = second_node(cluster)
    last = random.Random(turn).randint(1, 8)
    before: list[str] = []

    def watch(done: int, _failed: int, _all: int) -> None:
        if done == last:
            before.extend(done_in(out))
            cluster.remove_node(node, allow_graceful=False)

    def measure(simulation: taffeta.Simulation) -> dict[str, Any]:
        with log.open("a") as file:
            file.write(f"{simulation.scene.overrides[-1]}\n")
        return {}

    scene = scene_of_a_while()
    taffeta.sweep(scene, grid={DENSITY: VALUES}, out=out, measure=measure, backend="ray", progress=watch)
    assert rows(out) == rows(undisturbed)
    times = Counter(log.read_text().splitlines())
    assert len(before) == last
    assert all(times[density] == 1 for density in before)
    assert len(times) == len(VALUES)
