"""Figures that a notebook shows where they stand, without magic: pyplot, which would see to that, is not imported."""

from __future__ import annotations

import io

from matplotlib.figure import Figure

from warpmuscle.core.errors import Error


class InlineFigure(Figure):
    """A figure without a window of its own."""

    def show(self, warn: bool = True) -> None:
        """Say what shows a figure."""
        raise Error("a notebook shows a figure; elsewhere, figure.savefig('figure.png') writes it")

    def _repr_png_(self) -> bytes:
        """What a notebook shows."""
        picture = io.BytesIO()
        self.savefig(picture, format="png")
        return picture.getvalue()
