"""Several films beside each other in one."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import Error
from warpmuscle.core.plain_text import number_of
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Scene
from warpmuscle.video.colours import HORIZON
from warpmuscle.video.film import Film, Look, check_look, make_films
from warpmuscle.video.painter import Painter

MOST = 16
_IN_A_ROW = 4  # films; more stand in several rows


@dataclass(frozen=True)
class Beside:
    """Films over the same F frames, row by row."""

    look: Look  # of the whole picture
    films: tuple[Film, ...]
    columns: int

    @property
    def time(self) -> Floats:
        """Times (F,) of the film that lasts longest, s."""
        return max((film.time for film in self.films), key=lambda time: float(time[-1] - time[0]))


def films_beside(motions: Sequence[tuple[str, Recording, Scene]], look: Look) -> Beside:
    """Prepare films of motions with their names and scenes, at the same scale and pace.

    Raises:
        Error: too many of them, or as `make_films`.
    """
    if not 1 <= len(motions) <= MOST:
        raise Error(
            f"{number_of(len(motions), 'motion')} cannot be seen beside each other in a film; at most {MOST} can"
        )
    check_look(look)
    columns = len(motions) if len(motions) <= _IN_A_ROW else math.ceil(math.sqrt(len(motions)))
    rows = -(-len(motions) // columns)
    width, height = 2 * (look.width // (2 * columns)), 2 * (look.height // (2 * rows))
    if width < 64 or height < 64:
        raise Error(f"{number_of(len(motions), 'motion', 'need')} a larger picture than {look.width} x {look.height}")
    return Beside(look, tuple(make_films(motions, replace(look, width=width, height=height))), columns)


class Sheet:
    """Paints frames of films beside each other; only the last one with muscles has the scale of colours."""

    def __init__(self, beside: Beside) -> None:
        """Prepare the pages; raises Error without matplotlib."""
        self._beside = beside
        last = max((place for place, film in enumerate(beside.films) if film.activation.shape[1]), default=0)
        self._painters = [Painter(film, colors=place == last) for place, film in enumerate(beside.films)]

    def frame(self, number: int) -> NDArray[np.uint8]:
        """Frame (height, width, 3)."""
        look, columns = self._beside.look, self._beside.columns
        sky = np.round(255.0 * np.array(HORIZON)).astype(np.uint8)
        whole = np.broadcast_to(sky, (look.height, look.width, 3)).copy()
        for place, painter in enumerate(self._painters):
            picture = painter.frame(number)
            height, width, _ = picture.shape
            top, left = place // columns * height, place % columns * width
            whole[top : top + height, left : left + width] = picture
        return whole
