"""Sequences made to rise by as little as possible."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from warpmuscle.core.array_types import Floats


def rising(values: Iterable[float]) -> Floats:
    """The sequence that never falls and has the least squared distance from values (n,), (n,).

    Neighbours that fall are pooled (Ayer 1955).
    """
    blocks: list[list[float]] = []  # of pooled neighbours: their mean and number
    for value in values:
        blocks.append([float(value), 1.0])
        while len(blocks) > 1 and blocks[-2][0] > blocks[-1][0]:
            (a, m), (b, n) = blocks[-2:]
            blocks[-2:] = [[(a * m + b * n) / (m + n), m + n]]
    return np.repeat([block[0] for block in blocks], [int(block[1]) for block in blocks])
