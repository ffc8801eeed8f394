"""A vector environment for Gymnasium: two grippers fold a towel in half, in many worlds at once."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypeAlias

import gymnasium
import numpy as np
import taffeta
from gymnasium.spaces import Box
from gymnasium.vector import AutoresetMode, VectorEnv
from numpy.typing import NDArray

Array: TypeAlias = NDArray[Any]
Infos: TypeAlias = "dict[str, Any]"

#: Rows and columns of the towel's nodes, and the length of its sides [m].
NODES, SIDE = 21, 0.4
#: The distance kept from the table, and that between two layers [m].
OFFSET, THICKNESS = 0.01, 0.016
#: Duration of a step, which is one frame [s], and its number of sub-steps.
STEP, SUBSTEPS = 1 / 20, 24
#: Every fourth row and column is seen.
SEEN = slice(None, None, 4)
SEEN_ROWS = len(range(NODES)[SEEN])
#: Largest speed of a gripper along each axis [m/s], and how far it reaches for the towel [m].
SPEED, REACH = 0.5, 0.03
#: Vertices that a gripper holds. About two of them the towel can turn, as between two fingers.
GRASPED = 2
#: Where grippers may be [m].
LOWEST, HIGHEST = np.array([-0.4, 0.015, -0.4]), np.array([0.4, 0.4, 0.4])
#: The towel is folded where it is as near to its target and as flat as this [m].
FOLDED_ERROR, FOLDED_HEIGHT = 0.015, 0.045


def towel() -> taffeta.Scene:
    """A towel that lies on a table."""
    # Its springs are as good as rigid, and short steps keep its length; levels are for cloth that hangs.
    scene = taffeta.Scene().time(dt=STEP, max_step=STEP / SUBSTEPS).solver("xpbd", sweeps=1, levels=0)
    scene = scene.world(drag=2e-4)
    scene = scene.grid(
        "towel",
        rows=NODES,
        cols=NODES,
        size=(SIDE, SIDE),
        area_density=0.4,
        position=(0.0, OFFSET, 0.0),
        springs={
            "structural": {"k": 2000.0, "d": 0.02},
            "shear": {"k": 50.0, "d": 0.02},
            "bend": {"k": 0.2, "d": 0.02},
        },
        self_collision={"form": "nodes", "thickness": THICKNESS, "friction": 0.5},
    )
    return scene.plane("table", offset=OFFSET, friction=0.6)


def variety(n: int, seed: int) -> dict[str, list[Any]]:
    """Mass, stiffness, friction and position of n towels, for ``taffeta.Worlds``.

    The towel of a world depends on the seed and on its index alone, not on how many there are.
    """
    paths: dict[str, list[Any]] = {
        "body.towel.area_density": [],
        "body.towel.springs.bend.k": [],
        "collider.table.friction": [],
        "body.towel.place": [],
    }
    for index in range(n):
        random = np.random.default_rng([seed, index])
        x, z = random.uniform(-0.03, 0.03, 2).tolist()
        turn = {"axis": [0.0, 1.0, 0.0], "degrees": random.uniform(-20.0, 20.0)}
        paths["body.towel.area_density"].append(random.uniform(0.3, 0.5))
        paths["body.towel.springs.bend.k"].append(random.uniform(0.1, 0.4))
        paths["collider.table.friction"].append(random.uniform(0.5, 0.8))
        paths["body.towel.place"].append({"position": [x, OFFSET, z], "rotation": turn})
    return paths


class FoldTowel(VectorEnv[Array, Array, Array]):
    """A towel on a table in each world, and two grippers that fold it: row 0 is to come to lie on the last row.

    An action is float32 [worlds, 2, 4] between -1 and 1: the velocity of each gripper in units of ``SPEED``, and whether it is
    closed (above 0). A gripper that closes within ``REACH`` of the towel pins the nearest vertices and takes them along until it
    opens. A step lasts ``STEP``.

    An observation is float32 [worlds, 116], which ``split`` takes apart: positions of 6 × 6 vertices [m], positions of the
    grippers [m], and whether they hold something.

    The *error* is the mean distance of vertices from their target [m]: that of the half that stays is where it started, that of
    the other half is on top of its mirror image. The *height* is how far vertices are above two layers in the mean [m]. A step's
    reward is by how much it lowers their sum, relative to the error at the start, and 1 more where the towel is folded: with both
    grippers open, an error below ``FOLDED_ERROR``, and no vertex above ``FOLDED_HEIGHT``. That ends the episode. After
    ``max_episode_steps`` it is truncated, and so it is where a world diverges, which ``infos["diverged"]`` says.

    Args:
        num_envs: Number of worlds.
        max_episode_steps: Steps until an episode is truncated.
        autoreset_mode: When a world whose episode has ended starts again. With ``DISABLED`` call ``reset`` with a ``reset_mask``.
        towels: Seed of the towels' mass, stiffness, friction and position, which a world keeps.
        threads: How many worlds are stepped at a time; as many as the machine runs, if it is not given.
    """

    def __init__(
        self,
        num_envs: int = 1,
        *,
        max_episode_steps: int = 120,
        autoreset_mode: AutoresetMode = AutoresetMode.NEXT_STEP,
        towels: int = 0,
        threads: int | None = None,
    ) -> None:
        self.metadata = {"render_modes": [], "autoreset_mode": autoreset_mode}
        self.num_envs = num_envs
        self.single_observation_space = Box(-np.inf, np.inf, (SEEN_ROWS**2 * 3 + 2 * 3 + 2,), np.float32)
        self.single_action_space = Box(-1.0, 1.0, (2, 4), np.float32)
        self.observation_space = Box(-np.inf, np.inf, (num_envs, *self.single_observation_space.shape), np.float32)
        self.action_space = Box(-1.0, 1.0, (num_envs, 2, 4), np.float32)
        self.worlds = taffeta.Worlds(towel(), num_envs, vary=variety(num_envs, towels), threads=threads)
        self._mode, self._limit = autoreset_mode, max_episode_steps
        self._positions = self.worlds.positions().astype(np.float32)
        self._target = targets(self._positions)
        self._start_error = distance(self._positions, self._target)
        self._grippers = np.zeros((num_envs, 2, 3))
        self._holds = np.zeros((num_envs, 2), np.bool_)
        self._vertices = np.zeros((num_envs, 2, GRASPED), np.int64)
        self._grasps = np.zeros((num_envs, 2, GRASPED, 3))
        self._cost = np.zeros(num_envs)
        self._steps = np.zeros(num_envs, np.int64)
        self._ended = np.ones(num_envs, np.bool_)
        self._randoms: list[np.random.Generator] = []

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Array, Infos]:
        """Starts new episodes: in all worlds, or in those of ``options["reset_mask"]``, bool [worlds].

        Args:
            seed: Where grippers start and how the towel is wrinkled: one for each world, or that of the first, after which they
                are numbered. Without it each goes on with its own random numbers.
        """
        mask = np.asarray((options or {}).get("reset_mask", np.ones(self.num_envs, np.bool_)))
        if mask.shape != (self.num_envs,) or mask.dtype != np.bool_ or not mask.any():
            raise ValueError(f"reset_mask is no array of {self.num_envs} booleans of which one is True at least")
        if not self._randoms:
            self._randoms = [np.random.default_rng() for _ in range(self.num_envs)]
        for index, own in enumerate(self._seeds(seed)):
            if mask[index] and own is not None:
                self._randoms[index] = np.random.default_rng(own)
        self._start(mask)
        return self._observe(), self._infos(mask, np.zeros_like(mask), np.zeros_like(mask))

    def step(self, actions: Array) -> tuple[Array, Array, Array, Array, Infos]:
        """Steps all worlds; those whose episode has ended start again as ``autoreset_mode`` says."""
        if not self._randoms:
            raise gymnasium.error.ResetNeeded("call reset before step")
        if self._mode == AutoresetMode.DISABLED and self._ended.any():
            raise gymnasium.error.ResetNeeded("call reset for the worlds whose episode has ended")
        restarts = self._ended.copy()
        runs = ~restarts
        if restarts.any():
            self._start(restarts)
        before = self._cost.copy()
        diverged = self._advance(np.asarray(actions, np.float64), runs)
        self._steps += runs
        success = runs & ~diverged & self._folded()
        rewards = np.where(runs & ~diverged, (before - self._cost) / self._start_error, 0.0) + success
        truncated = runs & ~success & (diverged | (self._steps >= self._limit))
        self._ended = success | truncated
        observations, infos = self._observe(), self._infos(np.ones_like(runs), success, diverged)
        if self._mode == AutoresetMode.SAME_STEP and self._ended.any():
            ended = self._ended.copy()
            final = np.full(self.num_envs, None, dtype=object)
            for index in chosen(ended):
                final[index] = observations[index]
            last = self._infos(ended, success, diverged)
            self._start(ended)
            observations, infos = self._observe(), self._infos(np.ones_like(runs), success & ~ended, diverged & ~ended)
            infos |= {"final_obs": final, "_final_obs": ended, "final_info": last, "_final_info": ended.copy()}
        return observations, rewards, success, truncated, infos

    def _seeds(self, seed: int | Sequence[int | None] | None) -> Sequence[int | None]:
        """A seed for each world, or None."""
        if seed is None:
            return [None] * self.num_envs
        seeds = [seed + index for index in range(self.num_envs)] if isinstance(seed, int) else seed
        if len(seeds) != self.num_envs:
            raise ValueError(f"there are {len(seeds)} seeds; {self.num_envs} would do")
        return seeds

    def _start(self, mask: NDArray[np.bool_]) -> None:
        """Starts the chosen worlds again."""
        self.worlds.reset(mask)
        for index in chosen(mask):
            random = self._randoms[index]
            self.worlds[index].disturb(1e-3, int(random.random() * 2**31))
            shift = random.uniform(-0.05, 0.05, (2, 3))
            self._grippers[index] = np.array([[-0.2, 0.12, -0.25], [0.2, 0.12, -0.25]]) + shift
        self._holds[mask] = False
        self._steps[mask] = 0
        self._ended[mask] = False
        self._measure()

    def _advance(self, actions: Array, runs: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Opens, closes and moves grippers and steps the chosen worlds. Returns which of them have diverged."""
        closed = actions[:, :, 3] > 0.0
        self._open(runs[:, None] & self._holds & ~closed)
        self._close(runs[:, None] & ~self._holds & closed)
        shift = np.clip(actions[:, :, :3], -1.0, 1.0) * (SPEED * STEP)
        self._grippers[runs] = np.clip(self._grippers + shift, LOWEST, HIGHEST)[runs]
        to = self._grippers[:, :, None] + self._grasps
        to[..., 1] = np.maximum(to[..., 1], OFFSET)
        for index in chosen(runs & np.any(self._holds, axis=1)):
            holds = self._holds[index]
            vertices, places = self._vertices[index, holds], to[index, holds]
            self.worlds[index].pin("towel", vertices.ravel(), places.reshape(-1, 3))
        diverged = self.worlds.step(mask=runs)
        self._measure()
        return diverged

    def _open(self, grippers: NDArray[np.bool_]) -> None:
        """Has grippers let go of the towel, bool [worlds, 2]."""
        for index, gripper in np.argwhere(grippers).tolist():
            self.worlds[index].unpin("towel", self._vertices[index, gripper])
        self._holds[grippers] = False

    def _close(self, grippers: NDArray[np.bool_]) -> None:
        """Has grippers hold the vertices next to them, if these are near enough, bool [worlds, 2]."""
        for index, gripper in np.argwhere(grippers).tolist():
            offsets = self._positions[index] - self._grippers[index, gripper]
            distances = np.linalg.norm(offsets, axis=1)
            other = 1 - gripper
            if self._holds[index, other]:
                distances[self._vertices[index, other]] = np.inf
            nearest = np.argsort(distances, kind="stable")[:GRASPED]
            if distances[nearest].max() <= REACH:
                self._vertices[index, gripper] = nearest
                self._grasps[index, gripper] = offsets[nearest]
                self._holds[index, gripper] = True

    def _measure(self) -> None:
        """Reads the positions, and how far the towels are from being folded."""
        self.worlds.positions(out=self._positions)
        self._error = distance(self._positions, self._target)
        self._height = np.maximum(self._positions[..., 1] - (OFFSET + THICKNESS), 0.0).mean(1)
        self._cost = self._error + self._height

    def _folded(self) -> NDArray[np.bool_]:
        """Which towels are folded."""
        flat: NDArray[np.bool_] = np.max(self._positions[..., 1], axis=1) < FOLDED_HEIGHT
        free: NDArray[np.bool_] = ~np.any(self._holds, axis=1)
        return np.logical_and(self._error < FOLDED_ERROR, flat & free)

    def _observe(self) -> Array:
        """What is seen of all worlds."""
        n = self.num_envs
        seen = self._positions.reshape(n, NODES, NODES, 3)[:, SEEN, SEEN].reshape(n, -1)
        return np.concatenate([seen, self._grippers.reshape(n, 6), self._holds], axis=1, dtype=np.float32)

    def _infos(self, given: NDArray[np.bool_], success: NDArray[np.bool_], diverged: NDArray[np.bool_]) -> Infos:
        """What is said of worlds; as in Gymnasium, a mask with the same name and an underscore tells for which."""
        values = {"error": self._error, "height": self._height, "success": success, "diverged": diverged}
        infos: Infos = {name: np.where(given, value, 0).astype(value.dtype) for name, value in values.items()}
        return infos | {f"_{name}": given.copy() for name in values}


