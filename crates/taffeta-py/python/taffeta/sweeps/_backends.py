"""Where runs of a sweep happen: processes of this machine, or a cluster of Ray or Dask."""

from __future__ import annotations

import os
import signal
import threading
import time
from concurrent.futures import Future
from typing import TYPE_CHECKING, Any, Protocol

from taffeta._errors import InputError
from taffeta._packages import package
from taffeta.sweeps import _run

if TYPE_CHECKING:
    from taffeta.sweeps._plan import Sample


class Backend(Protocol):
    """Where runs happen. One can be given to several sweeps, which then share its workers."""

    @property
    def slots(self) -> int:
        """How many runs are given to it at a time."""
        ...

    #: What a future raises whose worker is gone; the run is given out again.
    lost: tuple[type[BaseException], ...]

    def submit(self, packed: bytes, sample: Sample) -> Future[_run.Outcome]:
        """Gives out a run. There are never more than ``slots`` of them."""
        ...

    def close(self) -> None:
        """Ends its workers, also those that are at work."""
        ...


class Local:
    """Processes of this machine.

    Each is a pool of its own, so that one that is killed takes no other with it, and is known as the one that ran the sample.

    Args:
        jobs: How many; as many as this process may use cores, if it is not given.
    """

    def __init__(self, jobs: int | None = None) -> None:
        if jobs is not None and jobs not in range(1, 1025):
            raise InputError(f"jobs is {jobs}; a whole number from 1 to 1024 would do")
        loky = package("loky")
        self.lost: tuple[type[BaseException], ...] = (loky.process_executor.BrokenProcessPool,)
        self.slots: int = jobs or loky.cpu_count()
        self._pools: list[Any] = [_pool() for _ in range(self.slots)]
        self._given: list[Future[_run.Outcome] | None] = [None] * self.slots

    def submit(self, packed: bytes, sample: Sample) -> Future[_run.Outcome]:
        """Gives a run to a process that has none."""
        slot = next(slot for slot, given in enumerate(self._given) if given is None or given.done())
        try:
            given: Future[_run.Outcome] = self._pools[slot].submit(_run.execute, packed, sample)
        except self.lost:
            # It was killed since its last run.
            self._pools[slot].shutdown(kill_workers=True)
            self._pools[slot] = _pool()
            given = self._pools[slot].submit(_run.execute, packed, sample)
        self._given[slot] = given
        return given

    def close(self) -> None:
        """Ends the processes."""
        for pool in self._pools:
            pool.shutdown(kill_workers=True)


def _pool() -> Any:
    return package("loky").ProcessPoolExecutor(max_workers=1, initializer=_begin, initargs=(os.getpid(),))


def _begin(parent: int) -> None:
    """What a process does first: Ctrl-C is for the one that gave it work, and it ends where that one is gone."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with, args=(parent,), daemon=True).start()


def _end_with(parent: int) -> None:
    while os.getppid() == parent:
        time.sleep(0.2)
    os._exit(1)


class Ray:
    """A cluster of Ray. It needs ``pip install ray``, and taffeta on every node.

    Args:
        address: Of the cluster; if it is not given, the one in use, or else one is started on this machine.
        jobs: Cores of the one that is started.
    """

    def __init__(self, address: str | None = None, jobs: int | None = None) -> None:
        ray = self._ray = package("ray")
        errors = package("ray.exceptions")
        self.lost: tuple[type[BaseException], ...] = (
            errors.WorkerCrashedError,
            errors.NodeDiedError,
            errors.ObjectLostError,
            errors.OutOfMemoryError,
            errors.LocalRayletDiedError,
        )
        self._is_own = not ray.is_initialized()
        if address is not None and not self._is_own:
            raise InputError(f"{address}: this program is in a cluster of Ray already; ray.shutdown() leaves it")
        if self._is_own:
            cores = {} if address or "RAY_ADDRESS" in os.environ else {"num_cpus": jobs}
            ray.init(address=address, include_dashboard=False, log_to_driver=False, **cores)
        # A run that was lost is given out again by the sweep, which counts how often.
        self._execute: Any = ray.remote(max_retries=0, num_cpus=1)(_run.execute)
        self._stored: tuple[bytes, Any] | None = None

    @property
    def slots(self) -> int:
        """Twice the cores of the cluster as it is now: the next run of a core waits beside it."""
        return max(2, 2 * int(self._ray.cluster_resources().get("CPU", 1)))

    def submit(self, packed: bytes, sample: Sample) -> Future[_run.Outcome]:
        """Gives a run to the cluster."""
        if self._stored is None or self._stored[0] is not packed:
            self._stored = (packed, self._ray.put(packed))
        future: Future[_run.Outcome] = self._execute.remote(self._stored[1], sample).future()
        return future

    def close(self) -> None:
        """Leaves the cluster; one that was started for the sweep ends."""
        if self._is_own:
            self._ray.shutdown()


class Dask:
    """A cluster of Dask. It needs ``pip install distributed``, and taffeta on every worker.

    Args:
        address: Of its scheduler; if it is not given, workers are started on this machine.
        jobs: How many of those.
    """

    def __init__(self, address: str | None = None, jobs: int | None = None) -> None:
        distributed = package("distributed")
        made: Any = None
        if address is None:
            made = distributed.LocalCluster(n_workers=jobs, threads_per_worker=1, processes=True, dashboard_address=None)
        self._cluster = made
        try:
            self._client: Any = distributed.Client(made if made is not None else address)
        except (OSError, TimeoutError) as error:
            raise InputError(f"{address}: no scheduler of Dask answers there ({_short(error)})") from None
        self._executor: Any = self._client.get_executor(pure=False)
        self.lost: tuple[type[BaseException], ...] = (distributed.scheduler.KilledWorker, OSError)

    @property
    def slots(self) -> int:
        """The threads of the workers as they are now: what waits beside a run would be lost with its worker."""
        threads: dict[str, int] = self._client.nthreads()
        return max(1, sum(threads.values()))

    def submit(self, packed: bytes, sample: Sample) -> Future[_run.Outcome]:
        """Gives a run to the cluster."""
        future: Future[_run.Outcome] = self._executor.submit(_run.execute, packed, sample)
        return future

    def close(self) -> None:
        """Leaves the cluster; one that was started for the sweep ends."""
        self._executor.shutdown(wait=False)
        self._client.close()
        if self._cluster is not None:
            self._cluster.close()


NAMES = ("local", "ray", "dask")


def refuse_unknown(backend: str | Backend) -> None:
    """Refuses a name that is none."""
    if isinstance(backend, str) and backend not in NAMES:
        raise InputError(f"there is no backend `{backend}`; there are: {', '.join(NAMES)}")


def _short(error: BaseException) -> str:
    return next(iter(str(error).splitlines()), type(error).__name__).strip()


def named(backend: str | Backend, jobs: int | None) -> tuple[Backend, bool]:
    """A backend by its name, and whether it is the sweep's own to close."""
    if not isinstance(backend, str):
        if jobs is not None:
            raise InputError("jobs are of a backend that is named; this one has its own")
        return backend, False
    if backend == "local":
        return Local(jobs), True
    if backend == "ray":
        return Ray(jobs=jobs), True
    refuse_unknown(backend)
    return Dask(jobs=jobs), True
