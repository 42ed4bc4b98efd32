"""What a model of MuJoCo says and a scene does not hold, as notes."""

from __future__ import annotations

import numpy as np

from warpmuscle.core.plain_text import number_of
from warpmuscle.formats.mujoco.loops import CONNECT, WELD
from warpmuscle.formats.mujoco.reference import BALL, Reference
from warpmuscle.formats.mujoco.skeleton import JOINT_EQUALITY

KINDS = {3: "tendon", 4: "flex"}  # mjtEq


def tell_lost(reference: Reference) -> None:
    """Note equalities, frictions and limits that have no effect, and the medium around a model."""
    model = reference.model
    for eq in range(model.neq):
        kind = int(model.eq_type[eq])
        if kind not in (JOINT_EQUALITY, CONNECT, WELD) and model.eq_active0[eq]:
            name = model.equality(eq).name or str(eq)
            reference.lose(f"equality {name}", f"a {KINDS.get(kind, 'flexible')} holds nothing here")
    if soft := sum(bool(model.eq_active0[eq]) and model.eq_type[eq] == JOINT_EQUALITY for eq in range(model.neq)):
        reference.lose("equality", f"{number_of(int(soft), 'coupling')} of joints hold exactly; MuJoCo's give way")
    rubbing = [reference.name("joint", int(model.dof_jntid[k])) for k in range(model.nv) if model.dof_frictionloss[k]]
    for name in dict.fromkeys(rubbing):
        reference.lose(f"joint {name}", "its friction has no effect here")
    for body in np.flatnonzero(model.body_mocapid >= 0):
        reference.lose(f"body {reference.name('body', int(body))}", "a mocap body stays where it is here")
    for limited in np.flatnonzero(model.jnt_actfrclimited) if model.nu else ():
        name = reference.name("joint", int(limited))
        reference.lose(f"joint {name}", "the greatest force of its actuators (actuatorfrcrange) has no effect here")
    for joint in range(model.njnt):
        if model.jnt_type[joint] == BALL and model.jnt_limited[joint]:
            reference.lose(f"joint {reference.name('joint', joint)}", "its limit, a cone, has no effect here")
    if model.opt.density > 0.0 or model.opt.viscosity > 0.0:
        reference.lose("option", "density and viscosity of a medium have no effect here")
    if reference.gravity > 0.0 and (model.body_gravcomp != 0.0).any():
        reference.lose("gravcomp", "compensation of gravity has no effect here")
