"""The laws of muscles, by the name that a scene has for them."""

from warpmuscle.kernels.muscle.hill_law import HILL
from warpmuscle.kernels.muscle.ideal_law import IDEAL
from warpmuscle.kernels.muscle.legacy_law import LEGACY
from warpmuscle.kernels.muscle.muscle_kind import MuscleLaw

LAWS: dict[str, MuscleLaw] = {"hill": HILL, "legacy": LEGACY, "ideal": IDEAL}
