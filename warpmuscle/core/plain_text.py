"""Text of files and users as a terminal may show it."""

from __future__ import annotations

import re
from collections.abc import Sequence

# Control characters but for tabs and ends of lines, marks that reorder letters, tags, and halves of characters.
_UNPRINTABLE = re.compile(
    "[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069\ufff9-\ufffb\U000e0000-\U000e007f\ud800-\udfff]"
)
_NOT_IN_XML = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\ud800-\udfff\ufffe\uffff]")

_PLURALS = (("ay", "ays"), ("ey", "eys"), ("y", "ies"), ("is", "es"), ("ch", "ches"), ("sh", "shes"), ("x", "xes"))
_OF_ONE = {"are": "is", "were": "was", "have": "has", "do": "does"}  # verbs that take more than an s


def printable(text: str) -> str:
    r"""Text in which what would steer a terminal, or cannot be written, stands as an escape such as `\x1b`."""
    return _UNPRINTABLE.sub(lambda found: ascii(found[0])[1:-1], text)


def readable(word: str) -> str:
    """A word of a command, or the name of a file, as text that any file can hold: as UTF-8, without other bytes.

    Where names are not UTF-8, or the locale is not, Python keeps bytes as halves of letters, which nothing writes.
    """
    return word.encode("utf-8", "surrogateescape").decode("utf-8", "replace")


def xml_text(text: str) -> str:
    """Text in which characters that no XML file may hold, even as a reference, are replaced."""
    return _NOT_IN_XML.sub("\ufffd", text)


def number_of(count: int, noun: str, verb: str = "") -> str:
    """A number of things in words: "1 joint", "2 joints", "3 bodies", "1 axis", "2 axes".

    Args:
        noun: of one thing. verb: of several ones, such as "are" or "need", which follows: "1 joint is", "2 joints are".
    """
    if count == 1:
        return f"1 {noun} {_OF_ONE.get(verb, verb + 's')}" if verb else f"1 {noun}"
    return f"{count} {_plural(noun)}" + (f" {verb}" if verb else "")


def _plural(noun: str) -> str:
    old, new = next((pair for pair in _PLURALS if noun.endswith(pair[0])), ("", "s"))
    return noun.removesuffix(old) + new


def many_of(count: float, noun: str) -> str:
    """A number of things, of which there may be millions: "1 step", "940 steps", "64 thousand steps"."""
    for least, size, word in ((1e6, 1e6, "million"), (1e4, 1e3, "thousand")):
        if count >= least:
            return f"{count / size:.4g} {word} {_plural(noun)}"
    return number_of(round(count), noun)


def few_of(words: Sequence[str], most: int, between: str = ", ") -> str:
    """Words in a row, or the first of them and how many more there are: "a, b and 3 more"."""
    more = f" and {len(words) - most} more" if len(words) > most else ""
    return between.join(words[:most]) + more


def rounded(value: float, decimals: int) -> str:
    """A number with so many decimals; a zero has no sign."""
    text = f"{value:.{decimals}f}"
    return text.removeprefix("-") if float(text) == 0.0 else text


def one_line(text: str) -> str:
    """The same on one line."""
    return printable(" ".join(text.split()))
