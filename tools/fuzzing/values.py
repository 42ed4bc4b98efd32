"""Values that programs stumble over, and TOML text of any data."""

from __future__ import annotations

import json
import math
from random import Random
from typing import Any

NUMBERS: list[float | int] = [
    0, -0.0, 1, -1, 2, 0.5, 1e-3, 1e-9, 1e-300, 5e-324, 1e9, -1e9, 1e20, 1e39, 1e155, -1e155, 1e300, 1.7e308, -1.7e308,
    math.nan, math.inf, -math.inf, 10**9, 2**31, 2**53, 2**63 - 1, -(2**63), 3, 7, 100, 12345.678,
]  # fmt: skip
WORDS = [
    "nan", "inf", "-inf", "1e999", "-1e308", "1e308", "1e-320", "0", "-0", "-1", "1e5", "99999999999999999999", "0x10",
    "1_000", "1,5", "1.2.3", "--5", "+", "e", "\u0967", "1e", ".", "NaN", "Infinity", "null", "true", "",
]  # fmt: skip
NAMES = [
    "../x", "/etc/passwd", "a/b", "..", ".", "", " ", "-o", "--trust", "[red]", "[/b]", "a[/b]", ":100:",
    "\x1b[31mred", "\x1b]0;title\x07", "\r", "\u202e", "<script>alert(1)</script>", "</script>", "a\nb", "a\tb",
    "x" * 300, "\u00e4\u00f6", "\U0001f600", "a.b", "0", "root", "None", "__class__", "{0}", "%s", "$\\frac{", "$x$",
    "'", '"', "\\", "*", "?", "a,b", "a;b", "\ufeff", "\x7f", "\ud7ff", "NUL", "con:aux",
]  # fmt: skip


def number(rng: Random, near: float | int | None = None) -> float | int:
    """A number that is often extreme, or one near another number."""
    if near is not None and math.isfinite(near) and rng.random() < 0.4:
        return rng.choice([-near, 2 * near, near * 1e3, near * 1e-3, near + 1, near * rng.uniform(0.5, 1.5)])
    return rng.choice(NUMBERS)


def value(rng: Random, depth: int = 0) -> Any:
    """A value of any type that TOML has."""
    kind = rng.randrange(9 if depth < 3 else 6)
    if kind < 2:
        return number(rng)
    if kind == 2:
        return rng.choice(NAMES)
    if kind == 3:
        return rng.random() < 0.5
    if kind == 4:
        return rng.choice(["fwalk.toml", "scene.toml", "biped.toml", "os:system", "*", "walk56"])
    if kind == 5:
        return Raw(rng.choice(["1979-05-27", "07:32:00", "1979-05-27T07:32:00Z", "0xff", "0b1", "+nan", "1e400"]))
    if kind == 6:
        return [value(rng, depth + 1) for _ in range(rng.choice([0, 1, 2, 3, 3, 4, 50]))]
    if kind == 7:
        return {rng.choice(NAMES) or "k": value(rng, depth + 1) for _ in range(rng.randrange(4))}
    return free(rng)


def free(rng: Random) -> dict[str, Any]:
    """A free parameter, complete or not, in order or not."""
    table: dict[str, Any] = {"value": number(rng), "min": number(rng), "max": number(rng)}
    for name, extra in {
        "step": number(rng), "scale": rng.choice(["log", "linear", "x"]), "same_as": rng.choice(["duration", "name"]),
        "factor": number(rng), "through": [[number(rng), number(rng)] for _ in range(rng.randrange(4))],
    }.items():  # fmt: skip
        if rng.random() < 0.15:
            table[name] = extra
    if rng.random() < 0.2:
        table.pop(rng.choice(list(table)))
    return table


class Raw(str):
    """TOML text that stands as it is."""


def toml_value(data: Any) -> str:
    """A value as TOML text in one line."""
    if isinstance(data, Raw):
        return str(data)
    if isinstance(data, bool):
        return str(data).lower()
    if isinstance(data, float) and not math.isfinite(data):
        return "nan" if math.isnan(data) else "inf" if data > 0 else "-inf"
    if isinstance(data, int | float):
        return repr(data)
    if isinstance(data, dict):
        return "{ " + ", ".join(f"{toml_key(key)} = {toml_value(item)}" for key, item in data.items()) + " }"
    if isinstance(data, list | tuple):
        return "[" + ", ".join(map(toml_value, data)) + "]"
    return _quoted(str(data))


def toml_key(name: str) -> str:
    """A key as TOML text."""
    return name if name and all(c.isascii() and (c.isalnum() or c in "_-") for c in name) else _quoted(name)


def toml_text(data: dict[str, Any]) -> str:
    """A table as TOML text; tables two deep have headings, all below them stands in lines."""
    plain = [f"{toml_key(k)} = {toml_value(v)}" for k, v in data.items() if not isinstance(v, dict)]
    parts = ["\n".join(plain)]
    for name, table in data.items():
        if isinstance(table, dict):
            rows = [f"{toml_key(k)} = {toml_value(v)}" for k, v in table.items()]
            parts.append("\n".join([f"\n[{toml_key(name)}]", *rows]))
    return "\n".join(parts) + "\n"


def _quoted(text: str) -> str:
    return json.dumps(text, ensure_ascii=True).replace("\x7f", "\\u007f")
