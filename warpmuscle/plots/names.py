"""What figures and curves are called, however somebody writes them."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from typing import NamedTuple

ALIASES = {
    "grf": "ground_force", "ground reaction force": "ground_force", "ground reaction forces": "ground_force",
    "emg": "activation", "muscle activation": "activation", "muscle activations": "activation",
    "excitation": "control", "joint angles": "joints", "joint angle": "joints", "kinematics": "joints",
    "joint moments": "moments", "joint torques": "moments", "torques": "moments", "torque": "moments",
    "kinetics": "moments", "power": "moments", "powers": "moments", "joint powers": "moments",
    "muscles": "activation", "muscle activity": "activation", "stick figure": "sticks", "stick figures": "sticks",
    "ground forces": "ground_force", "footprints": "feet", "foot": "feet", "cost": "convergence",
    "costs": "convergence", "history": "convergence", "learning curve": "convergence", "params": "parameters",
    "moment arm": "moment_arms",
}  # fmt: skip
CURVES = {
    "com": "centre of mass",
    "center of mass": "centre of mass",
    "hip angle": "hip flexion",
    "knee angle": "knee flexion",
    "ankle angle": "ankle dorsiflexion",
    "ankle flexion": "ankle dorsiflexion",
    "torque": "moment",
    "soleus": "sol",
    "gastrocnemius": "gas",
    "hamstrings": "ham",
    "tibialis anterior": "ta",
    "vasti": "vas",
    "gluteus maximus": "glu",
    "rectus femoris": "rf",
}  # of curves, and of muscles by the abbreviations of shipped scenes
SIDES = {"left": "left", "right": "right", "l": "left", "r": "right"}
JOINTS = ("hip", "knee", "ankle")
FEW = 6  # names that a message lists
_SWAPS = (
    ("l", "r", r"^{}(?=[A-Z_])"),
    ("left", "right", r"{}"),
    ("l", "r", r"(?<=_){}$"),
    ("L", "R", r"^{}(?=[A-Z_])"),
)


def plain(name: str) -> str:
    """A name in small letters, with single spaces for `_` and the like."""
    return " ".join(name.lower().replace("_", " ").replace("-", " ").split())


def without_side(name: str) -> tuple[str, str]:
    """A name without the side at its begin or end, and that side: of `knee_angle_r` or `right knee`; or "" for none."""
    words = plain(name).split()
    if len(words) > 1 and words[-1] in SIDES:
        return " ".join(words[:-1]), SIDES[words[-1]]
    if len(words) > 1 and words[0] in SIDES:
        return " ".join(words[1:]), SIDES[words[0]]
    return name, ""


def kind_named(name: str, kinds: Iterable[str]) -> str:
    """The kind of figure that a name means: itself, in another case, with spaces, in the plural; else the name."""
    asked = plain(name)
    known = {plain(kind): kind for kind in kinds}
    ways = (asked, asked.removesuffix("s"), f"{asked}s", plain(ALIASES.get(asked, "")))
    return next((known[way] for way in ways if way in known), name)


def curves_named(name: str, curves: Iterable[str]) -> list[str]:
    """Curves that a name means: the one that is called so, or else all that hold its words; `knee` is its angle."""
    asked, listed = plain(name), list(curves)
    known = {plain(curve) for curve in listed}
    for word, meant in CURVES.items() if asked not in known else ():
        asked = re.sub(rf"\b{word}\b", meant, asked)
    asked = asked if asked in known else asked.removesuffix(" activation")  # of a muscle
    exact = [curve for curve in listed if plain(curve) == asked]
    if exact or not asked:
        return exact[:1]
    found = [curve for curve in listed if all(word in plain(curve).split() for word in asked.split())]
    angles = [curve for curve in found if plain(curve).endswith("flexion")]
    return angles if len(angles) == 1 and asked in JOINTS else found


class Pair(NamedTuple):
    """A part on both sides, or in the middle, where both names are the same."""

    label: str
    left: str
    right: str


def pairs(names: Sequence[str]) -> list[Pair]:
    """The names as pairs of left and right where both sides are among them, in the order of their first part."""
    found: dict[str, Pair] = {}
    for name in names:
        pair = _pair(name, names)
        found.setdefault(pair.left, pair)
    return list(found.values())


def _pair(name: str, names: Sequence[str]) -> Pair:
    for left, right, place in _SWAPS:
        for own, other in ((left, right), (right, left)):
            swapped = re.sub(place.format(own), other, name, count=1)
            if swapped != name and swapped in names:
                label = re.sub(place.format(own), "", name, count=1).strip("_. ")
                return Pair(label or name, *((name, swapped) if own == left else (swapped, name)))
    return Pair(name, name, name)
