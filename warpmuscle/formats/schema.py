"""What scenes may say, from their types: as a JSON schema, and field by field."""

from __future__ import annotations

import ast
import inspect
import io
import textwrap
import tokenize
from collections.abc import Iterator
from functools import cache
from typing import Any

import msgspec

from warpmuscle.kernels.objective.objective_terms import REWARDS, TERMS
from warpmuscle.scene import Objective, Scene
from warpmuscle.scene.learning import Rewards
from warpmuscle.scene.number import OF_OWNER, Free
from warpmuscle.scene.part import Part, Range
from warpmuscle.scene.units import declared, units_of

DIALECT = "https://json-schema.org/draft/2020-12/schema"
BOUNDS = {
    Range.ABOVE_0: {"exclusiveMinimum": 0},
    Range.FROM_0: {"minimum": 0},
    Range.FRACTION: {"minimum": 0, "maximum": 1},
}
BASE = "another scene, a file or a shipped one, from which this one takes all that it does not say itself"
FILES = "or a file that holds the character's tables, or several, of which later ones add to earlier ones"


def parts() -> dict[str, type]:
    """The structures that a scene may have, by name."""

    def below(part: type[Part]) -> Iterator[type[Part]]:
        for child in part.__subclasses__():
            yield child
            yield from below(child)

    found: list[type] = [Free, *below(Part)]
    return {part.__name__: part for part in found}


@cache
def notes(part: type) -> dict[str, str]:
    """What the source says of fields of a structure in comments behind them; of weights, what their terms are."""
    found: dict[str, str] = {}
    for owner in reversed(part.__mro__):
        if owner.__module__.startswith("warpmuscle.scene") and not owner.__name__.startswith("_"):
            found |= _comments(textwrap.dedent(inspect.getsource(owner)))
    if issubclass(part, Rewards):
        taken = {"cost": "taken off", "earned": "earned"}
        found = {one.name: f"{taken[one.sign]}: {one.description}" for one in REWARDS.values()} | found
    if issubclass(part, Objective):
        found = {term.name: f"weight of this term: {term.description}, {term.unit}" for term in TERMS.values()} | found
    return found


def _comments(source: str) -> dict[str, str]:
    """The comments behind fields in the source of a class."""
    comments = {
        token.start[0]: token.string.lstrip("# ")
        for token in tokenize.generate_tokens(io.StringIO(source).readline)
        if token.type == tokenize.COMMENT
    }
    body = ast.parse(source).body[0]
    assert isinstance(body, ast.ClassDef)
    found = {}
    for field in body.body:
        if isinstance(field, ast.AnnAssign) and isinstance(field.target, ast.Name):
            lines = range(field.lineno, (field.end_lineno or field.lineno) + 1)
            if said := [comments[line] for line in lines if line in comments]:
                found[field.target.id] = said[0]
    return found


def unit_of(part: type, field: str) -> str:
    """The unit of a field; empty if it has none."""
    unit = units_of(part).get(field, "1") if issubclass(part, Part) else "1"
    return {"1": "", OF_OWNER: "that of what it is a curve of"}.get(unit, unit)


def scene_schema() -> dict[str, Any]:
    """The JSON schema of a scene's TOML file: every field with its type, unit, range, default and meaning.

    No field is required, since a file may take it from its `base`, and a list may be a table of the items that change.
    """
    schema = msgspec.json.schema(Scene)
    kinds = parts()
    definitions = {name: _plain(definition) for name, definition in schema["$defs"].items()}
    for name, definition in definitions.items():
        ranges = declared(kinds[name], Range) if issubclass(kinds[name], Part) else {}
        definition["description"] = inspect.cleandoc(definition.get("description", ""))
        for field, said in definition["properties"].items():
            texts = (notes(kinds[name]).get(field, ""), unit_of(kinds[name], field))
            if description := "; in ".join(text for text in texts if text):
                said["description"] = description
            for kind in said.get("anyOf", [said]) if field in ranges else ():
                kind.update(BOUNDS[ranges[field]] if kind.get("type") in ("number", "integer") else {})
    scene = definitions["Scene"]["properties"]
    scene["base"] = {"type": "string", "description": BASE}
    paths = [{"type": "string"}, {"type": "array", "items": {"type": "string"}}]
    scene["character"] = {"anyOf": [scene["character"], *paths], "description": FILES}
    return {"$schema": DIALECT, "title": "A scene of warpmuscle", "$ref": "#/$defs/Scene", "$defs": definitions}


def _plain(schema: Any) -> Any:
    """A schema as a TOML file may be: without null and required fields, and with tables in place of lists."""
    if isinstance(schema, list):
        return [_plain(item) for item in schema if item != {"type": "null"}]
    if not isinstance(schema, dict):
        return schema
    plain = {
        key: {name: _plain(said) for name, said in value.items()} if key == "properties" else _plain(value)
        for key, value in schema.items()
        if key not in ("required", "discriminator") and not (key == "default" and value in (None, {}, [], ()))
    }
    if len(plain.get("anyOf", ())) == 1:
        plain |= plain.pop("anyOf")[0]
    if plain.get("type") != "array":
        return plain
    items = plain.pop("prefixItems", [plain.get("items", {})])
    plain["items"] = items[0] if all(item == items[0] for item in items) else {"anyOf": items}
    default = {"default": plain.pop("default")} if "default" in plain else {}
    table = {"type": "object", "patternProperties": {"^[0-9]+$": plain["items"]}, "additionalProperties": False}
    return {"anyOf": [plain, table], **default}
