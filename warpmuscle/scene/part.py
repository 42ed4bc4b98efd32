"""What all parts of a scene are made of."""

from __future__ import annotations

from enum import Enum
from typing import Literal

import msgspec

Side = Literal["left", "right"]


class Range(Enum):
    """Where every number of a field lies, as its annotation declares: `mass: Annotated[Number, "kg", ABOVE_0]`."""

    ABOVE_0 = "greater than 0"
    FROM_0 = "not negative"
    FRACTION = "from 0 to 1"


ABOVE_0, FROM_0, FRACTION = Range.ABOVE_0, Range.FROM_0, Range.FRACTION


class Part(msgspec.Struct, forbid_unknown_fields=True, omit_defaults=True):
    """Base of everything in a scene: unknown keys are errors, defaults are not written."""
