"""States of gait and reflexes of a scene from a SCONE controller, with the names of its parameters."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field

import numpy as np

from warpmuscle.formats.scone.numbers import AUTO_FACTOR, FreeNumber, as_scene_number, read_number
from warpmuscle.formats.scone.parameters import Parameter
from warpmuscle.formats.scone.zml import Node
from warpmuscle.scene import Character, GaitReflex, GaitStates, Scene
from warpmuscle.scene.gait_states.part import ROOT, STATES, sided
from warpmuscle.scene.number import Number

STATE_NAMES = dict(zip(("EarlyStance", "LateStance", "Liftoff", "Swing", "Landing"), STATES, strict=True))
LABELS = ("name", "signature_prefix", "signature_postfix", "symmetric", "auto_std_factor")
THRESHOLDS = {
    "stance_load_threshold": "stance_load", "swing_load_threshold": "swing_load", "landing_threshold": "landing",
    "late_stance_threshold": "late_stance", "liftoff_threshold": "liftoff",
}  # fmt: skip
OF_MUSCLE = {  # numbers of a MuscleReflex
    "C0": "constant", "KL": "length_gain", "L0": "length_offset", "KV": "velocity_gain", "V0": "velocity_offset",
    "KF": "force_gain", "F0": "force_offset",
}  # fmt: skip
OF_JOINT = {
    "C0": "constant", "KP": "angle_gain", "P0": "angle_target", "KV": "rate_gain", "V0": "rate_target",
}  # fmt: skip
NEGATIVE_MUSCLE = {"allow_neg_L": ("length", True), "allow_neg_V": ("velocity", False), "allow_neg_F": ("force", True)}
NEGATIVE_JOINT = {"allow_neg_P": ("angle", True), "allow_neg_V": ("rate", True)}


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


def read_controllers(nodes: Iterable[Node], scene: Scene, root: list[str], bindings: Bindings) -> None:
    """Put the controller of a scenario into a scene.

    Args:
        root: names of the root's coordinates.

    Raises:
        SceneError: something of it is not known, with file and line.
    """
    for node in nodes:
        _Reader(scene, root, bindings).controller(node)


class _Reader:
    """Reads the controllers of one scenario."""

    def __init__(self, scene: Scene, root: list[str], bindings: Bindings) -> None:
        self._scene, self._root, self._bindings = scene, root, bindings

    def controller(self, node: Node) -> None:
        """A controller of a kind that is known."""
        read = CONTROLLERS.get(node.key)
        if read is None:
            node.fail(f"controllers of this kind are not known here; there are {', '.join(CONTROLLERS)}")
        read(self, node)
        node.tell_unused()

    def composite(self, node: Node) -> None:
        """Several controllers, whose excitations add up."""
        _labels(node)
        node.find("Controllers")
        for child in [*node.children, *(one for group in node.every("Controllers") for one in group.children)]:
            if child.children and child.key != "Controllers":
                child.used = True
                self.controller(child)

    def gait_states(self, node: Node) -> None:
        """The states of both legs, and what reflexes act in them."""
        before = self._bindings.std_factor
        self._bindings.std_factor = node.number_of("auto_std_factor", before)
        _labels(node)
        if not node.truth_of("symmetric", True):
            node.fail("legs with parameters of their own are not known here; give symmetric = 1")
        states = self._states(node)
        for key, name in THRESHOLDS.items():
            found = node.find(key)
            if found is not None:
                setattr(states, name, self._bindings.number(found, key, f"gait_states.{name}"))
        if (length := node.find("override_leg_length")) is not None:
            states.leg_length = length.number()
        if node.number_of("leg_load_sensor_delay", 0.0) != 0.0:
            node.fail("a leg_load_sensor_delay other than 0 is not known here")
        for one in node.need("ConditionalControllers").every("ConditionalController"):
            words = one.need("states").text().replace(",", ";").split(";")
            for group in words:
                during = [self._state(one, word) for word in group.split()]
                mask = "".join("1" if state in during else "0" for state in reversed(STATES))
                for child in one.every("ReflexController"):
                    self._reflexes(child, during, f"S{mask}.")
                    child.tell_unused()
            one.tell_unused()
        node.need("ConditionalControllers").tell_unused()
        self._bindings.std_factor = before

    def reflexes(self, node: Node) -> None:
        """Reflexes that always act."""
        self._reflexes(node, list(STATES), "")

    def _state(self, node: Node, word: str) -> str:
        if word not in STATE_NAMES:
            node.fail(f"there is no state {word!r}; there are {', '.join(STATE_NAMES)}")
        return STATE_NAMES[word]

    def _states(self, node: Node) -> GaitStates:
        if self._scene.gait_states is None:
            base, length = leg_of(self._scene.character)
            self._scene.gait_states = GaitStates({}, base=base, leg_length=length)
        return self._scene.gait_states

    def _reflexes(self, node: Node, during: list[str], prefix: str) -> None:
        _labels(node)
        for group in [node, *node.every("Reflexes")]:
            for child in group.children:
                if child.key in REFLEXES:
                    child.used = True
                    self._reflex(child, during, prefix)
            if group is not node:
                group.tell_unused("reflexes are " + ", ".join(REFLEXES))

    def _reflex(self, node: Node, during: list[str], prefix: str) -> None:
        states, kind = self._states(node), node.key
        target, source = node.need("target"), node.find("source")
        muscle, sensed = target.text(), "" if source is None else source.text()
        own = muscle if not sensed or sensed == muscle else f"{muscle}-{sensed}"
        own = node.string_of("par_name") or own
        key = key_of(f"{prefix}{own}", states.reflexes)
        place = f"gait_states.reflexes.{key}"
        reflex = GaitReflex(muscle, during=list(during))  # type: ignore[arg-type]
        self._known(target, muscle, self._scene.character.muscles, "muscle")
        names, negative = (OF_JOINT, NEGATIVE_JOINT) if kind == "DofReflex" else (OF_MUSCLE, NEGATIVE_MUSCLE)
        if kind == "DofReflex":
            if source is None:
                node.fail("there is no `source` in it")
            reflex.joint = ROOT if sensed in self._root else sensed
            if reflex.joint != ROOT:
                self._known(source, sensed, self._scene.character.joints, "joint")
            elif self._root and sensed != self._root[0]:
                source.fail(f"of the root only its turn {self._root[0]!r} can be sensed")
        elif sensed and source is not None:
            reflex.of = "" if sensed == muscle else sensed
            self._known(source, sensed, self._scene.character.muscles, "muscle")
        for word, name in names.items():
            found = node.find(word)
            if found is not None:
                setattr(reflex, name, self._bindings.number(found, f"{prefix}{own}.{word}", f"{place}.{name}"))
        reflex.positive = [signal for word, (signal, usual) in negative.items() if not node.truth_of(word, usual)]  # type: ignore[misc]
        if (delay := node.find("delay")) is not None:
            reflex.delay = self._bindings.number(delay, f"{prefix}{own}.delay", f"{place}.delay")
        if kind == "ConditionalMuscleReflex":
            self._condition(node, reflex, f"{prefix}{own}", place)
        if node.number_of("condition", 0.0) != 0.0:
            node.fail("a condition of the sign is not known here")
        node.tell_unused()
        states.reflexes[key] = reflex

    def _condition(self, node: Node, reflex: GaitReflex, own: str, place: str) -> None:
        """The joint that silences a reflex beyond an interval."""
        joint = node.need("dof")
        reflex.within_joint = joint.text()
        self._known(joint, joint.text(), self._scene.character.joints, "joint")
        for word, name in (("pos_min", "within_low"), ("pos_max", "within_high")):
            found = node.find(word)
            if found is not None:
                number = self._bindings.number(found, f"{own}-{joint.text()}.{word}", f"{place}.{name}")
                setattr(reflex, name, number)

    def _known(self, node: Node, name: str, names: Mapping[str, object], what: str) -> None:
        for side in "lr":
            if sided(name, names, side) not in names:
                node.fail(f"there is no {what} {name!r} in the model, nor {name}_{side}")


def leg_of(character: Character) -> tuple[str, float]:
    """The body that legs hang on, the root, and their length, m: of the lines between their bodies' centres of mass."""
    joints = {joint.child: joint for joint in character.joints.values()}
    length, body = 0.0, character.feet[0] if character.feet is not None else character.root
    while body in joints and joints[body].parent != character.root:
        joint = joints[body]
        ends = (joint.position_in_parent, joint.position_in_child)
        near, far = (np.array(end, dtype=float) for end in ends)
        length += float(np.linalg.norm(near - far))
        body = joint.parent
    return character.root, length or 1.0


def _labels(node: Node) -> None:
    for label in LABELS:
        node.find(label)


def key_of(name: str, taken: Mapping[str, object]) -> str:
    """A key of a scene for a name of SCONE's, which no other one has."""
    key = name.replace(".", "_")
    number = 2
    while key in taken:
        key, number = f"{name.replace('.', '_')}_{number}", number + 1
    return key


REFLEXES = ("MuscleReflex", "ConditionalMuscleReflex", "DofReflex")
CONTROLLERS: dict[str, Callable[[_Reader, Node], None]] = {
    "GaitStateController": _Reader.gait_states,
    "ReflexController": _Reader.reflexes,
    "CompositeController": _Reader.composite,
}
