"""Scenes as OpenSim models: bodies, joints, muscles, surfaces, contact, in the layout of version 4."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import SceneError
from warpmuscle.core.files import replace_file
from warpmuscle.core.pose import about, euler_xyz, from_rotation_vector, multiply, normalized, rotate, turned_to_heading
from warpmuscle.formats.lines import Ignored
from warpmuscle.formats.osim.build_forces import MATERIAL
from warpmuscle.formats.osim.loops.write import constraint_elements
from warpmuscle.formats.osim.placement import WORLD, vector
from warpmuscle.formats.osim.write_muscles import axis_text, frame_path, muscle_xml
from warpmuscle.formats.osim.xml_text import (
    angles_of,
    element,
    frame_xml,
    function_xml,
    name_of,
    numbers,
    objects,
    placed,
)
from warpmuscle.scene import Body, Box, Capsule, ContactMaterial, Displacement, Joint, JointState, Scene, Sphere
from warpmuscle.scene.geometry import contact_points
from warpmuscle.scene.initial_pose import plain_number, plain_vector
from warpmuscle.scene.joints import joint_type, root_type
from warpmuscle.scene.opensim_root import root_values, usual_root
from warpmuscle.scene.surfaces import CylinderSurface, EllipsoidSurface, SphereSurface, Surface

VERSION, WITH_POLYNOMIALS = 40000, 40600  # of the file; the latter for paths that are polynomials
STIFFNESS, DISSIPATION = 1.0e6, 2.0  # of contact: Pa and s/m, as models of walking have them
NOT_HELD = "OpenSim models do not hold this"
RANGE_ONLY = "the range is kept, but not its stiffness"
SPHERES_ONLY = "contacts of OpenSim models are spheres; boxes are left out"
OTHER_CONTACT = "spheres touch the ground by OpenSim's law, with a stiffness of 1e6 Pa"


def write(scene: Scene, path: Path) -> list[Ignored]:
    """Write a checked scene without free parameters as a model; what it does not hold, by the keys of the scene."""
    lost: list[Ignored] = []
    replace_file(path, model_text(scene, path, lost))
    return lost


def model_text(scene: Scene, path: Path, lost: list[Ignored]) -> str:
    """The text of a model file."""
    polynomials = any(muscle.polynomial or muscle.pulleys for muscle in scene.character.muscles.values())
    joints, couplers = _joints(scene)
    shapes, contact = _contact(scene, path, lost)
    forces = [muscle_xml(scene, name, path, lost) for name in scene.character.muscles]
    forces += contact
    for key in ("controller", "custom_controller", "forces", "motion", "objects", "stages", "tracking", "water"):
        if getattr(scene, key):
            lost.append(Ignored(path, 0, key, NOT_HELD))
    if scene.ground.terrain is not None:
        lost.append(Ignored(path, 0, "ground.terrain", NOT_HELD))
    if scene.ground.treadmill is not None:
        lost.append(Ignored(path, 0, "ground.treadmill", NOT_HELD))
    for name, own in scene.actuation.items():
        if plain_number(own.stiffness) or plain_number(own.damping):
            lost.append(Ignored(path, 0, f"actuation.{name}", NOT_HELD))
    for name, joint in scene.character.joints.items():
        if joint.limits and plain_number(joint.limit_stiffness):
            lost.append(Ignored(path, 0, f"character.joints.{name}.limit_stiffness", RANGE_ONLY))
    markers = scene.opensim.markers if scene.opensim is not None else {}
    marks = [
        element("Marker", placed("socket_parent_frame", frame_path(scene, marker.body), plain_vector(marker.position)),
            name=name)
        for name, marker in markers.items()
    ]  # fmt: skip
    parts = [
        element("credits", scene.description or "warpmuscle"),
        element("gravity", numbers([0.0, -plain_number(scene.gravity), 0.0])),
        element("length_units", "meters"), element("force_units", "N"),
        element("Ground", _surfaces(scene, "ground"), name="ground"),
        objects("BodySet", [_body(scene, name) for name in scene.character.bodies if not _is_ground(scene, name)]),
        objects("JointSet", joints), objects("ConstraintSet", couplers + constraint_elements(scene)),
        objects("ForceSet", forces),
        objects("MarkerSet", marks), objects("ContactGeometrySet", shapes),
    ]  # fmt: skip
    version = WITH_POLYNOMIALS if polynomials else VERSION
    model = element("Model", "\n".join(parts), name=name_of(scene.name))
    return (
        f'<?xml version="1.0" encoding="UTF-8" ?>\n<OpenSimDocument Version="{version}">\n{model}\n</OpenSimDocument>\n'
    )


def _is_ground(scene: Scene, name: str) -> bool:
    """Whether a body is the ground itself: a fixed root without mass that stands at the world's origin."""
    return frame_path(scene, name) == "/ground"


