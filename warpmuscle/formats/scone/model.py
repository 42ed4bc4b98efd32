"""A scene's character, ground and muscles from a model of Hyfydy (.hfd).

Its x is forward, y up and z to the right, and bodies have their origin at the centre of mass, as ours. Joints hold
exactly here, where Hyfydy has stiff springs (see `joints`); contact is by its own law.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.plain_text import readable
from warpmuscle.core.pose import about, rotate
from warpmuscle.formats.lines import Notes
from warpmuscle.formats.osim.placement import WORLD, direction, vector
from warpmuscle.formats.scone.joints import DEGREE, Coordinate, put_joints
from warpmuscle.formats.scone.zml import Node
from warpmuscle.scene import (
    Body,
    Character,
    ContactMaterial,
    Force,
    Ground,
    Muscle,
    MuscleModel,
    Scene,
    Sphere,
    ViaPoint,
)
from warpmuscle.scene.number import Number

SOURCE = re.compile(r"(?P<sign>-?)(?P<name>.+)_(?P<kind>[rt])(?P<axis>[xyz])(?P<side>_[lr])?")
HELD = "joints hold exactly here, and their stiffness and damping are not used"
OPTIONS = ("joint_stiffness", "joint_damping", "damping_mode", "limit_damping_mode", "density")  # of held joints
BESIDE = "has no mass and hangs on no joint: what stands beside a character, such as a treadmill, is not known here"
SHAPES = ("capsule", "box", "cylinder")  # that no ground is felt by
UNTOUCHED = "only spheres touch the ground here; left out"
UNBOUNDED_TORQUE = 1.0e6  # N m
MOTOR = (
    "stiffness", "damping", "most",
    *(f"{axis}_{what}" for axis in ("lean", "list", "turn") for what in ("gain", "target", "damping")),
)  # fmt: skip
MATERIAL = {"static_friction": 1.0, "stiffness": 1.0e6, "damping": 1.0}  # defaults of Hyfydy


@dataclass
class HyfydyModel:
    """A scene, and what reading it has left."""

    scene: Scene
    coordinates: dict[str, Coordinate] = field(default_factory=dict)
    root: list[str] = field(default_factory=list)  # names of the root's coordinates
    motors: dict[str, str] = field(default_factory=dict)  # forces of the scene, by coordinates that they turn


@dataclass
class Options:
    """How Hyfydy computes, by a scenario's `composite_force` and integrator; its usual values."""

    transition_velocity: float = 0.15  # m/s
    damping: float = 0.1  # of muscles, `xi`
    v_max: float = 10.0  # l_opt/s
    activation_rate: float = 100.0  # 1/s
    deactivation_rate: float = 25.0


def read_model(top: Node, notes: Notes, options: Options | None = None) -> HyfydyModel:
    """The model of a file.

    Raises:
        SceneError: something of it cannot be represented or is not known, with file and line.
    """
    return _Builder(top.need("model"), notes, options or Options()).build()


def sphere_stiffness(stiffness: float, radius: float) -> float:
    """OpenSim's stiffness, N/m^2, of a sphere with a stiffness of Hyfydy, whose force is (k d)^(3/2) of the depth.

    k is that of both sides together, half of that of equal ones. So 5975.21 at a radius of 3 cm is OpenSim's 2e6, which
    the twin models of both have.
    """
    return float(stiffness**1.5 / (4.0 / 3.0 * math.sqrt(radius)))


