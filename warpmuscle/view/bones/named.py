"""What bodies are by their names, as models of OpenSim call them: their joints alone do not always tell."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Literal

Role = Literal["thigh", "shank", "ankle bone", "knee cap", "upper arm", "forearm", "hand", "rib cage", "collar bone",
               "shoulder blade", ""]  # fmt: skip
# In this order: `ulna_radius_hand` is a forearm with its hand.
ROLES: tuple[tuple[str, Role], ...] = (
    ("femur|thigh|upper_?leg", "thigh"),
    ("patella", "knee cap"),
    ("talus", "ankle bone"),
    ("tibia|shank|lower_?leg", "shank"),
    ("humerus|upper_?arm", "upper arm"),
    ("ulna|radius|fore_?arm|lower_?arm", "forearm"),
    ("hand", "hand"),
    ("thorax|rib_?cage", "rib cage"),
    ("clavicle|collar_?bone", "collar bone"),
    ("scapula|shoulder_?blade", "shoulder blade"),
)
FEET = "calcn|calcaneus|foot"


def named_role(body: str) -> Role:
    """What a body is; empty where its name does not say."""
    return next((role for pattern, role in ROLES if _has(body, pattern)), "")


def named_head(body: str) -> bool:
    """Whether a body is a head by its name."""
    return _has(body, "head|skull")


def named_neck(body: str) -> bool:
    """Whether a body is a neck, with or without its head, by its name."""
    return _has(body, "neck|head")


def named_feet(bodies: Iterable[str]) -> list[str]:
    """Bodies whose names say that they are feet, such as `calcn_r`."""
    return [body for body in bodies if _has(body, FEET)]


def _has(body: str, pattern: str) -> bool:
    """Whether a name has one of these words, with `r`, `right` or the like beside it at most."""
    side = "r|l|right|left"
    return re.search(rf"(?:^|[_ ])(?:(?:{side})[_ ]?)?(?:{pattern})(?:$|[_ \d]|(?:{side})$)", body.lower()) is not None
