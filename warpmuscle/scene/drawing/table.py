"""A scene in a notebook: a table, and the body as it starts."""

from __future__ import annotations

from warpmuscle.core.html_table import html_table
from warpmuscle.core.plain_text import number_of
from warpmuscle.scene import Scene
from warpmuscle.scene.anatomy import picture
from warpmuscle.scene.parameters import free_parameters
from warpmuscle.scene.scene import drawn_by


def drawn(scene: Scene) -> str:
    """HTML of a scene: the body as it starts above a table."""
    parts = scene.character
    rows = [
        ("scene", scene.name),
        ("is", scene.description),
        ("bodies", str(len(parts.bodies))),
        ("driven by", number_of(len(parts.muscles), "muscle") if parts.muscles else "torques"),
        ("free parameters", str(len(free_parameters(scene)))),
        ("duration", f"{scene.duration:g} s"),
    ]
    return str(picture(scene)) + html_table(("", ""), [row for row in rows if row[1]])


drawn_by.append(drawn)
