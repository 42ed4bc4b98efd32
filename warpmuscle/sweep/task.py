"""One optimisation of a sweep that is to be done."""

from __future__ import annotations

from dataclasses import dataclass

from warpmuscle.results.records import SearchOptions
from warpmuscle.scene import Scene


@dataclass(frozen=True)
class Task:
    """One optimisation to be done."""

    name: str
    scene: Scene
    seed: int
    options: SearchOptions
    command: str  # put into its result as what made it
    keep: str = "all"  # or best: of its candidates, see `results.brief`
    rivals: str = ""  # what runs have in common that it competes with, see `pruning`; empty if with none
