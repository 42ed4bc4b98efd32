"""Bodies and joints of a character by number: breadth first from the root."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from warpmuscle.scene import Character

COORDINATES = {"ball": 4, "universal": 2, "hinge": 1, "fixed": 0}
SPEEDS = {"ball": 3, "universal": 2, "hinge": 1, "fixed": 0}
ROOT_COORDINATES = {"free": 7, "planar": 3, "fixed": 7}
ROOT_SPEEDS = {"free": 6, "planar": 3, "fixed": 0}


@dataclass(frozen=True)
class Topology:
    """Names and numbers of bodies and joints; joint i - 1 connects body i to its parent."""

    bodies: tuple[str, ...]
    joints: tuple[str, ...]
    parents: tuple[int, ...]  # by body, -1 for the root
    level_start: tuple[int, ...]  # (levels + 1,)
    first_child: tuple[int, ...]
    child_count: tuple[int, ...]
    coordinate_start: tuple[int, ...]  # (bodies + 1,)
    speed_start: tuple[int, ...]  # (bodies + 1,)

    @property
    def coordinates(self) -> int:
        """Number of coordinates of an instance."""
        return self.coordinate_start[-1]

    @property
    def speeds(self) -> int:
        """Number of speeds of an instance: its degrees of freedom."""
        return self.speed_start[-1]

    def body_of_joint(self, joint: str) -> int:
        """Number of the body that a joint carries; `root` is the root."""
        return 0 if joint == "root" else self.joints.index(joint) + 1


def coordinate_names(names: Topology, character: Character) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Names of all coordinates and of all speeds: `root.x`, a hinge's own, `ankle.0`, `hip.qx` and `hip.x`."""
    parts = {"ball": ("qx", "qy", "qz", "qw"), "universal": ("0", "1"), "hinge": ("",), "fixed": ()}
    rates = parts | {"ball": ("x", "y", "z")}
    orientation = ("qx", "qy", "qz", "qw")
    root = {"free": ("x", "y", "z", *orientation), "planar": ("y", "z", "turn"), "fixed": ("x", "y", "z", *orientation)}
    root_rates = {"free": ("x", "y", "z", "wx", "wy", "wz"), "planar": ("y", "z", "turn"), "fixed": ()}
    kind = character.root_joint
    coordinates, speeds = [f"root.{part}" for part in root[kind]], [f"root.{part}" for part in root_rates[kind]]
    for name in names.joints:
        joint = character.joints[name].type
        coordinates += [f"{name}.{part}".rstrip(".") for part in parts[joint]]
        speeds += [f"{name}.{part}".rstrip(".") for part in rates[joint]]
    return tuple(coordinates), tuple(speeds)


def topology(character: Character) -> Topology:
    """Number the bodies breadth first from the root, children in the order of the character's joints."""
    bodies, joints, parents, depth = [character.root], [], [-1], [0]
    first_child, child_count = [], []
    for number, name in enumerate(bodies):  # grows while it is walked through
        children = [key for key, joint in character.joints.items() if joint.parent == name]
        first_child.append(len(bodies))
        child_count.append(len(children))
        for key in children:
            bodies.append(character.joints[key].child)
            joints.append(key)
            parents.append(number)
            depth.append(depth[number] + 1)
    types = [character.joints[key].type for key in joints]
    levels = [depth.index(d) for d in range(max(depth) + 1)]
    coordinates = [ROOT_COORDINATES[character.root_joint], *(COORDINATES[t] for t in types)]
    speeds = [ROOT_SPEEDS[character.root_joint], *(SPEEDS[t] for t in types)]
    return Topology(
        bodies=tuple(bodies),
        joints=tuple(joints),
        parents=tuple(parents),
        level_start=(*levels, len(bodies)),
        first_child=tuple(first_child),
        child_count=tuple(child_count),
        coordinate_start=(0, *np.cumsum(coordinates).tolist()),
        speed_start=(0, *np.cumsum(speeds).tolist()),
    )
