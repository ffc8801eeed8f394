"""Policies that fold a towel, or try to: actions from observations, in numpy."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from fold_towel import REACH, SIDE, SPEED, STEP, Array, split


class Policy(Protocol):
    """Actions [worlds, 2, 4] for observations [worlds, 116]."""

    def __call__(self, observations: Array, /) -> Array: ...


class Random:
    """Moves, opens and closes at random."""

    def __init__(self, seed: int = 0) -> None:
        self._random = np.random.default_rng(seed)

    def __call__(self, observations: Array, /) -> Array:
        return self._random.uniform(-1.0, 1.0, (len(observations), 2, 4)).astype(np.float32)


def scripted(observations: Array, /) -> Array:
    """Grasps the corners of row 0, carries them in an arc to the corners of the last row, and lets go.

    It knows nothing but what it sees, and has no state: what comes next follows from where corners are and what is held.
    """
    vertices, grippers, holds = split(observations)
    near, far = vertices[:, 0, [0, -1]], vertices[:, -1, [0, -1]]
    both, some = np.all(holds, axis=1, keepdims=True), np.any(holds, axis=1, keepdims=True)
    left = (far - near)[..., [0, 2]]
    rest = np.linalg.norm(left, axis=-1)
    done = np.all(rest < 0.1 * SIDE, axis=1, keepdims=True) & ~both

    # On the way over, each aims at a point a little ahead of it on the arc.
    along = np.clip(1.05 - rest / SIDE, 0.0, 1.0)
    ahead = np.clip(along + 0.08, 0.0, 1.0)
    axis = (vertices[:, -1, [0, -1]] - vertices[:, 2, [0, -1]]) * [1.0, 0.0, 1.0]
    axis /= np.maximum(np.linalg.norm(axis, axis=-1, keepdims=True), 1e-6)
    arc = far - axis * (SIDE * (1.0 - ahead))[..., None]
    arc[..., 1] = 0.03 + 0.13 * np.sin(np.pi * ahead)

    # Before, they come from above, a little inside of the corner, so that they hold two vertices of the hem.
    inside = vertices[:, 0, [1, -2]] - near
    corner = near + 0.12 * inside + [0.0, 0.01, 0.0]
    beside = np.linalg.norm((grippers - corner)[..., [0, 2]], axis=-1)
    corner[..., 1] += np.where(beside > 0.02, 0.05, 0.0)
    ready = np.all(np.linalg.norm(grippers - corner, axis=-1) < 0.4 * REACH, axis=1, keepdims=True)
    away = grippers + [0.0, 0.02, 0.0]

    goal = np.where(both[..., None], arc, np.where(done[..., None], away, corner))
    over = (rest < 0.04 * SIDE) & (grippers[..., 1] < 0.05)
    arrived = np.all(over, axis=1, keepdims=True)
    closed = (both & ~arrived) | (~both & ~done & (ready | some))
    velocity = (goal - grippers) / (SPEED * STEP)
    fastest = np.maximum(np.max(np.abs(velocity), axis=(1, 2), keepdims=True), 1.0)
    actions = np.empty((len(observations), 2, 4), np.float32)
    actions[..., :3] = velocity / fastest
    actions[..., 3] = np.where(closed, 1.0, -1.0)
    return actions
