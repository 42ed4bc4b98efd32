"""Laws of muscles, by the name that a scene has for them. Without Warp, for scenes to know.

A law is a file of its name, `hill_law.py` for hill, with a `muscle_kind.MuscleLaw` of its name in capitals, `HILL`.

- hill: activation dynamics, and contraction of a fibre on a tendon, by the curves of the model.
- legacy: exactly as the program of Bergmann 2017 computed it, unbounded, with its switch and its old moment arms.
- ideal: the desired force at once, without activation and contraction (Bergmann 2017, section 7.1).
"""

from typing import Literal, get_args

Law = Literal["hill", "legacy", "ideal"]
NAMES: tuple[str, ...] = get_args(Law)
