"""Threads, and Ctrl-C."""

from __future__ import annotations

import os
import signal
import threading
import time

import numpy as np
import pytest
import taffeta


def interrupt_after(seconds: float) -> threading.Timer:
    timer = threading.Timer(seconds, os.kill, (os.getpid(), signal.SIGINT))
    timer.start()
    return timer


@pytest.mark.parametrize("rows", [8, 32])
def test_ctrl_c_leaves_the_last_whole_frame(rows: int) -> None:
    scene = taffeta.Scene().solver("ice", form="primal")
    scene.grid("cloth", rows=rows, cols=rows, size=(1, 1), material="cotton").pin("cloth", rows=0)
    simulation = taffeta.Simulation(scene, threads=1)
    timer = interrupt_after(0.2)
    start = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        simulation.step(100_000_000)
    assert time.monotonic() - start < 5.0
    timer.join()
    frame = simulation.frame
    assert frame > 0
    twin = taffeta.Simulation(scene, threads=1)
    twin.step(frame)
    assert twin.state_hash() == simulation.state_hash()
    simulation.step(2)
    twin.step(2)
    assert twin.state_hash() == simulation.state_hash()


def test_ctrl_c_stops_a_long_frame_on_its_way() -> None:
    # A frame of ten thousand sub-steps takes some seconds.
    scene = taffeta.Scene().time(dt=1.0, max_step=1e-4)
    springs = {kind: {"k": 100.0, "d": 0.01} for kind in ("structural", "shear", "bend")}
    scene.grid("cloth", rows=200, cols=200, size=(1, 1), node_mass=1e-2, springs=springs).pin("cloth", rows=0)
    simulation = taffeta.Simulation(scene, threads=1)
    before = simulation.state_hash()
    timer = interrupt_after(0.2)
    start = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        simulation.step()
    took = time.monotonic() - start
    timer.join()
    assert took < 1.0, f"{took} s"
    assert simulation.frame == 0
    assert simulation.state_hash() == before


def test_other_threads_of_python_run_while_frames_do() -> None:
    scene = taffeta.Scene().solver("ice", form="primal")
    scene.grid("cloth", rows=32, cols=32, size=(1, 1), material="cotton").pin("cloth", rows=0)
    simulation = taffeta.Simulation(scene, threads=1)
    done = threading.Event()

    def run() -> None:
        simulation.step(60)
        done.set()

    thread = threading.Thread(target=run)
    thread.start()
    looks = 0
    while not done.is_set():
        looks += 1
        time.sleep(0.001)
    thread.join()
    assert looks > 20


def test_two_simulations_run_in_two_threads_and_one_is_shared(cloth: taffeta.Scene) -> None:
    alone = taffeta.Simulation(cloth, threads=1)
    alone.step(40)
    both = [taffeta.Simulation(cloth, threads=2) for _ in range(2)]
    shared = taffeta.Simulation(cloth, threads=1)
    out = np.zeros((64, 3), np.float32)

    def run(simulation: taffeta.Simulation) -> None:
        for _ in range(40):
            simulation.step()
            simulation.positions(out=np.zeros_like(out))
            with_other = shared.snapshot()
            shared.step()
            shared.restore(with_other)
            simulation.adopt_state(simulation)

    threads = [threading.Thread(target=run, args=(one,), daemon=True) for one in both]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(timeout=60.0)
        assert not thread.is_alive(), "they wait for each other"
    assert {one.state_hash() for one in both} == {alone.state_hash()}


def test_a_handler_of_signals_may_use_the_simulation_that_runs(cloth: taffeta.Scene) -> None:
    simulation = taffeta.Simulation(cloth, threads=1)
    seen: list[int] = []

    def handle(*_: object) -> None:
        simulation.positions()
        seen.append(simulation.frame)
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGINT, handle)
    try:
        timer = interrupt_after(0.1)
        with pytest.raises(KeyboardInterrupt):
            simulation.step(100_000_000)
        timer.join()
    finally:
        signal.signal(signal.SIGINT, before)
    assert seen == [simulation.frame]
