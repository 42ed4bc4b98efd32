"""The command that lists the shipped scenes; it imports little, so as to answer at once."""

from __future__ import annotations

from warpmuscle.cli.console import marked, out
from warpmuscle.core.shipped import STUDIES, description, scene_groups, shipped_scenes


def scenes() -> None:
    """List the shipped scenes by what they are good for."""
    found = shipped_scenes()
    for study, names in scene_groups(found).items():
        out.print(marked(f"{study}:", "bold cyan", f" {STUDIES[study]}"))
        for name in names:
            out.print(marked(f"  {name}", "bold", f"  {description(found[name], found)}"))
