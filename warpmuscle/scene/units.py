"""Units of the numbers of a scene, as its fields declare them: `mass: Annotated[Number, "kg"]`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fnmatch import fnmatchcase
from functools import cache
from typing import Annotated, TypeVar, get_args, get_origin, get_type_hints

from warpmuscle.scene.number import OF_OWNER
from warpmuscle.scene.part import Part

T = TypeVar("T")


@cache
def declared(part: type[Part], kind: type[T]) -> dict[str, T]:
    """By field, what the fields of a structure declare beside their type, of a kind such as text."""
    found: dict[str, T] = {}
    for name, hint in get_type_hints(part, include_extras=True).items():
        for said in get_args(hint)[1:] if get_origin(hint) is Annotated else ():
            if isinstance(said, kind):
                found[name] = said
    return found


def units_of(part: type[Part]) -> dict[str, str]:
    """Unit by field, "1" of a pure number, of the fields of a structure that hold numbers."""
    return declared(part, str)


def unit_below(owner: object, field: str, unit: str) -> str:
    """Unit of a field's numbers: that of the structure's field, else that of what the list, table or curve is in."""
    if not isinstance(owner, Part):
        return unit
    declared = units_of(type(owner)).get(field, "1")
    return unit if declared == OF_OWNER else declared


def unit_at(scene: Part, path: str) -> str:
    """Unit of the first number at a dotted path of a scene, whose parts may be patterns; "" if there is none."""
    node, unit = scene, "1"
    for name in path.split("."):
        members: Mapping[str, object]
        if isinstance(node, Part):
            members = {field: getattr(node, field) for field in node.__struct_fields__}
        elif isinstance(node, Mapping):
            members = node
        elif isinstance(node, Sequence) and not isinstance(node, str):
            members = {str(index): member for index, member in enumerate(node)}
        else:
            return ""
        found = next((member for member in members if fnmatchcase(member, name)), None)
        if found is None:
            return ""
        node, unit = members[found], unit_below(node, found, unit)  # type: ignore[assignment]
    return "" if isinstance(node, str | bool) else unit
