"""The folder of a sweep: what ran, what each run left, and the table of all."""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Callable, Generator
from contextlib import contextmanager
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

import numpy as np

from taffeta._errors import InputError
from taffeta._packages import package

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from taffeta.sweeps._run import Outcome

MANIFEST = "manifest.json"
RESULTS = "results.parquet"


class Folder:
    """Runs by their keys. What is kept is whole: a run that was cut off is not there.

    ```text
    manifest.json     what ran: scene, options, versions
    results.parquet   a row a run, in the order of the samples
    runs/KEY.json     the row of a run, and how it ran
    runs/KEY.npz      its arrays
    ```
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._runs = path / "runs"

    @contextmanager
    def taken(self, experiment: dict[str, Any]) -> Generator[None]:
        """Has the folder to itself. It is made, or is one of the same experiment."""
        filelock = package("filelock")
        try:
            self._runs.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise InputError(f"{self.path}: {error.strerror}") from error
        lock = filelock.FileLock(self.path / ".lock", timeout=0)
        try:
            lock.acquire()
        except filelock.Timeout:
            raise InputError(f"{self.path}: another sweep is writing to it") from None
        try:
            self._refuse_another(experiment)
            for left in self._runs.glob("*.part"):
                left.unlink()
            yield
        finally:
            lock.release()

    def _refuse_another(self, experiment: dict[str, Any]) -> None:
        try:
            before = json.loads((self.path / MANIFEST).read_text())["experiment"]
        except FileNotFoundError:
            return
        except (ValueError, KeyError, TypeError):
            raise InputError(f"{self.path / MANIFEST}: it is damaged; another folder would do") from None
        differs = [name for name in experiment if experiment[name] != before.get(name)]
        if differs:
            name = differs[0]
            was, now = _short(before.get(name)), _short(experiment[name])
            what = f"its {name} was {was}, and is {now}; another folder would do, or remove this one"
            raise InputError(f"{self.path}: it is of another sweep: {what}")

    def manifest(self, content: dict[str, Any]) -> None:
        """Writes the manifest."""
        _write(self.path / MANIFEST, lambda file: file.write(json.dumps(content, indent=2).encode()))

    def done(self, keys: list[str]) -> dict[str, dict[str, Any]]:
        """The rows of those that have run to their end."""
        rows = {key: self._row(key) for key in keys}
        return {key: row for key, row in rows.items() if row is not None}

    def _row(self, key: str) -> dict[str, Any] | None:
        try:
            row: dict[str, Any] = json.loads((self._runs / f"{key}.json").read_text())["row"]
        except (FileNotFoundError, ValueError, KeyError, TypeError):
            return None
        return row

    def keep(self, key: str, sample: dict[str, Any], outcome: Outcome) -> None:
        """Keeps a run. Its row is written last: where that is, the arrays are."""
        if outcome.arrays:
            arrays: dict[str, Any] = dict(outcome.arrays)
            _write(self._runs / f"{key}.npz", lambda file: np.savez(file, **arrays))
        how = {"seconds": round(outcome.seconds, 6), "host": outcome.host, "process": outcome.process}
        content = {"sample": sample, "row": outcome.row, **how}
        _write(self._runs / f"{key}.json", lambda file: file.write(json.dumps(content).encode()))

    def arrays(self, key: str) -> dict[str, NDArray[Any]]:
        """The arrays of a run."""
        try:
            with np.load(self._runs / f"{key}.npz") as file:
                return dict(file)
        except FileNotFoundError:
            return {}

    def results(self, table: Any) -> None:
        """Writes the table."""
        _write(self.path / RESULTS, lambda file: package("pyarrow.parquet").write_table(table, file))

    def read_results(self) -> Any:
        """The table as it was written last."""
        try:
            return package("pyarrow.parquet").read_table(self.path / RESULTS, partitioning=None)
        except FileNotFoundError:
            raise InputError(f"{self.path}: it has no {RESULTS}, so it is no folder of a sweep") from None


def _write(path: Path, write: Callable[[IO[bytes]], Any]) -> None:
    """Writes a file that is there as a whole or not at all, also where the power fails."""
    handle, part = tempfile.mkstemp(dir=path.parent, suffix=".part")
    try:
        with os.fdopen(handle, "wb") as file:
            write(file)
            file.flush()
            os.fsync(file.fileno())
        os.replace(part, path)
    except BaseException:
        Path(part).unlink(missing_ok=True)
        raise


def _short(value: Any) -> str:
    text = json.dumps(value)
    return text if len(text) <= 80 else f"{text[:77]}…"
