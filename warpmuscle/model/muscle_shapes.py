"""Shapes of curves, tendons and least activations, as a kernel wants them where muscles differ in these."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from typing import Any, NamedTuple

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.arrays import rows
from warpmuscle.kernels import structs
from warpmuscle.kernels.curve import splines
from warpmuscle.kernels.curve.curve_sets import BLANKEVOORT, CURVES, LIGAMENT, PATH_ACTUATOR, SPLINE
from warpmuscle.kernels.curve.millard_tables import Numbers, table_of
from warpmuscle.kernels.curve.shaped_curves import FAMILIES, Shaped
from warpmuscle.kernels.muscle.contraction import COMPLIANT, EITHER, RIGID, SWITCH
from warpmuscle.model.expressions.curve_tables import spline_table
from warpmuscle.model.expressions.programs import piece_rows
from warpmuscle.scene import (
    BlankevoortLigament,
    CurveShape,
    DeGrooteCurves,
    Displacement,
    Ligament,
    MillardCurves,
    MujocoCurves,
    Muscle,
    MuscleModel,
    SplineCurves,
    ThelenCurves,
)
from warpmuscle.scene.muscles import given, is_cable
from warpmuscle.scene.muscles.curves import LEAST_DAMPING, SHAPED, STRAINS, family

TENDON = {"rigid": RIGID, "switch": SWITCH, "compliant": COMPLIANT}
DEFAULTS: dict[str, CurveShape] = {
    "millard": MillardCurves(), "thelen": ThelenCurves(), "de_groote": DeGrooteCurves(), "mujoco": MujocoCurves(),
}  # fmt: skip
NUMBERS = CURVES | {"spline": SPLINE}  # of families
MOST_END_SLOPE = 0.99  # of the slope near the end: with that slope itself, the curve has no corner there
LEAST_END_SLOPE, LEAST_ACTIVE, LEAST_ACTIVATION = 0.1, 0.1, 0.01  # of a compliant Millard muscle without damping


class Shapes(NamedTuple):
    """What the device has of the shapes of some muscles."""

    columns: dict[str, Floats]  # (rows, muscles) by field of `kernels.structs.CurveRow`
    table: Floats  # (knots, 2)


def tendon_kind(muscles: Sequence[Muscle], model: MuscleModel) -> int:
    """Which tendons some muscles have."""
    tendons = {muscle.tendon or model.tendon for muscle in muscles} or {model.tendon}
    return TENDON[tendons.pop()] if len(tendons) == 1 else int(EITHER)


def shaped_kind(muscles: Sequence[Muscle], model: MuscleModel) -> Shaped | None:
    """The families of curves of some muscles, if any has a shape that is not the default one."""
    if not any(given(muscle, model, field) is not None for muscle in muscles for field in SHAPED):
        return None
    families = {NUMBERS[family(_shape(muscle, model))] for muscle in muscles if not is_cable(muscle)}
    usual = {CURVES[model.curves]} & FAMILIES.keys() or {min(FAMILIES)}  # where none is a muscle
    return Shaped(tuple(sorted(families or usual)), any(map(is_cable, muscles)))


def has_floor(muscles: Sequence[Muscle], model: MuscleModel) -> bool:
    """Whether some muscle of a scene, whose numbers may be free, has a least activation."""
    floors = [_floor(muscle, model) for muscle in muscles]
    return any(not isinstance(floor, float) or floor > 0.0 for floor in floors)


def muscle_shapes(muscles: Sequence[Muscle], model: MuscleModel, before: Floats | None = None) -> Shapes | None:
    """The shapes of some muscles; None where muscles do not differ in such things.

    Args:
        before: rows (n, 2) that the table begins with.
    """
    shaped = shaped_kind(muscles, model)
    if shaped is None and tendon_kind(muscles, model) != EITHER and not has_floor(muscles, model):
        return None
    tables = _Tables(before)
    entries = [_entry(muscle, model, shaped is not None, tables) for muscle in muscles]
    columns = {field: rows([_number(entry.get(field, 0.0)) for entry in entries]) for field in structs.CurveRow.vars}
    return Shapes(columns, tables.joined())


class _Tables:
    """Tables one behind the other, each once."""

    def __init__(self, before: Floats | None = None) -> None:
        self._starts: dict[Hashable, int] = {}
        self._made: list[Floats] = [] if before is None or not len(before) else [before]

    def start(self, key: Hashable, make: Callable[[], Floats]) -> int:
        """The first row of a table, which is made if there is none of this key."""
        if key not in self._starts:
            self._starts[key] = sum(map(len, self._made))
            self._made.append(make())
        return self._starts[key]

    def joined(self) -> Floats:
        """All of them, (knots, 2)."""
        return np.concatenate(self._made) if self._made else np.zeros((1, 2))


def _number(value: Any) -> Any:
    """An array with a value an instance, or a float for one without dimensions."""
    return value if np.ndim(value) else float(value)


def _shape(muscle: Muscle, model: MuscleModel) -> CurveShape:
    return given(muscle, model, "curve_shape") or DEFAULTS[model.curves]


def _entry(muscle: Muscle, model: MuscleModel, shaped: bool, tables: _Tables) -> dict[str, Any]:
    """The fields of a muscle's row that are not zero; `tables` gets what tables there are to be."""
    if is_cable(muscle):
        return _cable(muscle, tables)
    entry = {"tendon": TENDON[muscle.tendon or model.tendon], "minimum_activation": _floor(muscle, model)}
    if not shaped:
        return entry
    shape = _shape(muscle, model)
    name = family(shape)
    default_tendon, default_passive = STRAINS[name]
    tendon, passive = (given(muscle, model, field) for field in ("tendon_strain", "passive_strain"))
    tendon = np.asarray(default_tendon if tendon is None else tendon, dtype=np.float64)
    passive = np.asarray(default_passive if passive is None else passive, dtype=np.float64)
    entry |= {"curves": NUMBERS[name], "tendon_rate": 1.0 / tendon}
    if isinstance(shape, SplineCurves):
        own = splines.SHAPE if shape.velocity is None else 0.0
        start = tables.start(repr(shape), lambda: spline_table(shape))
        return entry | {"tendon_rate": 1.0, "table": start, "shortest": splines.SHORTEST, "velocity_shape": own}
    if isinstance(shape, MillardCurves):
        numbers = millard_numbers(shape, float(tendon.flat[0]), float(passive.flat[0]), _undamped(muscle, model))
        return entry | {"table": tables.start(numbers, lambda: table_of(numbers)), "shortest": shape.active_from}
    if isinstance(shape, ThelenCurves):
        return entry | _thelen(shape, passive)
    if isinstance(shape, MujocoCurves):
        return entry | {
            "shortest": shape.active_from,
            "active_width": shape.active_until,
            "passive_floor": shape.passive_from,
            "passive_rate": shape.active_until if shape.passive_until is None else shape.passive_until,
            "passive_scale": shape.passive_force,
            "lengthening_force": shape.lengthening_force,
        }
    assert isinstance(shape, DeGrooteCurves)
    floor = np.exp(4.0 * (0.2 - 1.0) / passive)
    return entry | {
        "shortest": 0.2,
        "active_width": 1.0 / np.asarray(shape.active_width),
        "passive_rate": 4.0 / passive,
        "passive_floor": floor,
        "passive_scale": float(shape.passive) / (np.exp(4.0) - floor),
    }


