"""The JSON schema of scenes accepts what is shipped, refuses what the reader refuses, and tells units and defaults."""

import tomllib
from pathlib import Path

import jsonschema
import pytest

from warpmuscle.formats.schema import notes, scene_schema
from warpmuscle.scene import Failure, Objective

ROOT = Path(__file__).parents[2]
SCENES = [
    path
    for folder in ("warpmuscle/scenes", "warpmuscle/examples/files")
    for path in sorted((ROOT / folder).rglob("*.toml"))
    if {"name", "segments"} & set(tomllib.loads(path.read_text()))
    == {"name"}  # sweeps have no name, creatures segments
]
SCHEMA = scene_schema()
CHECK = jsonschema.Draft202012Validator(SCHEMA)


def test_the_schema_is_one():
    jsonschema.Draft202012Validator.check_schema(SCHEMA)


@pytest.mark.parametrize("path", SCENES, ids=lambda path: path.stem)
def test_shipped_scenes_keep_to_it(path: Path):
    CHECK.validate(tomllib.loads(path.read_text()))


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
    assert not CHECK.is_valid(tomllib.loads(text))


def test_fields_have_their_meaning_unit_and_default():
    ground = SCHEMA["$defs"]["Ground"]["properties"]
    assert ground["stiffness"]["description"] == "0 switches contact off; in N/m"
    assert ground["stiffness"]["default"] == 2.0e5
    assert notes(Failure)["heading"] == "largest turn from its heading"
    assert notes(Objective)["speed"] == "weight of this term: squared error of the forward speed, over time, m^2/s"
