"""Terms of a scene's own that see the torques which the controller wants of joints, by the joints' names."""

from functools import cache
from typing import Any

import warp as wp

from warpmuscle.kernels.structs import ModelRef, ScratchRef, StateRef


@cache
def term_of_desired(term: Any, struct: Any, bodies: tuple[int, ...]) -> Any:
    """The Warp function (instance, model, state, work) -> float of a term that takes a structure of torques besides.

    It must be called where the working set has the controller's torques, before muscles act.

    Args:
        term: Warp function (instance, model, state, work, torques) -> float.
        struct: of the torques, `wp.vec3` each. bodies: that the joints of its fields carry, in their order.
    """
    lines = (
        f"torques.{name} = *wp::address(work.torque, {body});" for name, body in zip(struct.vars, bodies, strict=True)
    )

    @wp.func_native(snippet="\n".join(lines))
    def look(torques: wp.ref[struct], work: ScratchRef): ...

    @wp.func
    def with_torques(instance: int, model: ModelRef, state: StateRef, work: ScratchRef) -> float:
        torques = struct()
        look(torques, work)
        return term(instance, model, state, work, torques)

    return with_torques
