"""Packs the extension with a wheel of taffeta inside: `python pack.py WHEEL FOLDER` prints the zip that it has made."""

import re
import sys
import zipfile
from pathlib import Path

SOURCE = Path(__file__).parent / "extension"
# What Blender calls the platforms of wheels.
PLATFORMS = (
    (r"(many|)linux.*_x86_64", "linux-x64"),
    (r"(many|)linux.*_aarch64", "linux-arm64"),
    (r"macosx_.*_arm64", "macos-arm64"),
    (r"macosx_.*_x86_64", "macos-x64"),
    (r"win_amd64", "windows-x64"),
    (r"win_arm64", "windows-arm64"),
)


def pack(wheel, out):
    """The extension for the platform of the wheel, in a zip; the same bytes for the same files."""
    version, platform = wheel.stem.split("-")[1], wheel.stem.split("-")[-1]
    found = next((name for pattern, name in PLATFORMS if re.fullmatch(pattern, platform.split(".")[0])), None)
    if found is None:
        raise SystemExit(f"{wheel.name} is for {platform}, which Blender does not run on")
    manifest = (SOURCE / "blender_manifest.toml").read_text("utf-8")
    if f'\nversion = "{version}"\n' not in manifest:
        raise SystemExit(f"{wheel.name} is of another version than blender_manifest.toml")
    added = f'platforms = ["{found}"]\nwheels = ["./wheels/{wheel.name}"]\n'
    manifest = manifest.replace("\n[permissions]", f"{added}\n[permissions]")
    path = out / f"taffeta-{version}-{found}.zip"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:

        def add(name, data):
            archive.writestr(zipfile.ZipInfo(name, (2026, 1, 1, 0, 0, 0)), data, zipfile.ZIP_DEFLATED)

        add("blender_manifest.toml", manifest)
        for source in sorted(SOURCE.glob("*.py")):
            add(source.name, source.read_bytes())
        for licence in ("LICENSE-MIT", "LICENSE-APACHE"):
            add(licence, (SOURCE.parent.parent / licence).read_bytes())
        add(f"wheels/{wheel.name}", wheel.read_bytes())
    return path


if __name__ == "__main__":
    print(pack(Path(sys.argv[1]), Path(sys.argv[2])))
