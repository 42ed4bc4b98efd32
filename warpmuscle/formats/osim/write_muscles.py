"""Muscles of scenes as OpenSim's."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.pose import normalized
from warpmuscle.formats.lines import Ignored
from warpmuscle.formats.osim.build_muscles import FAMILIES, SHAPES, STRAINS, TWICE
from warpmuscle.formats.osim.cables import cable_xml
from warpmuscle.formats.osim.joints.several import powers
from warpmuscle.formats.osim.muscles.write import old_muscle_xml
from warpmuscle.formats.osim.placement import WORLD, direction, vector
from warpmuscle.formats.osim.xml_text import element, function_xml, name_of, numbers, objects
from warpmuscle.scene import Displacement, Muscle, PolynomialPath, Scene, SplineCurves, ViaPoint
from warpmuscle.scene.initial_pose import plain_number, plain_vector
from warpmuscle.scene.joints import joint_type, root_type
from warpmuscle.scene.masses import massless
from warpmuscle.scene.muscles import is_cable
from warpmuscle.scene.muscles.curves import STRAINS as USUAL_STRAINS
from warpmuscle.scene.muscles.curves import family

CURVES = {  # of Millard's muscle: which fields of the scene they have
    "ActiveForceLengthCurve": ("active_from", "active_bend", "active_until", "active_slope", "active_least"),
    "ForceVelocityCurve": (
        "shortening_end_slope", "shortening_slope", "isometric_slope", "lengthening_end_slope", "lengthening_slope",
        "lengthening_force", "shortening_curviness", "lengthening_curviness",
    ),
    "FiberForceLengthCurve": ("passive_slack", "passive_low_slope", "passive_slope", "passive_curviness"),
    "TendonForceLengthCurve": ("tendon_slope", "tendon_toe_force", "tendon_curviness"),
}  # fmt: skip


def frame_path(scene: Scene, body: str) -> str:
    """The path of a body; a root without mass that is fixed is the ground."""
    character = scene.character
    if body == character.root and not root_type(character).speeds and massless(character.bodies[body]):
        return "/ground"
    return f"/bodyset/{name_of(body)}"


def axis_text(axis: Floats) -> str:
    """An axis as text."""
    return numbers(direction(axis))


def muscle_xml(scene: Scene, name: str, path: Path, lost: list[Ignored]) -> str:
    """A muscle with its path and properties."""
    muscle, model = scene.character.muscles[name], scene.muscle_model
    key = f"character.muscles.{name}"

    def value(field: str) -> Any:
        own = getattr(muscle, field)
        return getattr(model, field) if own is None else own

    def lose(what: str) -> None:
        lost.append(Ignored(path, 0, key, what))

    if is_cable(muscle):
        return cable_xml(muscle, _path(scene, name, path, lost), name_of(name), lose)
    shape = muscle.curve_shape or model.curve_shape
    if isinstance(shape, SplineCurves):
        return old_muscle_xml(muscle, shape, name_of(name), _path(scene, name, path, lost), value, lose)
    curves = family(shape) if shape is not None else model.curves
    if curves not in USUAL_STRAINS:
        lost.append(Ignored(path, 0, f"{key}.curves", f"{curves} curves are written as Millard's"))
        curves = "millard"
    kind = next(one for one, of in FAMILIES.items() if of == curves)
    inner = _path(scene, name, path, lost)
    values = {
        "max_isometric_force": muscle.f_max, "optimal_fiber_length": muscle.l_opt,
        "tendon_slack_length": muscle.l_slack, "pennation_angle_at_optimal": muscle.pennation,
        "max_contraction_velocity": value("v_max"), "activation_time_constant": value("rise_time"),
        "deactivation_time_constant": value("fall_time"), "default_activation": model.initial_activation,
    }  # fmt: skip
    if kind != "DeGrooteFregly2016Muscle":
        values["minimum_activation"] = max(plain_number(value("minimum_activation")), 0.0)
    if kind != "Thelen2003Muscle":
        values["fiber_damping"] = value("damping")
    inner += element("ignore_tendon_compliance", "false" if value("tendon") == "compliant" else "true")
    inner += "".join(element(tag, numbers([plain_number(number)])) for tag, number in values.items())
    if plain_number(muscle.delay):
        lost.append(Ignored(path, 0, f"{key}.delay", "OpenSim models do not hold this"))
    strains = [
        plain_number(own) if (own := value(field)) is not None else USUAL_STRAINS[curves][k]
        for k, field in enumerate(("tendon_strain", "passive_strain"))
    ]
    return element(kind, inner + _shape(kind, curves, shape, strains), name=name_of(name))


def _shape(kind: str, curves: str, shape: Any, strains: list[float]) -> str:
    """The strains, and the numbers of the curves that are not their defaults."""
    words = {field: tag for tag, field in SHAPES[curves].items()}
    if kind in STRAINS:
        inner = "".join(element(tag, numbers([strain])) for tag, strain in zip(STRAINS[kind], strains, strict=True))
        for field, tag in words.items():
            if shape is not None and field != "passive":
                inner += element(tag, numbers([plain_number(getattr(shape, field))]))
        return inner
    words |= {field: tag for (_, tag), field in TWICE.items()}
    found = ""
    for curve, fields in CURVES.items():
        numbers_of = {words[field]: getattr(shape, field) for field in fields} if shape is not None else {}
        if shape is None and curve == "ActiveForceLengthCurve":
            numbers_of = {"minimum_value": 0.0}
        if curve in ("FiberForceLengthCurve", "TendonForceLengthCurve"):
            numbers_of["strain_at_one_norm_force"] = strains[curve == "FiberForceLengthCurve"]
        inner = "".join(element(tag, numbers([one])) for tag, one in numbers_of.items() if one is not None)
        found += element(curve, inner, name=curve.lower())
    return found


def _path(scene: Scene, name: str, path: Path, lost: list[Ignored]) -> str:
    """The path of a muscle: points and wraps, or a polynomial."""
    muscle = scene.character.muscles[name]
    if muscle.polynomial is not None or muscle.pulleys:
        return _polynomial(scene, muscle.polynomial or _of_pulleys(muscle))
    points = [_point(scene, point, f"{name_of(name)}-P{k}", path, lost) for k, point in enumerate(muscle.path, 1)]
    wraps = []
    for k, wrap in enumerate(muscle.wraps, 1):
        ends = " ".join(str(-1 if end is None else end) for end in (wrap.first, wrap.last))
        inner = element("wrap_object", name_of(wrap.surface)) + element("method", wrap.method) + element("range", ends)
        wraps.append(element("PathWrap", inner, name=f"wrap{k}"))
    return element("GeometryPath", objects("PathPointSet", points) + objects("PathWrapSet", wraps), name="geometrypath")


def _point(scene: Scene, point: ViaPoint, name: str, path: Path, lost: list[Ignored]) -> str:
    inner = element("socket_parent_frame", frame_path(scene, point.body))
    place = vector(WORLD.T @ plain_vector(point.place()))
    if point.motion:
        return _moving(scene, point, name, inner, place, path, lost)
    inner += element("location", numbers(place))
    condition = point.condition
    if condition is None:
        return element("PathPoint", inner, name=name)
    if plain_number(condition.blend) > 0.0:
        lost.append(Ignored(path, 0, f"{name}.condition", "OpenSim's points come and go at once, without `blend`"))
    inner += element("socket_coordinate", _coordinate(scene, condition.joint, condition.axis))
    inner += element("range", numbers([plain_number(condition.low), plain_number(condition.high)]))
    return element("ConditionalPathPoint", inner, name=name)


def _moving(
    scene: Scene, point: ViaPoint, name: str, inner: str, place: tuple[float, ...], path: Path, lost: list[Ignored]
) -> str:  # fmt: skip
    """A point that moves along OpenSim's axes of its body; motions along others are left out."""
    along: dict[int, Any] = {}
    for motion in point.motion:
        axis = WORLD.T @ normalized(plain_vector(motion.axis))
        k = int(np.argmax(np.abs(axis)))
        if abs(axis[k] - 1.0) > 1e-9 or k in along:
            lost.append(Ignored(path, 0, f"{name}.motion", "OpenSim's points move along each axis of a body once"))
            continue
        along[k] = motion
    for k, axis_name in enumerate("xyz"):
        given = along.get(k)
        names = [motion.joint for motion in ([given] if given is not None else point.motion)]
        still = Displacement((1.0, 0.0, 0.0), value=place[k])
        inner += element(f"socket_{axis_name}_coordinate", _coordinate(scene, names[0]))  # which each axis must name
        function = function_xml(still if given is None else shifted(given, place[k]))
        inner += element(f"{axis_name}_location", function)
    return element("MovingPathPoint", inner, name=name)


