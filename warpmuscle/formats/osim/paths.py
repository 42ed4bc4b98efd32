"""Paths of muscles, the surfaces that they wrap over, and muscles themselves as records."""

from __future__ import annotations

from dataclasses import replace

from warpmuscle.core.plain_text import number_of
from warpmuscle.formats.lines import Notes
from warpmuscle.formats.osim.elements import Element
from warpmuscle.formats.osim.frames import Frames
from warpmuscle.formats.osim.functions import ZERO, Function, owned_function, read_function
from warpmuscle.formats.osim.muscles.path_expressions import path_tension
from warpmuscle.formats.osim.properties import Properties, last_name
from warpmuscle.formats.osim.records import Model, Muscle, OldCurves, PathWrap, Point, PolynomialPath, Surface
from warpmuscle.formats.osim.wraps.shortest import Route

EXPRESSION = "ExpressionBasedPathForce"
# Numbers of each class with OpenSim 4.6's defaults.
COMMON = {
    "max_isometric_force": 1000.0, "optimal_fiber_length": 0.1, "tendon_slack_length": 0.2,
    "pennation_angle_at_optimal": 0.0, "max_contraction_velocity": 10.0,
}  # fmt: skip
CLASSES: dict[str, dict[str, float]] = {
    "Millard2012EquilibriumMuscle": {
        **COMMON, "fiber_damping": 0.1, "default_activation": 0.05, "activation_time_constant": 0.01,
        "deactivation_time_constant": 0.04, "minimum_activation": 0.01, "min_control": 0.01, "max_control": 1.0,
    },
    "Thelen2003Muscle": {
        **COMMON, "default_activation": 0.05, "FmaxTendonStrain": 0.04, "FmaxMuscleStrain": 0.6, "KshapeActive": 0.45,
        "KshapePassive": 5.0, "Af": 0.25, "Flen": 1.4, "fv_linear_extrap_threshold": 0.95,
        "activation_time_constant": 0.015, "deactivation_time_constant": 0.05, "minimum_activation": 0.01,
        "min_control": 0.01, "max_control": 1.0,
    },
    "DeGrooteFregly2016Muscle": {
        **COMMON, "default_activation": 0.5, "active_force_width_scale": 1.0, "fiber_damping": 0.0,
        "passive_fiber_strain_at_one_norm_force": 0.6, "tendon_strain_at_one_norm_force": 0.049,
        "activation_time_constant": 0.015, "deactivation_time_constant": 0.06, "min_control": 0.0,
        "max_control": 1.0,
    },
    "PathActuator": {"optimal_force": 1.0, "min_control": float("-inf"), "max_control": float("inf")},
    "Ligament": {"resting_length": 0.0, "pcsa_force": 0.0},
    "Blankevoort1991Ligament": {
        "slack_length": 0.0, "linear_stiffness": 1.0, "transition_strain": 0.06, "damping_coefficient": 0.003,
    },
    "PathSpring": {"resting_length": 0.0, "stiffness": 0.0, "dissipation": 0.0},
    EXPRESSION: {"resting_length": 0.0},
}  # fmt: skip
LIGAMENT_CURVE = Function(  # of OpenSim's Ligament that has none of its own
    x=(-5.0, 0.998, 0.999, 1.0, 1.1, 1.2, 1.3, 1.4, 1.5, 1.6, 1.601, 1.602, 5.0),
    y=(0.0, 0.0, 0.0, 0.0, 0.035, 0.12, 0.26, 0.55, 1.17, 2.0, 2.0, 2.0, 2.0),
)
TRUTHS = ("ignore_tendon_compliance", "ignore_activation_dynamics", "ignore_passive_fiber_force")
CURVES = ("ActiveForceLengthCurve", "ForceVelocityCurve", "FiberForceLengthCurve", "TendonForceLengthCurve")
POINTS = ("PathPoint", "ConditionalPathPoint", "MovingPathPoint")
SIZES: dict[str, dict[str, tuple[float, ...]]] = {  # of surfaces, with OpenSim 4.6's defaults, m
    "WrapCylinder": {"radius": (1.0,), "length": (1.0,)},
    "WrapSphere": {"radius": (0.05,)},
    "WrapEllipsoid": {"dimensions": (0.05, 0.05, 0.05)},
    "WrapTorus": {"inner_radius": (0.01,), "outer_radius": (0.05,)},
}
MOST_DIMENSIONS, MOST_POWERS = 10, 20  # of polynomials; OpenSim takes 6 dimensions
NOT_MOVING = ("default_fiber_length", "default_normalized_tendon_force", "maximum_pennation_angle", "max_control",
    "min_control", "optimal_force", "tendon_compliance_dynamics_mode", "activation_dynamics_smoothing",
    "min_control")  # fmt: skip


