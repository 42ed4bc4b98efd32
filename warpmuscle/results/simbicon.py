"""What frames hold of a SIMBICON controller; motions under other controllers, or none, lack it."""

from warpmuscle.results.quantity import quantity

_FRAME = ("frame",)

PHASE = quantity(
    "1", _FRAME, "phase of the controller's state, 0 to 1 or more", lambda raw: raw.recorded("simbicon.phase")
)
STANCE = quantity("1", _FRAME, "stance foot: 0 left, 1 right", lambda raw: raw.recorded("simbicon.stance"))
STATE = quantity("1", _FRAME, "index of the controller's state", lambda raw: raw.recorded("simbicon.machine_state"))
