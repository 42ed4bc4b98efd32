"""Units of the numbers of a scene, as its fields declare them: `mass: Annotated[Number, "kg"]`."""

from __future__ import annotations

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
