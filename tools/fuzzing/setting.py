"""Where a case is made, and what is done with every scene."""

from __future__ import annotations

import shutil
from dataclasses import dataclass
from pathlib import Path
from random import Random

Command = list[str]
SHORT = ["--duration", "0.02"]
SEARCH = ["--candidates", "3", *SHORT]
EXPORTS = ["walk.mot", "walk.sto", "walk.csv", "walk.parquet", "walk.nc", "walk.zarr"]
KINDS_OF_FIGURES = ["sticks", "angles", "convergence", "parameters", "dataset:/replay/0/com", "activation"]


@dataclass(frozen=True)
class Setting:
    """Where a case is made: its empty folder, the sound inputs, and a file elsewhere that no output may show."""

    folder: Path
    seeds: Path
    secret: Path
    reference: Path | None  # inputs of the original program, if there are any

    def copy(self, *names: str) -> None:
        """Put sound inputs into the folder."""
        for name in names:
            shutil.copy(self.seeds / name, self.folder / name)


def scene_commands(file: str, rng: Random, simulated: bool = True) -> list[Command]:
    """What is done with a scene; a kernel is needed by some of it."""
    plain: list[Command] = [
        ["info", file], ["convert", file, "-o", "out.toml"], ["convert", file, "-o", "out.rbs"],
        ["convert", file, "-o", "out.xml"],
    ]  # fmt: skip
    running: list[Command] = [
        ["simulate", file, *SHORT, "-o", "out.h5"], ["simulate", file, *SHORT, "-o", "out.h5"],
        ["optimize", file, *SEARCH, "-o", "out.h5"], ["simulate", file, *SHORT, "--legacy"],
        ["fit-muscles", file, "-o", "fitted.toml", *SHORT], ["view", file, "--export", "out.html", *SHORT],
    ]  # fmt: skip
    first = rng.choice(running if simulated and rng.random() < 0.5 else plain)
    return [first, ["info", "out.toml"]] if first[-1] == "out.toml" else [first]
