"""MuJoCo's flexible sheets: implicit elasticity, or constraints that keep the lengths of edges."""

from importlib.metadata import version as installed

import mujoco

import sheet

NAME = "MuJoCo"

MODEL = """
<mujoco>
  <option timestep="{step!r}" gravity="0 -{gravity} 0" integrator="{integrator}" solver="CG" iterations="{iterations}">
    <flag contact="disable"/>
  </option>
  <size memory="1G"/>
  <worldbody>
    <flexcomp name="sheet" type="direct" dim="2" mass="{mass}" radius="0.001" point="{points}" element="{elements}">
      <contact selfcollide="none" contype="0" conaffinity="0"/>
      {material}
      <pin id="{pins}"/>
    </flexcomp>
  </worldbody>
</mujoco>
"""
THICKNESS = 0.005  # by which a stiffness in N/m becomes Young's modulus [m]


def methods(n):
    return {"elasticity, `discrete` integrator": elastic(), "edge equality constraints, CG": constraints()}


def elastic():
    for steps in (1, 2, 3, 4, 6):
        for k in (500, 700, 1000, 2500, 4000, 5000):
            yield {"steps": steps, "k": k}


def constraints():
    """`time` is the time constant of constraints in steps, for which MuJoCo asks for 2 at least."""
    for steps in (8, 12, 16, 24):
        for iterations in (10, 20, 30, 40):
            for time in (2, 3):
                yield {"steps": steps, "iterations": iterations, "time": time}


class Sheet:
    def __init__(self, n, settings):
        self.steps = settings["steps"]
        step = sheet.FRAME / self.steps
        if "k" in settings:
            integrator = "discrete"
            material = f'<elasticity young="{settings["k"] / THICKNESS}" poisson="0" thickness="{THICKNESS}" elastic2d="stretch"/>'
        else:
            integrator = "Euler"
            material = f'<edge equality="true" solref="{settings["time"] * step} 1" solimp="0.99 0.9999 0.0001"/>'
        self.model = mujoco.MjModel.from_xml_string(MODEL.format(
            step=step, gravity=sheet.GRAVITY, integrator=integrator, iterations=settings.get("iterations", 100), mass=sheet.MASS,
            points=words(sheet.start(n)), elements=words(sheet.triangles(n)), material=material, pins=words(sheet.pins(n))))
        self.data = mujoco.MjData(self.model)
        mujoco.mj_forward(self.model, self.data)

    def frame(self):
        mujoco.mj_step(self.model, self.data, nstep=self.steps)

    def positions(self):
        return self.data.flexvert_xpos.copy()


def words(numbers):
    return " ".join(f"{x:.9g}" for x in getattr(numbers, "flat", numbers))


def swing(run, settings, limit, options):
    return sheet.swing(run, Sheet(run.n, settings), limit)


def version(options):
    return installed("mujoco")
