"""Reflexes of a SCONE controller as reflexes of a scene, with the names of their parameters."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from warpmuscle.formats.lines import Notes
from warpmuscle.formats.osim.placement import WORLD, direction, vector
from warpmuscle.formats.scone.joints import Coordinate
from warpmuscle.formats.scone.numbers import AUTO_FACTOR, FreeNumber, as_scene_number, read_number
from warpmuscle.formats.scone.parameters import Parameter
from warpmuscle.formats.scone.zml import Node
from warpmuscle.scene import Force, GaitReflex, Scene
from warpmuscle.scene.gait_states.part import ROOT, SensedBalance, SensedPoint, SensedTurn, Side, Signal, State, sided
from warpmuscle.scene.number import Number

OF_MUSCLE = {  # numbers of a MuscleReflex
    "C0": "constant", "KL": "length_gain", "L0": "length_offset", "KV": "velocity_gain", "V0": "velocity_offset",
    "KF": "force_gain", "F0": "force_offset", "KS": "spindle_gain", "S0": "spindle_offset", "KA": "activation_gain",
    "A0": "activation_offset",
}  # fmt: skip
OF_ANGLE = {
    "C0": "constant", "KP": "angle_gain", "P0": "angle_target", "KV": "rate_gain", "V0": "rate_target",
}  # fmt: skip
OF_POSITION = {
    "C0": "constant", "KP": "position_gain", "P0": "position_target", "KV": "speed_gain", "V0": "speed_target",
}  # fmt: skip
OF_POINT = {**OF_POSITION, "KA": "acceleration_gain", "A0": "acceleration_target"}
Negative = Mapping[str, tuple[Signal, bool]]  # the signal, and whether it may be negative where nothing is said
NEGATIVE_MUSCLE: Negative = {
    "allow_neg_L": ("length", True), "allow_neg_V": ("velocity", False), "allow_neg_F": ("force", True),
    "allow_neg_S": ("spindle", False), "allow_neg_A": ("activation", False),
}  # fmt: skip
RARE = ("spindle", "activation")  # signals that are said to be cut only where they are sensed
NEGATIVE_ANGLE: Negative = {"allow_neg_P": ("angle", True), "allow_neg_V": ("rate", True)}
NEGATIVE_POSITION: Negative = {"allow_neg_P": ("position", True), "allow_neg_V": ("speed", True)}
OPPOSITE = "_o"  # ends the name of what belongs to the other leg
SUFFIX = {"left": "_l", "right": "_r", "both": ""}
SIDE_OF = ("_l", "_r")  # end the name of what is of one leg alone
ONE_SIDE: dict[str, Side] = {"_l": "left", "_r": "right"}
SIDES: dict[Side, str] = {"left": "l", "right": "r", "both": "lr"}
OF_MOTOR = {"P0": "target", "KP": "gain", "KV": "damping"}  # of what drives a motor about an axis
MOTOR_AXES = {"z": "lean", "x": "list", "y": "turn"}
AT_ONCE = "motors of joints act without delay here"
OF_STEP = "its acceleration is the mean over a control step, not that of the step of the simulation before"
ANGLES_FROM, BODIES_FROM = (2, 0, 4, 2348), (2, 0, 6)  # versions of SCONE: how turns are sensed, and on which side
ABOUT_AXIS = "of the root its turn about an axis of its own is taken, which is the same while it turns about one alone"


@dataclass
class Bindings:
    """Values of parameters, and where in the scene they went."""

    values: Mapping[str, Parameter] = field(default_factory=dict)
    places: dict[str, str] = field(default_factory=dict)  # paths in the scene, by name of the parameter
    means: dict[str, FreeNumber] = field(default_factory=dict)
    std_factor: float = AUTO_FACTOR

    def number(self, node: Node, name: str, place: str) -> Number:
        """The number of a node, which as a free one has this name, and starts from its best value if there is one."""
        found = read_number(node, self.std_factor)
        if isinstance(found, FreeNumber):
            self.places[name], self.means[name] = place, found
        known = self.values.get(name)
        return as_scene_number(found, None if known is None else known.best)


class Sensed(NamedTuple):
    """What of a body reflexes name besides its muscles, joints and segments."""

    root: Mapping[str, Coordinate]  # coordinates of the root
    motors: Mapping[str, tuple[Coordinate, str]]  # by coordinate: it, and the force that turns it
    version: tuple[int, ...] = ()  # of SCONE that the scenario is of; the newest if empty


class Acting(NamedTuple):
    """When and where reflexes act, and how their parameters' names begin."""

    during: Sequence[State]
    prefix: str = ""
    sides: Sequence[Side] = ("both",)  # left and right by themselves where their parameters are their own


