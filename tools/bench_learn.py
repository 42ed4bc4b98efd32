"""Decisions a second of the learning environment, and where the time of a decision goes.

    python tools/bench_learn.py [SCENE] [--instances 4096 16384] [--device cuda:0] [--seconds 3] [--json FILE]

Random actions, resets on, once captured as a CUDA graph and once launched kernel by kernel; then the parts of a
decision, each waited for, and what a policy of 512, 256 and 128 units and an update of it by PPO take besides.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Callable
from itertools import pairwise
from typing import Any

import torch
import warp as wp
from torch import nn

from warpmuscle.learning import RolloutEnv, Task
from warpmuscle.learning.episodes import PARTS

WARM_UP = 20  # decisions
HORIZON = 24  # decisions between two updates
EPOCHS, BATCHES = 5, 4


def rate(env: RolloutEnv, seconds: float, act: Callable[[], torch.Tensor]) -> float:
    """Decisions a second of all instances together."""
    for _ in range(WARM_UP):
        env.step(act())
    synchronize(env)
    begin, made = time.perf_counter(), 0
    while time.perf_counter() - begin < seconds:
        for _ in range(10):
            env.step(act())
        synchronize(env)
        made += 10
    return made * env.num_envs / (time.perf_counter() - begin)


def synchronize(env: RolloutEnv) -> None:
    wp.synchronize_device(env.batch.device)
    if env.device.type == "cuda":
        torch.cuda.synchronize(env.device)


def by_part(env: RolloutEnv, decisions: int, act: Callable[[], torch.Tensor]) -> dict[str, float]:
    """Milliseconds that each part of a decision takes, the device waited for after each."""
    spent = dict.fromkeys(PARTS, 0.0)
    told = wp.to_torch(env.batch.actions.requested)
    for _ in range(decisions):
        told.copy_(act())
        synchronize(env)
        last = time.perf_counter()

        def mark(part: str) -> None:
            nonlocal last
            synchronize(env)
            now = time.perf_counter()
            spent[part] += now - last
            last = now

        env.batch.step(mark=mark)
    return {part: 1e3 * value / decisions for part, value in spent.items()}


def network(inputs: int, outputs: int, device: torch.device) -> nn.Module:
    sizes = (inputs, 512, 256, 128)
    layers: list[nn.Module] = []
    for before, after in pairwise(sizes):
        layers += [nn.Linear(before, after), nn.ELU()]
    return nn.Sequential(*layers, nn.Linear(128, outputs)).to(device)


def learning(env: RolloutEnv) -> dict[str, float]:
    """Milliseconds a decision that a policy takes, and an update of policy and value by PPO, shared out."""
    actor, critic = (network(env.num_observations, k, env.device) for k in (env.num_actions, 1))
    optimizer = torch.optim.Adam([*actor.parameters(), *critic.parameters()], lr=1e-4)
    observed = env.observation.repeat(HORIZON, 1)

    def timed(work: Callable[[], Any], times: int) -> float:
        work()
        synchronize(env)
        begin = time.perf_counter()
        for _ in range(times):
            work()
        synchronize(env)
        return 1e3 * (time.perf_counter() - begin) / times

    def update() -> None:
        for rows in torch.randperm(len(observed), device=env.device).chunk(BATCHES):
            x = observed[rows]
            loss = actor(x).square().sum(1).mean() + critic(x).square().mean()
            optimizer.zero_grad()
            loss.backward()
            optimizer.step()

    with torch.no_grad():
        deciding = timed(lambda: (actor(env.observation), critic(env.observation)), 20)
    return {"policy": deciding, "learning": timed(update, 3) * EPOCHS / HORIZON}


def measure(scene: str, count: int, device: str | None, seconds: float) -> dict[str, Any]:
    """All of one number of instances."""
    env = RolloutEnv(scene, count, device, Task(), capture=True)
    generator = torch.Generator(device=env.device).manual_seed(0)
    noise = torch.randn((16, count, env.num_actions), generator=generator, device=env.device)
    turn = 0

    def act() -> torch.Tensor:
        nonlocal turn
        turn += 1
        return noise[turn % len(noise)]

    captured = rate(env, seconds, act)
    env.capture = False
    launched = rate(env, seconds, act)
    parts = by_part(env, 10, act)
    result = {"scene": scene, "instances": count, "captured": captured, "launched": launched}
    return result | {"ms": parts | learning(env)}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", nargs="?", default="walk56")
    parser.add_argument("--instances", type=int, nargs="+", default=[4096, 16384])
    parser.add_argument("--device")
    parser.add_argument("--seconds", type=float, default=3.0)
    parser.add_argument("--json")
    options = parser.parse_args()
    results = []
    for count in options.instances:
        found = measure(options.scene, count, options.device, options.seconds)
        results.append(found)
        print(f"{found['scene']}, {count} instances: {found['captured']:,.0f} decisions/s", end="")
        print(f", {found['launched']:,.0f} kernel by kernel; ms a decision:", end="")
        print("".join(f" {name} {value:.3f}" for name, value in found["ms"].items()), flush=True)
        if options.json:
            with open(options.json, "w") as file:
                json.dump(results, file, indent=1)


if __name__ == "__main__":
    main()