def read_surfaces(
    holder: Element, path: str, model: Model, own: Properties, taken: dict[str, int], notes: Notes
) -> None:  # fmt: skip
    """The surfaces of a body or frame at a path, but for those that are switched off.

    Args:
        taken: lines of all surfaces by name; of two that have one, paths go round the first, as in OpenSim.
    """
    wraps = holder.child("WrapObjectSet")
    for element in wraps.objects() if wraps is not None else ():
        if element.tag not in SIZES:
            element.fail(f"surfaces of this class are not known; {', '.join(SIZES)} are")
        sizes: list[float] = []
        for tag, usual in SIZES[element.tag].items():
            found = own.find(element, tag)
            sizes += usual if found is None or not found.words() else found.numbers(len(usual))
        surface = Surface(
            element.tag, element.name, element.line, path, own.vector(element, "xyz_body_rotation"),
            own.vector(element, "translation"), own.word(element, "quadrant", "all").lower(), tuple(sizes),
        )  # fmt: skip
        active = own.truth(element, "active", True)
        if element.name in taken:
            message = f"paths go round the surface of this name in line {taken[element.name]}, as in OpenSim"
            notes.ignore(element.file, element.line, f"{element.tag} {element.name}", message)
        elif active:
            model.surfaces[element.name] = surface
        taken.setdefault(element.name, element.line)


def read_muscle(
    element: Element, frames: Frames, own: Properties, old: OldCurves | None = None, route: Route | None = None
) -> Muscle:
    """A muscle or path actuator of a class in `CLASSES`, with curves through knots if it has such.

    Args:
        route: points and wraps of a path that is a shortest one.
    """
    muscle = _muscle(element, frames, own, old, route)
    return muscle if element.tag != EXPRESSION else _as_ligament(muscle, element, own)


def _as_ligament(muscle: Muscle, element: Element, own: Properties) -> Muscle:
    """A path with a tension that is an expression, as a ligament of 1 N."""
    text = own.find(element, "expression")
    if text is None or not text.text.strip():
        element.fail("has no <expression>")
    clamped = own.truth(element, "clamp_stretch", True)
    found = path_tension(element, text, muscle.numbers["resting_length"], clamped)
    numbers = {"resting_length": found.unit, "pcsa_force": 1.0, "dissipation": found.dissipation}
    return replace(muscle, kind="Ligament", numbers=numbers, tension=found.function, lost=found.lost)


def _muscle(
    element: Element, frames: Frames, own: Properties, old: OldCurves | None = None, route: Route | None = None
) -> Muscle:
    """A muscle or path actuator with its numbers and its path; arguments: those of `read_muscle`."""
    numbers = {tag: own.number(element, tag, default, True) for tag, default in CLASSES[element.tag].items()}
    truths = {tag: own.truth(element, tag, False) for tag in TRUTHS}
    curves: dict[str, dict[str, float]] = {}
    for tag in CURVES:
        curve = own.find(element, tag)
        if curve is not None:
            curves[tag] = {child.tag: child.number() for child in curve.children if child.words()}
    for tag in NOT_MOVING:
        element.child(tag)
    path = f"/forceset/{element.name}"
    tension = _tension(element, own)
    if route is not None:
        return Muscle(
            element.tag, element.name, element.line, numbers, truths, curves, *route, tension=tension, old=old,
            shortest=True,
        )  # fmt: skip
    function = own.find(element, "FunctionBasedPath")
    if function is not None:
        polynomial = _polynomial(function)
        return Muscle(
            element.tag, element.name, element.line, numbers, truths, curves, (), (), polynomial, tension, old
        )
    geometry = own.find(element, "GeometryPath")
    if geometry is None:
        element.fail("has no <GeometryPath>, and paths of another class are not known, but FunctionBasedPath")
    points, wraps = geometry.child("PathPointSet"), geometry.child("PathWrapSet")
    return Muscle(
        element.tag, element.name, element.line, numbers, truths, curves,
        tuple(_point(one, path, frames, own) for one in (points.objects() if points is not None else ())),
        tuple(_wrap(one, own) for one in (wraps.objects() if wraps is not None else ())), tension=tension, old=old,
    )  # fmt: skip


