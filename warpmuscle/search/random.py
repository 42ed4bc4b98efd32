"""Random search: independent candidates, uniform within their intervals, to a given precision."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


class RandomSearch:
    """Uniform candidates (Bergmann 2017, section 6); the first one is where the search starts.

    Candidate k is the same for a given seed however many are asked for at a time.
    """

    def __init__(self, start: Floats, low: Floats, high: Floats, seed: int) -> None:
        """Search low..high, (P,) each, from a start (P,)."""
        self._start, self._low, self._high = start, low, high
        self._generator = np.random.default_rng(seed)
        self._first = True

    def ask(self, count: int) -> Floats:
        """The next candidates, (count, P)."""
        values = self._generator.uniform(self._low, self._high, size=(count, len(self._low)))
        if self._first and count > 0:
            values[0] = self._start
            self._first = False
        return values

    def tell(self, candidates: Floats, costs: Floats) -> None:
        """Costs (count,) of candidates (count, P); random search learns nothing from them."""
