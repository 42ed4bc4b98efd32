"""`walk56_person` for tests of what imitates its gait."""

from pathlib import Path

import msgspec

from warpmuscle import examples
from warpmuscle.formats import load
from warpmuscle.scene import Scene

SCENE = "walk56_person"


def as_of_policy() -> Scene:
    """The scene as a shipped policy of it values it, so that both share a step: here that decides nothing."""
    valued = load(Path(examples.__file__).parent / "files" / "walk56_like_people.toml").objective
    return msgspec.structs.replace(load(SCENE), objective=valued)
