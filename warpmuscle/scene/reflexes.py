"""Muscle reflexes of a scene: excitations from what legs feel, in place of those from wanted torques.

Units are SI and radians; see `scene.py`. The equations stand in `kernels/control/reflex.py`.
"""

from __future__ import annotations

from typing import Annotated, Literal

from warpmuscle.scene.number import Number
from warpmuscle.scene.part import FRACTION, FROM_0, Part

Signal = Literal[
    "constant", "force", "length", "velocity", "lean", "lean_at_lift", "angle", "load", "other_load"
]  # fmt: skip


OF_MUSCLES = ("force", "length", "velocity")  # signals


class Reflex(Part):
    """One term of a muscle's excitation: gain part(signal - offset + lead rate), times a load, in a phase of a leg.

    `signal`: constant, 1; of muscle `of` force over f_max, length over l_opt, or velocity in l_opt/s; angle of joint
    `of`, a hinge, or the first of a universal joint; forward lean of the trunk, or what it was as the leg last left the
    ground; load, the vertical ground force on the leg in body weights, or other_load, that on the other one.
    `rate` is the signal's own, of what has one: length, lean and angle.
    `during`: stance, the leg is loaded; swing, it is not; trailing, in stance after the other leg has landed.
    `side`: of which leg's muscle.
    """

    gain: Annotated[Number, "1"]
    signal: Signal = "constant"
    of: str = ""  # muscle or joint without its l or r; the muscle itself if empty
    offset: Annotated[Number, "1"] = 0.0
    lead: Annotated[Number, "s"] = 0.0
    part: Literal["all", "positive", "negative"] = "all"
    moving: Literal["either", "rising", "falling"] = "either"  # it acts only while the signal rises, or falls
    during: Literal["always", "stance", "swing", "trailing"] = "always"
    times: Literal["once", "load", "other_load"] = "once"
    side: Literal["both", "left", "right"] = "both"


class Reflexes(Part):
    """Reflexes of both legs by muscle without its l or r, `SOL` for `lSOL` and `rSOL`; each has names of one's own.

    A muscle hears the sum of its reflexes after its own delay; it does not listen to wanted torques then. Those drive
    all muscles without reflexes, and what torques drive. As in Geyer and Herr 2010.
    With `besides`, muscles hear what torques want of them and their reflexes together, as spastic ones do.
    """

    muscles: dict[str, dict[str, Reflex]]
    trunk: str = "torso"  # the body whose lean is felt
    stance_load: Annotated[Number, "1", FROM_0] = 0.05  # body weights; a leg that carries more stands
    least: Annotated[Number, "1", FRACTION] = 0.01  # excitation that muscles with reflexes have, unless `besides`
    besides: bool = False
