"""The commands that fit muscles and synergies to recorded motions of an arm, and make new throws.

May import: cli and all below.
To add: a command in a module of its own, its name below; what several of them share in `options.py`.
"""

from __future__ import annotations

from collections.abc import Sequence

from warpmuscle.cli.groups import add, group, instead
from warpmuscle.cli.throw.compare import compare
from warpmuscle.cli.throw.fit import fit
from warpmuscle.cli.throw.goal import goal
from warpmuscle.cli.throw.predict import predict

GOALS = {"--target", "--height", "--speed", "--angle", "--flight-time", "--release", "--adapt", "--solutions"}
COMPARED = {"--numbers", "--as-published", "--curve"}


def _former(arguments: Sequence[str]) -> str:
    """What to type now, for `warpmuscle throw` as one command with these arguments."""
    given = {word.partition("=")[0] for word in arguments}
    if given & GOALS and given & COMPARED:
        return f"`warpmuscle throw goal` for goals, `warpmuscle throw compare` for {' and '.join(given & COMPARED)}"
    return instead(f"throw {'goal' if given & GOALS else 'compare' if given & COMPARED else 'fit'}", arguments)


throw = group("Fit an arm to recorded motions, throw a ball at goals, compare fits.", _former)
for command in (fit, goal, predict, compare):
    add(throw, command.__name__, command)
