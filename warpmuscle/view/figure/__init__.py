"""A character as a figure to look at: limbs, trunk, feet and a head, bones, and exact shapes; numbers only.

Bones of a person (`bones.skeleton`) are put where joints are; of a figure that is one of many they are lines. Limbs are
as thick as their mass is at the density of water (1000 kg/m^3), and so is the trunk; feet and boxes are the shapes that
touch the ground, with round edges, drawn up to the ankle.

Each file adds to what the one before it knows or draws: `physique` (places and sizes), `feet`, `bones`, `flesh`.

May import: view and all below.
To add: what is known of a body to `physique`; what is drawn of it to the file of its layer.
"""

from __future__ import annotations

from collections.abc import Sequence

from warpmuscle.scene import Character
from warpmuscle.scene.masses import massless
from warpmuscle.view.figure.flesh import Flesh
from warpmuscle.view.pieces import Piece, exact_shape


def figure_of(
    character: Character, feet: Sequence[str], body_names: Sequence[str], coarse: bool = False
) -> list[Piece]:
    """The figure of a character without free parameters: flesh, bones and exact shapes.

    Args:
        feet: names of the bodies that walk. coarse: whether it is small in the picture, one of many.
    """
    return _Figure(character, feet, body_names, coarse).pieces()


class _Figure(Flesh):
    """Collects the pieces of all bodies."""

    def pieces(self) -> list[Piece]:
        for name, body in self.character.bodies.items():
            if name in self.feet and body.shapes:
                self._foot(name)
            elif name in self.cages or body.shapes or not massless(body):
                self._body(name)
            if self.coarse:
                self._bone_lines(name)
            elif name in self.cages or not massless(body):
                self._bones(name)
            number, side = self.names.index(name), self.sides[name]
            self.made += [exact_shape(shape, number, side) for shape in body.shapes]
        return self.made
