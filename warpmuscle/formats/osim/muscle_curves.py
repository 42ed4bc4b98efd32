"""Curves of OpenSim's muscles: the names of their numbers there and here, and what most muscles of a model share."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from typing import Any

from warpmuscle.formats.osim import records
from warpmuscle.scene import (
    CurveShape,
    DeGrooteCurves,
    MillardCurves,
    Muscle,
    MuscleModel,
    ThelenCurves,
)

FAMILIES = {"Millard2012EquilibriumMuscle": "millard", "Thelen2003Muscle": "thelen",
    "DeGrooteFregly2016Muscle": "de_groote"}  # fmt: skip
SHAPES: dict[str, dict[str, str]] = {  # fields of the curves by the numbers of the model
    "millard": {
        "min_norm_active_fiber_length": "active_from", "transition_norm_fiber_length": "active_bend",
        "max_norm_active_fiber_length": "active_until", "shallow_ascending_slope": "active_slope",
        "minimum_value": "active_least", "concentric_slope_at_vmax": "shortening_end_slope",
        "concentric_slope_near_vmax": "shortening_slope", "isometric_slope": "isometric_slope",
        "eccentric_slope_at_vmax": "lengthening_end_slope", "eccentric_slope_near_vmax": "lengthening_slope",
        "max_eccentric_velocity_force_multiplier": "lengthening_force", "concentric_curviness": "shortening_curviness",
        "eccentric_curviness": "lengthening_curviness", "strain_at_zero_force": "passive_slack",
        "stiffness_at_low_force": "passive_low_slope", "norm_force_at_toe_end": "tendon_toe_force",
    },
    "thelen": {
        "KshapeActive": "active_width", "KshapePassive": "passive_shape", "Af": "velocity_shape",
        "Flen": "lengthening_force", "fv_linear_extrap_threshold": "straight_from",
    },
    "de_groote": {"active_force_width_scale": "active_width"},
}  # fmt: skip
TWICE = {  # numbers that two curves have by the same name
    ("FiberForceLengthCurve", "stiffness_at_one_norm_force"): "passive_slope",
    ("FiberForceLengthCurve", "curviness"): "passive_curviness",
    ("TendonForceLengthCurve", "stiffness_at_one_norm_force"): "tendon_slope",
    ("TendonForceLengthCurve", "curviness"): "tendon_curviness",
}
STRAINS = {  # of tendon and passive fibre at f_max
    "Thelen2003Muscle": ("FmaxTendonStrain", "FmaxMuscleStrain"),
    "DeGrooteFregly2016Muscle": (
        "tendon_strain_at_one_norm_force", "passive_fiber_strain_at_one_norm_force",
    ),
}  # fmt: skip
COMMON = ("v_max", "damping", "rise_time", "fall_time", "minimum_activation", "tendon_strain", "passive_strain",
    "tendon", "curve_shape")  # fmt: skip


def put_curves(one: records.Muscle, muscle: Muscle) -> None:
    """The strains and the curves' numbers of a muscle."""
    family = FAMILIES[one.kind]
    if one.kind in STRAINS:
        muscle.tendon_strain, muscle.passive_strain = (one.numbers[name] for name in STRAINS[one.kind])
    else:
        tendon = one.curves.get("TendonForceLengthCurve", {})
        passive = one.curves.get("FiberForceLengthCurve", {})
        muscle.tendon_strain = tendon.get("strain_at_one_norm_force", 0.049)
        muscle.passive_strain = passive.get("strain_at_one_norm_force", 0.7)
    names = SHAPES[family]
    values: dict[str, Any] = {names[name]: number for name, number in one.numbers.items() if name in names}
    for curve, numbers in one.curves.items():
        for name, number in numbers.items():
            field = TWICE.get((curve, name), names.get(name))
            if field is not None:
                values[field] = number
    shapes: dict[str, type[CurveShape]] = {
        "millard": MillardCurves, "thelen": ThelenCurves, "de_groote": DeGrooteCurves,
    }  # fmt: skip
    muscle.curve_shape = shapes[family](**values)
    if one.truths["ignore_passive_fiber_force"] and isinstance(muscle.curve_shape, DeGrooteCurves):
        muscle.curve_shape.passive = False


def settle(common: MuscleModel, muscles: Iterable[Muscle]) -> None:
    """Give the model of all muscles the values that most of them have, and those their own no longer."""
    every = list(muscles)
    for field in COMMON:
        candidates = [getattr(muscle, field) for muscle in every]
        if field == "curve_shape":
            candidates = [shape for shape in candidates if shape.__struct_config__.tag == common.curves]
        values = Counter(map(repr, candidates)).most_common(1)
        value = next(one for one in candidates if repr(one) == values[0][0])
        setattr(common, field, value)
        for muscle in every:
            if getattr(muscle, field) == value:
                setattr(muscle, field, None)
