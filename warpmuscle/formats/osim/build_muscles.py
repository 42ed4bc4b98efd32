"""Muscles, their paths and the surfaces that these wrap over, from a model's records."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable
from typing import Any, Literal

import numpy as np

from warpmuscle.core.plain_text import number_of
from warpmuscle.formats.lines import Notes
from warpmuscle.formats.osim import records
from warpmuscle.formats.osim.cables import made_cable
from warpmuscle.formats.osim.chain import set_function
from warpmuscle.formats.osim.frames import note, on_body, refused, turned
from warpmuscle.formats.osim.functions import ENDLESS, Function, span_within, spans_within
from warpmuscle.formats.osim.joints.several import powers
from warpmuscle.formats.osim.moves import Coordinates, finite_range
from warpmuscle.formats.osim.placement import Placement, direction, rotation_vector, vector
from warpmuscle.formats.osim.records import Model
from warpmuscle.scene import (
    Condition,
    CurveShape,
    CylinderSurface,
    DeGrooteCurves,
    EllipsoidSurface,
    MillardCurves,
    Muscle,
    MuscleModel,
    PointMotion,
    PolynomialPath,
    SphereSurface,
    Spline,
    SplineCurves,
    Surface,
    ThelenCurves,
    TorusSurface,
    ViaPoint,
    Wrap,
)
from warpmuscle.scene.muscles import is_cable
from warpmuscle.scene.number import Number

SIDES = {"all": "", "unassigned": "", "": "", **{f"{s}{a}": f"{s or '+'}{a}" for s in ("", "+", "-") for a in "xyz"}}
METHODS = ("hybrid", "midpoint", "axial")
AT_ONCE = 1.0e-6  # s, time constants with which an activation is the excitation after every step
MARGIN = 1.0e-5  # rad or m, by which OpenSim's conditional points count beyond the ends of their range

MOST_CONTROL = 1.0e3  # of a muscle whose control has no bound
FAMILIES = {"Millard2012EquilibriumMuscle": "millard", "Thelen2003Muscle": "thelen",
    "DeGrooteFregly2016Muscle": "de_groote"}  # fmt: skip
BLENDED = "DeGrooteFregly2016Muscle"  # the class whose activation rises and falls by a law of its own
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
LEAST_FORCE, LEAST_TENDON = 1.0e-6, 1.0e-6  # N, m, of muscles that have none
COMMON = ("v_max", "damping", "rise_time", "fall_time", "minimum_activation", "tendon_strain", "passive_strain",
    "tendon", "curve_shape")  # fmt: skip


def build_surfaces(model: Model, placement: Placement) -> dict[str, Surface]:
    """The surfaces that some muscle wraps over."""
    used = {wrap.surface for muscle in model.muscles for wrap in muscle.wraps}
    return {name: _surface(model, one, placement) for name, one in model.surfaces.items() if name in used}


def _surface(model: Model, one: records.Surface, placement: Placement) -> Surface:
    body, position = placement.point(one.frame, one.translation)
    turn = rotation_vector(placement.axes(one.frame) @ turned(one.rotation))
    if one.quadrant not in SIDES:
        raise refused(model, one.line, f"surface {one.name!r}: there is no quadrant {one.quadrant!r}")
    side = SIDES[one.quadrant]
    sizes = one.sizes
    match one.kind:
        case "WrapCylinder":
            return CylinderSurface(body, position, sizes[0], sizes[1], turn, side, one.side_point)  # type: ignore[arg-type]
        case "WrapSphere":
            return SphereSurface(body, position, sizes[0], turn, side)  # type: ignore[arg-type]
        case "WrapEllipsoid":
            return EllipsoidSurface(body, position, vector(np.array(sizes)), turn, side)  # type: ignore[arg-type]
    return TorusSurface(body, position, sizes[0], sizes[1], turn, side)  # type: ignore[arg-type]


def controls_of(model: records.Model, notes: Notes) -> dict[str, tuple[float, float]]:
    """Bounds of the controls of muscles where they are not the least activation and 1."""
    found = {}
    for one in model.muscles:
        if one.kind in FAMILIES:
            least = one.numbers.get("minimum_activation", 0.0)
            low, high = max(one.numbers["min_control"], least), max(one.numbers["max_control"], least)
            if low > high:
                reason = f"its min_control, {low:g}, is above its max_control, {high:g}: neither counts"
                note(notes, model, one, reason)
            elif (low, high) != (least, 1.0):
                found[one.name] = (low, min(high, MOST_CONTROL))
    return found


class MuscleBuilder:
    """Makes muscles of the records of one model."""

    def __init__(self, model: Model, placement: Placement, coordinates: Coordinates, notes: Notes) -> None:
        self._model, self._placement, self._coordinates, self._notes = model, placement, coordinates, notes

    def build(self) -> tuple[MuscleModel, dict[str, Muscle]]:
        """What all muscles have in common, and the muscles with what they have of their own."""
        found: dict[str, Muscle] = {}
        activations: Counter[float] = Counter()
        kinds: Counter[str] = Counter()
        for one in self._model.muscles:
            cable = None
            if one.kind not in FAMILIES:
                cable, reason = made_cable(one)
                if reason:
                    note(self._notes, self._model, one, reason)
                if cable is None:
                    continue
            made = self._routed(one, cable or self._muscle(one))
            if made.polynomial is None and len(made.path) < 2:
                reason = f"left out: of its path {number_of(len(made.path), 'point')} can count, where it takes two"
                note(self._notes, self._model, one, reason)
                continue
            found[one.name] = made
            self._notes.places[f"character.muscles.{one.name}"] = (self._model.file, one.line)
            if cable is not None:
                continue
            activations[one.numbers["default_activation"]] += 1
            kinds[FAMILIES[one.kind]] += 1
        if not kinds:
            return MuscleModel(curves="millard" if found else "lee"), found
        laws = {one.name: _activation(one) for one in self._model.muscles if one.name in found and one.kind in FAMILIES}
        common = MuscleModel(curves=kinds.most_common(1)[0][0], activation=Counter(laws.values()).most_common(1)[0][0])
        for name, law in laws.items():
            found[name].activation = law if law != common.activation else None
        common.initial_activation = activations.most_common(1)[0][0]
        if len(activations) > 1:
            others = sum(activations.values()) - activations[common.initial_activation]
            first = next(m for m in self._model.muscles if m.kind in FAMILIES)
            reason = (
                f"{number_of(others, 'muscle', 'start')} from another default_activation; all start from that of most"
            )
            note(self._notes, self._model, first, reason)
        settle(common, [muscle for muscle in found.values() if not is_cable(muscle)])
        return common, found

    def _muscle(self, one: records.Muscle) -> Muscle:
        """A muscle with all its values as its own."""
        n = one.numbers
        self._tell_zeros(one)
        muscle = Muscle(
            f_max=n["max_isometric_force"] or LEAST_FORCE, l_opt=n["optimal_fiber_length"],
            l_slack=n["tendon_slack_length"] or LEAST_TENDON,
            pennation=n["pennation_angle_at_optimal"], v_max=n["max_contraction_velocity"],
            rise_time=n["activation_time_constant"], fall_time=n["deactivation_time_constant"],
            minimum_activation=n.get("minimum_activation", 0.0), damping=n.get("fiber_damping", 0.0),
            tendon="compliant" if n["tendon_slack_length"] and not one.truths["ignore_tendon_compliance"] else "rigid",
        )  # fmt: skip
        if one.truths["ignore_activation_dynamics"]:
            muscle.rise_time = muscle.fall_time = AT_ONCE
        put_curves(one, muscle)
        return muscle

    def _tell_zeros(self, one: records.Muscle) -> None:
        """Note what of a muscle is nearly nothing here, and nothing in OpenSim."""
        if one.numbers["max_isometric_force"] == 0.0:
            reason = f"has no force in OpenSim, and pulls with up to {LEAST_FORCE:g} N here"
            note(self._notes, self._model, one, reason)
        if one.numbers["tendon_slack_length"] == 0.0:
            reason = f"has no tendon in OpenSim, and a rigid one of {LEAST_TENDON:g} m here"
            note(self._notes, self._model, one, reason)

    def _routed(self, one: records.Muscle, muscle: Muscle) -> Muscle:
        """A muscle with its path."""
        if one.polynomial is not None:
            muscle.polynomial = self._polynomial(one, one.polynomial)
            return muscle
        kept = [0]  # how many points of ours there are up to each of the model's
        for point in one.points:
            muscle.path += self._points(one, point)
            kept.append(len(muscle.path))
        for wrap in one.wraps:
            muscle.wraps += self._wrap(one, wrap, kept)
        return muscle

    def _points(self, one: records.Muscle, point: records.Point) -> list[ViaPoint]:
        """A point of a path as one of ours; none if its range is empty, or its coordinate locked outside of it."""
        if not point.motion:
            body, position = self._placement.point(point.frame, point.location)
            if not point.coordinate:
                return [ViaPoint(body, position)]
            argument, function = self._argument(one, point.coordinate, point.line)
            low, high = (end + margin for end, margin in zip(point.range, (-MARGIN, MARGIN), strict=True))
            if low > high:
                message = "its range runs from {:g} to {:g}; it never comes in, as in OpenSim".format(*point.range)
                self._notes.ignore(self._model.file, point.line, f"ConditionalPathPoint of {one.name}", message)
                return []
            if not argument:
                return [ViaPoint(body, position)] if low <= function.at(0.0) <= high else []
            if function.line is None:
                domain = finite_range(self._coordinates.by_name[argument])
                spans = spans_within(function, (low, high), domain)
                if len(spans) > 1:
                    message = f"its coordinate {point.coordinate!r} comes into the range several times"
                    raise refused(self._model, point.line, f"{point.name!r}: {message}")
                return [ViaPoint(body, position, Condition(argument, *span, blend=0.0)) for span in spans]
            if function.line[1] == 0.0:
                return [ViaPoint(body, position)] if low <= function.line[0] <= high else []
            offset, slope = function.line
            low, high = sorted((max(min(end, ENDLESS), -ENDLESS) - offset) / slope for end in (low, high))
            return [ViaPoint(body, position, Condition(argument, low, high, blend=0.0))]
        axes = self._placement.axes(point.frame)
        constant, motions = np.zeros(3), []
        for index, (coordinate, function) in enumerate(point.motion):
            argument, within = "", list[float]()
            if coordinate and not function.constant:
                argument, inner = self._argument(one, coordinate, point.line)
                domain = finite_range(self._coordinates.by_name[argument or coordinate])
                within = span_within(inner, self._coordinates.by_name[coordinate].range, domain)
                function = self._coordinates.put(function, inner, argument or coordinate, coordinate)
            if not argument:
                constant[index] = function.at(0.0)
                continue
            motions.append(PointMotion(direction(axes[:, index]), joint=argument, within=within))
            set_function(motions[-1], function)
        body, position = self._placement.point(point.frame, constant)
        return [ViaPoint(body, position, motion=motions)]

    def _argument(self, one: records.Muscle, coordinate: str, line: int) -> tuple[str, Function]:
        if coordinate not in self._coordinates.by_name:
            raise refused(self._model, line, f"muscle {one.name!r}: there is no coordinate {coordinate!r}")
        return self._coordinates.master(coordinate)

    def _wrap(self, one: records.Muscle, wrap: records.PathWrap, kept: list[int]) -> list[Wrap]:
        if wrap.surface not in self._model.surfaces:
            message = f"its surface {wrap.surface!r} is switched off or not there; the path runs without it"
            self._notes.ignore(self._model.file, wrap.line, f"PathWrap of {one.name}", message)
            return []
        method = wrap.method if wrap.method in METHODS else "hybrid"
        first, last = (end if end >= 1 else None for end in wrap.range)
        if first is not None and last is not None and first >= last:
            message = f"its range runs from point {first} to {last}; the path runs without it, as in OpenSim"
            self._notes.ignore(self._model.file, wrap.line, f"PathWrap of {one.name}", message)
            return []
        if first is not None and first < len(kept):
            first = kept[first - 1] + 1
        if last is not None and last < len(kept):
            last = kept[last]
        return [Wrap(wrap.surface, first, last, method)]  # type: ignore[arg-type]

    def _polynomial(self, one: records.Muscle, path: records.PolynomialPath) -> PolynomialPath:
        """A polynomial in coordinates that are free; constant ones are put in."""
        terms = math.comb(path.dimension + path.order, path.dimension)
        if terms != len(path.coefficients):
            given = number_of(len(path.coefficients), "coefficient")
            message = f"{given} for the {number_of(terms, 'term')} of its dimension and order"
            raise refused(self._model, path.line, f"muscle {one.name!r}: {message}")
        exponents = list(powers(path.dimension, path.order))
        joints: list[str] = []
        values = np.ones(len(exponents))
        kept: list[int] = []
        for index, name in enumerate(path.coordinates):
            argument, function = self._argument(one, name, path.line)
            if argument and function.line != (0.0, 1.0):
                raise refused(self._model, path.line, f"muscle {one.name!r}: {name!r} is coupled to another coordinate")
            if argument:
                joints.append(argument)
                kept.append(index)
            else:
                values *= function.at(0.0) ** np.array([row[index] for row in exponents])
        coefficients: list[Number] = [float(c * v) for c, v in zip(path.coefficients, values, strict=True)]
        return PolynomialPath(joints, [[row[index] for index in kept] for row in exponents], coefficients)


def put_curves(one: records.Muscle, muscle: Muscle) -> None:
    """The strains and the curves' numbers of a muscle."""
    family = FAMILIES[one.kind]
    if one.old is not None:
        functions = [getattr(one.old, name) for name in ("active", "passive", "tendon", "velocity")]
        splines = [None if f is None else Spline([*f.x], [*f.y], f.ends) for f in functions]
        muscle.curve_shape, muscle.damping = SplineCurves(*splines), one.old.damping  # type: ignore[arg-type]
        return
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


