"""Joints that nothing holds together: their shifts are free, and the ligaments and contacts that held them left out."""

from __future__ import annotations

from collections import Counter

from warpmuscle.formats.lines import Ignored, Notes
from warpmuscle.formats.osim.elements import Element
from warpmuscle.formats.osim.frames import GROUND, on_body
from warpmuscle.formats.osim.records import Lost, Model
from warpmuscle.formats.osim.tree import Branch

HOLDING = ("Ligament", "Contact", "ElasticFoundation", "HuntCrossley", "Bushing", "Spring")  # in the names of classes


def lost_force(element: Element, shapes: dict[str, set[str]]) -> Lost:
    """A force that is left out, with all names in it, those in the shapes that it names among them."""
    names = words_of(element)
    for name in tuple(names & shapes.keys()):
        names |= shapes[name]
    return Lost(element.tag, frozenset(names))


def words_of(element: Element) -> set[str]:
    """The names in an element: its words, and the last names of paths."""
    return {word.rpartition("/")[2] for inner in element.all() for word in inner.text.split()}


def tell_loose(model: Model, tree: list[Branch], notes: Notes) -> None:
    """Note before anything else that a model cannot stand, if a joint is free to shift and lost what held it."""
    told = [text for branch in tree if (text := _loose(model, branch))]
    if told:
        some = "; ".join(told[:4]) + (f"; and {len(told) - 4} more" if len(told) > 4 else "")
        reason = (
            f"this model cannot stand: nothing holds joints that are free to shift, {some}. Lock or couple their shifts"
        )
        notes.ignored.insert(0, Ignored(model.file, model.line, f"Model {model.name}", reason))


def _loose(model: Model, branch: Branch) -> str:
    """What a joint within the body lost, if it is free to shift; else nothing."""
    shifts = {move.argument for move in branch.moves if move.argument and not move.turns}
    ends = [on_body(model, frame)[0] for frame in (branch.near, branch.far)]
    if not shifts or GROUND in ends:
        return ""
    bodies = {end.rpartition("/")[2] for end in ends}
    counts = Counter(
        lost.kind for lost in model.lost if lost.names & bodies and any(word in lost.kind for word in HOLDING)
    )
    if not counts:
        return ""
    what = ", ".join(f"{count} {kind}" for kind, count in counts.items())
    free = len({move.argument for move in branch.moves if move.argument})
    return f"{branch.joint.name} ({free} free coordinates) lost {what}"
