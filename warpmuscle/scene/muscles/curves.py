"""Numbers of the curves of OpenSim's muscles, where they are not the defaults; each type is one family of curves.

The strains of tendon and passive fibre at f_max, which all families have, are fields of `Muscle` and `MuscleModel`.
Lengths are over l_opt, forces over f_max, speeds over v_max, positive when lengthening.
"""

from __future__ import annotations

from typing import Annotated, Literal

from warpmuscle.scene.displacement import Displacement
from warpmuscle.scene.muscles.cables import BlankevoortLigament, Ligament, PathActuator
from warpmuscle.scene.number import Number
from warpmuscle.scene.part import ABOVE_0, FROM_0, Part

STRAINS = {  # of tendon and passive fibre
    "millard": (0.049, 0.7), "thelen": (0.04, 0.6), "de_groote": (0.049, 0.6), "mujoco": (0.04, 0.6),
    "spline": (0.04, 0.6),
}  # fmt: skip
SHAPED = ("tendon_strain", "passive_strain", "curve_shape")  # fields of `Muscle` and `MuscleModel` that shape curves
SPECIAL = (  # fields of `Muscle` in place of those of `MuscleModel`
    "tendon", "v_max", "damping", "rise_time", "fall_time", "activation", "activation_smoothing", "minimum_activation",
    *SHAPED,
)  # fmt: skip
LEAST_DAMPING = (
    1.0e-3  # of a compliant Millard muscle; with less, OpenSim changes the curves so that they can be solved
)


class MillardCurves(Part, tag_field="type", tag="millard"):
    """The curves of OpenSim's Millard2012EquilibriumMuscle; defaults are those of OpenSim 4.6.

    They are tables of quintic Bezier curves, so that a search cannot change them. None: as OpenSim derives it, from the
    strain (passive_slope = 2/(passive_strain - passive_slack), passive_low_slope = 0.2, passive_curviness = 0.75,
    tendon_slope = 1.375/tendon_strain, tendon_toe_force = 2/3, tendon_curviness = 0.5).
    A fibre is not shorter than active_from, nor so short that its pennation exceeds acos(0.1).
    """

    active_from: Annotated[float, "1"] = 0.4441  # min_norm_active_fiber_length
    active_bend: Annotated[float, "1"] = 0.73  # transition_norm_fiber_length
    active_until: Annotated[float, "1"] = 1.8123  # max_norm_active_fiber_length
    active_slope: Annotated[float, "1"] = 0.8616  # shallow_ascending_slope
    active_least: Annotated[float, "1"] = 0.0  # minimum_value
    shortening_end_slope: Annotated[float, "1"] = 0.0  # concentric_slope_at_vmax
    shortening_slope: Annotated[float, "1"] = 0.25  # concentric_slope_near_vmax
    isometric_slope: Annotated[float, "1"] = 5.0
    lengthening_slope: Annotated[float, "1"] = 0.15  # eccentric_slope_near_vmax
    lengthening_end_slope: Annotated[float, "1"] = 0.0  # eccentric_slope_at_vmax
    lengthening_force: Annotated[float, "1"] = 1.4  # max_eccentric_velocity_force_multiplier
    shortening_curviness: Annotated[float, "1"] = 0.6  # concentric_curviness
    lengthening_curviness: Annotated[float, "1"] = 0.9  # eccentric_curviness
    passive_slack: Annotated[float, "1"] = 0.0  # strain_at_zero_force
    passive_low_slope: Annotated[float | None, "1"] = None  # stiffness_at_low_force
    passive_slope: Annotated[float | None, "1"] = None  # stiffness_at_one_norm_force
    passive_curviness: Annotated[float | None, "1"] = None
    tendon_slope: Annotated[float | None, "1"] = None  # stiffness_at_one_norm_force
    tendon_toe_force: Annotated[float | None, "1"] = None  # norm_force_at_toe_end
    tendon_curviness: Annotated[float | None, "1"] = None


class ThelenCurves(Part, tag_field="type", tag="thelen"):
    """The curves of OpenSim's Thelen2003Muscle; defaults are those of OpenSim 4.6. A fibre may be as short as 0.01."""

    active_width: Annotated[Number, "1", ABOVE_0] = 0.45  # KshapeActive
    passive_shape: Annotated[Number, "1", ABOVE_0] = 5.0  # KshapePassive
    velocity_shape: Annotated[Number, "1", ABOVE_0] = 0.25  # Af
    lengthening_force: Annotated[Number, "1"] = 1.4  # Flen
    straight_from: Annotated[Number, "1"] = 0.95  # fv_linear_extrap_threshold, of lengthening_force


class DeGrooteCurves(Part, tag_field="type", tag="de_groote"):
    """The curves of OpenSim's DeGrooteFregly2016Muscle; defaults are those of OpenSim 4.6."""

    active_width: Annotated[Number, "1", ABOVE_0] = 1.0  # active_force_width_scale
    passive: bool = True  # not ignore_passive_fiber_force


class MujocoCurves(Part, tag_field="type", tag="mujoco"):
    """The curves of MuJoCo's muscle actuators, by their defaults; the tendon is rigid, and strains have no effect."""

    active_from: Annotated[Number, "1", FROM_0] = 0.5  # lmin
    active_until: Annotated[Number, "1"] = 1.6  # lmax
    passive_force: Annotated[Number, "1", FROM_0] = 1.3  # fpmax: twice the force half-way to passive_until
    lengthening_force: Annotated[Number, "1"] = 1.2  # fvmax
    passive_from: Annotated[Number, "1"] = 1.0  # where the passive force begins, as `biasprm` may say
    passive_until: Annotated[Number | None, "1"] = None  # lmax of the passive force; None: active_until


class Spline(Part):
    """A function through knots (x, y), as that of a `Displacement`."""

    x: Annotated[list[float], "1"]
    y: Annotated[list[float], "1"]
    ends: Literal["simm", "natural", "linear"] = "simm"

    @property
    def displacement(self) -> Displacement:
        """The same function as one of a coordinate, along x."""
        return Displacement((1.0, 0.0, 0.0), x=self.x, y=[*self.y], ends=self.ends)


class SplineCurves(Part, tag_field="type", tag="spline"):
    """Curves through knots, as those of OpenSim's Schutte1993Muscle_Deprecated and RigidTendonMuscle.

    Without a `velocity`, force over speed is Schutte's (1993): (1 + v)/(1 - v/0.15) shortening, and lengthening
    (1.4 v + s)/(v + s) with s = 0.13 * 0.15/1.15. They are tables on the device, so that a search cannot change them.
    Strains of tendon and passive fibre have no effect.
    """

    active: Spline  # over length
    passive: Spline  # over length
    tendon: Spline  # over strain
    velocity: Spline | None = None  # over speed


CurveShape = (
    MillardCurves
    | ThelenCurves
    | DeGrooteCurves
    | MujocoCurves
    | SplineCurves
    | PathActuator
    | Ligament
    | BlankevoortLigament
)


def family(shape: CurveShape) -> str:
    """The name of the curves of a shape, as `MuscleModel.curves` has them."""
    return str(shape.__struct_config__.tag)
