"""Films as files: H.264 in .mp4, and pictures that move, .gif and .webp."""

from __future__ import annotations

import contextlib
import os
import secrets
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warpmuscle.errors import Error
from warpmuscle.formats.files import check_writable, unwritable
from warpmuscle.video.beside import Beside, Sheet
from warpmuscle.video.film import Film
from warpmuscle.video.painter import FORCE_TINTS, Painter, muscle_colors

ENDINGS = (".mp4", ".gif", ".webp")
Tell = Callable[[int, int], None]  # of frames done, of all
_COLORS = 192  # of a .gif
_SAMPLE = 8  # frames that its colours are chosen from
Image = NDArray[np.uint8]


def check_film(path: Path) -> None:
    """Raise Error now, rather than after the work, if no film can be written to a file of this name."""
    if path.suffix.lower() not in ENDINGS:
        raise Error(f"{path}: a film is written as {', '.join(ENDINGS)}")
    if path.suffix.lower() == ".mp4":
        _ffmpeg()
    check_writable(path)


def write(film: Film | Beside, path: str | Path, tell: Tell | None = None) -> None:
    """Draw a film and write it, whole or not at all; the name's ending (.mp4, .gif, .webp) chooses the format.

    Raises:
        Error: another ending, a package is missing, or the file cannot be written.
    """
    path = Path(path)
    check_film(path)
    target = path.resolve()
    temporary = target.with_name(f".{target.name}.{secrets.token_hex(4)}{path.suffix.lower()}")
    make = {".mp4": _write_mp4, ".gif": _write_gif, ".webp": _write_webp}[path.suffix.lower()]
    try:
        make(temporary, film, _frames(film, tell))
        os.replace(temporary, target)
    except OSError as error:
        raise Error(f"{path}: {unwritable(error)}") from None
    finally:
        with contextlib.suppress(OSError):
            temporary.unlink(missing_ok=True)


def _frames(film: Film | Beside, tell: Tell | None) -> Iterator[Image]:
    painter = Sheet(film) if isinstance(film, Beside) else Painter(film)
    for number in range(len(film.time)):
        yield painter.frame(number)
        if tell is not None:
            tell(number + 1, len(film.time))


def _ffmpeg() -> Any:
    try:
        import imageio_ffmpeg
    except ImportError:
        raise Error("an .mp4 needs imageio-ffmpeg: pip install 'warpmuscle[video]'") from None
    return imageio_ffmpeg


def _write_mp4(path: Path, film: Film | Beside, frames: Iterator[Image]) -> None:
    look = film.look
    options = ["-crf", "20", "-preset", "medium", "-movflags", "+faststart"]
    writer = _ffmpeg().write_frames(
        str(path), (look.width, look.height), fps=look.rate, codec="libx264", pix_fmt_out="yuv420p", quality=None,
        output_params=options, macro_block_size=2, ffmpeg_log_level="error",
    )  # fmt: skip
    writer.send(None)
    try:
        for frame in frames:
            writer.send(np.ascontiguousarray(frame))
    finally:
        writer.close()
    if not path.exists():
        raise OSError("ffmpeg wrote nothing")


def _write_gif(path: Path, film: Film | Beside, frames: Iterator[Image]) -> None:
    """The same colours in all frames, so that what does not change costs nothing."""
    from PIL import Image as Pictures

    pictures = [Pictures.fromarray(frame) for frame in frames]
    chosen = pictures[:: max(1, len(pictures) // _SAMPLE)]
    sheet = Pictures.fromarray(np.concatenate([np.asarray(picture) for picture in chosen]))
    own = np.concatenate([muscle_colors(), FORCE_TINTS])  # what is thin has none among the most frequent colours
    common = sheet.quantize(_COLORS - len(own), Pictures.Quantize.MEDIANCUT, dither=Pictures.Dither.NONE)
    palette = Pictures.new("P", (1, 1))
    palette.putpalette((common.getpalette() or []) + (255.0 * own).round().astype(int).ravel().tolist())
    indexed = [picture.quantize(palette=palette, dither=Pictures.Dither.NONE) for picture in pictures]
    # A .gif counts hundredths of a second: rounded so that the film as a whole lasts as long as it should.
    ends = np.round(np.arange(len(indexed) + 1) * 100.0 / film.look.rate).astype(int)
    duration = (10 * np.maximum(np.diff(ends), 1)).tolist()
    indexed[0].save(path, save_all=True, append_images=indexed[1:], duration=duration, loop=0, optimize=False)


def _write_webp(path: Path, film: Film | Beside, frames: Iterator[Image]) -> None:
    from PIL import Image as Pictures

    pictures = [Pictures.fromarray(frame) for frame in frames]
    duration = round(1000.0 / film.look.rate)
    pictures[0].save(
        path, save_all=True, append_images=pictures[1:], duration=duration, loop=0, quality=70, method=4
    )  # fmt: skip
