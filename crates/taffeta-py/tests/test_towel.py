"""The example that folds towels, as an environment of Gymnasium."""

from __future__ import annotations

import subprocess
import sys
from typing import Any

import numpy as np
import pytest
from conftest import ROOT

gymnasium = pytest.importorskip("gymnasium")
FOLDER = ROOT / "examples/towel"
sys.path.insert(0, str(FOLDER))

from fold_towel import OFFSET, FoldTowel, split  # noqa: E402
from gymnasium.utils.env_checker import check_env  # noqa: E402
from gymnasium.vector import AutoresetMode  # noqa: E402
from gymnasium.wrappers.vector import RecordEpisodeStatistics  # noqa: E402
from policies import Random, scripted  # noqa: E402

def hashes(env: FoldTowel) -> list[str]:
    return [world.state_hash() for world in env.worlds]


def test_spaces_contain_what_is_given_and_taken() -> None:
    env = FoldTowel(3)
    observations, infos = env.reset(seed=1)
    assert env.observation_space.contains(observations)
    assert env.single_observation_space.contains(observations[0])
    actions = Random()(observations)
    assert env.action_space.contains(actions)
    assert env.action_space.contains(scripted(observations))
    observations, rewards, terminated, truncated, infos = env.step(actions)
    assert env.observation_space.contains(observations)
    assert rewards.shape == terminated.shape == truncated.shape == (3,)
    assert (rewards.dtype, terminated.dtype, truncated.dtype) == (np.float64, np.bool_, np.bool_)
    for name in ("error", "height", "success", "diverged"):
        assert infos[name].shape == infos[f"_{name}"].shape == (3,)


def test_the_same_seed_gives_the_same_bits_on_any_number_of_threads() -> None:
    def run(n: int, seed: int, threads: int) -> list[str]:
        env = FoldTowel(n, threads=threads)
        observations, _ = env.reset(seed=seed)
        for step in range(12):
            noise = np.random.default_rng(step).uniform(-0.2, 0.2, (3, 2, 4))[:n].astype(np.float32)
            observations, *_ = env.step(scripted(observations) + noise)
        assert split(observations)[2].any(), "some towel is held"
        return hashes(env)

    first = run(3, 7, threads=1)
    assert run(3, 7, threads=2) == first
    assert run(2, 7, threads=2) == first[:2], "a world does not depend on how many there are"
    assert not set(run(3, 11, threads=2)) & set(first)


def test_a_masked_reset_touches_no_other_world() -> None:
    env, twin = (FoldTowel(3, autoreset_mode=AutoresetMode.DISABLED) for _ in range(2))
    observations, _ = env.reset(seed=3)
    twin.reset(seed=3)
    for _ in range(10):
        actions = scripted(observations)
        observations, *_ = env.step(actions)
        twin.step(actions)
    before = hashes(env)
    mask = np.array([False, True, False])
    reset, infos = env.reset(options={"reset_mask": mask})
    after = hashes(env)
    assert [after[0], after[2]] == [before[0], before[2]]
    assert after[1] != before[1]
    np.testing.assert_array_equal(reset[~mask], observations[~mask])
    assert infos["_error"].tolist() == mask.tolist()
    actions = scripted(observations)
    env.step(actions)
    twin.step(actions)
    assert hashes(env)[::2] == hashes(twin)[::2]


def test_the_scripted_policy_folds_the_towel() -> None:
    env = FoldTowel(4, autoreset_mode=AutoresetMode.DISABLED)
    observations, infos = env.reset(seed=5)
    start = infos["error"]
    success, total = np.zeros(4, np.bool_), np.zeros(4)
    for _ in range(40):
        observations, rewards, terminated, _, infos = env.step(scripted(observations))
        total += rewards * ~success
        success |= terminated
        if terminated.any():
            # What is folded starts again, while the others go on.
            assert (infos["error"][terminated] < 0.15 * start[terminated]).all()
            for index in np.flatnonzero(terminated):
                assert env.worlds[int(index)].intersections()["pairs"] == 0, "no layer passes through another"
            observations, _ = env.reset(options={"reset_mask": terminated})
        if success.all():
            break
    assert success.all()
    # The sum of rewards is what error and height fell by, relative to the start, and 1.
    assert (total > 1.75).all() and (total < 2.0).all()


def test_grasps_hold_until_grippers_open() -> None:
    env = FoldTowel(2, autoreset_mode=AutoresetMode.DISABLED)
    observations, _ = env.reset(seed=1)
    offsets = []
    for _ in range(16):
        observations, *_ = env.step(scripted(observations))
        _, grippers, holds = split(observations)
        hem = env.worlds.positions().reshape(2, 21, 21, 3)[:, 0, [[0, 1], [-1, -2]]]
        # What a gripper presses onto the table stays above it.
        if holds.all() and hem[..., 1].min() > OFFSET + 1e-4:
            offsets.append(hem - grippers[:, :, None])
    assert len(offsets) >= 6
    for offset in offsets:
        np.testing.assert_allclose(offset, offsets[0], atol=1e-6)
    lifted = hem[..., 1].mean()
    actions = np.zeros((2, 2, 4), np.float32)
    actions[:, :, 3] = -1.0
    for _ in range(3):
        observations, *_ = env.step(actions)
    assert not split(observations)[2].any()
    assert env.worlds.positions().reshape(2, 21, 21, 3)[:, 0, :, 1].mean() < lifted - 0.03, "it falls"