def _body(scene: Scene, name: str) -> str:
    """A body, whose origin is its centre of mass, as in the scene."""
    body = scene.character.bodies[name]
    axes = WORLD.T @ rotate(normalized(plain_vector(body.inertia_axes)), np.eye(3)).T
    i = axes @ np.diag(plain_vector(body.inertia)) @ axes.T
    six = vector(np.array([i[0, 0], i[1, 1], i[2, 2]])) + vector(np.array([i[0, 1], i[0, 2], i[1, 2]]))
    return element(
        "Body",
        element("mass", numbers([plain_number(body.mass)])) + element("mass_center", "0 0 0")
        + element("inertia", numbers(six)) + _surfaces(scene, name), name=name_of(name),
    )  # fmt: skip


def _surfaces(scene: Scene, body: str) -> str:
    """The surfaces on a body, or those on a root that is the ground."""
    found = [
        _surface(name, surface)
        for name, surface in scene.character.surfaces.items()
        if (frame_path(scene, surface.body) == "/ground" if body == "ground" else surface.body == body)
    ]
    return objects("WrapObjectSet", found) if found else ""


def _surface(name: str, surface: Surface) -> str:
    turn = WORLD.T @ rotate(from_rotation_vector(plain_vector(surface.orientation)), np.eye(3)).T
    inner = element("xyz_body_rotation", numbers(angles_of(turn)))
    inner += element("translation", numbers(vector(WORLD.T @ plain_vector(surface.position))))
    inner += element("quadrant", surface.side or "all")
    if isinstance(surface, CylinderSurface):
        kind, sizes = "WrapCylinder", {"radius": [surface.radius], "length": [surface.length]}
    elif isinstance(surface, SphereSurface):
        kind, sizes = "WrapSphere", {"radius": [surface.radius]}
    elif isinstance(surface, EllipsoidSurface):
        kind, sizes = "WrapEllipsoid", {"dimensions": list(surface.radii)}
    else:
        kind, sizes = "WrapTorus", {"inner_radius": [surface.inner_radius], "outer_radius": [surface.outer_radius]}
    inner += "".join(element(tag, numbers(map(plain_number, values))) for tag, values in sizes.items())
    return element(kind, inner, name=name_of(name))


def _joints(scene: Scene) -> tuple[list[str], list[str]]:
    """All joints, that of the root first, and couplers for those that follow others."""
    found = [] if _is_ground(scene, scene.character.root) else [_root(scene)]
    couplers = []
    for name, joint in scene.character.joints.items():
        found.append(_joint(scene, name, joint))
        if joint.follows:
            inner = element("coupled_coordinates_function", function_xml(Displacement((1.0, 0.0, 0.0), slope=1.0)))
            inner += element("independent_coordinate_names", name_of(joint.follows))
            inner += element("dependent_coordinate_name", name_of(name))
            couplers.append(element("CoordinateCouplerConstraint", inner, name=f"{name_of(name)}_follows"))
    return found, couplers


def _root(scene: Scene) -> str:
    """The joint between the ground and the root: that of the model which the scene came from, or one of its kind."""
    character, state = scene.character, scene.initial_state
    position, turn = plain_vector(state.root_position), normalized(plain_vector(state.root_orientation))
    about_up = np.array([0.0, 0.0, 0.0, 1.0])
    if state.heading is not None:
        about_up = turned_to_heading(turn, plain_number(state.heading))
    turn = multiply(about_up, turn)
    child = frame_path(scene, character.root)
    if not root_type(character).speeds:
        matrix = WORLD.T @ rotate(turn, np.eye(3)).T @ WORLD
        frame = frame_xml("near", "/ground", WORLD.T @ position, angles_of(matrix))
        return _assembled("WeldJoint", "root", child, frame, np.zeros(3), "", "")
    kept = scene.opensim if scene.opensim is not None and scene.opensim.root is not None else usual_root(character)
    assert kept.root is not None
    values = root_values(kept, position[None], turn[None])[0]
    coordinates = "".join(
        _coordinate(name_of(n), float(v), 0.0, None) for n, v in zip(kept.root_coordinates, values, strict=True)
    )
    names = map(name_of, kept.root_coordinates)
    transform = _transform(
        [(one, next(names)) for one in kept.root.rotations], [(one, next(names)) for one in kept.root.translations]
    )
    frame = frame_xml("near", "/ground", WORLD.T @ plain_vector(kept.root.position_in_parent))
    own = WORLD.T @ plain_vector(kept.root.position_in_child)
    return _assembled("CustomJoint", f"ground_{name_of(character.root)}", child, frame, own, coordinates, transform)