def split(observations: Array) -> tuple[Array, Array, Array]:
    """Takes observations apart.

    Returns:
        Positions of vertices [worlds, 6, 6, 3] [m], positions of the grippers [worlds, 2, 3] [m], and whether they hold
        something, bool [worlds, 2].
    """
    n, seen = len(observations), SEEN_ROWS**2 * 3
    vertices = observations[:, :seen].reshape(n, SEEN_ROWS, SEEN_ROWS, 3)
    return vertices, observations[:, seen : seen + 6].reshape(n, 2, 3), observations[:, seen + 6 :] > 0.5


def chosen(mask: NDArray[np.bool_]) -> list[int]:
    """Indices of the worlds that a mask chooses."""
    return [index for index, choice in enumerate(mask) if choice]


def targets(positions: Array) -> Array:
    """Where the vertices of towels that lie flat are to be, [worlds, vertices, 3] [m]."""
    rows = positions.reshape(-1, NODES, NODES, 3).copy()
    half = NODES // 2
    rows[:, :half] = rows[:, : -half - 1 : -1] + np.array([0.0, THICKNESS, 0.0], rows.dtype)
    return rows.reshape(positions.shape)


def distance(positions: Array, target: Array) -> Array:
    """Mean distance of vertices from their target [worlds] [m], float64."""
    distances: Array = np.linalg.norm(positions - target, axis=-1).astype(np.float64)
    return np.asarray(np.mean(distances, axis=1))


gymnasium.register(  # pyright: ignore[reportUnknownMemberType]
    id="taffeta/FoldTowel-v0", vector_entry_point="fold_towel:FoldTowel"
)
