"""What all parts of a scene are made of."""

from __future__ import annotations

from typing import Literal

import msgspec

Side = Literal["left", "right"]


class Part(msgspec.Struct, forbid_unknown_fields=True, omit_defaults=True):
    """Base of everything in a scene: unknown keys are errors, defaults are not written."""
