"""What a sweep file may hold, as it is decoded."""

from __future__ import annotations

import typing
from dataclasses import fields
from typing import Any, Literal

import msgspec

from warpmuscle.results.records import SearchOptions
from warpmuscle.sweep.pruning.rule import PruneTable
from warpmuscle.sweep.samples import Sample
from warpmuscle.sweep.study.table import StudyTable

Search: Any = msgspec.defstruct(
    "Search",
    [  # no strategy: the usual one for the scene
        ("strategy", str | None, None)
        if option.name == "strategy"
        else (option.name, typing.get_type_hints(SearchOptions)[option.name], option.default)
        for option in fields(SearchOptions)
    ],
    forbid_unknown_fields=True,
)


class SweepFile(msgspec.Struct, forbid_unknown_fields=True):
    """A sweep file."""

    scene: str = ""
    name: str = ""
    seed: int = 1
    set: dict[str, Any] = {}
    search: Search = msgspec.field(default_factory=Search)
    training: dict[str, Any] | None = None
    grid: dict[str, Any] | list[dict[str, Any]] = {}
    run: list[dict[str, Any]] = []
    sample: Sample | None = None
    study: StudyTable | None = None
    keep: Literal["all", "best"] | None = None
    prune: PruneTable | None = None
