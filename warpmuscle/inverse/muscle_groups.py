"""Groups of coordinates that muscles connect, such as those of a leg: each is a problem of its own."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from warpmuscle.core.arrays import starts, to_device
from warpmuscle.inverse.body_model import BodyModel
from warpmuscle.kernels.inverse import static_optimization as kernels


@dataclass(frozen=True)
class Groups:
    """Speeds and muscles of each group by number, and the levers of all M muscles."""

    speeds: list[list[int]]
    muscles: list[list[int]]
    levers: list[list[tuple[int, int]]]  # by muscle: number of the lever, and of the speed in its group

    @property
    def count(self) -> int:
        """How many there are."""
        return len(self.speeds)

    @property
    def coordinates(self) -> list[int]:
        """Speeds of all groups."""
        return [speed for group in self.speeds for speed in group]

    @property
    def most_coordinates(self) -> int:
        """The most speeds that a group has."""
        return max(map(len, self.speeds), default=0)

    @property
    def most_muscles(self) -> int:
        """The most muscles that a group has."""
        return max(map(len, self.muscles), default=0)

    def on(self, device: Any) -> kernels.Groups:
        """The device structure; levers are in the order of the groups' muscles."""
        found = kernels.Groups()
        ordered = [muscle for group in self.muscles for muscle in group]
        levers = [lever for muscle in ordered for lever in self.levers[muscle]]
        columns = {
            "first_coordinate": starts(map(len, self.speeds)),
            "coordinate": self.coordinates,
            "first_muscle": starts(map(len, self.muscles)),
            "muscle": ordered,
            "first_lever": starts(len(self.levers[muscle]) for muscle in ordered),
            "lever": [number for number, _ in levers],
            "place": [place for _, place in levers],
        }
        for name, values in columns.items():
            setattr(found, name, to_device(np.array(values, dtype=np.int64), int, device))
        return found


def groups_of(body: BodyModel) -> Groups:
    """The groups of a model's muscles that pull as they are activated, largest first."""
    own: list[list[tuple[int, int]]] = [[] for _ in body.muscles]  # levers and speeds of each muscle
    for number, (muscle, speed) in enumerate(zip(body.lever_muscle.tolist(), body.lever_speed.tolist(), strict=True)):
        if body.pulls[muscle]:
            own[muscle].append((number, speed))
    group_of: dict[int, set[int]] = {}
    for levers in own:
        speeds = {speed for _, speed in levers}
        together = set[int]().union(speeds, *(group_of[speed] for speed in speeds if speed in group_of))
        for speed in together:
            group_of[speed] = together
    groups = sorted({min(group): sorted(group) for group in group_of.values()}.values(), key=lambda g: (-len(g), g))
    muscles = [[m for m, levers in enumerate(own) if levers and levers[0][1] in set(group)] for group in groups]
    place = {speed: k for group in groups for k, speed in enumerate(group)}
    placed = [sorted(((number, place[speed]) for number, speed in one), key=lambda lever: lever[1]) for one in own]
    return Groups([list(group) for group in groups], muscles, placed)