class ReflexReader:
    """Reads the reflexes of one scenario."""

    def __init__(self, scene: Scene, body: Sensed, bindings: Bindings, notes: Notes) -> None:
        self._scene, self._root, self._bindings, self._notes = scene, body.root, bindings, notes
        self._motors, self._version = body.motors, body.version
        self._side: Side = "both"
        self._one = False  # whether names say of which leg what they mean is

    def turns(self, node: Node) -> bool:
        """Whether a reflex drives a motor in place of a muscle."""
        target = node.find("target")
        return target is not None and target.value in self._motors

    def drive(self, node: Node, prefix: str) -> None:
        """Let a motor hold its body upright about an axis."""
        target, source = node.need("target"), node.need("source")
        turned, force = self._motors[target.text()]
        motor = self._scene.forces[force]
        if node.key != "BodyOrientationReflex" or source.text() != motor.other_body:
            node.fail(f"motors are driven here by a BodyOrientationReflex of their own body, {motor.other_body!r}")
        node.find("axis_name")
        axis = turned.sign * np.eye(3)["xyz".index(turned.axis)]
        if not np.allclose(node.vector_of("axis", (0.0, 0.0, 1.0)), axis):
            node.fail(f"its axis must be that of {target.text()!r} here")
        own = f"{prefix}{target.text()}-{source.text()}"
        motor.scone_names = {**motor.scone_names, MOTOR_AXES[turned.axis]: own}
        self._drive(node, motor, MOTOR_AXES[turned.axis], own, force)
        if (delay := node.find("delay")) is not None and delay.number() > 0.0:
            self._notes.ignore(delay.file, delay.line, f"delay of {target.text()}", AT_ONCE)
        node.tell_unused(f"a motor is driven by {', '.join(OF_MOTOR)}")

    def _drive(self, node: Node, motor: Force, axis: str, own: str, force: str) -> None:
        if motor.parameters[f"{axis}_gain"] != 0.0:
            node.fail("one reflex drives a motor about this axis already")
        for word, what in OF_MOTOR.items():
            if (found := node.find(word)) is not None:
                place = f"forces.{force}.parameters.{axis}_{what}"
                motor.parameters[f"{axis}_{what}"] = self._bindings.number(found, f"{own}.{word}", place)

    def read(self, node: Node, acting: Acting, into: dict[str, GaitReflex]) -> None:
        """Add a reflex, or one for each leg."""
        target, muscles = node.need("target"), self._scene.character.muscles
        if target.text() in muscles and target.text().endswith(SIDE_OF):
            target.fail(f"names the muscle of one leg: leave {target.text()[-2:]} out, or say dual_sided = 0 above")
        for side in acting.sides:
            self._side = side
            self._read(node, acting, into, target.text())

    def read_one(self, node: Node, acting: Acting, into: dict[str, GaitReflex]) -> None:
        """Add a reflex of one leg, whose names all say which leg they are of."""
        target = node.need("target")
        if not target.text().endswith(SIDE_OF):
            target.fail("with dual_sided = 0 it says of which leg it is: its name ends in _l or _r")
        self._side, self._one = ONE_SIDE[target.text()[-2:]], True
        self._read(node, acting, into, target.text()[:-2])
        self._one = False

    def _read(self, node: Node, acting: Acting, into: dict[str, GaitReflex], muscle: str) -> None:
        kind, target = REFLEXES[node.key], node.need("target")
        source = node.find(kind.source)
        sensed = "" if source is None else source.text()
        names = (target.text(), sensed) if self._one else (self._named(muscle), self._named(sensed))
        own = names[0] if names[1] in ("", names[0]) and kind.source == "source" else "-".join(names)
        own = self._named(node.string_of("par_name")) or own
        key = key_of(f"{acting.prefix}{own}", into)
        place = f"gait_states.reflexes.{key}"
        self._notes.places[place] = (node.file, node.line)
        reflex = GaitReflex(muscle, during=list(acting.during), side=self._side)
        self.known(target, muscle, self._scene.character.muscles, "muscle")
        kind.read(self, node, reflex, source)
        for word, name in kind.numbers.items():
            found = node.find(word)
            if found is not None:
                setattr(reflex, name, self._bindings.number(found, f"{acting.prefix}{own}.{word}", f"{place}.{name}"))
        cut = [signal for word, (signal, usual) in kind.negative.items() if not node.truth_of(word, usual)]
        reflex.positive = [one for one in cut if one not in RARE or getattr(reflex, f"{one}_gain") != 0.0]
        if (delay := node.find("delay")) is not None:
            reflex.delay = self._bindings.number(delay, f"{acting.prefix}{own}.delay", f"{place}.delay")
        if node.key == "ConditionalMuscleReflex":
            self._condition(node, reflex, f"{acting.prefix}{own}", place)
        if node.number_of("condition", 0.0) != 0.0:
            node.fail("a condition of the sign is not known here")
        node.tell_unused()
        into[key] = reflex

    def _named(self, name: str) -> str:
        """How parameters call something: with its side where legs have numbers of their own."""
        return f"{name}{SUFFIX[self._side]}" if name else ""

    def _muscle(self, node: Node, reflex: GaitReflex, source: Node | None) -> None:
        if source is None:
            return
        sensed = self._other(reflex, source.text())
        reflex.of = "" if sensed == reflex.muscle and not reflex.opposite else sensed
        self.known(source, sensed, self._scene.character.muscles, "muscle", reflex.opposite)

    def _joint(self, node: Node, reflex: GaitReflex, source: Node | None) -> None:
        """A joint's angle; of the root its turn forwards, or about another axis."""
        if source is None:
            node.fail("there is no `source` in it")
        sensed, mirrored = source.text(), node.truth_of("mirror_left", False)
        own = self._root.get(sensed)
        if own is None:
            if mirrored:
                node.fail("mirror_left is known here of turns of the root alone")
            reflex.joint = self._other(reflex, sensed)
            self.known(source, reflex.joint, self._scene.character.joints, "joint", reflex.opposite)
        elif own.kind == "r" and own.axis == "z":
            reflex.joint = ROOT
        elif own.kind == "r":
            axis = own.sign * WORLD @ np.eye(3)["xyz".index(own.axis)]
            reflex.turn = SensedTurn(self._scene.character.root, direction(axis), mirrored=mirrored)
            self._notes.ignore(source.file, source.line, sensed, ABOUT_AXIS)
        else:
            turns = ", ".join(repr(name) for name, one in self._root.items() if one.kind == "r")
            source.fail(f"of the root only its turns can be sensed: {turns}")

    def _turn(self, node: Node, reflex: GaitReflex, source: Node | None) -> None:
        if source is None:
            node.fail("there is no `source` in it")
        node.find("axis_name")
        body = self._other(reflex, source.text())
        self.known(source, body, self._scene.character.bodies, "body", reflex.opposite)
        reflex.turn = self._sided_turn(body, self._direction(node, "axis", (0.0, 0.0, 1.0)), reflex.opposite)

    def _sided_turn(self, body: str, axis: tuple[float, float, float], opposite: bool) -> SensedTurn:
        """What senses a turn: left is what the body is of, or the muscle, if the body is of no side or SCONE is old."""
        angles = self._since(ANGLES_FROM) and sorted(map(abs, axis)) == [0.0, 0.0, 1.0]
        if not self._since(BODIES_FROM) or (not opposite and body[-2:] not in SIDE_OF):
            return SensedTurn(body, axis, angles=angles)
        if opposite or body.endswith("_l"):
            x, y, z = axis
            axis = (x, 0.0 - y, 0.0 - z)
        return SensedTurn(body, axis, mirrored=opposite, angles=angles)

    def _since(self, version: tuple[int, ...]) -> bool:
        return not self._version or self._version >= version

    def _point(self, node: Node, reflex: GaitReflex, source: Node | None) -> None:
        if source is None:
            node.fail("there is no `source` in it")
        body = self._other(reflex, source.text())
        self.known(source, body, self._scene.character.bodies, "body", reflex.opposite)
        place = vector(WORLD @ np.array(node.vector_of("offset")))
        reflex.point = SensedPoint(body, self._direction(node, "direction", None), place)
        if node.find("KA") is not None:
            self._notes.ignore(source.file, source.line, source.text(), OF_STEP)

    def _balance(self, node: Node, reflex: GaitReflex, source: Node | None) -> None:
        if node.truth_of("mirror_left", False):
            node.fail("mirror_left is not known here: directions of the left leg are mirrored as they are")
        pivot = "" if source is None else self._other(reflex, source.text())
        if pivot and source is not None:
            self.known(source, pivot, self._scene.character.bodies, "body", reflex.opposite)
        reflex.balance = SensedBalance(self._direction(node, "dir", (0.0, 0.0, 1.0)), pivot)

    def _direction(self, node: Node, key: str, usual: tuple[float, float, float] | None) -> tuple[float, float, float]:
        """A direction of SCONE's axes in ours."""
        given = node.find(key)
        if given is None and usual is None:
            node.fail(f"there is no `{key}` in it")
        found = WORLD @ np.array(node.vector_of(key, usual or (0.0, 0.0, 0.0)))
        if not np.linalg.norm(found) > 0.0:
            node.fail(f"its {key} has no length")
        return vector(found)

    def _other(self, reflex: GaitReflex, name: str) -> str:
        """A name without what says of which leg it is, or that it is of the other one."""
        if self._one and name.endswith(SIDE_OF):
            reflex.opposite = ONE_SIDE[name[-2:]] != self._side
            return name[:-2]
        reflex.opposite = name.endswith(OPPOSITE)
        return name.removesuffix(OPPOSITE)

    def _condition(self, node: Node, reflex: GaitReflex, own: str, place: str) -> None:
        """The joint that silences a reflex beyond an interval."""
        joint = node.need("dof")
        own_leg = self._one and ONE_SIDE.get(joint.text()[-2:]) == self._side
        reflex.within_joint = joint.text()[:-2] if own_leg else joint.text()
        self.known(joint, reflex.within_joint, self._scene.character.joints, "joint")
        for word, name in (("pos_min", "within_low"), ("pos_max", "within_high")):
            found = node.find(word)
            if found is not None:
                number = self._bindings.number(found, f"{own}-{joint.text()}.{word}", f"{place}.{name}")
                setattr(reflex, name, number)

    def known(
        self, node: Node, name: str, names: Mapping[str, object], what: str, opposite: bool = False
    ) -> None:  # fmt: skip
        """Fail unless there is something of a name on each side that is meant, or of the other legs."""
        for side in SIDES[self._side]:
            side = {"l": "r", "r": "l"}[side] if opposite else side
            if sided(name, names, side) not in names:
                node.fail(f"there is no {what} {name!r} in the model, nor {name}_{side}")


