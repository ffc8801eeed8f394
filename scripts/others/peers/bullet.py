"""Bullet, by PyBullet: its soft bodies of the classic world, which keep lengths by positions, and deformable ones of springs."""

import tempfile
from importlib.metadata import version as installed

import pybullet

import sheet

NAME = "Bullet (PyBullet)"


def methods(n):
    return {"classic soft body": classic(), "deformable, explicit springs": springs(n)}


def classic():
    """Each step has 20 iterations, which PyBullet does not let one change."""
    for steps in (4, 6, 7, 8, 10, 12, 14, 16, 18, 20, 25, 30, 40, 60, 80, 120):
        yield {"steps": steps}


def springs(n):
    for k in (600, 1000, 3000, 3500):
        for close in (1.0, 1.2):
            yield {"steps": round(close * 100 * n / 40 * (k / 2500) ** 0.5), "k": k}


class Sheet:
    def __init__(self, n, settings):
        self.steps = settings["steps"]
        pybullet.resetSimulation(pybullet.RESET_USE_DEFORMABLE_WORLD if "k" in settings else 0)
        pybullet.setGravity(0, -sheet.GRAVITY, 0)
        pybullet.setTimeStep(sheet.FRAME / self.steps)
        material = {}
        if "k" in settings:
            material = {"useMassSpring": 1, "springElasticStiffness": settings["k"], "springDampingStiffness": 0.02,
                        "springDampingAllDirections": 0, "useBendingSprings": 0, "springBendingStiffness": 0}
        with tempfile.NamedTemporaryFile("w", suffix=".obj") as file:
            file.writelines("v {:.9g} {:.9g} {:.9g}\n".format(*at) for at in sheet.start(n))
            file.writelines("f {} {} {}\n".format(*corners) for corners in sheet.triangles(n) + 1)
            file.flush()
            self.body = pybullet.loadSoftBody(file.name, mass=sheet.MASS, collisionMargin=0.001, useSelfCollision=0, **material)
        for pin in sheet.pins(n):
            pybullet.createSoftBodyAnchor(self.body, pin, -1, -1)

    def frame(self):
        for _ in range(self.steps):
            pybullet.stepSimulation()

    def positions(self):
        return pybullet.getMeshData(self.body, -1, flags=pybullet.MESH_DATA_SIMULATION_MESH)[1]


def swing(run, settings, limit, options):
    if not pybullet.isConnected():
        pybullet.connect(pybullet.DIRECT)
    return sheet.swing(run, Sheet(run.n, settings), limit)


def version(options):
    return installed("pybullet")
