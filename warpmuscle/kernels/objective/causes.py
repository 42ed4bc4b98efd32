"""Which of a scene's own parts, or of what is given from outside, ended an instance; `model/causes.py` has the names.

A part is seen where it returns its value, before the value is added to others: later, everything is NaN. Only parts of
users are looked at, and only kernels that have some have this compiled in.
"""

import warp as wp

from warpmuscle.kernels.functions import func
from warpmuscle.kernels.objective.failure import is_somewhere
from warpmuscle.kernels.structs import LARGEST, ScratchRef, StateRef

TERM, FORCE, EFFORT, EXCITATION, GIVEN_TORQUE, GIVEN_EXCITATION, CONDITION = range(1, 8)  # what it is
KINDS = 256  # of each, that numbers have room for
ENTRY = 8 * KINDS


def cause_of(part: int, kind: int = 0) -> int:
    """The number of a part, TERM ..., the `kind`-th of its sort; a joint, force or muscle times ENTRY is added."""
    return part + 8 * min(kind, KINDS - 1)


@func
def blame(instance: int, cause: int, state: StateRef, work: ScratchRef):
    """Let an instance have diverged because of a part; the first of them counts."""
    if state.cause[instance] == 0:
        state.cause[instance] = cause
    work.flags[1] = 1


@func
def checked(value: float, instance: int, cause: int, state: StateRef, work: ScratchRef) -> float:
    """The value of a part, which is to blame if it is none or beyond all bounds."""
    if not (wp.abs(value) < LARGEST):
        blame(instance, cause, state, work)
    return value


@func
def checked_vector(value: wp.vec3, instance: int, cause: int, state: StateRef, work: ScratchRef) -> wp.vec3:
    """The same of a vector."""
    if not is_somewhere(value):
        blame(instance, cause, state, work)
    return value