def _rates(axes: Floats, velocity: Floats) -> Floats:
    """Rates of coordinates whose units give velocities (R, k) so that together they give this one (k,)."""
    return np.asarray(np.linalg.lstsq(axes.T, velocity, rcond=None)[0])


def _joint(scene: Scene, name: str, joint: Joint) -> str:
    """A joint with its coordinates, where they start and their ranges."""
    if joint.beside:
        message = "a joint that depends on two coordinates cannot be written as an OpenSim model"
        raise SceneError(message, key=f"character.joints.{name}.beside")
    frame = frame_xml("near", frame_path(scene, joint.parent), WORLD.T @ plain_vector(joint.position_in_parent))
    own = WORLD.T @ plain_vector(joint.position_in_child)
    child, kind = frame_path(scene, joint.child), joint_type(joint)
    if not kind.moves and not joint.follows:
        return _assembled("WeldJoint", name_of(name), child, frame, own, "", "")
    state = scene.initial_state.joints.get(name, JointState())
    if kind.quaternion:
        turns = [Displacement(axis, slope=1.0) for axis in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))]
        values = euler_xyz(normalized(plain_vector(state.orientation))[None])[0]
        first = about(np.array([1.0, 0.0, 0.0]), values[0])
        second = multiply(first, about(np.array([0.0, 1.0, 0.0]), values[1]))
        axes = [np.array([1.0, 0.0, 0.0]), rotate(first, [0.0, 1.0, 0.0]), rotate(second, [0.0, 0.0, 1.0])]
        speeds = _rates(np.array(axes), plain_vector(state.angular_velocity))
        names = [f"{name_of(name)}_{axis}" for axis in "xyz"]
        coordinates = "".join(
            _coordinate(n, float(q), float(v), None) for n, q, v in zip(names, values, speeds, strict=True)
        )
        return _assembled("CustomJoint", name_of(name), child, frame, own, coordinates,
            _transform(list(zip(turns, names, strict=True)), []))  # fmt: skip
    if joint.follows:
        driver = scene.character.joints[joint.follows]
        q, _ = joint_type(driver).start(driver, scene.initial_state.joints.get(joint.follows, JointState()))
        coordinates = _coordinate(name_of(name), float(q[0, 0]), 0.0, None)
        both = ([(one, name_of(name)) for one in part] for part in (joint.rotations, joint.translations))
        return _assembled("CustomJoint", name_of(name), child, frame, own, coordinates, _transform(*both))
    q, v = kind.start(joint, state)
    names = [f"{name_of(name)}_{word}".rstrip("_") for word in kind.angles]
    ranges = [kind.range(joint, axis) for axis in range(len(names))]
    coordinates = "".join(
        _coordinate(n, float(q[0, k]), float(v[0, k]), ranges[k]) for k, n in enumerate(names)
    )  # fmt: skip
    along = [Displacement(axis, slope=1.0) for axis in joint.axes]
    rotations = [(one, names[0]) for one in joint.rotations]
    translations = [(one, names[0]) for one in joint.translations]
    if joint.type == "slide":
        translations = [(along[0], names[0])]
    elif len(along) == 2:  # the child turns by b of the parent, then by a of its own
        rotations = [(along[1], names[1]), (along[0], names[0])]
    elif along:
        rotations = [(along[0], names[0])]
    return _assembled("CustomJoint", name_of(name), child, frame, own, coordinates, _transform(rotations, translations))


def _coordinate(name: str, value: float, speed: float, limits: tuple[float, float] | None) -> str:
    inner = element("default_value", numbers([value])) + element("default_speed_value", numbers([speed]))
    inner += element("range", numbers(limits or (-10.0, 10.0)))
    return element("Coordinate", inner, name=name)


def _transform(rotations: list[tuple[Displacement, str]], translations: list[tuple[Displacement, str]]) -> str:
    """A spatial transform; axes without motion are filled up with ones that are independent of the others."""
    inner = ""
    for kind, moves in (("rotation", rotations), ("translation", translations)):
        axes = [WORLD.T @ normalized(plain_vector(one.axis)) for one, _ in moves]
        while len(axes) < 3:
            axes.append(_independent(axes))
        for k, axis in enumerate(axes):
            moving = k < len(moves)
            given = element("coordinates", moves[k][1] if moving else "") + element("axis", axis_text(axis))
            given += function_xml(moves[k][0] if moving else Displacement((1.0, 0.0, 0.0)), name="function")
            inner += element("TransformAxis", given, name=f"{kind}{k + 1}")
    return element("SpatialTransform", inner)


