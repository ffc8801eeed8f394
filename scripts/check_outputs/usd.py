"""USD by usd-core."""

import numpy as np

from check_outputs.run import counted


def check_usd(run):
    from pxr import Usd, UsdGeom, UsdValidation

    (path,) = run.names(".usda")
    stage = Usd.Stage.Open(str(path))
    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    errors = UsdValidation.ValidationContext(validators).Validate(stage)
    messages = "; ".join(error.GetMessage() for error in errors)
    run.demand(f"USD: all {len(validators)} validators of usd-core", not errors, messages)
    times = np.array(run.times())
    codes = np.arange(len(times)) / stage.GetTimeCodesPerSecond()
    run.demand("USD: times", np.abs(codes - times).max() < 1e-6 * max(1.0, times[-1]), f"{codes[-1]} s at the end")
    prims = [prim for prim in stage.Traverse() if prim.IsA(UsdGeom.PointBased)]
    run.demand(f"USD: {counted(len(prims), 'prim')}", len(prims) == len(run.bodies), f"not {len(run.bodies)}")
    for prim, (name, part) in zip(prims, run.bodies):
        points = UsdGeom.PointBased(prim).GetPointsAttr()
        samples = points.GetTimeSamples()
        there = counted(len(samples), "sample")
        run.demand(f"USD {name}: {there}", len(samples) == len(run.positions), "not all frames")
        run.compare(
            f"USD {name} by usd-core",
            ((points.Get(time), run.positions[frame, part]) for frame, time in enumerate(samples)),
        )
