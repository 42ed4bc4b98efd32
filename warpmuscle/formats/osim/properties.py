"""Values of elements; what an element does not say, its class does in the file's section of defaults."""

from __future__ import annotations

from warpmuscle.formats.osim.elements import Element
from warpmuscle.formats.osim.records import Vec3


class Properties:
    """Reads values of elements of one file."""

    def __init__(self, defaults: Element | None) -> None:
        self._defaults = {one.tag: one for one in defaults.children} if defaults is not None else {}

    def find(self, element: Element, *tags: str) -> Element | None:
        """The child of an element, or of the defaults of its class, with one of these tags."""
        default = self._defaults.get(element.tag)
        own = element.child(*tags)
        if own is not None or default is None:
            return own
        return default.child(*tags)

    def number(self, element: Element, tag: str, default: float, infinite: bool = False) -> float:
        """A number; an empty element has none."""
        found = self.find(element, tag)
        return default if found is None or not found.words() else found.number(infinite)

    def truth(self, element: Element, tag: str, default: bool) -> bool:
        """True or false."""
        found = self.find(element, tag)
        return default if found is None or not found.words() else found.truth()

    def word(self, element: Element, tag: str, default: str = "") -> str:
        """A name."""
        found = self.find(element, tag)
        return default if found is None else found.word() or default

    def vector(self, element: Element, tag: str, default: Vec3 = (0.0, 0.0, 0.0)) -> Vec3:
        """Three numbers."""
        found = self.find(element, tag)
        if found is None or not found.words():
            return default
        x, y, z = found.numbers(3)
        return x, y, z

    def applied(self, element: Element) -> bool:
        """Whether a force is applied, or a constraint enforced, as both are unless the file says otherwise."""
        return self.truth(element, "appliesForce", True) and self.truth(element, "isEnforced", True)


def last_name(path: str) -> str:
    """The name of a component from its path."""
    return path.rpartition("/")[2]


def held(element: Element, name: str) -> Element | None:
    """What a property of objects holds: a child of this tag, or, as OpenSim writes it, one that has it for its name."""
    found = element.child(name)
    if found is None:
        named = [child for child in element.children if child.name == name]
        found = named[-1] if named else None
    elif len(found.children) == 1 and found.children[0].tag.endswith("Set"):
        found = found.children[0]
    if found is not None:
        found.used = True
    return found