def _independent(axes: list[Floats]) -> Floats:
    """A unit vector at right angles to one or two others, or any."""
    if len(axes) == 2:
        return normalized(np.cross(axes[0], axes[1]))
    candidates = [np.cross(axes[0], unit) if axes else unit for unit in np.eye(3)]
    return normalized(max(candidates, key=lambda one: float(np.linalg.norm(one))))


def _assembled(kind: str, name: str, child: str, near: str, own: Floats, coordinates: str, transform: str) -> str:
    inner = element("socket_parent_frame", "near") + element("socket_child_frame", "far")
    inner += element("coordinates", coordinates) + element("frames", near + frame_xml("far", child, own))
    return element(kind, inner + transform, name=name)


def _contact(scene: Scene, path: Path, lost: list[Ignored]) -> tuple[list[str], list[str]]:
    """Spheres where shapes meet the ground, the ground, and what acts between them."""
    if plain_number(scene.ground.stiffness) <= 0.0:
        return [], []
    shapes, by_material = [], dict[tuple[float, ...], list[str]]()
    for name, body in scene.character.bodies.items():
        points = [(shape, *point) for shape in body.shapes for point in contact_points(shape)]
        for k, (shape, point, radius) in enumerate(points):
            own = f"{name_of(name)}_{k}"
            if isinstance(shape, Box) or plain_number(radius) <= 0.0:
                lost.append(Ignored(path, 0, f"character.bodies.{name}.shapes", SPHERES_ONLY))
                continue
            inner = placed("socket_frame", frame_path(scene, name), plain_vector(point))
            inner += element("radius", numbers([plain_number(radius)]))
            shapes.append(element("ContactSphere", inner, name=own))
            material = _material(scene, body, shape)
            key = tuple(plain_number(getattr(material, field)) for field in MATERIAL)
            by_material.setdefault(key, []).append(own)
    if not shapes:
        return [], []
    if scene.ground.law == "spring":
        lost.append(Ignored(path, 0, "ground", OTHER_CONTACT))
    normal = WORLD.T @ normalized(plain_vector(scene.ground.normal))
    turn = np.stack([-normal, *_beside(normal)], axis=1)
    inner = element("socket_frame", "/ground")
    inner += element("location", numbers(vector(normal * plain_number(scene.ground.height))))
    shapes.append(element("ContactHalfSpace", inner + element("orientation", numbers(angles_of(turn))), name="floor"))
    return shapes, _contact_forces(scene.ground.law == "smooth_hunt_crossley", by_material)


def _material(scene: Scene, body: Body, shape: Sphere | Capsule) -> ContactMaterial:
    """What a shape is made of, or what comes near to a spring."""
    if scene.ground.law != "spring":
        return shape.material or scene.ground.material or ContactMaterial()
    friction = min(plain_number(body.friction), plain_number(scene.ground.friction))
    return ContactMaterial(STIFFNESS, DISSIPATION, friction, friction, 0.0, 0.1)


def _contact_forces(smooth: bool, by_material: dict[tuple[float, ...], list[str]]) -> list[str]:
    """The forces of spheres, by the numbers in `MATERIAL` that they are made of."""
    forces = []
    for k, (values, names) in enumerate(by_material.items()):
        tags = {tag: element(tag, numbers([value])) for tag, value in zip(MATERIAL.values(), values, strict=True)}
        if smooth:
            for own in names:
                ends = element("socket_sphere", f"/contactgeometryset/{own}")
                ends += element("socket_half_space", "/contactgeometryset/floor")
                forces.append(element("SmoothSphereHalfSpaceForce", ends + "".join(tags.values()), name=f"on_{own}"))
            continue
        inner = element("geometry", " ".join(["floor", *names])) + "".join(tags[tag] for tag in list(tags)[:5])
        one = element("HuntCrossleyForce::ContactParameters", inner)
        inner = objects("HuntCrossleyForce::ContactParametersSet", [one], name="contact_parameters")
        forces.append(element("HuntCrossleyForce", inner + tags["transition_velocity"], name=f"contact_{k}"))
    return forces


def _beside(normal: Floats) -> tuple[Floats, Floats]:
    """Two unit vectors that make a right-handed frame with the one against a normal."""
    second = _independent([normal])
    return second, np.cross(-normal, second)
