"""Motions as moving pictures, drawn without a screen; needs the extra `video` of the package.

May import: plots, view and all below.
To add: a format of files to `files`; what is painted to `painter`.
"""

from __future__ import annotations

from warpmuscle.video.files import ENDINGS, check_film, write
from warpmuscle.video.film import Film, Look, make_film
from warpmuscle.video.side_by_side import Beside, films_beside

__all__ = ["ENDINGS", "Beside", "Film", "Look", "check_film", "films_beside", "make_film", "write"]
