#!/usr/bin/env python3
"""Has a random and a scripted policy fold towels, and prints how well they do and how fast.

pip install "gymnasium>=1.1" matplotlib target/wheels/taffeta-*.whl
python3 examples/towel/run.py --worlds 64
python3 examples/towel/run.py --worlds 1,32,512 --picture fold.png
"""

from __future__ import annotations

import argparse
import time
from dataclasses import dataclass
from typing import Any

import fold_towel
import gymnasium
import numpy as np
from policies import Policy, Random, scripted


@dataclass
class Result:
    """What became of the first episode of each world."""

    success: float
    steps: float
    error: float
    reward: float
    diverged: int
    rate: float
    cpu: float


def play(env: gymnasium.vector.VectorEnv[Any, Any, Any], policy: Policy, seed: int) -> Result:
    """Runs an episode in each world. Worlds that are done go on with another until the last is."""
    n = env.num_envs
    observations, _ = env.reset(seed=seed)
    running = np.ones(n, np.bool_)
    success, steps, error, reward = np.zeros(n, np.bool_), np.zeros(n), np.zeros(n), np.zeros(n)
    diverged, calls = 0, 0
    started, cpu = time.perf_counter(), time.process_time()
    while running.any():
        observations, rewards, terminated, truncated, infos = env.step(policy(observations))
        calls += 1
        steps += running
        reward += rewards * running
        ends = running & (terminated | truncated)
        success[ends], error[ends] = terminated[ends], infos["error"][ends]
        diverged += int((infos["diverged"] & ends).sum())
        running &= ~ends
    rate = n * calls / (time.perf_counter() - started)
    cpu = (time.process_time() - cpu) / (n * calls)
    return Result(success.mean(), steps.mean(), error.mean(), reward.mean(), diverged, rate, cpu)


def main() -> None:
    """Reads the command line, and prints a table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--worlds", default="64", help="how many, or several numbers with commas")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--threads", type=int, help="worlds that are stepped at a time")
    parser.add_argument("--picture", help="a PNG to draw a fold of the scripted policy to, by matplotlib")
    arguments = parser.parse_args()
    policies: dict[str, Policy] = {"random": Random(arguments.seed), "scripted": scripted}
    print("| policy | worlds | folded | steps | error [mm] | reward | diverged | world-steps/s | CPU a step [ms] |")
    print("|---|---|---|---|---|---|---|---|---|")
    for name, policy in policies.items():
        for n in map(int, arguments.worlds.split(",")):
            env = gymnasium.make_vec("taffeta/FoldTowel-v0", num_envs=n, threads=arguments.threads)
            result = play(env, policy, arguments.seed)
            env.close()
            print(
                f"| {name} | {n} | {result.success:.1%} | {result.steps:.1f} | {result.error * 1e3:.1f}"
                f" | {result.reward:.2f} | {result.diverged} | {result.rate:,.0f} | {result.cpu * 1e3:.2f} |",
                flush=True,
            )
    print(f"A step is {fold_towel.STEP:.3f} s, in {fold_towel.SUBSTEPS} sub-steps.")
    if arguments.picture:
        from picture import draw

        draw(arguments.picture, arguments.seed)


if __name__ == "__main__":
    main()
