"""Draws the moments of a fold, by matplotlib."""

from __future__ import annotations

from importlib import import_module
from typing import Any

import numpy as np
from fold_towel import NODES, FoldTowel, split
from gymnasium.vector import AutoresetMode
from policies import scripted


def draw(path: str, seed: int = 0, moments: tuple[int, ...] = (0, 7, 11, 15, 18, 40)) -> None:
    """Folds a towel by the scripted policy, and draws it after these numbers of steps.

    Args:
        path: The PNG.
        seed: Seed of the episode.
        moments: Steps at which it is drawn.
    """
    env = FoldTowel(1, autoreset_mode=AutoresetMode.DISABLED, threads=1)
    observations, _ = env.reset(seed=seed)
    figure: Any = import_module("matplotlib.figure").Figure(figsize=(12.0, 6.4), layout="constrained")
    over = False
    for step in range(max(moments) + 1):
        if step in moments:
            axes: Any = figure.add_subplot(2, (len(moments) + 1) // 2, moments.index(step) + 1, projection="3d")
            show(axes, env, observations, f"{step * env.worlds[0].dt:.2f} s")
        if over:
            env.worlds.step()
        else:
            observations, _, terminated, truncated, _ = env.step(scripted(observations))
            over = bool((terminated | truncated).any())
    figure.savefig(path, dpi=75)


def show(axes: Any, env: FoldTowel, observations: Any, title: str) -> None:
    """Draws the towel of the first world: both sides of it, and the grippers, red where they hold it."""
    points = env.worlds[0].positions()
    faces = env.worlds[0].faces()
    collection = import_module("mpl_toolkits.mplot3d.art3d").Poly3DCollection
    corners = points[faces][..., [0, 2, 1]] * [1.0, -1.0, 1.0]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    # Triangles face up where the towel starts; the side below has another colour.
    up = normals[:, 2:3] > 0.0
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    light = 0.45 + 0.55 * np.abs(normals @ np.array([0.4, -0.3, 0.87]))[:, None]
    checks = (np.arange(len(faces)) // 2 // (NODES - 1) // 4 + np.arange(len(faces)) // 2 % (NODES - 1) // 4) % 2
    colours = np.where(up, [0.45, 0.62, 0.85], [0.95, 0.72, 0.45]) * (0.85 + 0.15 * checks[:, None]) * light
    axes.add_collection3d(collection(corners, facecolors=colours, edgecolors=colours * 0.8, linewidths=0.3))
    _, grippers, holds = split(observations)
    for gripper, holding in zip(grippers[0], holds[0], strict=True):
        axes.scatter(gripper[0], -gripper[2], gripper[1], color="firebrick" if holding else "black", s=60)
    axes.set(xlim=(-0.25, 0.25), ylim=(-0.25, 0.25), zlim=(0.0, 0.25), title=title)
    axes.set_box_aspect((1.0, 1.0, 0.5))
    axes.view_init(elev=24.0, azim=-65.0)
    axes.set_xticks([])
    axes.set_yticks([])
    axes.set_zticks([0.0, 0.1, 0.2])