def shifted(one: Displacement, by: float) -> Displacement:
    """A displacement with a constant added to it."""
    moved = Displacement(one.axis, one.value, one.slope, one.x, one.y, one.ends, one.polynomial)
    if one.x:
        moved.y = [plain_number(y) + by for y in one.y]
    elif one.polynomial:
        moved.polynomial = [plain_number(one.polynomial[0]) + by, *one.polynomial[1:]]
    else:
        moved.value = plain_number(one.value) + by
    return moved


def _coordinate(scene: Scene, joint: str, axis: int = 0) -> str:
    """The path of a joint's coordinate."""
    words = joint_type(scene.character.joints[joint]).angles
    name = name_of(joint) if len(words) == 1 else f"{name_of(joint)}_{words[axis]}"
    return f"/jointset/{name_of(joint)}/{name}"


def _of_pulleys(muscle: Muscle) -> PolynomialPath:
    """A path over pulleys as a polynomial: the rest length less arms times angles."""
    count = len(muscle.pulleys)
    constant = plain_number(muscle.rest_length if muscle.rest_length is not None else 0.0)
    constant += sum(plain_number(one.moment_arm) * plain_number(one.rest_angle) for one in muscle.pulleys)
    arms = [-plain_number(one.moment_arm) for one in muscle.pulleys]
    return PolynomialPath(
        [one.joint for one in muscle.pulleys], [[0] * count, *np.eye(count, dtype=int).tolist()], [constant, *arms],
        [one.axis for one in muscle.pulleys],
    )  # fmt: skip


def _polynomial(scene: Scene, polynomial: PolynomialPath) -> str:
    """A path that is a polynomial, with all coefficients up to its degree."""
    axes = polynomial.axes or [0] * len(polynomial.joints)
    paths = [_coordinate(scene, joint, axis) for joint, axis in zip(polynomial.joints, axes, strict=True)]
    order = max(map(sum, polynomial.exponents), default=0)
    given: dict[tuple[int, ...], float] = {}
    for row, number in zip(polynomial.exponents, polynomial.coefficients, strict=True):
        given[tuple(row)] = given.get(tuple(row), 0.0) + plain_number(number)
    coefficients = [given.get(row, 0.0) for row in powers(len(paths), order)]
    function = element("coefficients", numbers(coefficients)) + element("dimension", str(len(paths)))
    function = element("MultivariatePolynomialFunction", function + element("order", str(order)))
    inner = element("coordinate_paths", " ".join(paths)) + element("length_function", function)
    return element("FunctionBasedPath", inner, name="path")
