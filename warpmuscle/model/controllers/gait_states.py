"""States of gait and their reflexes as a kernel wants them: terms of all simulated muscles in flat arrays."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import warp as wp

from warpmuscle.core.arrays import records_to_device, rows, starts, structs_to_device, to_device
from warpmuscle.core.errors import SceneError
from warpmuscle.kernels import gait_state_structs as structs
from warpmuscle.kernels.control.control import ControllerKind
from warpmuscle.kernels.control.gait_states import gait_state_stage, state_force
from warpmuscle.kernels.reflex_structs import ReflexSpan
from warpmuscle.kernels.structs import LEFT, RIGHT
from warpmuscle.model.controllers.entry import Zeros
from warpmuscle.scene import Scene
from warpmuscle.scene.gait_states.part import ROOT, STATES, Fixed, GaitPattern, GaitReflex, GaitStates, sided
from warpmuscle.scene.masses import is_zero
from warpmuscle.scene.number import Number
from warpmuscle.scene.parameters import greatest
from warpmuscle.scene.topology import Topology

SIDES = (("l", LEFT), ("r", RIGHT))
MEANT = {"both": "lr", "left": "l", "right": "r"}
HERE = (0.0, 0.0, 0.0)
TURNS, MOVES = ("angle", "rate"), ("position", "speed")  # signals of a turn, and of a point or the centre of mass
OF_MUSCLES = {
    "length": structs.FIBRE_LENGTH, "velocity": structs.FIBRE_VELOCITY, "force": structs.FIBRE_FORCE,
    "spindle": structs.SPINDLE, "activation": structs.ACTIVATION,
}  # fmt: skip


class Sensor(NamedTuple):
    """What is sensed, see `kernels.gait_state_structs.GaitSensor`."""

    kind: int
    source: int
    place: Fixed = HERE
    along: Fixed = HERE


class Term(NamedTuple):
    """A term of a muscle's excitation: what it senses, and its numbers."""

    sensor: int
    states: int
    positive: int
    change: bool
    angle: int
    rate: int
    gain: Number
    offset: Number
    low: Number
    high: Number
    delay: Number


