"""Units of the numbers of a scene, as its fields declare them: `mass: Annotated[Number, "kg"]`."""

from __future__ import annotations

from functools import cache
from typing import Annotated, get_args, get_origin, get_type_hints

from warpmuscle.scene.number import OF_OWNER
from warpmuscle.scene.part import Part


@cache
def units_of(part: type[Part]) -> dict[str, str]:
    """Unit by field, "1" of a pure number, of the fields of a structure that hold numbers."""
    hints = get_type_hints(part, include_extras=True)
    return {name: get_args(hint)[1] for name, hint in hints.items() if get_origin(hint) is Annotated}


def unit_below(owner: object, field: str, unit: str) -> str:
    """Unit of a field's numbers: that of the structure's field, else that of what the list, table or curve is in."""
    if not isinstance(owner, Part):
        return unit
    declared = units_of(type(owner)).get(field, "1")
    return unit if declared == OF_OWNER else declared
