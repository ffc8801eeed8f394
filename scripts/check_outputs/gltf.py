"""GLB by Khronos' validator (npm gltf-validator) and trimesh."""

import json
import os
import shutil
import subprocess
import sys

import numpy as np

VALIDATE = """
const validator = require("gltf-validator");
const bytes = new Uint8Array(require("fs").readFileSync(process.argv[1]));
validator.validateBytes(bytes).then(report => console.log(JSON.stringify(report)));
"""


def check_validator(run):
    (path,) = run.names(".glb")
    if shutil.which("node") is None:
        raise ImportError("node is not installed")
    folders = [os.environ.get("NODE_PATH"), os.path.join(sys.prefix, "node_modules")]
    environment = os.environ | {"NODE_PATH": os.pathsep.join(filter(None, folders))}
    command = ["node", "-e", VALIDATE, str(path)]
    done = subprocess.run(command, env=environment, capture_output=True, text=True)
    if "Cannot find module" in done.stderr:
        raise ImportError("gltf-validator is not installed (npm install --prefix VENV gltf-validator)")
    report = json.loads(done.stdout)
    issues = report["issues"]
    counts = ", ".join(f"{kind.lower()} {issues['num' + kind]}" for kind in ["Errors", "Warnings", "Infos", "Hints"])
    codes = sorted({issue["code"] for issue in issues["messages"]})
    what = " ".join([f"GLB: Khronos validator {report['validatorVersion']}: {counts}", *codes])
    run.demand(what, issues["numErrors"] + issues["numWarnings"] == 0, json.dumps(issues["messages"][:5]))


def geometries(run):
    """Each body's geometry as trimesh reads it, and the body's vertex at each of its vertices."""
    import trimesh

    (path,) = run.names(".glb")
    scene = trimesh.load(path, process=False)
    for name, part in run.bodies:
        geometry, count = scene.geometry[name], part.stop - part.start
        copies = getattr(geometry, "vertex_attributes", {}).get("_VERTEX")
        vertices = np.arange(count) if copies is None else np.ravel(copies).astype(int)
        yield geometry, vertices


def check_trimesh(run):
    for (name, part), (geometry, vertices) in zip(run.bodies, geometries(run)):
        copies = len(vertices) - (part.stop - part.start)
        expected = run.positions[-1, part][vertices].astype(np.float32)
        run.compare(f"GLB {name} by trimesh, vertices copied at seams: {copies}", [(geometry.vertices, expected)], 0.0)