def test_next_step_restarts_a_world_in_the_step_after_its_end() -> None:
    env = FoldTowel(2, max_episode_steps=3, autoreset_mode=AutoresetMode.NEXT_STEP)
    first, _ = env.reset(seed=1)
    actions = np.ones((2, 2, 4), np.float32)
    for step in range(1, 4):
        last, _, terminated, truncated, _ = env.step(actions)
        assert truncated.tolist() == [step == 3] * 2
        assert not terminated.any()
    assert env.worlds.frames.tolist() == [3, 3]
    again, rewards, terminated, truncated, infos = env.step(actions)
    assert env.worlds.frames.tolist() == [0, 0], "the action is not used"
    assert not (rewards.any() or terminated.any() or truncated.any())
    assert "final_obs" not in infos
    assert not (again == last).all() and not (again == first).all()
    env.step(actions)
    assert env.worlds.frames.tolist() == [1, 1]


def test_same_step_restarts_a_world_at_its_end_and_keeps_what_was_last() -> None:
    env, twin = (
        FoldTowel(2, max_episode_steps=3, autoreset_mode=mode)
        for mode in (AutoresetMode.SAME_STEP, AutoresetMode.DISABLED)
    )
    env.reset(seed=1)
    twin.reset(seed=1)
    actions = np.ones((2, 2, 4), np.float32)
    for _ in range(3):
        observations, rewards, _, truncated, infos = env.step(actions)
        last, twin_rewards, _, _, twin_infos = twin.step(actions)
    assert truncated.all()
    assert env.worlds.frames.tolist() == [0, 0]
    np.testing.assert_array_equal(np.stack(list(infos["final_obs"])), last)
    np.testing.assert_array_equal(rewards, twin_rewards)
    np.testing.assert_array_equal(infos["final_info"]["error"], twin_infos["error"])
    assert infos["_final_obs"].all() and infos["_final_info"].all()
    again, _ = twin.reset(options={"reset_mask": np.ones(2, np.bool_)})
    np.testing.assert_array_equal(observations, again)


def test_disabled_asks_for_a_reset() -> None:
    env = FoldTowel(2, max_episode_steps=1, autoreset_mode=AutoresetMode.DISABLED)
    actions = np.zeros((2, 2, 4), np.float32)
    with pytest.raises(gymnasium.error.ResetNeeded):
        env.step(actions)
    env.reset(seed=1)
    env.step(actions)
    with pytest.raises(gymnasium.error.ResetNeeded):
        env.step(actions)
    with pytest.raises(ValueError, match="reset_mask is no array of 2 booleans"):
        env.reset(options={"reset_mask": np.zeros(2, np.bool_)})


def test_a_world_that_diverges_is_said_and_starts_again() -> None:
    env = FoldTowel(3)
    env.reset(seed=1)
    env.worlds[1].apply_force("towel", 0, (1e14, 0.0, 0.0))
    actions = np.zeros((3, 2, 4), np.float32)
    observations, rewards, terminated, truncated, infos = env.step(actions)
    assert infos["diverged"].tolist() == truncated.tolist() == [False, True, False]
    assert not terminated.any()
    assert rewards[1] == 0.0
    assert np.isfinite(observations).all()
    _, _, _, truncated, infos = env.step(actions)
    assert not infos["diverged"].any() and not truncated.any()
    assert env.worlds.frames.tolist() == [2, 0, 2]


class Single(gymnasium.Env):  # type: ignore[misc, name-defined]
    """One world as an environment of its own, for Gymnasium's checks, which are not for many."""

    def __init__(self) -> None:
        self.many = FoldTowel(1, autoreset_mode=AutoresetMode.DISABLED, threads=1)
        self.observation_space, self.action_space = self.many.single_observation_space, self.many.single_action_space

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        super().reset(seed=seed)
        observations, infos = self.many.reset(seed=seed, options=options)
        return observations[0], {name: value[0] for name, value in infos.items()}

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        observations, rewards, terminated, truncated, infos = self.many.step(action[None])
        given = {name: value[0] for name, value in infos.items()}
        return observations[0], float(rewards[0]), bool(terminated[0]), bool(truncated[0]), given


@pytest.mark.filterwarnings("ignore:.*(infinity|closed|Env).*:UserWarning")
def test_gymnasium_has_nothing_against_a_world() -> None:
    check_env(Single(), skip_render_check=True)


def test_gymnasium_makes_it_and_its_wrappers_take_it() -> None:
    made = gymnasium.make_vec("taffeta/FoldTowel-v0", num_envs=2, max_episode_steps=3)
    assert isinstance(made.unwrapped, FoldTowel)
    assert made.metadata["autoreset_mode"] == AutoresetMode.NEXT_STEP
    env = RecordEpisodeStatistics(made)
    env.reset(seed=1)
    total = np.zeros(2)
    for _ in range(3):
        _, rewards, _, _, infos = env.step(env.action_space.sample())
        total += rewards
    assert infos["episode"]["l"].tolist() == [3, 3]
    np.testing.assert_allclose(infos["episode"]["r"], total, atol=1e-6)
    env.close()


def test_the_command_prints_a_table() -> None:
    words = [sys.executable, str(FOLDER / "run.py"), "--worlds", "2"]
    table = subprocess.run(words, capture_output=True, text=True, check=True).stdout
    assert "| scripted | 2 | 100.0% |" in table
    assert "| random | 2 | 0.0% |" in table