def _tension(element: Element, own: Properties) -> Function | None:
    """The function of a ligament, of its length over that at rest."""
    if element.tag != "Ligament":
        return None
    holder = own.find(element, "force_length_curve")
    if holder is None:
        named = [child for child in element.children if child.name == "force_length_curve"]
        return read_function(named[-1]) if named else LIGAMENT_CURVE
    return owned_function(holder) or LIGAMENT_CURVE


def _point(element: Element, path: str, frames: Frames, own: Properties) -> Point:
    """A point of a path at `path`."""
    if element.tag not in POINTS:
        element.fail(f"points of this class are not known; {', '.join(POINTS)} are")
    frame = frames.socket(element, path, "parent_frame")
    if element.tag == "MovingPathPoint":
        element.child("location")  # as it was when it was saved
        motion = tuple(_motion(element, axis) for axis in "xyz")
        return Point(element.name, element.line, frame, (0.0, 0.0, 0.0), motion=motion)
    location = own.vector(element, "location")
    if element.tag == "PathPoint":
        return Point(element.name, element.line, frame, location)
    socket, span = element.child("socket_coordinate"), own.find(element, "range")
    if socket is None or not socket.word():
        element.fail("a conditional point needs a coordinate")
    low, high = span.numbers(2, infinite=True) if span is not None and span.words() else (0.0, 0.0)
    return Point(element.name, element.line, frame, location, last_name(socket.word()), (low, high))


def _motion(element: Element, axis: str) -> tuple[str, Function]:
    """By which coordinate a point is moved along an axis of its frame, and how far; without a location it is at 0."""
    socket, holder = element.child(f"socket_{axis}_coordinate"), element.child(f"{axis}_location")
    function = owned_function(holder) if holder is not None else ZERO
    if function is None:
        element.fail(f"has no function in its <{axis}_location>")
    name = last_name(socket.word()) if socket is not None else ""
    if not name and not function.constant:
        element.fail(f"names no coordinate that moves it along {axis}")
    return name, function


def _wrap(element: Element, own: Properties) -> PathWrap:
    """What a path wraps over, and between which points."""
    if element.tag != "PathWrap":
        element.fail("wraps of this class are not known; PathWrap is")
    span = own.find(element, "range")
    words = span.numbers(2) if span is not None and span.words() else (-1.0, -1.0)
    first, last = int(words[0]), int(words[1])
    surface, method = own.word(element, "wrap_object"), own.word(element, "method", "hybrid").lower()
    if not surface:
        element.fail("has no <wrap_object>")
    return PathWrap(surface, element.line, method if method != "unassigned" else "hybrid", (first, last))


def _polynomial(element: Element) -> PolynomialPath:
    """A path that is a polynomial of coordinates; functions of its speed and moment arms follow from that."""
    paths, holder = element.child("coordinate_paths"), element.child("length_function")
    function = holder.child("MultivariatePolynomialFunction") if holder is not None else None
    function = function or element.child("MultivariatePolynomialFunction")
    if paths is None or function is None:
        element.fail("needs <coordinate_paths> and a MultivariatePolynomialFunction as its length")
    for tag in ("moment_arm_functions", "lengthening_speed_function"):
        element.child(tag)
    names = tuple(last_name(word) for word in paths.words())
    dimension, order = function.child("dimension"), function.child("order")
    numbers = function.child("coefficients")
    if dimension is None or order is None or numbers is None:
        function.fail("needs <dimension>, <order> and <coefficients>")
    size, greatest = int(dimension.number()), int(order.number())
    if not 0 < size <= MOST_DIMENSIONS or not 0 <= greatest <= MOST_POWERS:
        message = f"a polynomial has 1 to {MOST_DIMENSIONS} dimensions and an order of 0 to {MOST_POWERS}"
        function.fail(f"{message}, not {size} and {greatest}")
    if size != len(names):
        function.fail(f"has {number_of(size, 'dimension')} for {number_of(len(names), 'coordinate')}")
    return PolynomialPath(element.line, names, size, greatest, tuple(numbers.numbers()))
