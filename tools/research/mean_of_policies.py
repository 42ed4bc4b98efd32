"""A policy whose weights are the mean of those of several, which were learnt from the same one.

For docs/tutorials/learn.md.

python tools/research/mean_of_policies.py s1.h5 s2.h5 s3.h5 scene.toml -o mean.h5

The file keeps how the first was learnt, names the others among its commands, and holds the given scene and the gait
that is imitated in it, which may differ from those of learning in numbers. What is no network, such as the whole
learning curve, is left out.
"""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from warpmuscle.cli.ending import run_script
from warpmuscle.core.errors import Error
from warpmuscle.formats import load, toml
from warpmuscle.learning import EpisodeBatch
from warpmuscle.learning.player import text_of
from warpmuscle.results.learned import Layer, PolicyTable
from warpmuscle.results.result import read, write


def mean_of(policies: Sequence[PolicyTable]) -> PolicyTable:
    """The policy between some of the same inputs, outputs and layers; raises Error for others."""
    first = policies[0]
    shapes = [layer.weight.shape for layer in first.layers]
    for other in policies[1:]:
        if (first.observation, first.action) != (other.observation, other.action):
            raise Error("the policies observe or move different things")
        if [layer.weight.shape for layer in other.layers] != shapes:
            raise Error("the policies have different layers")

    def mean(arrays: Sequence[Any]) -> Any:
        return np.mean([array.astype(float) for array in arrays], axis=0).astype(np.float32)

    layers = tuple(
        Layer(mean([layer.weight for layer in same]), mean([layer.bias for layer in same]))
        for same in zip(*(policy.layers for policy in policies), strict=True)
    )
    noises = [policy.noise for policy in policies if policy.noise is not None]
    noise = first.noise
    if noise is not None and len(noises) == len(policies):
        noise = replace(noise, deviation=mean([one.deviation for one in noises]))
    usual = {name: mean([getattr(policy, name) for policy in policies]) for name in ("mean", "deviation")}
    return replace(first, layers=layers, noise=noise, **usual)


def main(
    policies: Annotated[list[Path], typer.Argument()], scene: Annotated[Path, typer.Argument()],
    output: Annotated[Path, typer.Option("-o", "--output")] = Path("mean.h5"),
) -> None:  # fmt: skip
    results = [read(path) for path in policies]
    learned = [result.learned for result in results if result.learned is not None]
    if len(learned) < len(results):
        raise Error("one of the files holds no policy")
    task = load(str(scene))
    assert task.learning is not None
    gait = EpisodeBatch(task, 1, "cpu", task.learning).kept_gait
    kept = replace(
        learned[0], policy=replace(mean_of([one.policy for one in learned]), gait=gait), task=text_of(task.learning),
        curve={name: column[-1:] for name, column in learned[0].curve.items()}, critic=None,
    )  # fmt: skip
    names = [path.name for path in (*policies, scene)]
    own = shlex.join(["python", "tools/research/mean_of_policies.py", *names, "-o", output.name])
    commands = "\n".join([*dict.fromkeys(result.command for result in results), own])
    write(output, replace(results[0], scene=toml.dumps(task), learned=kept, replays=(), command=commands))


if __name__ == "__main__":
    run_script(main)
