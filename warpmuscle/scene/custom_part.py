"""Numbers of parts of a scene's own, which it names as `module:name`."""

from __future__ import annotations

from typing import Annotated

from warpmuscle.scene.number import Number
from warpmuscle.scene.part import Part


class CustomPart(Part):
    """Parameters of a part of one's own, such as a term or a reward, by the names that its module declares."""

    parameters: Annotated[dict[str, Number], "1"] = {}
    each: Annotated[dict[str, dict[str, Number]], "1"] = {}  # others, by joint or muscle, of a part of these
