"""What a damage is, and those that any file may have."""

from __future__ import annotations

import gzip
from collections.abc import Callable
from random import Random
from typing import NamedTuple

from damaging.trial import Trial


class Damage(NamedTuple):
    """A change of sound recordings, and what must be told of it.

    Attributes:
        told: what must be found in an error or a note; empty: any error or note will do, or a result that is as the
            sound one; None: nothing needs to be told, but the result must be as the sound one.
    """

    name: str
    change: Callable[[Trial, Random], None]
    told: str | None


def some(count: int, rng: Random) -> list[int]:
    """A third of the frames, in one piece inside."""
    first = rng.randrange(1, max(count - count // 3 - 1, 2))
    return list(range(first, min(first + max(count // 3, 1), count)))


def changed_line(number: int, change: Callable[[bytes], bytes]) -> Callable[[bytes], bytes]:
    """A change of one line of a file, counted from 0."""

    def edit(data: bytes) -> bytes:
        lines = data.split(b"\n")
        lines[number] = change(lines[number])
        return b"\n".join(lines)

    return edit


def cut(what: str, told: str) -> Damage:
    """A file that ends somewhere, in a number or between rows."""

    def change(trial: Trial, rng: Random) -> None:
        part = rng.choice([0.0, 0.001, 0.1, 0.4, 0.7, 0.95])
        trial.edit(what, lambda data: data[: int(part * len(data))])

    return Damage(f"{what} cut off", change, told)


def spliced(what: str) -> Damage:
    """Bytes that are no text."""

    def change(trial: Trial, rng: Random) -> None:
        piece = rng.choice([b"\0", b"\xff\xfe", b"\x1b[31m", b"\x80" * 5, rng.randbytes(12), "\u202e".encode()])

        def edit(data: bytes) -> bytes:
            at = rng.randrange(len(data))
            return data[:at] + piece + data[at:]

        trial.edit(what, edit)

    return Damage(f"bytes in {what}", change, "")


def beheaded(what: str) -> Damage:
    """A file that begins with a line that is far too long, or lacks its first lines."""

    def change(trial: Trial, rng: Random) -> None:
        kind = rng.randrange(3)
        if kind == 0:
            trial.edit(what, lambda data: data[data.index(b"\n") + 1 :])
        elif kind == 1:
            trial.edit(what, changed_line(0, lambda line: line + b"x" * 2_000_000))
        else:
            trial.edit(what, lambda data: b"\n".join(data.split(b"\n")[3:]))

    return Damage(f"head of {what}", change, "")


def written_elsewhere(what: str) -> list[Damage]:
    """The same text as other programs and systems write it."""
    ways: dict[str, Callable[[bytes], bytes]] = {
        "of Windows": lambda data: data.replace(b"\n", b"\r\n"),
        "of an old Macintosh": lambda data: data.replace(b"\n", b"\r"),
        "with a mark of order": lambda data: b"\xef\xbb\xbf" + data,
        "in UTF-16": lambda data: data.decode().encode("utf-16"),
        "with decimal commas": lambda data: data.replace(b".", b","),
        "without a last line": lambda data: data.rstrip(b"\n")[:-3],
        "twice": lambda data: data + data,
        "with blanks at the ends of lines": lambda data: data.replace(b"\n", b" \t\n"),
        "with empty lines between": lambda data: data.replace(b"\n", b"\n\n"),
        "packed": gzip.compress,
        "of zeros": lambda data: bytes(len(data)),
        "with words for numbers": lambda data: data.replace(b"0.", b"O."),
    }

    def damage(name: str, way: Callable[[bytes], bytes]) -> Damage:
        return Damage(f"{what} {name}", lambda trial, rng: trial.edit(what, way), "")

    return [damage(name, way) for name, way in ways.items()]
