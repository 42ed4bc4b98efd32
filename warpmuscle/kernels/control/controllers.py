"""Controllers that a scene chooses by `type` in its `[controller]`, besides SIMBICON; to add one, name it here."""

from warpmuscle.kernels.control.control import CustomController
from warpmuscle.kernels.control.joint_pd import joint_pd
from warpmuscle.kernels.control.walking.controller import walking
from warpmuscle.kernels.program.controller import quadratic_program

CONTROLLERS: dict[str, CustomController] = {
    "joint_pd": joint_pd,
    "walking": walking,
    "quadratic_program": quadratic_program,
}


def checked(name: str, controller: CustomController) -> CustomController:
    """A controller that drives something; TypeError if it has no function that does."""
    if controller.effort is None and (controller.damping is not None or controller.excitation is None):
        raise TypeError(
            f"controller {name!r} in CONTROLLERS needs a Warp function: `effort` of joints, or `excitation`"
        )
    return controller


CONTROLLERS = {name: checked(name, one)._replace(shipped=True) for name, one in CONTROLLERS.items()}
