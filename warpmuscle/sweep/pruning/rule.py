"""When runs of a sweep are held against each other, and how many go on: the table `[prune]` of a sweep file.

Example:
    [prune]
    after = [0.25, 0.5]                 # parts of the candidates of a run, after which some stop
    keep = 0.5                          # the part that goes on each time
    among = ["seed"]                    # axes whose values compete; all runs do if not given

Successive halving (Jamieson, Talwalkar 2016, AISTATS, PMLR 51:240-248). Runs that go on are the same to the last bit as
without it.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import msgspec

from warpmuscle.core.errors import SceneError
from warpmuscle.core.plain_text import number_of
from warpmuscle.scene.validation.checks import near

MOST_RIVALS = 2048  # runs that compete, which go side by side


class PruneTable(msgspec.Struct, forbid_unknown_fields=True):
    """The table `[prune]` of a sweep file."""

    after: list[float] = msgspec.field(default_factory=lambda: [0.25, 0.5])
    keep: float = 0.5
    among: list[str] = []


@dataclass(frozen=True)
class Rule:
    """After which parts of its candidates a run is held against its rivals, and which part of them goes on."""

    after: tuple[float, ...]
    keep: float
    among: tuple[str, ...]

    def rivals(self, axes: Mapping[str, float | str], candidates: int) -> str:
        """What runs have in common that compete with each other."""
        fixed = {} if not self.among else {name: value for name, value in axes.items() if name not in self.among}
        return repr((candidates, sorted(fixed.items())))

    def rungs(self, candidates: int) -> list[int]:
        """Numbers of candidates after which runs of so many are compared."""
        return [max(math.ceil(part * candidates), 1) for part in self.after]


def rule_of(
    table: PruneTable | None, runs: Sequence[tuple[Mapping[str, float | str], int]], training: Any, study: Any,
    staged: bool,
) -> Rule | None:  # fmt: skip
    """The rule of a table, found to be possible for runs with these axes and numbers of candidates; None without one.

    Args:
        training, study: the tables of these names. staged: whether a search is in stages.

    Raises:
        SceneError: runs are none that could compete, a part is none, an axis is not there, or too many runs compete.
    """
    if table is None:
        return None
    for there, why in (
        (training is not None, "trainings run one after the other, and none is pruned"),
        (study is not None, "a study compares searches that have ended, and pruned ones have not"),
        (staged, "searches in stages run one by one, and none is pruned"),
    ):
        if there:
            raise SceneError(f"{why}; leave [prune] out", key="prune")
    if not table.after or any(not 0.0 < part < 1.0 for part in table.after) or sorted(set(table.after)) != table.after:
        raise SceneError("takes parts of the candidates between 0 and 1, increasing: [0.25, 0.5]", key="prune.after")
    if not 0.0 < table.keep < 1.0:
        raise SceneError(f"the part that goes on is between 0 and 1, not {table.keep:g}", key="prune.keep")
    names = list(dict.fromkeys(name for axes, _ in runs for name in axes))
    for index, name in enumerate(table.among):
        if name not in names:
            raise SceneError(f"no axis is called {name!r}{near(name, names)}", key=f"prune.among.{index}")
    rule = Rule(tuple(table.after), table.keep, tuple(table.among))
    most = max(Counter(rule.rivals(axes, count) for axes, count in runs).values(), default=0)
    if most > MOST_RIVALS:
        message = f"{number_of(most, 'run')} would compete, {MOST_RIVALS} at most may; name fewer axes"
        raise SceneError(message, key="prune.among")
    return rule
