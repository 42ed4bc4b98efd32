"""Mutations of TOML data: values, types, names, structure."""

from __future__ import annotations

from random import Random
from typing import Any

from fuzzing.values import NAMES, free, number, value

Place = tuple[Any, Any]  # a table or list, and a key or index in it


def changed(data: dict[str, Any], rng: Random) -> dict[str, Any]:
    """Data, in place, after one to three mutations."""
    for _ in range(rng.choice([1, 1, 1, 2, 3])):
        _change(data, rng)
    return data


def places(data: Any) -> list[Place]:
    """Every place in the data, those of whole tables and lists included."""
    found: list[Place] = []
    items = data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list) else ()
    for key, inner in items:
        found.append((data, key))
        found += places(inner)
    return found


def paths(data: Any, above: str = "") -> list[str]:
    """Dotted paths of all values that are neither table nor list."""
    items = data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list) else ()
    found = []
    for key, inner in items:
        path = f"{above}.{key}" if above else str(key)
        found += paths(inner, path) or [path]
    return found


def _change(data: dict[str, Any], rng: Random) -> None:
    every = places(data)
    if not every:
        return
    # Places are many at the leaves and few at the top, where as much can go wrong.
    owner, key = rng.choice(every if rng.random() < 0.7 else [place for place in every if place[0] is data])
    old = owner[key]
    match rng.randrange(12):
        case 0 | 1 | 2 | 3:
            leaves = [p for p in every if isinstance(p[0][p[1]], int | float) and not isinstance(p[0][p[1]], bool)]
            owner, key = rng.choice(leaves or every)
            owner[key] = number(rng, owner[key] if leaves else None)
        case 4:
            owner[key] = value(rng)
        case 5:
            del owner[key]
        case 6:
            if isinstance(owner, dict):
                owner[rng.choice([*NAMES, str(key).upper(), f"{key}_"])] = owner.pop(key)
        case 7:
            if isinstance(owner, dict):
                owner[rng.choice(NAMES)] = value(rng)
            else:
                owner += [value(rng)] * rng.choice([1, 1, 30])
        case 8:
            owner[key] = free(rng) | ({"value": old, "min": old, "max": old} if rng.random() < 0.5 else {})
        case 9:
            owner[key] = {"same_as": rng.choice(paths(data))}
        case 10:
            other = rng.choice(every)
            owner[key] = other[0][other[1]]
            if _contains(owner[key], owner):
                owner[key] = old
        case 11:
            _rename(every, rng)


def _rename(every: list[Place], rng: Random) -> None:
    """Put a name, or another text that there is, in place of a text."""
    texts = [p for p in every if isinstance(p[0][p[1]], str)]
    if texts:
        owner, key = rng.choice(texts)
        owner[key] = rng.choice([*NAMES, *(p[0][p[1]] for p in texts)])


def _contains(data: Any, part: Any) -> bool:
    """Whether a table or list is part of the data, which then would have no end."""
    if data is part:
        return True
    inner = data.values() if isinstance(data, dict) else data if isinstance(data, list) else ()
    return any(_contains(item, part) for item in inner)