class Terms:
    """Collects the terms of all muscles, and the sensors that they need."""

    def __init__(self, states: GaitStates, scene: Scene, names: Topology, muscles: Sequence[str]) -> None:
        self._states, self._scene, self._names, self._muscles = states, scene, names, muscles
        self.sensors: list[Sensor] = []
        self.terms: list[list[Term]] = [[] for _ in muscles]
        self.patterns: list[list[GaitPattern]] = [[] for _ in muscles]
        self.side = [LEFT] * len(muscles)
        for side, number in SIDES:
            for name, reflex in states.reflexes.items():
                if side in MEANT[reflex.side]:
                    self._add(name, reflex, side, number)
            for name, pattern in states.patterns.items():
                if side in MEANT[pattern.side]:
                    target = self._muscle(pattern.muscle, side, f"gait_states.patterns.{name}.muscle")
                    self.side[target] = number
                    self.patterns[target].append(pattern)

    def _add(self, name: str, reflex: GaitReflex, side: str, number: int) -> None:
        """The terms of a reflex on one side."""
        key = f"gait_states.reflexes.{name}"
        of_side = {"l": "r", "r": "l"}[side] if reflex.opposite else side
        target = self._muscle(reflex.muscle, side, f"{key}.muscle")
        source = self._muscle(reflex.of or reflex.muscle, of_side, f"{key}.of")
        self.side[target] = number
        states = _states(reflex.during)
        angle = rate = structs.NOTHING
        if reflex.within_joint:
            angle, rate = self._of_joint(reflex.within_joint, side)
        own = self.terms[target]

        def add(
            sensor: int, signal: str, gain: Number, offset: Number, within: bool = True, change: bool = False
        ) -> None:
            limits = (angle, rate) if within else (structs.NOTHING, structs.NOTHING)
            numbers = (gain, offset, reflex.within_low, reflex.within_high, reflex.delay)
            positive = (2 if signal in OF_MUSCLES else 1) if signal in reflex.positive else 0
            own.append(Term(sensor, states, positive, change, *limits, *numbers))

        add(structs.NOTHING, "", reflex.constant, 0.0, within=False)
        for signal, kind in OF_MUSCLES.items():
            gain = getattr(reflex, f"{signal}_gain")
            if not is_zero(gain):
                add(self._sensor(kind, source), signal, gain, getattr(reflex, f"{signal}_offset"))
        if reflex.joint:
            for signal, sensor in zip(("angle", "rate"), self._of_joint(reflex.joint, of_side), strict=True):
                gain = getattr(reflex, f"{signal}_gain")
                if not is_zero(gain):
                    # The root's lean counts forwards in the kernel: gain (target + lean).
                    forwards = reflex.joint == ROOT
                    target_of = getattr(reflex, f"{signal}_target")
                    add(sensor, signal, gain if forwards else -gain, -target_of if forwards else target_of)
        for signals, sensors in self._of_bodies(reflex, side, of_side):
            for signal, sensed in zip(signals, sensors, strict=True):
                gain = getattr(reflex, f"{signal}_gain")
                if not is_zero(gain):
                    add(self._sensor(*sensed), signal, -gain, getattr(reflex, f"{signal}_target"))
        faster: Any = reflex.acceleration_gain
        if (point := reflex.point) is not None and not is_zero(faster):
            speed = self._sensor(structs.SPEED, self._body(point.body, of_side), point.place, point.direction)
            add(speed, "acceleration", -faster, reflex.acceleration_target, change=True)

    def _of_bodies(
        self, reflex: GaitReflex, side: str, of_side: str
    ) -> list[tuple[tuple[str, str], tuple[Sensor, Sensor]]]:
        """Signals and sensors of a turn, a point and the centre of mass, as far as a reflex has them."""
        found = []
        if (turn := reflex.turn) is not None:
            x, y, z = turn.axis
            # An axis that turns with the sense of a mirror: left and right change places, x is to the left.
            axis = (x, -y, -z) if turn.mirrored and side == "l" else (x, y, z)
            of = self._body(turn.body, of_side)
            how = structs.TURN_ANGLE if turn.angles else structs.TURN
            found.append((TURNS, (Sensor(how, of, HERE, axis), Sensor(structs.TURN_RATE, of, HERE, axis))))
        if (point := reflex.point) is not None:
            rest = (self._body(point.body, of_side), point.place, point.direction)
            found.append((MOVES, (Sensor(structs.POSITION, *rest), Sensor(structs.SPEED, *rest))))
        if (balance := reflex.balance) is not None:
            x, y, z = balance.direction
            pivot = self._body(balance.pivot, of_side) if balance.pivot else structs.NOTHING
            level = (pivot, HERE, (-x if side == "l" else x, y, z))
            found.append((MOVES, (Sensor(structs.BALANCE, *level), Sensor(structs.BALANCE_SPEED, *level))))
        return found

    def _body(self, name: str, side: str) -> int:
        return self._names.bodies.index(sided(name, self._scene.character.bodies, side))

    def _muscle(self, name: str, side: str, key: str) -> int:
        found = sided(name, self._scene.character.muscles, side)
        if found not in self._muscles:
            raise SceneError(f"{found} acts on no joint that muscles drive, so it is not simulated", key=key)
        return self._muscles.index(found)

    def _of_joint(self, name: str, side: str) -> tuple[int, int]:
        """Sensors of an angle and of its rate."""
        if name == ROOT:
            return self._sensor(structs.LEAN, 0), self._sensor(structs.LEAN_RATE, 0)
        body = self._names.body_of_joint(sided(name, self._scene.character.joints, side))
        return self._sensor(structs.ANGLE, body), self._sensor(structs.ANGLE_RATE, body)

    def _sensor(self, kind: int, source: int, place: Fixed = HERE, along: Fixed = HERE) -> int:
        sensor = Sensor(kind, source, place, along)
        if sensor not in self.sensors:
            self.sensors.append(sensor)
        return self.sensors.index(sensor)


def has_gait_states(scene: Scene, muscles: Sequence[str] = ()) -> bool:
    """Whether a scene has states of gait."""
    return scene.gait_states is not None


def compiled(before: ControllerKind, scene: Scene) -> ControllerKind:
    """What a step has compiled in."""
    return before._replace(sense=gait_state_stage, force=state_force)


def control_steps(scene: Scene) -> int:
    """Steps of a control step."""
    assert scene.gait_states is not None
    return max(round(scene.gait_states.control_step / scene.time_step), 1)