def key_of(name: str, taken: Mapping[str, object]) -> str:
    """A key of a scene for a name of SCONE's, which no other one has."""
    key = name.replace(".", "_")
    number = 2
    while key in taken:
        key, number = f"{name.replace('.', '_')}_{number}", number + 1
    return key


class Kind(NamedTuple):
    """A kind of reflex: what says what it senses, its numbers, and which signals may be kept from being negative."""

    read: Callable[[ReflexReader, Node, GaitReflex, Node | None], None]
    numbers: Mapping[str, str]
    negative: Negative
    source: str = "source"


REFLEXES = {
    "MuscleReflex": Kind(ReflexReader._muscle, OF_MUSCLE, NEGATIVE_MUSCLE),
    "ConditionalMuscleReflex": Kind(ReflexReader._muscle, OF_MUSCLE, NEGATIVE_MUSCLE),
    "DofReflex": Kind(ReflexReader._joint, OF_ANGLE, NEGATIVE_ANGLE),
    "BodyOrientationReflex": Kind(ReflexReader._turn, OF_ANGLE, NEGATIVE_ANGLE),
    "BodyPointReflex": Kind(ReflexReader._point, OF_POINT, {}),
    "ComPivotReflex": Kind(ReflexReader._balance, OF_POSITION, NEGATIVE_POSITION, "pivot_body"),
}
