"""What is said of parts of a SCONE scenario that are not known here."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NoReturn

from warpmuscle.formats.scone.zml import Node

SCRIPTED = "scripts in Lua are not run here; see how scenes name code of their own, docs/tutorials/own-parts.md"


def refuse(node: Node, what: str, known: Iterable[str]) -> NoReturn:
    """SceneError at a part of a kind that is not known, with those that are.

    Args:
        what: that parts of this sort are called, such as `controllers`.
    """
    if node.key.startswith("Script"):
        node.fail(SCRIPTED)
    node.fail(f"{what} of this kind are not known here; there are {', '.join(known)}")


def put_off(node: Node) -> bool:
    """Whether a controller or a measure is `disabled`; then all of it counts as used."""
    if not node.truth_of("disabled", False):
        return False
    for one in node.all():
        one.used = True
    return True
