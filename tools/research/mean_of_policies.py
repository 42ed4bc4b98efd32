"""A policy whose weights are the mean of those of two, which were learnt from the same one.

For docs/tutorials/learn.md.

python tools/research/mean_of_policies.py one.h5 other.h5 scene.toml --share 0.5 -o mean.h5

The file keeps how the first was learnt, names the other one among its commands, and holds the given scene, which may
differ from the one of learning in its numbers. What is no network, such as the whole learning curve, is left out.
"""

from __future__ import annotations

import shlex
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from warpmuscle.core.errors import Error
from warpmuscle.formats import load, toml
from warpmuscle.learning.player import text_of
from warpmuscle.results.learned import Layer, PolicyTable
from warpmuscle.results.result import read, write


def mean_of(one: PolicyTable, other: PolicyTable, share: float) -> PolicyTable:
    """A policy between two of the same inputs and outputs; with a share of 0 the first, with 1 the other."""
    if (one.observation, one.action) != (other.observation, other.action):
        raise Error("the two policies observe or move something else")
    if [layer.weight.shape for layer in one.layers] != [layer.weight.shape for layer in other.layers]:
        raise Error("the two policies have other layers")

    def between(a: Any, b: Any) -> Any:
        return np.asarray((1.0 - share) * a.astype(float) + share * b.astype(float), dtype=np.float32)

    layers = [
        Layer(between(a.weight, b.weight), between(a.bias, b.bias))
        for a, b in zip(one.layers, other.layers, strict=True)
    ]
    noise = one.noise
    if noise is not None and other.noise is not None:
        noise = replace(noise, deviation=between(noise.deviation, other.noise.deviation))
    normal = {"mean": between(one.mean, other.mean), "deviation": between(one.deviation, other.deviation)}
    return replace(one, layers=tuple(layers), noise=noise, **normal)


def main(
    one: Path, other: Path, scene: Path, share: float = 0.5,
    output: Annotated[Path, typer.Option("-o", "--output")] = Path("mean.h5"),
) -> None:  # fmt: skip
    results = [read(path) for path in (one, other)]
    first, second = (result.learned for result in results)
    if first is None or second is None:
        raise Error("one of the two files holds no policy")
    task = load(str(scene))
    assert task.learning is not None
    learned = replace(
        first, policy=mean_of(first.policy, second.policy, share), task=text_of(task.learning),
        curve={name: column[-1:] for name, column in first.curve.items()}, critic=None,
    )  # fmt: skip
    names = [path.name for path in (one, other, scene)]
    own = ["python", "tools/research/mean_of_policies.py", *names, "--share", f"{share:g}", "-o", output.name]
    commands = [*(result.command for result in results), shlex.join(own)]
    write(output, replace(results[0], scene=toml.dumps(task), learned=learned, replays=(), command="\n".join(commands)))


if __name__ == "__main__":
    typer.run(main)
