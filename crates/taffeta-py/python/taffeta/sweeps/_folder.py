"""The folder of a sweep: what ran, what each run left, and the table of all."""

from __future__ import annotations

import hashlib
import json
import os
import zipfile
from collections.abc import Callable, Generator
from contextlib import contextmanager
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

import numpy as np

from taffeta._errors import InputError
from taffeta._kinds import is_mapping
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
        # Absolute: programs change their folder.
        self.path = path.absolute()
        self._runs = self.path / "runs"

    @contextmanager
    def taken(self, experiment: dict[str, Any]) -> Generator[None]:
        """Has the folder to itself. It is made, or is one of the same experiment."""
        try:
            self._runs.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise InputError(f"{self.path}: {error.strerror}") from error
        with locked(self.path, "sweep"):
            self._refuse_another(experiment)
            for left in (*self.path.glob("*.part"), *self._runs.glob("*.part")):
                left.unlink()
            yield

    def _refuse_another(self, experiment: dict[str, Any]) -> None:
        before = self.read_manifest().get("experiment")
        if before is None:
            return
        differs = [name for name in experiment if experiment[name] != before.get(name)]
        if differs:
            name = differs[0]
            was, now = _short(before.get(name)), _short(experiment[name])
            what = f"`{name}` was {was} and is now {now}"
            raise InputError(f"{self.path} holds another sweep: {what}; choose another folder, or remove this one")

    def read_manifest(self) -> dict[str, Any]:
        """The manifest; nothing, if there is none."""
        try:
            content: Any = json.loads((self.path / MANIFEST).read_text())
        except FileNotFoundError:
            return {}
        except ValueError:
            content = None
        if is_mapping(content) and is_mapping(content.get("experiment")):
            return dict(content)
        raise InputError(f"{self.path / MANIFEST}: it is damaged; another folder would do")

    def manifest(self, content: dict[str, Any]) -> None:
        """Writes the manifest."""
        _write(self.path / MANIFEST, lambda file: file.write(json.dumps(content, indent=2).encode()))

    def done(self, keys: list[str], experiment: dict[str, Any]) -> dict[str, dict[str, Any]]:
        """The rows of those that have run to their end."""
        wanted = _name(experiment)
        rows = {key: self._row(key, wanted) for key in keys}
        return {key: row for key, row in rows.items() if row is not None}

    def _row(self, key: str, experiment: str) -> dict[str, Any] | None:
        try:
            run: Any = json.loads((self._runs / f"{key}.json").read_text())
        except (OSError, ValueError):
            return None
        if not is_mapping(run) or run.get("experiment") != experiment or not is_mapping(run.get("row")):
            return None
        row: dict[str, Any] = dict(run["row"])
        is_whole = row.get("status") in ("done", "failed")
        return row if is_whole and (not run.get("arrays") or (self._runs / f"{key}.npz").is_file()) else None

    def keep(self, key: str, sample: dict[str, Any], outcome: Outcome, experiment: dict[str, Any]) -> None:
        """Keeps a run. Its row is written last: where that is, the arrays are."""
        if outcome.arrays:
            arrays: dict[str, Any] = dict(outcome.arrays)
            _write(self._runs / f"{key}.npz", lambda file: np.savez(file, **arrays))
        how = {"seconds": round(outcome.seconds, 6), "host": outcome.host, "process": outcome.process}
        about = {"experiment": _name(experiment), "arrays": list(outcome.arrays), "detail": outcome.detail}
        content = {"sample": sample, "row": outcome.row, **how, **about}
        _write(self._runs / f"{key}.json", lambda file: file.write(json.dumps(content).encode()))

    def arrays(self, key: str) -> dict[str, NDArray[Any]]:
        """The arrays of a run; none, if it kept none."""
        path = self._runs / f"{key}.npz"
        if not path.exists():
            return {}
        try:
            with np.load(path) as file:
                return dict(file)
        except (OSError, ValueError, zipfile.BadZipFile) as error:
            raise InputError(f"{path}: it is damaged ({error}); remove it, and call the sweep again") from None

    def results(self, table: Any) -> None:
        """Writes the table."""
        _write(self.path / RESULTS, lambda file: package("pyarrow.parquet").write_table(table, file))

    def read_results(self) -> Any:
        """The table as it was written last."""
        try:
            return package("pyarrow.parquet").read_table(self.path / RESULTS, partitioning=None)
        except FileNotFoundError:
            raise InputError(f"{self.path} is no folder of a sweep: it has no {RESULTS}") from None
        except Exception as error:
            raise InputError(f"{self.path / RESULTS}: it is damaged ({error}); call the sweep again") from None


@contextmanager
def locked(path: Path, what: str) -> Generator[None]:
    """Has a folder to itself, which is there."""
    filelock = package("filelock")
    lock = filelock.FileLock(path / ".lock", timeout=0)
    try:
        lock.acquire()
    except filelock.Timeout:
        raise InputError(f"{path}: another {what} is writing to it") from None
    try:
        yield
    finally:
        lock.release()


def _name(experiment: dict[str, Any]) -> str:
    """A short name of what must be the same for runs to belong together."""
    return hashlib.sha256(json.dumps(experiment, sort_keys=True).encode()).hexdigest()[:16]


def _write(path: Path, write: Callable[[IO[bytes]], Any]) -> None:
    """Writes a file that is there as a whole or not at all, also where the power fails."""
    part = path.with_name(f"{path.name}.{os.getpid()}.part")
    try:
        with part.open("wb") as file:
            write(file)
            file.flush()
            os.fsync(file.fileno())
        os.replace(part, path)
    except BaseException:
        part.unlink(missing_ok=True)
        raise


def _short(value: Any) -> str:
    text = json.dumps(value)
    return text if len(text) <= 80 else f"{text[:77]}…"