def _activation(one: records.Muscle) -> Literal["excited_rise", "blended", "scaled"]:
    """The law by which a muscle's activation rises and falls."""
    if one.old is not None:
        return "excited_rise"
    return "blended" if one.kind == BLENDED else "scaled"


def settle(common: MuscleModel, muscles: Iterable[Muscle]) -> None:
    """Give the model of all muscles the values that most of them have, and those their own no longer."""
    every = list(muscles)
    for field in COMMON:
        candidates = [getattr(muscle, field) for muscle in every]
        if field == "curve_shape":
            candidates = [shape for shape in candidates if shape.__struct_config__.tag in (common.curves, "spline")]
        values = Counter(map(repr, candidates)).most_common(1)
        value = next(one for one in candidates if repr(one) == values[0][0])
        setattr(common, field, value)
        for muscle in every:
            if getattr(muscle, field) == value:
                setattr(muscle, field, None)


def on_ground(model: Model) -> bool:
    """Whether a path, a surface or a constraint is fixed to the ground."""
    frames = {point.frame for muscle in model.muscles for point in muscle.points}
    frames |= {surface.frame for surface in model.surfaces.values()}
    frames |= {frame for force in model.forces for frame in force.frames}
    frames |= {frame for loop in model.loops for frame in (loop.frame, loop.other_frame)}
    return any(on_body(model, frame)[0] == "/ground" for frame in frames)
