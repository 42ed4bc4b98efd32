"""The JSON schema of scenes accepts what is shipped, refuses what the reader refuses, and tells units and defaults."""

import tomllib
from functools import cache
from pathlib import Path
from typing import Any

import jsonschema
import pytest

from warpmuscle.formats.schema import notes, scene_schema
from warpmuscle.scene import Failure, Objective

ROOT = Path(__file__).parents[2]


def is_scene(text: str) -> bool:
    """Whether a file of ours is a scene: sweeps have no name, and creatures segments; told without parsing it."""
    top = f"\n{text}".partition("\n[")[0]
    return "\nname = " in top and "\n[segments" not in text and "\nsegments = " not in top


SCENES = [
    path
    for folder in ("warpmuscle/scenes", "warpmuscle/examples/files")
    for path in sorted((ROOT / folder).rglob("*.toml"))
    if is_scene(path.read_text())
]


@cache
def schema() -> dict[str, Any]:
    return scene_schema()


@cache
def checker() -> jsonschema.Draft202012Validator:
    return jsonschema.Draft202012Validator(schema())


def test_the_schema_is_one():
    jsonschema.Draft202012Validator.check_schema(schema())


@pytest.mark.parametrize("path", SCENES, ids=lambda path: path.stem)
def test_shipped_scenes_keep_to_it(path: Path):
    checker().validate(tomllib.loads(path.read_text()))


@pytest.mark.parametrize(
    "text",
    [
        "[ground]\nstifness = 3",
        "duration = 'long'",
        "[controller]\nstart_stance = 'middle'",
        "[ground]\nstiffness = { value = 1, mini = 0 }",
        "[ground]\nstiffness = -1",
        "duration = 0",
        "[ground]\nrestitution = 1.1",
        "character = 3",
    ],
)
def test_what_no_scene_can_say_is_refused(text: str):
    assert not checker().is_valid(tomllib.loads(text))


def test_fields_have_their_meaning_unit_and_default():
    ground = schema()["$defs"]["Ground"]["properties"]
    assert ground["stiffness"]["description"] == "0 switches contact off; in N/m"
    assert ground["stiffness"]["default"] == 2.0e5
    assert notes(Failure)["heading"] == "largest turn from its heading"
    assert notes(Objective)["speed"] == "weight of this term: squared error of the forward speed, over time, m^2/s"
