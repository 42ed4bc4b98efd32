"""The shipped scenes as a list; it imports little, so as to answer at once."""

from __future__ import annotations

from collections.abc import Sequence

from warpmuscle.cli.console import marked, out
from warpmuscle.core.errors import Error
from warpmuscle.core.shipped import STUDIES, description, scene_groups, shipped_scenes


def print_scenes(words: Sequence[str] = ()) -> None:
    """Print the shipped scenes that have all of these words in their names or descriptions; raises Error for none."""
    found, asked = shipped_scenes(), [word.lower() for word in words]
    texts = {name: description(path, found) for name, path in found.items()}
    chosen = [name for name, text in texts.items() if all(word in f"{name} {text}".lower() for word in asked)]
    if not chosen:
        raise Error(f"no shipped scene has {' and '.join(map(repr, words))}; `warpmuscle scenes` lists all")
    for study, names in scene_groups(found).items():
        if not (listed := [name for name in names if name in chosen]):
            continue
        out.print(marked(f"{study}:", "bold cyan", f" {STUDIES[study]}"))
        for name in listed:
            out.print(marked(f"  {name}", "bold", f"  {texts[name]}"))
