"""The zip as Blender takes it."""

import os
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import bpy


def test_blenders_own_validator_accepts_the_zip():
    program = Path(bpy.__file__).parents[2] / "addons_core/bl_pkg/cli/blender_ext.py"
    if not program.exists():
        program = next(Path(bpy.__file__).parent.rglob("bl_pkg/cli/blender_ext.py"))
    said = subprocess.run([sys.executable, program, "validate", os.environ["TAFFETA_ZIP"]], capture_output=True, text=True, check=False)
    assert said.returncode == 0, said.stdout + said.stderr


def test_the_zip_has_the_wheel_that_its_manifest_names_and_no_more():
    with zipfile.ZipFile(os.environ["TAFFETA_ZIP"]) as archive:
        manifest = tomllib.loads(archive.read("blender_manifest.toml").decode())
        names = archive.namelist()
    assert [f"./{name}" for name in names if name.endswith(".whl")] == manifest["wheels"]
    assert {"__init__.py", "worker.py", "LICENSE-MIT", "LICENSE-APACHE"} <= set(names)
    assert not [name for name in names if "test" in name or name.endswith(".pyc")]


def test_the_extension_says_nothing_wrong_of_itself():
    """All classes are named as Blender wants them, and all operators have words for their tooltips."""
    for name in dir(bpy.ops.taffeta):
        kind = getattr(bpy.types, f"TAFFETA_OT_{name}")
        assert kind.bl_label and kind.__doc__, name
        assert not kind.__doc__.endswith("."), "Blender ends tooltips itself"
