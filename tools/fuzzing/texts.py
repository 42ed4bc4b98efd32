"""Mutations of text files: numbers, words, lines, ends, encodings, sizes."""

from __future__ import annotations

import re
from collections.abc import Callable
from random import Random

from fuzzing.values import NAMES, WORDS

NUMBER = re.compile(r"(?<![\w.])[+-]?\d+\.?\d*(?:[eE][+-]?\d+)?")
WORD = re.compile(r"[A-Za-z_/]\w*")
LONG = 200_000  # characters of a line that is too long
MANY = 3000  # times that a line is repeated

Mutation = Callable[[str, Random], str]


def mutated(text: str, rng: Random) -> bytes:
    """A text after one to four mutations, encoded in one way or another."""
    for _ in range(rng.choice([1, 1, 1, 2, 3, 4])):
        text = rng.choice(MUTATIONS)(text, rng)
    return encoded(text, rng)


def encoded(text: str, rng: Random) -> bytes:
    """Mostly UTF-8; else another encoding, a mark at its begin, or bytes that are no text."""
    data = text.encode("utf-8", "surrogatepass")
    match rng.randrange(24):
        case 0:
            return text.encode("utf-16", "surrogatepass")
        case 1:
            return b"\xef\xbb\xbf" + data
        case 2:
            return data.replace(b"\n", rng.choice([b"\r\n", b"\r", b"\n\n", b"\x0b", b"\x85", b"\0"]))
        case 3:
            at = rng.randrange(len(data) + 1)
            return data[:at] + rng.randbytes(rng.randrange(1, 20)) + data[at:]
    return data


def damaged(data: bytes, rng: Random) -> bytes:
    """Bytes of which some are changed, cut off, repeated or zero."""
    content = bytearray(data)
    for _ in range(rng.choice([1, 1, 2, 5, 30])):
        if not content:
            break
        at = rng.randrange(len(content))
        match rng.randrange(6):
            case 0:
                del content[at:]
            case 1:
                content[at : at + 8] = rng.choice([b"\xff" * 8, bytes(8), b"\x00\x00\xf0\x7f" * 2, rng.randbytes(8)])
            case 2:
                del content[at : at + rng.randrange(1, 100)]
            case 3:
                content[at:at] = content[at : at + rng.randrange(1, 1000)]
            case _:
                content[at] = rng.randrange(256)
    return bytes(content)


def _replaced(pattern: re.Pattern[str], choose: Callable[[str, Random], str]) -> Mutation:
    """Replace one or several matches of a pattern."""

    def mutate(text: str, rng: Random) -> str:
        found = list(pattern.finditer(text))
        if not found:
            return text
        for match in sorted(rng.sample(found, min(rng.choice([1, 1, 1, 3]), len(found))), key=lambda m: -m.start()):
            text = text[: match.start()] + choose(match[0], rng) + text[match.end() :]
        return text

    return mutate


def _other_number(old: str, rng: Random) -> str:
    return rng.choice([*WORDS, f"-{old}", f"{old}e3", f"{old}e-6", f"{old}e30", f"{old}e300", f"{old}0"])


def _other_word(old: str, rng: Random) -> str:
    return rng.choice([*NAMES, old.upper(), old[:-1], old + old, f"{old}_", rng.choice(WORDS)])


def _lines(change: Callable[[list[str], int, Random], None]) -> Mutation:
    def mutate(text: str, rng: Random) -> str:
        lines = text.split("\n")
        change(lines, rng.randrange(len(lines)), rng)
        return "\n".join(lines)

    return mutate


def _delete(lines: list[str], at: int, rng: Random) -> None:
    del lines[at : at + rng.choice([1, 1, 1, 3, 10])]


def _double(lines: list[str], at: int, rng: Random) -> None:
    lines.insert(rng.randrange(len(lines) + 1), lines[at])


def _swap(lines: list[str], at: int, rng: Random) -> None:
    other = rng.randrange(len(lines))
    lines[at], lines[other] = lines[other], lines[at]


def _cells(lines: list[str], at: int, rng: Random) -> None:
    """Another number of cells or words in a line."""
    mark = rng.choice([",", " ", "\t", "="])
    lines[at] = rng.choice([lines[at] + mark, lines[at].rpartition(mark)[0], lines[at] + f"{mark}1"])


def _long(lines: list[str], at: int, rng: Random) -> None:
    lines[at] += rng.choice(["x", "9", " ", "1 ", "[", "{a=", ",", "#", '"']) * LONG


def _many(lines: list[str], at: int, rng: Random) -> None:
    lines[at:at] = [lines[at]] * MANY


def _cut(text: str, rng: Random) -> str:
    return text[: rng.randrange(len(text) + 1)]


def _insert(text: str, rng: Random) -> str:
    at = rng.randrange(len(text) + 1)
    return text[:at] + rng.choice([*NAMES, *WORDS, "\0", "\x1b", "#", "\n", '"""', "[[", "]]", "{", "}"]) + text[at:]


MUTATIONS: list[Mutation] = [
    *[_replaced(NUMBER, _other_number)] * 6,
    *[_replaced(WORD, _other_word)] * 3,
    *[_lines(change) for change in (_delete, _double, _swap, _cells, _delete, _cells)],
    _lines(_long), _lines(_many), _cut, _insert, _insert,
]  # fmt: skip
