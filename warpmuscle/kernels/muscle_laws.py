"""The laws of muscles, by the name that a scene has for them."""

from warpmuscle.kernels.hill_law import HILL
from warpmuscle.kernels.ideal_law import IDEAL
from warpmuscle.kernels.legacy_law import LEGACY
from warpmuscle.kernels.muscle_kind import MuscleLaw

LAWS: dict[str, MuscleLaw] = {"hill": HILL, "legacy": LEGACY, "ideal": IDEAL}
