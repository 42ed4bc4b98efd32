"""Forces other than muscles, shapes that touch, and markers as records."""

from __future__ import annotations

from warpmuscle.formats.osim.elements import Element
from warpmuscle.formats.osim.frames import Frames
from warpmuscle.formats.osim.properties import Properties, last_name
from warpmuscle.formats.osim.records import Contact, Lost, Marker, Model, OsimForce

Defaults = dict[str, tuple[float, ...]]
NONE = (0.0, 0.0, 0.0)
PARAMETERS: Defaults = {
    "stiffness": (1.0,), "dissipation": (0.0,), "static_friction": (0.0,), "dynamic_friction": (0.0,),
    "viscous_friction": (0.0,), "transition_velocity": (0.01,),
}  # fmt: skip
EXPRESSIONS = ("Mx_expression", "My_expression", "Mz_expression", "Fx_expression", "Fy_expression", "Fz_expression")
NUMBERS: dict[str, Defaults] = {  # of each class, with OpenSim 4.6's defaults
    "CoordinateActuator": {"optimal_force": (1.0,), "min_control": (-1e300,), "max_control": (1e300,)},
    "CoordinateLimitForce": {
        "upper_stiffness": (1.0,), "upper_limit": (0.0,), "lower_stiffness": (1.0,), "lower_limit": (0.0,),
        "damping": (0.001,), "transition": (0.1,),
    },
    "SpringGeneralizedForce": {"stiffness": (0.0,), "rest_length": (0.0,), "viscosity": (0.0,)},
    "BushingForce": {
        "rotational_stiffness": NONE, "translational_stiffness": NONE, "rotational_damping": NONE,
        "translational_damping": NONE,
    },
    "ExpressionBasedBushingForce": {"rotational_damping": NONE, "translational_damping": NONE},
    "HuntCrossleyForce": {"transition_velocity": (0.01,)},
    "SmoothSphereHalfSpaceForce": {
        **PARAMETERS, "constant_contact_force": (1e-5,), "hertz_smoothing": (300.0,),
        "hunt_crossley_smoothing": (50.0,),
    },
}  # fmt: skip
WORDS: dict[str, tuple[str, ...]] = {
    "CoordinateActuator": ("coordinate",),
    "CoordinateLimitForce": ("coordinate",),
    "SpringGeneralizedForce": ("coordinate",),
    "ExpressionBasedBushingForce": EXPRESSIONS,
}
ABOUT_DRAWING = ("moment_visual_scale", "force_visual_scale", "visual_aspect_ratio", "force_visualization_radius",
    "force_visualization_scale_factor", "compute_dissipation_energy")  # fmt: skip


def read_force(element: Element, frames: Frames, own: Properties) -> list[OsimForce]:
    """The forces of an element of a class in `NUMBERS`; Hunt and Crossley's has one for each pair of its shapes."""
    numbers = {tag: _numbers(element, tag, default, own) for tag, default in NUMBERS[element.tag].items()}
    words = {tag: last_name(own.word(element, tag)) for tag in WORDS.get(element.tag, ())}
    for tag in ABOUT_DRAWING:
        element.child(tag)
    if "coordinate" in words:
        socket = element.child("socket_coordinate")
        words["coordinate"] = words["coordinate"] or (last_name(socket.word()) if socket is not None else "")
    for tag in EXPRESSIONS:
        if tag in words:
            words[tag] = own.word(element, tag, "0")
    if element.tag == "HuntCrossleyForce":
        return _hunt_crossley(element, numbers, own)
    if element.tag == "SmoothSphereHalfSpaceForce":
        for end in ("sphere", "half_space"):
            socket = element.child(f"socket_{end}")
            words[end] = last_name(socket.word()) if socket is not None else ""
    pair: tuple[str, ...] = ()
    if element.tag.endswith("BushingForce"):
        path = f"/forceset/{element.name}"
        pair = tuple(frames.socket(element, path, f"frame{number}") for number in (1, 2))
    return [OsimForce(element.tag, element.name, element.line, numbers, words, pair)]


def _numbers(element: Element, tag: str, default: tuple[float, ...], own: Properties) -> tuple[float, ...]:
    found = own.find(element, tag)
    if found is None or not found.words():
        return default
    return tuple(found.numbers(len(default), infinite=True))


def _hunt_crossley(element: Element, numbers: Defaults, own: Properties) -> list[OsimForce]:
    """One force for each set of shapes that share their parameters."""
    holder = element.child("HuntCrossleyForce::ContactParametersSet", "contact_parameters")
    found = []
    for parameters in holder.objects() if holder is not None else ():
        values: Defaults = {
            tag: _numbers(parameters, tag, default, own) for tag, default in PARAMETERS.items()
            if tag != "transition_velocity"
        }  # fmt: skip
        shapes = own.word(parameters, "geometry")
        names = " ".join(last_name(word) for word in shapes.split())
        found.append(OsimForce(element.tag, element.name, parameters.line, {**values, **numbers}, {"geometry": names}))
    return found


def read_contact(element: Element, model: Model, frames: Frames, own: Properties) -> None:
    """A sphere or a half-space."""
    path = f"/contactgeometryset/{element.name}"
    radius = own.number(element, "radius", 0.0) if element.tag == "ContactSphere" else 0.0
    frame = frames.socket(element, path, "frame")
    model.contacts[element.name] = Contact(
        element.tag, element.name, element.line, frame, own.vector(element, "location"),
        own.vector(element, "orientation"), radius,
    )  # fmt: skip


def read_marker(element: Element, frames: Frames, own: Properties) -> Marker:
    """A marker, wherever its place on the subject is known."""
    frame = frames.socket(element, f"/markerset/{element.name}", "parent_frame")
    fixed = own.truth(element, "fixed", False)
    return Marker(element.name, element.line, frame, own.vector(element, "location"), fixed)


def lost_force(element: Element, shapes: dict[str, set[str]]) -> Lost:
    """A force that is left out, with all names in it, those in the shapes that it names among them."""
    names = words_of(element)
    for name in tuple(names & shapes.keys()):
        names |= shapes[name]
    return Lost(element.tag, frozenset(names))


def words_of(element: Element) -> set[str]:
    """The names in an element: its words, and the last names of paths."""
    return {word.rpartition("/")[2] for inner in element.all() for word in inner.text.split()}