class _Builder:
    """Makes a scene of the nodes of one model."""

    def __init__(self, model: Node, notes: Notes, options: Options) -> None:
        self._model, self._notes, self._options = model, notes, options
        self._file: Path = model.file
        self._limits: dict[str, Node | None] = {}
        self._settings = model.find("model_options") or Node("model_options", model.file, model.line)

    def build(self) -> HyfydyModel:
        bodies = {self._name(body): body for body in self._model.every("body")}
        joints = self._joints(bodies)
        for name in OPTIONS:
            self._settings.find(name)
        roots = [name for name in bodies if name != "ground" and name not in joints]
        for name in roots if len(roots) > 1 else ():
            if bodies[name].number_of("mass", 0.0) == 0.0:
                bodies[name].fail(f"{name!r} {BESIDE}")
        if len(roots) != 1:
            named = ", ".join(roots[:3]) or "none"
            self._model.fail(f"one body hangs on no joint, and all others on it; here it is {named}")
        coordinates = self._coordinates()
        character = Character(root=roots[0], bodies={}, root_joint="free")
        for name, body in bodies.items():
            if name != "ground":
                character.bodies[name] = self._body(body)
                self._notes.places[f"character.bodies.{name}"] = (body.file, body.line)
        scene = Scene(self._model.string_of("name") or readable(self._file.stem), character)
        found = HyfydyModel(scene, coordinates)
        if any(node.find("stiffness") is not None for node in joints.values()) or self._settings.children:
            self._notes.ignore(self._file, self._settings.line, "joint_stiffness", HELD)
        self._put_root(found)
        put_joints(scene, coordinates, joints, bodies, self._settings, self._notes)
        self._put_motors(found, joints)
        self._put_muscles(scene)
        self._put_contact(scene)
        gravity = self._model.vector_of("gravity", (0.0, -9.81, 0.0))
        if gravity[0] != 0.0 or gravity[2] != 0.0 or gravity[1] > 0.0:
            self._model.fail("gravity must point along -y")
        scene.gravity = -gravity[1]
        self._settings.tell_unused()
        self._model.tell_unused()
        return found

    def _name(self, node: Node) -> str:
        name = node.string_of("name")
        if not name or len(name) > 200 or not name.isprintable():
            node.fail("needs a name")
        return name

    def _body(self, node: Node) -> Body:
        """Mass and inertia; a body starts where its joints put it."""
        mass, inertia = node.need("mass").number(), node.vector_of("inertia")
        for name in ("pos", "lin_vel", "ang_vel"):
            node.find(name)
        if any(node.vector_of("ori")):
            node.fail("bodies that are turned in the model's own pose are not known here")
        node.every("mesh")
        node.tell_unused()
        x, y, z = inertia
        return Body(mass, (z, y, x))

    def _joints(self, bodies: dict[str, Node]) -> dict[str, Node]:
        """Joints by their child."""
        found: dict[str, Node] = {}
        pairs = [(body.find("joint"), name) for name, body in bodies.items()]
        pairs += [(joint, joint.string_of("child")) for joint in self._model.every("joint")]
        for joint, child in pairs:
            if joint is None:
                continue
            joint.find("child")
            if child not in bodies or child in found:
                joint.fail(f"body {child!r} hangs on two joints" if child in found else f"there is no body {child!r}")
            parent = joint.need("parent").text()
            if parent not in bodies or parent == "ground":
                joint.fail(f"there is no body {parent!r} to hang on")
            found[child] = joint
        return found

    def _coordinates(self) -> dict[str, Coordinate]:
        found: dict[str, Coordinate] = {}
        for node in self._model.every("dof"):
            name, source = self._name(node), node.need("source")
            match = SOURCE.fullmatch(source.text())
            if match is None:
                source.fail(f"{source.text()!r} is not the turn or shift of a body, such as pelvis_rz")
            if name in found:
                node.fail(f"two are called {name!r}")
            owner = match["name"] + (match["side"] or "")
            sign = -1.0 if match["sign"] else 1.0
            found[name] = Coordinate(name, node.line, owner, match["kind"], match["axis"], sign)
            for key in ("range", "default"):
                node.find(key)
            node.tell_unused()
        return found

    def _put_root(self, found: HyfydyModel) -> None:
        """A root that stays in the sagittal plane where its coordinates are of this plane."""
        character = found.scene.character
        own = [one for one in found.coordinates.values() if one.owner == character.root]
        found.root = [one.name for one in own]
        if own and {(one.kind, one.axis) for one in own} <= {("r", "z"), ("t", "x"), ("t", "y")}:
            character.root_joint = "planar"

    def _put_motors(self, found: HyfydyModel, joints: dict[str, Node]) -> None:
        """Motors of joints, as far as they only hold both bodies alike."""
        children = {node.string_of("name") or f"{child}_joint": child for child, node in joints.items()}
        for node in self._model.every("joint_motor"):
            joint = node.need("joint")
            child = children.get(joint.text())
            if child is None:
                joint.fail(f"there is no joint {joint.text()!r}")
            for key in ("target_ori", "target_vel", "torque_offset"):
                if any(node.vector_of(key)):
                    node.fail(f"a {key} other than 0 is not known here")
            name = node.string_of("name") or f"{joint.text()}_motor"
            if name in found.scene.forces:
                node.fail(f"two are called {name!r}")
            values: dict[str, Number] = dict.fromkeys(MOTOR, 0.0)
            values |= {
                "stiffness": node.number_of("stiffness", 0.0), "damping": node.number_of("damping", 0.0),
                "most": node.number_of("max_torque", UNBOUNDED_TORQUE),
            }  # fmt: skip
            node.tell_unused()
            parent = joints[child].need("parent").text()
            found.scene.forces[name] = Force("joint_motor", body=parent, other_body=child, parameters=values)
            self._notes.places[f"forces.{name}"] = (node.file, node.line)
            for one in found.coordinates.values():
                if one.owner in (joint.text(), child) and one.kind == "r":
                    found.motors[one.name] = name

    def _put_muscles(self, scene: Scene) -> None:
        options = self._options
        factor = self._settings.number_of("muscle_force_multiplier", 1.0)
        scene.muscle_model = MuscleModel(
            curves="hyfydy", tendon="compliant", activation="excited", rise_time=1.0 / options.activation_rate,
            fall_time=1.0 / options.deactivation_rate, v_max=options.v_max, damping=options.damping,
            specific_tension=2.5e5, initial_activation=0.05,
        )  # fmt: skip
        for node in self._model.every("point_path_muscle", "joint_point_path_muscle"):
            name = self._name(node)
            if name in scene.character.muscles:
                node.fail(f"two are called {name!r}")
            muscle = Muscle(
                f_max=factor * node.need("max_isometric_force").number(),
                l_opt=node.need("optimal_fiber_length").number(), l_slack=node.need("tendon_slack_length").number(),
                pennation=node.number_of("pennation_angle", 0.0),
            )  # fmt: skip
            if node.number_of("stiffness_multiplier", 1.0) != 1.0:
                node.fail("a stiffness_multiplier other than 1 is not known here")
            for point in node.need("path").every(""):
                body = point.need("body").text()
                if body not in scene.character.bodies:
                    point.fail(f"there is no body {body!r}")
                muscle.path.append(ViaPoint(body, vector(WORLD @ np.array(point.vector_of("pos")))))
                point.tell_unused()
            node.tell_unused()
            scene.character.muscles[name] = muscle
            self._notes.places[f"character.muscles.{name}"] = (node.file, node.line)

    def _put_contact(self, scene: Scene) -> None:
        """Spheres on a plane of the ground, by the law of Hunt and Crossley, each with OpenSim's stiffness."""
        materials = {self._name(node): node for node in self._model.every("material")}
        for node in self._model.every("geometry"):
            kind, body = node.need("type").text(), node.need("body").text()
            if kind in SHAPES and body in scene.character.bodies:
                self._notes.ignore(node.file, node.line, f"{kind} on {body}", UNTOUCHED)
                continue
            place, turn = node.vector_of("pos"), node.vector_of("ori")
            node.find("name")
            material = node.find("material")
            if material is not None and material.text() not in materials:
                material.fail(f"there is no material {material.text()!r}")
            of = materials[material.text()] if material is not None else next(iter(materials.values()), None)
            if kind == "plane" and body == "ground":
                self._ground(scene, node, place, turn)
            elif kind == "sphere" and body in scene.character.bodies:
                radius = node.need("radius").number()
                if not radius > 0.0:
                    node.fail("needs a radius greater than 0")
                sphere = Sphere(vector(WORLD @ np.array(place)), radius, self._material(of, radius))
                shapes = scene.character.bodies[body].shapes
                self._notes.places[f"character.bodies.{body}.shapes.{len(shapes)}"] = (node.file, node.line)
                scene.character.bodies[body].shapes = [*shapes, sphere]
            else:
                node.fail(
                    f"a {kind} on {body!r} is not known here; only spheres on bodies and a plane on the ground are"
                )
            node.tell_unused()

    def _ground(self, scene: Scene, node: Node, place: tuple[float, ...], turn: tuple[float, ...]) -> None:
        normal = rotate(turn_of(turn), np.array(node.vector_of("normal", (0.0, 1.0, 0.0))))
        up = direction(WORLD @ normal)
        height = float(np.array(up) @ (WORLD @ np.array(place)))
        scene.ground = Ground(normal=up, height=height, law="hunt_crossley")

    def _material(self, node: Node | None, radius: float) -> ContactMaterial:
        node = node or Node("material", self._file, self._model.line)
        values = {key: node.number_of(key, default) for key, default in MATERIAL.items()}
        if values["stiffness"] < 0.0:
            node.fail("its stiffness must not be negative")
        dynamic = node.number_of("dynamic_friction", values["static_friction"])
        node.tell_unused()
        return ContactMaterial(
            stiffness=sphere_stiffness(values["stiffness"], radius), dissipation=values["damping"],
            static_friction=values["static_friction"], dynamic_friction=dynamic, viscous_friction=0.0,
            transition_velocity=self._options.transition_velocity,
        )  # fmt: skip


def turn_of(degrees: tuple[float, ...]) -> Floats:
    """The rotation (x, y, z, w) by angles about x, y and z, of which one at most is not 0."""
    index = int(np.argmax(np.abs(degrees)))
    return np.asarray(about(np.eye(3)[index], degrees[index] * DEGREE))
