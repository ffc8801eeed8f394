"""What is written: examples run, and types are those of the module."""

from __future__ import annotations

import doctest
import importlib
import importlib.util
import inspect
import json
import os
import re
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import pytest
import taffeta
from conftest import ROOT

PACKAGE = Path(__file__).resolve().parents[1]
EXAMPLES = [str(path) for path in sorted((ROOT / "examples/towel").glob("*.py"))]
OPTIONS = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
MODULES = (
    "taffeta",
    "taffeta._native",
    "taffeta._scene",
    "taffeta._pose",
    "taffeta._reports",
    "taffeta.sweeps",
    "taffeta.sweeps._plan",
    "taffeta.sweeps._progress",
    "taffeta.fitting._confidence",
)
PAGES = ("README.md", "docs/python.md", "docs/sweeps.md", "docs/fitting.md", "crates/taffeta-py/README.md")


@pytest.mark.parametrize("name", MODULES)
def test_examples_of_the_package_run(name: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    pytest.importorskip("pandas")
    pytest.importorskip("pyarrow")
    monkeypatch.chdir(tmp_path)
    module = importlib.import_module(name)
    run = attempted = 0
    finder = doctest.DocTestFinder()
    runner = doctest.DocTestRunner(optionflags=OPTIONS)
    for thing in examples(module):
        for test in finder.find(thing, thing.__name__, module=False, globs={**vars(module)}):  # type: ignore[attr-defined, arg-type]
            failed, tried = runner.run(test)
            run, attempted = run + failed, attempted + tried
    assert run == 0
    assert attempted > 0


def examples(module: ModuleType) -> list[object]:
    """The module alone, or what it defines."""
    if module.__name__ in ("taffeta", "taffeta.sweeps"):
        return [module]
    own = [thing for thing in vars(module).values() if inspect.isclass(thing) or inspect.isroutine(thing)]
    return [thing for thing in own if getattr(thing, "__module__", "") in (module.__name__, "taffeta")] or [module]


@pytest.mark.parametrize("page", PAGES)
def test_examples_of_the_pages_run(page: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    text = (ROOT / page).read_text()
    blocks = [block for block in re.findall(r"^```python\n(.*?)^```$", text, re.S | re.M) if ">>>" in block]
    assert blocks, "it has some"
    # As where the repository is, with a folder of one's own to write to.
    (tmp_path / "scenes").symlink_to(ROOT / "scenes")
    monkeypatch.chdir(tmp_path)
    source = "\n".join(blocks)
    test = doctest.DocTestParser().get_doctest(source, {}, page, page, 0)
    runner = doctest.DocTestRunner(optionflags=OPTIONS)
    assert runner.run(test).failed == 0


def test_the_notebook_was_run_and_runs() -> None:
    text = (ROOT / "examples/first_steps.ipynb").read_text()
    cells = [cell for cell in json.loads(text)["cells"] if cell["cell_type"] == "code"]
    assert [cell["execution_count"] for cell in cells] == list(range(1, len(cells) + 1))
    assert not any(output["output_type"] in ("error", "stream") for cell in cells for output in cell["outputs"])
    assert len(text) < 300_000
    pytest.importorskip("pandas")
    pytest.importorskip("matplotlib").use("Agg")
    names: dict[str, object] = {}
    for cell in cells:
        exec("".join(cell["source"]).replace("%matplotlib inline", ""), names)


def test_everything_public_is_documented() -> None:
    for name in taffeta.__all__:
        thing = getattr(taffeta, name)
        if not inspect.isclass(thing):
            continue
        assert inspect.getdoc(thing), name
        for member, value in vars(thing).items():
            if not member.startswith("_") and callable(value):
                assert inspect.getdoc(value), f"{name}.{member}"


def test_the_stub_is_as_it_is_written_from_the_module_and_names_all_of_it() -> None:
    command = [sys.executable, str(PACKAGE / "write_stub.py"), "--check"]
    said = subprocess.run(command, capture_output=True, text=True)
    assert said.returncode == 0, said.stderr
    from taffeta import _native

    stub = (PACKAGE / "python/taffeta/_native.pyi").read_text()
    for kind in (_native.Simulation, _native.Body, _native.Collider, _native):
        for name in vars(kind):
            if not name.startswith("_"):
                assert re.search(rf"(def|class) {name}\b", stub), name
    for name, method in vars(_native.Simulation).items():
        if inspect.isroutine(method) and not name.startswith("_"):
            [*of_module] = inspect.signature(method).parameters
            of_stub = re.search(rf"def {name}\((.*?)\) ->", stub, re.S)
            assert of_stub is not None
            written = re.findall(r"(?:^|, )\*{0,2}([a-z_]+)(?=[:,)]|$)", of_stub[1])
            assert written == of_module, name


def checked(command: list[str]) -> None:
    said = subprocess.run(command, capture_output=True, text=True, cwd=PACKAGE, env=dict(os.environ))
    assert said.returncode == 0, said.stdout + said.stderr


def test_mypy_has_nothing_to_say() -> None:
    pytest.importorskip("mypy")
    checked([sys.executable, "-m", "mypy", "python/taffeta", "write_stub.py", "tests/typed.py"])
    if importlib.util.find_spec("gymnasium") is not None:
        checked([sys.executable, "-m", "mypy", *EXAMPLES])


def test_pyright_has_nothing_to_say() -> None:
    pytest.importorskip("pyright")
    examples = EXAMPLES if importlib.util.find_spec("gymnasium") is not None else []
    paths = ["python/taffeta", "tests/typed.py", *examples]
    checked([sys.executable, "-m", "pyright", "--pythonpath", sys.executable, *paths])
