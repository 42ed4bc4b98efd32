"""States of gait, reflexes, patterns and noise of a scene from a SCONE controller, with the names of its parameters."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import msgspec
import numpy as np

from warpmuscle.formats.lines import Ignored, Notes
from warpmuscle.formats.osim.placement import WORLD, vector
from warpmuscle.formats.scone.reflexes import REFLEXES, SUFFIX, Acting, Bindings, ReflexReader, Sensed, key_of
from warpmuscle.formats.scone.start import matches
from warpmuscle.formats.scone.unknown import put_off, refuse
from warpmuscle.formats.scone.zml import Node
from warpmuscle.scene import Character, Force, GaitStates, Scene
from warpmuscle.scene.gait_states.part import STATES, GaitNoise, GaitPattern, LegThresholds, Shape, Side, State
from warpmuscle.scene.number import Free, Number

STATE_NAMES: dict[str, State] = dict(
    zip(("EarlyStance", "LateStance", "Liftoff", "Swing", "Landing"), STATES, strict=True)
)
LABELS = ("name", "signature_prefix", "signature_postfix", "symmetric", "auto_std_factor")
THRESHOLDS = {
    "stance_load_threshold": "stance_load", "swing_load_threshold": "swing_load", "landing_threshold": "landing",
    "late_stance_threshold": "late_stance", "liftoff_threshold": "liftoff",
}  # fmt: skip
LEGS = {"left": "leg0_l.", "right": "leg1_r."}  # how names of one leg's thresholds begin
ONES: tuple[Side, Side] = ("left", "right")
FUNCTIONS: dict[str, Shape] = {
    "PieceWiseLinear": "linear", "PieceWiseConstant": "constant", "Polynomial": "polynomial", "Constant": "constant",
}  # fmt: skip
MOST_KNOTS = 99
SHORTEST = 0.001  # s, from knot to knot
AT_LEAST = f"from knot to knot there are at least {SHORTEST:g} s here"
DURING = ("ReflexController", "FeedForwardController", "CompositeController")  # what may act in states of the gait
NO_MUSCLES = (
    "patterns drive muscles, of which the model has none; its motors are driven by a BodyOrientationReflex alone"
)


def read_controllers(nodes: Iterable[Node], scene: Scene, body: Sensed, bindings: Bindings, notes: Notes) -> None:
    """Put the controller of a scenario into a scene.

    Args:
        body: what reflexes may name of it. notes: gets what is taken otherwise.

    Raises:
        SceneError: something of it is not known, with file and line.
    """
    for node in nodes:
        _Reader(scene, body, bindings, notes).controller(node)


class _Reader:
    """Reads the controllers of one scenario."""

    def __init__(self, scene: Scene, body: Sensed, bindings: Bindings, notes: Notes) -> None:
        self._scene, self._bindings = scene, bindings
        self._reflexes = ReflexReader(scene, body, bindings, notes)
        self._notes = notes

    def controller(self, node: Node) -> None:
        """A controller of a kind that is known."""
        read = CONTROLLERS.get(node.key)
        if read is None:
            refuse(node, "controllers", CONTROLLERS)
        if put_off(node):
            return
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
        """The states of both legs, and what acts in them."""
        before = self._bindings.std_factor
        self._bindings.std_factor = node.number_of("auto_std_factor", before)
        _labels(node)
        symmetric = node.truth_of("symmetric", True)
        states = self._states(node)
        self._thresholds(node, states, symmetric)
        if (length := node.find("override_leg_length")) is not None:
            states.leg_length = length.number()
        if node.number_of("leg_load_sensor_delay", 0.0) != 0.0:
            node.fail("a leg_load_sensor_delay other than 0 is not known here")
        for one in node.need("ConditionalControllers").every("ConditionalController", ""):
            words = one.need("states").text().replace(",", ";").split(";")
            sides = self._legs(one, symmetric)
            for group in words:
                during = [self._state(one, word) for word in group.split()]
                mask = "".join("1" if state in during else "0" for state in reversed(STATES))
                acting = Acting(during, f"S{mask}.", sides)
                self._during(one, acting)
            one.tell_unused(f"what acts in states is {', '.join(DURING)}")
        node.need("ConditionalControllers").tell_unused()
        self._bindings.std_factor = before

    def _during(self, node: Node, acting: Acting) -> None:
        """What acts in some states, several of them within a composite controller."""
        for child in node.every(*DURING):
            if put_off(child):
                continue
            if child.key == "CompositeController":
                _labels(child)
                self._during(child, acting)
                for group in child.every("Controllers"):
                    self._during(group, acting)
                    group.tell_unused()
            elif child.key == "ReflexController":
                self._group(child, acting)
            else:
                self._patterns(child, acting)
            child.tell_unused()

    def reflexes(self, node: Node) -> None:
        """Reflexes that always act."""
        self._group(node, self._always(node))

    def feed_forward(self, node: Node) -> None:
        """Patterns over the time of the simulation."""
        self._patterns(node, self._always(node))

    def noise(self, node: Node) -> None:
        """Noise of all excitations."""
        noise = GaitNoise()
        for word, name in (("base_noise", "base"), ("proportional_noise", "proportional")):
            if (found := node.find(word)) is not None:
                setattr(noise, name, self._bindings.number(found, word, f"gait_states.noise.{name}"))
        seed = node.number_of("random_seed", float(noise.seed))
        if not (seed.is_integer() and 0 <= seed < 2**31):
            node.fail(f"its random_seed must be a whole number from 0 on, is {seed:g}")
        noise.seed = int(seed)
        _labels(node)
        self._states(node).noise = noise

    def perturbation(self, node: Node) -> None:
        """Pushes of a body at fixed times."""
        body, forces = node.need("body"), self._scene.forces
        self._reflexes.known(body, body.text(), self._scene.character.bodies, "body")
        key = key_of(node.string_of("name") or f"push_{body.text()}", forces)
        duration, interval = node.number_of("duration", 0.1), node.number_of("interval", 0.0)
        values: dict[str, Number] = {
            "start": node.number_of("start_time", 0.0), "duration": duration, "interval": interval,
            "end": node.number_of("stop_time", node.number_of("end_time", 0.0)),
        }  # fmt: skip
        for word, what in (("force", "force"), ("moment", "moment"), ("position_offset", "place")):
            turned = vector(WORLD @ np.array(node.vector_of(word)))
            values |= {f"{what}_{axis}": number for axis, number in zip("xyz", turned, strict=True)}
        if duration < 0.0 or 0.0 < interval < duration:
            node.fail("its duration must not be below 0, nor longer than its interval")
        _labels(node)
        node.find("random_seed")
        forces[key] = Force("push", body=body.text(), parameters=values)
        self._notes.places[f"forces.{key}"] = (node.file, node.line)

    def _always(self, node: Node) -> Acting:
        name = node.string_of("name")
        sides: tuple[Side, ...] = ("both",) if node.truth_of("symmetric", True) else ONES
        return Acting(STATES, f"{name}." if name else "", sides)

    def _legs(self, node: Node, symmetric: bool) -> tuple[Side, ...]:
        """The legs that a controller of some states is of."""
        legs = node.string_of("legs").lower()
        if legs not in ("", "left", "right", "l", "r"):
            node.fail(f"there are no legs {legs!r}, but left and right")
        if legs:
            return ("left",) if legs.startswith("l") else ("right",)
        return ("both",) if symmetric else ONES

    def _thresholds(self, node: Node, states: GaitStates, symmetric: bool) -> None:
        """At what legs come from state to state, each at its own numbers unless they are alike."""
        if not symmetric:
            states.right = states.right or LegThresholds()
        for key, name in THRESHOLDS.items():
            found = node.find(key)
            if found is None:
                continue
            if states.right is None or symmetric:
                setattr(states, name, self._bindings.number(found, key, f"gait_states.{name}"))
            else:
                left, right = (f"{prefix}{key}" for prefix in LEGS.values())
                setattr(states, name, self._bindings.number(found, left, f"gait_states.{name}"))
                setattr(states.right, name, self._bindings.number(found, right, f"gait_states.right.{name}"))

    def _state(self, node: Node, word: str) -> State:
        if word not in STATE_NAMES:
            node.fail(f"there is no state {word!r}; there are {', '.join(STATE_NAMES)}")
        return STATE_NAMES[word]

    def _states(self, node: Node) -> GaitStates:
        if self._scene.gait_states is None:
            base, length = leg_of(self._scene.character)
            self._scene.gait_states = GaitStates({}, base=base, leg_length=length)
        return self._scene.gait_states

    def _group(self, node: Node, acting: Acting) -> None:
        """The reflexes of a controller."""
        _labels(node)
        dual = node.truth_of("dual_sided", True)
        for group in [node, *node.every("Reflexes")]:
            for child in group.children:
                if child.key in REFLEXES:
                    child.used = True
                    if self._reflexes.turns(child):
                        self._reflexes.drive(child, acting.prefix)
                    elif not dual:
                        self._reflexes.read_one(child, acting, self._states(node).reflexes)
                    else:
                        self._reflexes.read(child, acting, self._states(node).reflexes)
            if group is not node:
                group.tell_unused("reflexes are " + ", ".join(REFLEXES))

    def _patterns(self, node: Node, acting: Acting) -> None:
        """A pattern of each muscle that is included, alike for both legs or one for each."""
        _labels(node)
        function = node.find("Function", *FUNCTIONS, *(f"{name}Function" for name in FUNCTIONS))
        if function is None:
            node.fail(f"there is no function in it; there are {', '.join(FUNCTIONS)}")
        word = function.need("type").text() if function.key == "Function" else function.key
        if word.removesuffix("Function") not in FUNCTIONS:
            function.fail(f"there is no function {word!r}; there are {', '.join(FUNCTIONS)}")
        shape = FUNCTIONS[word.removesuffix("Function")]
        include, exclude = node.string_of("include", "*"), node.string_of("exclude")
        muscles = self._scene.character.muscles
        if not muscles:
            node.fail(NO_MUSCLES)
        names = dict.fromkeys(
            name.removesuffix("_l").removesuffix("_r")
            for name in muscles
            if matches(name, include) and not matches(name, exclude)
        )
        if not names:
            node.fail(f"no muscle is included: {include!r} without {exclude!r}")
        patterns = self._states(node).patterns
        for side in acting.sides:
            for name in names:
                own = f"{acting.prefix}{name}{SUFFIX[side]}"
                key = key_of(own, patterns)
                self._reflexes.known(node, name, muscles, "muscle")
                self._notes.places[f"gait_states.patterns.{key}"] = (function.file, function.line)
                numbers = self._knots(function, shape, own, f"gait_states.patterns.{key}")
                flat = function.truth_of("flat_extrapolation", False)
                patterns[key] = GaitPattern(
                    name, numbers[0], during=list(acting.during), side=side, shape=shape, intervals=numbers[1],
                    flat=flat and shape == "linear",
                )  # fmt: skip
        function.tell_unused()

    def _knots(self, node: Node, shape: Shape, own: str, place: str) -> tuple[list[Number], list[Number]]:
        """The values and the intervals of a pattern, each with a name of its own."""
        if shape == "polynomial":
            degree = node.find("degree", "order") or node.need("degree")
            terms = [node.need(f"coefficient{k}") for k in range(_count(degree, 0) + 1)]
            numbers = [self._bindings.number(x, f"{own}.C{k}", f"{place}.values.{k}") for k, x in enumerate(terms)]
            return numbers, []
        if (value := node.find("value")) is not None:
            return [self._bindings.number(value, f"{own}.value", f"{place}.values.0")], []
        knots, value = _count(node.need("control_points"), 1), node.need("control_point_y")
        values = [self._bindings.number(value, f"{own}.Y{k}", f"{place}.values.{k}") for k in range(knots)]
        if knots == 1:
            node.find("control_point_dt")
            return values, []
        step = node.need("control_point_dt")
        steps = [self._bindings.number(step, f"{own}.DT{k}", f"{place}.intervals.{k}") for k in range(knots - 1)]
        return values, [self._longer(step, number) for number in steps]

    def _longer(self, node: Node, number: Number) -> Number:
        """A free interval whose bounds begin above 0: two knots at one time are no pattern."""
        if not isinstance(number, Free) or number.value is None or number.min is None or number.max is None:
            return number
        if number.min >= SHORTEST:
            return number
        if number.max <= SHORTEST:
            node.fail(f"its bounds end at {number.max:g}; {AT_LEAST}")
        said = (node.file, node.line, node.key, AT_LEAST)
        if Ignored(*said) not in self._notes.ignored:
            self._notes.ignore(*said)
        return msgspec.structs.replace(number, value=max(number.value, SHORTEST), min=SHORTEST)


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


def _count(node: Node, least: int) -> int:
    """A whole number of knots or coefficients."""
    number = node.number()
    if not (number.is_integer() and least <= number <= MOST_KNOTS):
        node.fail(f"must be a whole number from {least} to {MOST_KNOTS}, is {number:g}")
    return int(number)


def _labels(node: Node) -> None:
    for label in LABELS:
        node.find(label)


CONTROLLERS: dict[str, Callable[[_Reader, Node], None]] = {
    "GaitStateController": _Reader.gait_states,
    "ReflexController": _Reader.reflexes,
    "FeedForwardController": _Reader.feed_forward,
    "NoiseController": _Reader.noise,
    "PerturbationController": _Reader.perturbation,
    "CompositeController": _Reader.composite,
    "MirrorController": _Reader.composite,  # one for each side, which all are here
}
