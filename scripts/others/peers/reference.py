"""The motion that every engine should show: springs in NumPy, with 64 bits and steps far below what they need.

python reference.py > reference.json takes a minute or two; the mean heights of all frames [m] are kept in that file.
"""

import json

import numpy as np

import sheet

N = 40  # the mean height hardly depends on it
STIFFNESS = 5000.0  # of structural and shear springs; a tenth for bending [N/m]
DAMPING = 0.02  # [kg/s]
STEPS = 400  # a frame
SPRINGS = [(0, 1, 1.0), (1, 0, 1.0), (1, 1, 1.0), (1, -1, 1.0), (0, 2, 0.1), (2, 0, 0.1)]


def heights():
    """Mean heights of all frames [m]."""
    x = sheet.start(N).reshape(N, N, 3)
    v = np.zeros_like(x)
    inverse_mass = np.full((N, N, 1), (N - 1) ** 2 / sheet.MASS)  # nodes at the border have half of an inner one's mass
    for border in (np.s_[0], np.s_[-1], np.s_[:, 0], np.s_[:, -1]):
        inverse_mass[border] *= 2
    for pin in sheet.pins(N):
        inverse_mass[divmod(pin, N)] = 0.0
    gravity = np.where(inverse_mass > 0, [0.0, -sheet.GRAVITY, 0.0], 0.0)
    step, cell = sheet.FRAME / STEPS, sheet.SIZE / (N - 1)
    means = [x[..., 1].mean()]
    for _ in range(sheet.FRAMES):
        for _ in range(STEPS):
            force = np.zeros_like(x)
            for rows, cols, part in SPRINGS:
                a = np.s_[: N - rows, max(-cols, 0) : N - max(cols, 0)]
                b = np.s_[rows:, max(cols, 0) : N + min(cols, 0)]
                apart = x[b] - x[a]
                length = np.linalg.norm(apart, axis=-1, keepdims=True)
                along = apart / length
                speed = np.sum(along * (v[b] - v[a]), axis=-1, keepdims=True)
                pull = along * (part * STIFFNESS * (length - cell * np.hypot(rows, cols)) + DAMPING * speed)
                force[a] += pull
                force[b] -= pull
            v += step * (gravity + inverse_mass * force)
            x += step * v
        means.append(x[..., 1].mean())
    return [float(mean) for mean in means]


if __name__ == "__main__":
    print(json.dumps([round(height, 5) for height in heights()]))
