#!/usr/bin/env python3
"""What a scene gains that is split over GPUs: a model, and a check that a halo of two rings is enough.

pip install numpy
python3 scripts/split.py
"""

import numpy as np

# One H100 (docs/results/nvidia-h100-80gb-hbm3.md): the least a sub-step takes [s], and nodes a second of a grid of 1368 × 5717.
LEAST, RATE = 6.5e-6, 19_732e6
# Position and velocity as they lie in memory [byte].
NODE = 32
# Springs reach so many rows far.
REACH = 2
# Bandwidth in each direction [byte/s], and the time until the first byte comes [s]. Assumptions.
LINKS = {
    "NVLink 4": (450e9, 5e-6),
    "PCIe 5 ×16": (63e9, 10e-6),
    "InfiniBand NDR": (50e9, 20e-6),
    "by the host, as wgpu has it": (25e9, 200e-6),
}
GRIDS = ((512, 512), (1368, 5717), (4096, 4096), (16384, 16384))


def alone(nodes):
    """Time of a sub-step on one GPU [s]."""
    return max(LEAST, nodes / RATE)


def split(rows, cols, gpus, link, every):
    """Time of a sub-step on several that each have a strip, and exchange halos after so many sub-steps [s]."""
    bandwidth, latency = link
    halo = REACH * every * rows
    # What lies in the halo is computed twice, but for the last sub-step before an exchange.
    again = 2 * REACH * (every - 1) * rows
    return alone(rows * cols / gpus + again) + (latency + halo * NODE / bandwidth) / every


def model():
    """Speed of 2, 4 and 8 GPUs against one."""
    print("| grid | bytes a side | link | 2 | 4 | 8 | 8, exchanged every 4th sub-step |")
    print("|---|---|---|---|---|---|---|")
    for rows, cols in GRIDS:
        for name, link in LINKS.items():
            gains = [alone(rows * cols) / split(rows, cols, gpus, link, 1) for gpus in (2, 4, 8)]
            gains.append(alone(rows * cols) / split(rows, cols, 8, link, 4))
            cells = " | ".join(f"{gain:.2f}" for gain in gains)
            print(f"| {rows} × {cols} | {REACH * rows * NODE / 1000:.0f} kB | {name} | {cells} |")


def advanced(x, v, h=1e-3, k=50.0, m=1e-3):
    """A sub-step of a sheet with structural, shear and bend springs, [rows, cols, 3]."""
    force = np.zeros_like(x)
    for down, right in ((1, 0), (0, 1), (1, 1), (1, -1), (2, 0), (0, 2)):
        rest = 0.1 * np.hypot(down, right)
        rows, cols = x.shape[:2]
        near = slice(max(0, -right), cols - max(0, right))
        far = slice(max(0, right), cols + min(0, right))
        one, other = (slice(0, rows - down), near), (slice(down, rows), far)
        edge = x[other] - x[one]
        pull = k * (1.0 - rest / np.linalg.norm(edge, axis=2, keepdims=True)) * edge
        force[one] += pull
        force[other] -= pull
    v = v + h * (force / m + np.array([0.0, -9.81, 0.0]))
    return x + h * v, v


def check(every, steps=48):
    """Whether two halves that exchange halos after so many sub-steps have the bits of the whole."""
    rows = 40
    random = np.random.default_rng(1)
    x = np.stack(np.meshgrid(0.1 * np.arange(rows), [0.0], 0.1 * np.arange(24), indexing="ij"), axis=-1)[:, 0]
    x, v = x + 0.01 * random.normal(size=x.shape), random.normal(size=x.shape)
    half, halo = rows // 2, REACH * every
    parts = [(x[: half + halo], v[: half + halo]), (x[half - halo :], v[half - halo :])]
    for step in range(1, steps + 1):
        x, v = advanced(x, v)
        parts = [advanced(*part) for part in parts]
        if step % every == 0:
            whole = [np.concatenate([parts[0][i][:half], parts[1][i][halo:]]) for i in (0, 1)]
            parts = [tuple(a[: half + halo] for a in whole), tuple(a[half - halo :] for a in whole)]
    return all(np.array_equal(a, b) for a, b in zip(whole, (x, v)))


def main():
    print(f"A halo of {REACH} rings each sub-step has the bits of the whole: {check(1)}")
    print(f"A halo of {4 * REACH} rings every 4th sub-step, too: {check(4)}")
    model()


if __name__ == "__main__":
    main()
