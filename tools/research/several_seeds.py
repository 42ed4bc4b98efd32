"""Learns one task with several seeds at once on one device, and takes the mean of what they have learnt.

For docs/tutorials/learn.md.

python tools/research/several_seeds.py task.toml --from begun.h5 --until 432s --option learning_rate=3e-5 -o mean.h5

Each seed is a process of its own, `warpmuscle learn`, and leaves `mean_1.h5`, `mean_2.h5` and so on beside the mean.
They share the device: of five, each makes a fifth to a quarter of the decisions of one that has it alone, the latter if
NVIDIA's multi-process service runs (`nvidia-cuda-mps-control -d`). There is no mean if a seed ends with an error.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Annotated

import typer
from mean_of_policies import main as write_mean

from warpmuscle.cli.ending import run_script
from warpmuscle.core.errors import Error


def command_of(
    task: Path, source: Path, seed: int, until: str, options: list[str], settings: list[str], device: str | None,
    output: Path,
) -> list[str]:  # fmt: skip
    """The command that learns with one seed."""
    said = [part for option in options for part in ("--option", option)]
    said += [part for setting in settings for part in ("--set", setting)]
    where = [] if device is None else ["--device", device]
    return [
        sys.executable, "-m", "warpmuscle", "learn", str(task), "--from", str(source), "--until", until,
        "--seed", str(seed), *said, *where, "-o", str(output),
    ]  # fmt: skip


def main(
    task: Path,
    source: Annotated[Path, typer.Option("--from", help="Policy that all begin with.")],
    seeds: Annotated[int, typer.Option(min=1)] = 5,
    until: Annotated[str, typer.Option(help="Wall time of learning.")] = "432s",
    option: Annotated[list[str] | None, typer.Option(help="KEY=VALUE of the training.")] = None,
    setting: Annotated[
        list[str] | None, typer.Option("--set", help="KEY=VALUE of the task while it is learnt.")
    ] = None,
    device: Annotated[str | None, typer.Option()] = None,
    output: Annotated[Path, typer.Option("-o", "--output")] = Path("mean.h5"),
) -> None:
    """Learn, wait for all, and write the mean of their weights with the scene of the task."""
    files = [output.with_name(f"{output.stem}_{seed}.h5") for seed in range(1, seeds + 1)]
    running = [
        subprocess.Popen(
            command_of(task, source, seed, until, option or [], setting or [], device, file), stdout=subprocess.DEVNULL
        )
        for seed, file in enumerate(files, start=1)
    ]
    failed = [file.name for file, process in zip(files, running, strict=True) if process.wait() != 0]
    if failed:
        raise Error(f"learning ended with an error: {', '.join(failed)}")
    write_mean(files, task, output)


if __name__ == "__main__":
    run_script(main)
