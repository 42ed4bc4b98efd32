"""The description of a character, its controller, task and objective, as data: what a TOML file says.

`scene.scene.Scene` is the whole; parts stand in `part`, `controller`, `muscles`, `force`, `motion` and `reflexes`. What
is computed from a description without simulating it lives here, too: its tree of joints (`topology`), its free
parameters, masses, units, published norms. `validation` says what a scene must fulfil.

May import: core, kernels.
To add: a field to the part that it belongs to, with its unit and range, `Annotated[Number, "m", ABOVE_0]`; what else is
to be checked into `validation`.
"""

from typing import TYPE_CHECKING

from warpmuscle.kernels.moved import of_former_names
from warpmuscle.scene.scene import *  # noqa: F403, the names of its `__all__`
from warpmuscle.scene.scene import __all__ as __all__

if not TYPE_CHECKING:
    __getattr__ = of_former_names(__name__, {"State": "MachineState"})
