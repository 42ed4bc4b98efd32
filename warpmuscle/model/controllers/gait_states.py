"""States of gait and their reflexes as a kernel wants them: terms of all simulated muscles in flat arrays."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import warp as wp

from warpmuscle.core.arrays import records_to_device, rows, starts, structs_to_device
from warpmuscle.core.errors import SceneError
from warpmuscle.kernels import gait_state_structs as structs
from warpmuscle.kernels.control.control import ControllerKind
from warpmuscle.kernels.control.gait_states import gait_state_stage, state_force
from warpmuscle.kernels.reflex_structs import ReflexSpan
from warpmuscle.kernels.structs import LEFT, RIGHT
from warpmuscle.model.controllers.entry import Zeros
from warpmuscle.scene import Scene
from warpmuscle.scene.gait_states.part import ROOT, STATES, GaitReflex, GaitStates, sided
from warpmuscle.scene.masses import is_zero
from warpmuscle.scene.number import Number
from warpmuscle.scene.parameters import greatest
from warpmuscle.scene.topology import Topology

SIDES = (("l", LEFT), ("r", RIGHT))


class Term(NamedTuple):
    """A term of a muscle's excitation: what it senses, and its numbers."""

    sensor: int
    states: int
    positive: bool
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
        self.sensors: list[tuple[int, int]] = []
        self.terms: list[list[Term]] = [[] for _ in muscles]
        self.side = [LEFT] * len(muscles)
        for side, number in SIDES:
            for name, reflex in states.reflexes.items():
                self._add(name, reflex, side, number)

    def _add(self, name: str, reflex: GaitReflex, side: str, number: int) -> None:
        """The terms of a reflex on one side."""
        key = f"gait_states.reflexes.{name}"
        target = self._muscle(reflex.muscle, side, f"{key}.muscle")
        source = self._muscle(reflex.of or reflex.muscle, side, f"{key}.of")
        self.side[target] = number
        states = sum(1 << STATES.index(state) for state in set(reflex.during))
        angle = rate = structs.NOTHING
        if reflex.within_joint:
            angle, rate = self._of_joint(reflex.within_joint, side)
        own = self.terms[target]

        def add(sensor: int, signal: str, gain: Number, offset: Number, within: bool = True) -> None:
            limits = (angle, rate) if within else (structs.NOTHING, structs.NOTHING)
            numbers = (gain, offset, reflex.within_low, reflex.within_high, reflex.delay)
            own.append(Term(sensor, states, signal in reflex.positive, *limits, *numbers))

        add(structs.NOTHING, "", reflex.constant, 0.0, within=False)
        for signal, kind in (
            ("length", structs.FIBRE_LENGTH), ("velocity", structs.FIBRE_VELOCITY), ("force", structs.FIBRE_FORCE),
        ):  # fmt: skip
            gain = getattr(reflex, f"{signal}_gain")
            if not is_zero(gain):
                add(self._sensor(kind, source), signal, gain, getattr(reflex, f"{signal}_offset"))
        if reflex.joint:
            for signal, sensor in zip(("angle", "rate"), self._of_joint(reflex.joint, side), strict=True):
                gain = getattr(reflex, f"{signal}_gain")
                if not is_zero(gain):
                    # The root's lean counts forwards in the kernel: gain (target + lean).
                    forwards = reflex.joint == ROOT
                    target_of = getattr(reflex, f"{signal}_target")
                    add(sensor, signal, gain if forwards else -gain, -target_of if forwards else target_of)

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

    def _sensor(self, kind: int, source: int) -> int:
        if (kind, source) not in self.sensors:
            self.sensors.append((kind, source))
        return self.sensors.index((kind, source))


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
    s.sensor = records_to_device(
        structs.GaitSensor, device, kind=[kind for kind, _ in found.sensors], source=[of for _, of in found.sensors]
    )
    s.span = records_to_device(ReflexSpan, device, first=places[:-1], end=places[1:], side=found.side)
    s.plan = records_to_device(
        structs.StateReflexPlan, device, sensor=[term.sensor for term in every],
        states=[term.states for term in every], positive=[int(term.positive) for term in every],
        angle=[term.angle for term in every], rate=[term.rate for term in every],
    )  # fmt: skip
    columns = {field: rows([getattr(term, field) for term in every]) for field in ("gain", "offset", "low", "high")}
    columns["delay_steps"] = np.rint(rows([term.delay for term in every]) / (s.every * scene.time_step))
    s.row = structs_to_device(structs.StateReflexRow, columns, device)
    swing = states.stance_load if states.swing_load is None else states.swing_load
    limits: dict[str, Any] = {"stance_load": states.stance_load, "swing_load": swing, "least": states.least}
    limits |= {field: getattr(states, field) * states.leg_length for field in ("landing", "late_stance", "liftoff")}
    s.thresholds = structs_to_device(
        structs.GaitThresholds, {field: rows([value]) for field, value in limits.items()}, device
    )
    return s


def state_arrays(scene: Scene, instances: int, names: Topology, zeros: Zeros) -> dict[str, wp.array]:
    """Room for what instances remember, by its place in `kernels.structs.State`."""
    states = scene.gait_states
    assert states is not None
    longest = max(greatest(scene, reflex.delay) for reflex in states.reflexes.values())
    steps = int(2 ** math.ceil(math.log2(longest / states.control_step + 2.0)))
    sensors = 10 * len(states.reflexes)  # five of each reflex on each side, at most, and those that silence it
    return {
        "gait.phase": zeros(instances, 2, dtype=int),
        "gait.heard": zeros(instances, steps, 2 * sensors),
    }