def _cable(muscle: Muscle, tables: _Tables) -> dict[str, Any]:
    """What a row has of an actuator or a ligament."""
    shape = muscle.curve_shape
    if isinstance(shape, BlankevoortLigament):
        row = (shape.transition_strain, shape.damping)
        return {"curves": BLANKEVOORT, "table": tables.start(("blankevoort", *row), lambda: np.array([row]))}
    if not isinstance(shape, Ligament):
        return {"curves": PATH_ACTUATOR}
    key = (*shape.x, *shape.y, shape.ends, shape.dissipation)
    return {"curves": LIGAMENT, "table": tables.start(key, lambda: ligament_table(shape))}


def ligament_table(ligament: Ligament) -> Floats:
    """The function of a ligament as `kernels.muscle.cables.ligament_tension` reads it."""
    function = Displacement((1.0, 0.0, 0.0), x=ligament.x, y=[*ligament.y], ends=ligament.ends)
    return piece_rows(function, ligament.dissipation)


def _thelen(shape: ThelenCurves, passive: Floats) -> dict[str, Any]:
    """What a row has of Thelen's curves; straight_speed: where the multiplier is straight_from lengthening_force."""
    longest, a = np.asarray(shape.lengthening_force), np.asarray(shape.velocity_shape)
    edge = longest * np.asarray(shape.straight_from)
    return {
        "shortest": FAMILIES[CURVES["thelen"]].shortest,
        "active_width": shape.active_width,
        "passive_rate": np.asarray(shape.passive_shape) / passive,
        "passive_floor": 1.0,
        "passive_scale": 1.0 / np.expm1(np.asarray(shape.passive_shape)),
        "velocity_shape": a,
        "lengthening_force": longest,
        "straight_speed": (edge - 1.0) * (longest - 1.0) / ((2.0 + 2.0 / a) * (longest - edge)),
    }


def millard_numbers(c: MillardCurves, tendon: float, passive: float, undamped: bool) -> Numbers:
    """What a table is made of: as OpenSim's muscle takes it, which asks for some of the numbers only without damping.

    Args:
        tendon, passive: strains at f_max. undamped: whether the tendon is compliant and the fibre not damped.
    """
    ends = c.shortening_end_slope, c.lengthening_end_slope
    if not undamped:
        ends = 0.0, 0.0
    elif min(ends) < LEAST_END_SLOPE:
        ends = LEAST_END_SLOPE, LEAST_END_SLOPE
    near = c.shortening_slope, c.lengthening_slope
    ends = min(ends[0], MOST_END_SLOPE * near[0]), min(ends[1], MOST_END_SLOPE * near[1])
    own = {field: value for field in Numbers._fields if (value := getattr(c, field, None)) is not None}
    derived = {
        "passive_strain": passive,
        "passive_low_slope": 0.2,
        "passive_slope": 2.0 / (passive - c.passive_slack),
        "passive_curviness": 0.75,
        "tendon_toe_force": 2.0 / 3.0,
        "tendon_curviness": 0.5,
    }
    in_use = {
        "active_least": max(c.active_least, LEAST_ACTIVE) if undamped else 0.0,
        "shortening_end_slope": ends[0],
        "lengthening_end_slope": ends[1],
        "tendon_slope": 1.375 if c.tendon_slope is None else c.tendon_slope * tendon,
    }
    return Numbers(**derived | own | in_use)


def _undamped(muscle: Muscle, model: MuscleModel) -> bool:
    damping = given(muscle, model, "damping")
    compliant = TENDON[muscle.tendon or model.tendon] == COMPLIANT
    return compliant and isinstance(damping, float) and damping < LEAST_DAMPING


def _floor(muscle: Muscle, model: MuscleModel) -> Any:
    """The least activation of a muscle."""
    floor = given(muscle, model, "minimum_activation")
    shaped = any(given(muscle, model, field) is not None for field in SHAPED)
    if shaped and isinstance(_shape(muscle, model), MillardCurves) and _undamped(muscle, model):
        return max(floor, LEAST_ACTIVATION) if isinstance(floor, float) else floor
    return floor
