"""Models of OpenSim whose parts refer to others than they did, or whose numbers are written in other ways."""

from __future__ import annotations

import re
from random import Random

SOCKET = re.compile(r"(<socket_\w+>)([^<>]*)(</socket_\w+>)")
NAMED = re.compile(r'<([A-Za-z_:0-9]+) name="([^"<>]*)"')
NUMBERS = re.compile(r"(?<=>)\s*-?[\d.]+(?:e-?\d+)?(?:\s+-?[\d.]+(?:e-?\d+)?)*\s*(?=<)")
PARTS = "Body|PinJoint|CustomJoint|PathPoint|ConditionalPathPoint|PathWrap|Coordinate|TransformAxis"
BLOCK = re.compile(rf"<({PARTS})\b[^<>]*>.*?</\1>", re.DOTALL)
COUNTS = 1, 1, 2, 3


def linked(text: str, rng: Random) -> bytes:
    """A model with a few such changes."""
    for _ in range(rng.choice(COUNTS)):
        text = rng.choice(CHANGES)(text, rng)
    data = text.encode("utf-8", "surrogatepass")
    if rng.random() < 0.08:
        data = text.encode(rng.choice(["utf-16", "utf-16-le", "utf-32", "utf-7", "latin-1"]), "replace")
    return (b"\xef\xbb\xbf" + data) if rng.random() < 0.05 else data


def _replaced(text: str, found: re.Match[str] | None, new: str) -> str:
    return text if found is None else text[: found.start()] + new + text[found.end() :]


def _one(pattern: re.Pattern[str], text: str, rng: Random) -> re.Match[str] | None:
    found = list(pattern.finditer(text))
    return rng.choice(found) if found else None


def _other_socket(text: str, rng: Random) -> str:
    """A frame, body or coordinate that another part refers to, the part itself, or a path that leads elsewhere."""
    one, other = _one(SOCKET, text, rng), _one(SOCKET, text, rng)
    name = _one(NAMED, text, rng)
    if one is None or other is None or name is None:
        return text
    elsewhere = [
        other[2], name[2], f"/bodyset/{name[2]}", f"/jointset/{name[2]}", f"../{name[2]}", "../../..", ".", "/", "//",
        f"{one[2]}/{one[2]}", one[2].upper(), f" {one[2]}\n", one[2].replace("/", "\\"), "/bodyset/" + "x/" * 200,
    ]  # fmt: skip
    return _replaced(text, one, one[1] + rng.choice(elsewhere) + one[3])


def _other_name(text: str, rng: Random) -> str:
    """A name that another part has, none, or one that means something elsewhere."""
    one, other = _one(NAMED, text, rng), _one(NAMED, text, rng)
    if one is None or other is None:
        return text
    name = rng.choice([other[2], "", " ", "ground", "default", "a/b", "..", "[x]", "Ünïcödé", "x" * 3000, "=1+1"])
    return _replaced(text, one, f'<{one[1]} name="{name}"')


def _other_notation(text: str, rng: Random) -> str:
    """Numbers as other programs or people write them."""
    one = _one(NUMBERS, text, rng)
    if one is None:
        return text
    words = one[0].split()
    k = rng.randrange(len(words))
    words[k] = rng.choice([
        words[k].replace(".", ","), f"{words[k]}d0", f"{words[k]}f", f"0x{len(words)}", "1_0", "1e-400", "1e400", "--1",
        "+1", "1.#INF", "-nan(ind)", "٣", "½", "1/2", "pi", "(1)", "1 2", "", "9" * 400, "1e-45", "-0", "1e38", "-1e38",
    ])  # fmt: skip
    return _replaced(text, one, rng.choice([" ", ", ", "\t", "\n", "<!-- -->", ";"]).join(words))


def _other_count(text: str, rng: Random) -> str:
    """More numbers than there should be, or fewer."""
    one = _one(NUMBERS, text, rng)
    if one is None:
        return text
    words = one[0].split()
    return _replaced(text, one, " ".join(rng.choice([words[:-1], words + words, words[:1] * 5000, words[::-1]])))


def _other_order(text: str, rng: Random) -> str:
    """Two parts of one kind in each other's place, or one within another."""
    one, other = _one(BLOCK, text, rng), _one(BLOCK, text, rng)
    if one is None or other is None or one.span() == other.span():
        return text
    first, last = sorted((one, other), key=lambda found: found.start())
    if first.end() > last.start():
        return text
    if rng.random() < 0.5:
        middle = text[first.end() : last.start()]
        return text[: first.start()] + last[0] + middle + first[0] + text[last.end() :]
    inside = last.start() + last[0].rindex("</")
    return text[: first.start()] + text[first.end() : inside] + first[0] + text[inside:]


def _all_at_once(text: str, rng: Random) -> str:
    """All places, sizes, ranges or masses of a model, as of one in other units."""
    tag = rng.choice(["location", "translation", "range", "mass", "inertia", "coefficients", "x", "y", "orientation"])
    factor = rng.choice([0.0, 1000.0, 0.001, -1.0, 57.29578, 1e12])

    def other(found: re.Match[str]) -> str:
        try:
            return found[1] + " ".join(f"{float(word) * factor:.9g}" for word in found[2].split()) + found[3]
        except ValueError:
            return found[0]

    return re.sub(rf"(<{tag}>)([^<>]*)(</{tag}>)", other, text)


def _entities(text: str, rng: Random) -> str:
    """Declarations, comments and sections that a reader of XML may follow."""
    head = rng.choice([
        '<!DOCTYPE x [<!ENTITY a "1"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;">]>', "<!-- -- -->", "<?xml-stylesheet?>",
        '<!DOCTYPE x SYSTEM "secret.h5">', "<![CDATA[x]]>", '<!DOCTYPE x [<!ENTITY f SYSTEM "../secret.h5">]>',
    ])  # fmt: skip
    one = _one(NUMBERS, text, rng)
    inside = rng.choice(["&b;", "&f;", "<![CDATA[1]]>", "&#49;", "&#0;", "&lt;1", "<b/>1"])
    start = text.index("<OpenSimDocument") if "<OpenSimDocument" in text else 0
    text = _replaced(text, one, inside)
    return text[:start] + head + text[start:]


def _other_version(text: str, rng: Random) -> str:
    version = rng.choice(["10000", "20000", "20302", "30000", "30516", "40000", "40600", "50000", "-1", "4.5", "", "x"])
    return re.sub(r'Version="[^"]*"', f'Version="{version}"', text, count=1)


CHANGES = (
    _other_socket, _other_socket, _other_socket, _other_name, _other_name, _other_notation, _other_notation,
    _other_count, _other_order, _other_order, _all_at_once, _entities, _other_version,
)  # fmt: skip
