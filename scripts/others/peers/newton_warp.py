"""Newton's solvers of cloth, on Warp's CPU device."""

from importlib.metadata import version as installed

import newton
import warp as wp

import sheet

NAME = "Newton (Warp on the CPU)"


def methods(n):
    return {"`SolverVBD`": blocks(), "`SolverXPBD`": positions(n), "`SolverSemiImplicit`": explicit(n)}


# Numbers of steps are even, as a recorded frame must end in the state in which it began.


def blocks():
    for steps, iterations in ((4, 10), (10, 10), (20, 5), (40, 2), (80, 1), (40, 4), (80, 2), (160, 1), (40, 8), (80, 4), (160, 2),
                              (320, 1), (80, 8), (160, 4)):
        for k in (1000, 5000):
            yield {"solver": "vbd", "steps": steps, "iterations": iterations, "k": k}


def positions(n):
    """All springs at once without averaging: this is stable at steps that suit explicit springs only."""
    for steps in (80, 160, 320):
        for k in (500, 1000, 2500):
            yield {"solver": "xpbd", "steps": steps * n // 40, "iterations": 1, "k": k}


def explicit(n):
    for k in (500, 1000, 2500, 3500):
        for close in (1.0, 1.3):
            steps = 2 * round(close * 60 * n / 40 * (k / 500) ** 0.5)
            yield {"solver": "semi-implicit", "steps": steps, "k": k}


class Sheet:
    def __init__(self, n, settings):
        self.steps, solver, k = settings["steps"], settings["solver"], settings["k"]
        builder = newton.ModelBuilder(up_axis=newton.Axis.Y, gravity=(0.0, -sheet.GRAVITY, 0.0))
        elastic = {"tri_ke": 0.0, "tri_ka": 0.0, "tri_kd": 0.0, "add_springs": True, "spring_ke": k, "spring_kd": 0.0}
        if solver == "vbd":
            elastic = {"tri_ke": k, "tri_ka": k, "tri_kd": 0.0}
        builder.add_cloth_mesh(
            pos=wp.vec3(), rot=wp.quat_identity(), scale=1.0, vel=wp.vec3(), vertices=[wp.vec3(*at) for at in sheet.start(n)],
            indices=sheet.triangles(n).ravel().tolist(), density=sheet.MASS / sheet.SIZE**2, edge_ke=0.0, edge_kd=0.0,
            particle_radius=0.0, **elastic)  # without a radius no particle looks for others
        for pin in sheet.pins(n):
            builder.particle_mass[pin] = 0.0
            builder.particle_flags[pin] &= ~int(newton.ParticleFlags.ACTIVE)
        if solver == "vbd":
            builder.color()
        self.model = builder.finalize(device="cpu")
        self.solver = {
            "vbd": lambda: newton.solvers.SolverVBD(self.model, iterations=settings["iterations"]),
            "xpbd": lambda: newton.solvers.SolverXPBD(self.model, iterations=settings["iterations"]),
            "semi-implicit": lambda: newton.solvers.SolverSemiImplicit(self.model, enable_tri_contact=False),
        }[solver]()
        self.now, self.next, self.control = self.model.state(), self.model.state(), self.model.control()
        # A recorded frame is played back without Python. The first frame compiles, and recording needs compiled kernels.
        self.frame_by_steps()
        with wp.ScopedCapture(device="cpu") as capture:
            self.frame_by_steps()
        self.graph = capture.graph
        self.now.assign(self.model.state())

    def frame_by_steps(self):
        for _ in range(self.steps):
            self.now.clear_forces()
            self.solver.step(self.now, self.next, self.control, None, sheet.FRAME / self.steps)
            self.now, self.next = self.next, self.now

    def frame(self):
        wp.capture_launch(self.graph)

    def positions(self):
        return self.now.particle_q.numpy().copy()


def swing(run, settings, limit, options):
    wp.config.quiet = True
    return sheet.swing(run, Sheet(run.n, settings), limit)


def version(options):
    return f"{installed('newton')}, Warp {installed('warp-lang')}"
