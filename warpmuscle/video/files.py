"""Films as files: H.264 in .mp4, and pictures that move, .gif and .webp."""

from __future__ import annotations

import errno
import io
import os
import signal
import subprocess
from collections.abc import Callable, Iterator
from fractions import Fraction
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from warpmuscle.core.extras import imported, need
from warpmuscle.core.files import check_output, replace_file, replacing
from warpmuscle.video.colours import FORCES
from warpmuscle.video.film import Film
from warpmuscle.video.painter import Painter, muscle_colors
from warpmuscle.video.side_by_side import Beside, Sheet

ENDINGS = (".mp4", ".gif", ".webp")
Tell = Callable[[int, int], None]  # of frames done, of all
FFMPEG = "imageio_ffmpeg"
_COLORS = 192  # of a .gif
_SAMPLE = 8  # frames that its colours are chosen from
Image = NDArray[np.uint8]


def check_film(path: Path) -> None:
    """Raise Error now, rather than after the work, if no film can be written to a file of this name."""
    check_output(path, "a film", ENDINGS)
    if path.suffix.lower() == ".mp4":
        imported(FFMPEG, "an .mp4 needs")
    need("matplotlib", "a film needs")


def write(film: Film | Beside, path: str | Path, tell: Tell | None = None) -> None:
    """Draw a film and write it, whole or not at all; the name's ending (.mp4, .gif, .webp) chooses the format.

    Raises:
        Error: another ending, a package is missing, or the file cannot be written.
    """
    path = Path(path)
    check_film(path)
    frames, ending = _frames(film, tell), path.suffix.lower()
    if ending == ".mp4":
        with replacing(path, ending) as temporary:
            _write_mp4(temporary, film, frames)
    else:
        replace_file(path, _gif(film, frames) if ending == ".gif" else _webp(film, frames))


def _frames(film: Film | Beside, tell: Tell | None) -> Iterator[Image]:
    painter = Sheet(film) if isinstance(film, Beside) else Painter(film)
    for number in range(len(film.time)):
        yield painter.frame(number)
        if tell is not None:
            tell(number + 1, len(film.time))


def _write_mp4(path: Path, film: Film | Beside, frames: Iterator[Image]) -> None:
    """Encode with ffmpeg as another process; raises OSError unless it has written a whole film."""
    look, program = film.look, imported(FFMPEG, "an .mp4 needs").get_ffmpeg_exe()
    command = [
        program, "-nostdin", "-v", "quiet", "-f", "rawvideo", "-pix_fmt", "rgb24",
        "-s", f"{look.width}x{look.height}", "-r", str(Fraction(look.rate).limit_denominator()), "-i", "-", "-an",
        "-c:v", "libx264", "-pix_fmt", "yuv420p", "-crf", "20", "-preset", "medium", "-movflags", "+faststart",
        "-y", str(path),
    ]  # fmt: skip
    with subprocess.Popen(command, stdin=subprocess.PIPE, stderr=subprocess.DEVNULL) as encoder:
        assert encoder.stdin is not None
        try:
            for frame in frames:
                encoder.stdin.write(np.ascontiguousarray(frame).data)
            encoder.stdin.close()
        except BrokenPipeError:
            pass  # it has ended, and its code says why
        except BaseException:
            encoder.kill()
            raise
        code = encoder.wait()
    if code != 0:
        raise OSError(0, _why_ended(code))
    if not _is_complete(path):
        raise OSError(0, "ffmpeg wrote a part only")


def _why_ended(code: int) -> str:
    """What an exit code of ffmpeg says: a signal if it is negative, else the last byte of a negative error number."""
    if code == -getattr(signal, "SIGXFSZ", 0):
        return os.strerror(errno.EFBIG)
    if code > 0 and 256 - code in errno.errorcode:
        return os.strerror(256 - code)
    return f"ffmpeg ended with code {code}"


def _is_complete(path: Path) -> bool:
    """Whether an .mp4 consists of whole boxes, the frames and their index among them (ISO/IEC 14496-12, 4.2)."""
    size, at, kinds = path.stat().st_size, 0, set()
    with open(path, "rb") as file:
        while at < size:
            file.seek(at)
            head = file.read(16)
            length = int.from_bytes(head[:4], "big")
            length = int.from_bytes(head[8:16], "big") if length == 1 else length or size - at
            if length < 8:
                return False
            kinds.add(head[4:8])
            at += length
    return at == size and {b"moov", b"mdat"} <= kinds


def _gif(film: Film | Beside, frames: Iterator[Image]) -> bytes:
    """The same colours in all frames, so that what does not change costs nothing."""
    from PIL import Image as Pictures

    pictures = [Pictures.fromarray(frame) for frame in frames]
    chosen = pictures[:: max(1, len(pictures) // _SAMPLE)]
    sheet = Pictures.fromarray(np.concatenate([np.asarray(picture) for picture in chosen]))
    own = np.concatenate([muscle_colors(), FORCES])  # what is thin has none among the most frequent colours
    common = sheet.quantize(_COLORS - len(own), Pictures.Quantize.MEDIANCUT, dither=Pictures.Dither.NONE)
    palette = Pictures.new("P", (1, 1))
    palette.putpalette((common.getpalette() or []) + (255.0 * own).round().astype(int).ravel().tolist())
    indexed = [picture.quantize(palette=palette, dither=Pictures.Dither.NONE) for picture in pictures]
    # A .gif counts hundredths of a second: rounded so that the film as a whole lasts as long as it should.
    ends = np.round(np.arange(len(indexed) + 1) * 100.0 / film.look.rate).astype(int)
    duration = (10 * np.maximum(np.diff(ends), 1)).tolist()
    moving = io.BytesIO()
    indexed[0].save(
        moving, "GIF", save_all=True, append_images=indexed[1:], duration=duration, loop=0, optimize=False
    )  # fmt: skip
    return moving.getvalue()


def _webp(film: Film | Beside, frames: Iterator[Image]) -> bytes:
    from PIL import Image as Pictures

    pictures = [Pictures.fromarray(frame) for frame in frames]
    duration = round(1000.0 / film.look.rate)
    moving = io.BytesIO()
    pictures[0].save(
        moving, "WEBP", save_all=True, append_images=pictures[1:], duration=duration, loop=0, quality=70, method=4
    )  # fmt: skip
    return moving.getvalue()
