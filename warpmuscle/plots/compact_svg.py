"""Figures of matplotlib in a fraction of their bytes, for pages that hold many: what is seen stays the same."""

from __future__ import annotations

import itertools
import re
from collections import Counter

import numpy as np

FINE, COARSE = 100, 10  # parts of 1/72 inch that numbers are rounded to: of short paths, such as markers, and of curves
SHORT = 9  # points of a path up to which it is short
UNSEEN = 0.08  # of 1/72 inch, that a long line may pass beside its points
_STEP = re.compile(r"([MLz])\s*(?:(-?[\d.e+-]+)\s+(-?[\d.e+-]+))?")
_PLAIN = re.compile(r"[MLz\d.e+\-\s]*")


def compact_svg(content: bytes) -> bytes:
    """A figure with rounded numbers, without points on straight lines, and with each style written once."""
    text = content.decode()
    text = text[text.index("<svg") :]
    text = re.sub(r"\s*<metadata>.*?</metadata>", "", text, flags=re.DOTALL)
    text = re.sub(r'(?<= d=")[^"]*(?=")', lambda found: compact_path(found[0]), text)
    text = re.sub(r'(?<= [xy]=")-?\d+\.\d+(?=")', lambda found: f"{float(found[0]):.2f}", text)
    text = re.sub(r">\s*\n\s*<", "><", text)
    used = set(re.findall(r"#([\w-]+)", text))
    text = re.sub(r' id="([^"]*)"', lambda found: found[0] if found[1] in used else "", text)
    return _shared_styles(text).encode()


def compact_path(path: str) -> str:
    """The same lines with rounded numbers, each from the one before; a path with curves stays as it is."""
    if not _PLAIN.fullmatch(path):
        return re.sub(r"\s+", " ", path.strip())
    steps = [(kind, x, y) for kind, x, y in _STEP.findall(path)]
    parts = FINE if len(steps) <= SHORT else COARSE
    lines: list[list[tuple[float, float]]] = []
    closed: list[bool] = []
    for kind, x, y in steps:
        if kind == "z":
            closed[-1] = True
            continue
        if kind == "M":
            lines.append([])
            closed.append(False)
        lines[-1].append((float(x), float(y)))
    if parts == COARSE:
        lines = [thinned(points) for points in lines]
    whole = [[(round(x * parts), round(y * parts)) for x, y in points] for points in lines]
    return "".join(_line(points, end, parts) for points, end in zip(whole, closed, strict=True))


def thinned(points: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """The points that a line needs to pass all others within `UNSEEN`, by Douglas and Peucker (1973)."""
    place = np.array(points)
    kept = np.zeros(len(place), dtype=bool)
    kept[[0, -1]] = True
    open_ones = [(0, len(place) - 1)]
    while open_ones:
        first, last = open_ones.pop()
        if last - first < 2:
            continue
        away = place[first + 1 : last] - place[first]
        along = place[last] - place[first]
        square = float(along @ along)
        part = np.clip(away @ along / square, 0.0, 1.0) if square > 0.0 else np.zeros(len(away))
        distance = np.linalg.norm(away - part[:, None] * along, axis=1)
        farthest = int(np.argmax(distance))
        if distance[farthest] > UNSEEN:
            middle = first + 1 + farthest
            kept[middle] = True
            open_ones += [(first, middle), (middle, last)]
    return [points[k] for k in np.flatnonzero(kept)]


def _line(points: list[tuple[int, int]], closed: bool, parts: int) -> str:
    """A polyline with whole numbers of parts."""
    text = f"M{_number(points[0][0], parts)}{_next(points[0][1], parts)}"
    moves: list[tuple[int, int]] = []
    for (x0, y0), (x1, y1) in itertools.pairwise(points):
        move = (x1 - x0, y1 - y0)
        if move == (0, 0) and len(points) > 2:
            continue
        last = moves[-1] if moves else (0, 0)
        if moves and last[0] * move[1] == last[1] * move[0] and last[0] * move[0] + last[1] * move[1] > 0:
            moves[-1] = (last[0] + move[0], last[1] + move[1])
        else:
            moves.append(move)
    for number, (x, y) in enumerate(moves):
        text += ("l" + _number(x, parts) if number == 0 else _next(x, parts)) + _next(y, parts)
    return text + ("z" if closed else "")


def _number(whole: int, parts: int) -> str:
    """A number of parts in units, as short as can be."""
    text = f"{whole / parts:.{len(str(parts)) - 1}f}".rstrip("0").rstrip(".")
    return re.sub(r"^(-?)0\.", r"\1.", text) if text not in ("-0", "") else "0"


def _next(whole: int, parts: int) -> str:
    """The same behind another number."""
    text = _number(whole, parts)
    return text if text.startswith("-") else f" {text}"


def _shared_styles(text: str) -> str:
    """Styles that several elements have as classes."""
    counts = Counter(re.findall(r' style="([^"]*)"', text))
    names = {style: f"s{number}" for number, (style, count) in enumerate(counts.items()) if count > 1}
    rules = "".join(f".{name}{{{style}}}" for style, name in names.items() if "&" not in style)

    def short(found: re.Match[str]) -> str:
        return f' class="{names[found[1]]}"' if found[1] in names and "&" not in found[1] else found[0]

    return re.sub(r' style="([^"]*)"', short, text).replace("</style>", f"{rules}</style>", 1)
