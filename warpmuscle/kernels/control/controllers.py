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
CONTROLLERS = {name: controller._replace(shipped=True) for name, controller in CONTROLLERS.items()}