def gait_states_struct(scene: Scene, names: Topology, muscles: Sequence[str], device: Any) -> structs.GaitStates:
    """The device structure of a scene's states of gait; an empty one if it has none.

    Raises:
        SceneError: a reflex is of a muscle that is not simulated.
    """
    s = structs.GaitStates()
    states = scene.gait_states
    if states is None:
        return s
    found = Terms(states, scene, names, muscles)
    every = [term for own in found.terms for term in own]
    places = starts(len(own) for own in found.terms)
    s.every, s.base = control_steps(scene), names.bodies.index(states.base)
    sensors = found.sensors or [Sensor(structs.FIBRE_LENGTH, 0)]
    s.sensor = structs_to_device(
        structs.GaitSensor, {name: [getattr(one, name) for one in sensors] for name in Sensor._fields}, device
    )
    s.span = records_to_device(ReflexSpan, device, first=places[:-1], end=places[1:], side=found.side)
    s.plan = records_to_device(
        structs.StateReflexPlan, device, sensor=[term.sensor for term in every],
        states=[term.states for term in every], positive=[term.positive for term in every],
        change=[int(term.change) for term in every],
        angle=[term.angle for term in every], rate=[term.rate for term in every],
    )  # fmt: skip
    columns = {field: rows([getattr(term, field) for term in every]) for field in ("gain", "offset", "low", "high")}
    columns["delay_steps"] = np.rint(rows([term.delay for term in every]) / (s.every * scene.time_step))
    s.row = structs_to_device(structs.StateReflexRow, columns, device)
    both = [_thresholds(states, number) for _, number in sorted(SIDES, key=lambda one: one[1])]
    limits = {field: rows([one[field] for one in both]) for field in both[0]}
    s.thresholds = structs_to_device(structs.GaitThresholds, limits, device)
    s.control_step = s.every * scene.time_step
    s.noise_seed = states.noise.seed if states.noise is not None else 0
    s.begins = int(not scene.initial_state.activations)
    s.settles = int(scene.muscle_model.tendon == "compliant")
    _put_patterns(s, found, device)
    return s


def _thresholds(states: GaitStates, side: int) -> dict[str, Any]:
    """The numbers of a leg."""
    own = states.right if side == RIGHT else None

    def number(name: str) -> Any:
        given = None if own is None else getattr(own, name)
        return getattr(states, name) if given is None else given

    stance, swing = number("stance_load"), number("swing_load")
    limits: dict[str, Any] = {"stance_load": stance, "swing_load": stance if swing is None else swing}
    limits |= {field: number(field) * states.leg_length for field in ("landing", "late_stance", "liftoff")}
    noise = states.noise
    limits |= {"noise": noise.base if noise else 0.0, "noise_share": noise.proportional if noise else 0.0}
    return limits | {"least": states.least}


def _put_patterns(s: structs.GaitStates, found: Terms, device: Any) -> None:
    """The patterns of all muscles, and their knots."""
    own = found.patterns
    every = [pattern for of_muscle in own for pattern in of_muscle]
    places = starts(len(of_muscle) for of_muscle in own)
    s.pattern_span = records_to_device(ReflexSpan, device, first=places[:-1], end=places[1:], side=found.side)
    ends = starts(len(pattern.values) for pattern in every)
    s.pattern = records_to_device(
        structs.GaitPatternPlan, device, first=ends[:-1], end=ends[1:],
        shape=[_shape(pattern) for pattern in every], states=[_states(pattern.during) for pattern in every],
    )  # fmt: skip
    times: list[Any] = []
    for pattern in every:
        at: Any = 0.0
        times.append(at)
        for interval in [*pattern.intervals, *[1.0] * (len(pattern.values) - 1 - len(pattern.intervals))]:
            at = at + interval
            times.append(at)
    values = [value for pattern in every for value in pattern.values]
    pairs = np.broadcast_arrays(rows(times or [0.0]), rows(values or [0.0]))
    s.knot = to_device(np.stack(pairs, axis=-1), wp.vec2, device)


def _shape(pattern: GaitPattern) -> int:
    shapes: dict[str, int] = {
        "linear": structs.LINEAR, "flat": structs.FLAT, "constant": structs.CONSTANT, "polynomial": structs.POLYNOMIAL,
    }  # fmt: skip
    return shapes["flat" if pattern.shape == "linear" and pattern.flat else pattern.shape]


def _states(during: Sequence[str]) -> int:
    """Bits of states."""
    return sum(1 << STATES.index(state) for state in set(during))


def state_arrays(scene: Scene, instances: int, names: Topology, zeros: Zeros) -> dict[str, wp.array]:
    """Room for what instances remember, by its place in `kernels.structs.State`."""
    states = scene.gait_states
    assert states is not None
    longest = max((greatest(scene, reflex.delay) for reflex in states.reflexes.values()), default=0.0)
    # A change takes what was sensed one control step earlier, too.
    changes = any(not is_zero(reflex.acceleration_gain) for reflex in states.reflexes.values())
    steps = int(2 ** math.ceil(math.log2(longest / states.control_step + (3.0 if changes else 2.0))))
    sensors = 11 * max(len(states.reflexes), 1)  # of each reflex on each side, at most, with those that silence it
    return {
        "gait.began": zeros(instances, max(2 * len(states.patterns), 1), dtype=int),
        "gait.phase": zeros(instances, 2, dtype=int),
        "gait.heard": zeros(instances, steps, 2 * sensors),
    }
