"""Muscles of a scene and what drives its joints, as a kernel wants them."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp

from warpmuscle.core.array_types import Floats
from warpmuscle.core.arrays import rows, structs_to_device, to_device
from warpmuscle.core.pose import from_rotation_vector
from warpmuscle.kernels import structs
from warpmuscle.kernels.curve.curve_sets import CURVES
from warpmuscle.kernels.memory.scratch import PULLS_A_BODY
from warpmuscle.kernels.muscle.contraction import RIGID
from warpmuscle.kernels.muscle.muscle_kind import MuscleKind
from warpmuscle.kernels.muscle.muscle_laws import LAWS
from warpmuscle.model.bodies import stacked
from warpmuscle.model.controllers.gait_states import gait_states_struct
from warpmuscle.model.controllers.reflexes import reflexes_struct
from warpmuscle.model.expressions.programs import expression_tables
from warpmuscle.model.joint_groups import grouped_paths
from warpmuscle.model.joints import compiled_skeleton
from warpmuscle.model.muscle_shapes import has_floor, muscle_shapes, shaped_kind, tendon_kind
from warpmuscle.model.path_table import PathTable, path_table
from warpmuscle.model.paths import all_straight, paths_struct, route_struct, torque_parts
from warpmuscle.model.user_functions import custom_curves
from warpmuscle.scene import Actuation, Muscle, MuscleModel, Scene
from warpmuscle.scene.joints import joint_type
from warpmuscle.scene.masses import muscle_mass, specific_tension
from warpmuscle.scene.muscles import given, law_of
from warpmuscle.scene.number import Free
from warpmuscle.scene.topology import Topology
from warpmuscle.scene.validation.paths import is_route

NEGATIVE = {"keep": structs.KEEP, "drop": structs.DROP, "clip": structs.CLIP}
RATES = {"blended": structs.BLENDED, "excited": structs.EXCITED, "excited_rise": structs.EXCITED_RISE}
HILL = "hill"  # the law of muscles that ask for no other
LEGACY_RATE = 2000.0  # steps a second of the original program, in which its delays count


@dataclass(frozen=True)
class ActuationMap:
    """What drives the joints of a scene."""

    drives: dict[str, list[str]]  # by joint: one word a degree of freedom, see `scene.Actuation`
    muscles: tuple[str, ...]  # those that act on a joint that they drive; the others are not simulated
    table: PathTable  # of those muscles

    def of(self, scene: Scene) -> list[Muscle]:
        """The simulated muscles."""
        return [scene.character.muscles[name] for name in self.muscles]

    @property
    def by_torque_alone(self) -> bool:
        """Whether the controller's torques act as they are on all joints that are free to move."""
        return all(set(drive) <= {"torque", "kinematic"} for drive in self.drives.values())

    @property
    def torques_help(self) -> bool:
        """Whether torques of a motor act on any joint."""
        return any({"torque", "assisted"} & set(drive) for drive in self.drives.values())


def muscle_kind(model: MuscleModel, muscles: Iterable[Muscle] = ()) -> MuscleKind:
    """What a step has compiled in for some muscles of a scene, the moment arms being in the state."""
    muscles = list(muscles)
    name = law_of(model)
    pulleys = any(muscle.pulleys for muscle in muscles)
    hill = name == HILL
    several = has_several_activations(muscles, model)
    return MuscleKind(
        CURVES[model.curves], tendon_kind(muscles, model) if hill else RIGID, LAWS[name], pulleys=pulleys,
        neural=hill and model.activation == "neural", excited=hill and model.activation == "excited" and not several,
        excited_rise=hill and model.activation == "excited_rise" and not several,
        blended=hill and model.activation == "blended" and not several,
        smoothed=hill and (several or (model.activation == "scaled" and is_smoothed(muscles, model))),
        implicit=hill and model.implicit_damping,
        special_curves=shaped_kind(muscles, model) or custom_curves(model), floored=hill and has_floor(muscles, model),
    )  # fmt: skip


def is_smoothed(muscles: Iterable[Muscle], model: MuscleModel) -> bool:
    """Whether the time constant of some muscle's activation changes smoothly, or may where its width is free."""
    widths = [given(muscle, model, "activation_smoothing") for muscle in muscles]
    return any(isinstance(width, Free) or bool(np.any(width)) for width in widths)


def has_several_activations(muscles: Iterable[Muscle], model: MuscleModel) -> bool:
    """Whether activations of some muscles rise and fall by another law than those of the others."""
    return any(given(muscle, model, "activation") != model.activation for muscle in muscles)


def shared_joints(scene: Scene, names: Topology, found: ActuationMap) -> int:
    """Joints driven by muscles that one muscle crosses at most; 0 where torques are not shared out."""
    if scene.muscle_model.sharing == "each":
        return 0
    counts = [0] * len(found.muscles)
    for crossing in found.table.crossings:
        counts[crossing.muscle] += bool({"muscle", "assisted"} & set(found.drives[names.joints[crossing.joint - 1]]))
    return max(counts, default=0)


def driven(scene: Scene, names: Topology) -> ActuationMap:
    """Which joints torques and muscles drive, and which muscles are simulated."""
    character = scene.character
    every = path_table(character.muscles, names, character)
    crossed = {names.joints[crossing.joint - 1] for crossing in every.crossings}
    drives: dict[str, list[str]] = {}
    for joint in names.joints:
        count = len(joint_type(character.joints[joint]).speeds)
        given = scene.actuation[joint].drive if joint in scene.actuation else "muscle" if joint in crossed else "torque"
        drives[joint] = [given] * count if isinstance(given, str) else list(given)
    pulling = {joint for joint, drive in drives.items() if {"muscle", "assisted"} & set(drive)}
    acting = {c.muscle for c in every.crossings if names.joints[c.joint - 1] in pulling}
    chosen = tuple(name for i, name in enumerate(character.muscles) if i in acting)
    table = every
    if len(chosen) < len(character.muscles):
        table = path_table({name: character.muscles[name] for name in chosen}, names, character)
    return ActuationMap(drives, chosen, table)


def muscles_struct(scene: Scene, chosen: tuple[str, ...], device: Any) -> structs.Muscles:
    """The device structure of the simulated muscles (see `kernels.structs.Muscles`)."""
    model = scene.muscle_model
    muscles = [scene.character.muscles[name] for name in chosen]
    s = structs.Muscles()
    s.count = len(muscles)
    s.model = CURVES[model.curves]
    s.negative = NEGATIVE[model.negative]
    s.scaled_rates = int(model.activation in ("scaled", "blended"))
    own = {field: _of_muscles(muscles, field) for field in ("f_max", "l_opt", "l_slack", "slow_fibres")}
    own |= {
        field: _special_or_common(muscles, model, field) for field in ("v_max", "damping", "rise_time", "fall_time")
    }
    neural_time = _column(model.neural_time)
    columns = own | {
        "rise_rest": np.exp(-scene.time_step / own["rise_time"]),
        "fall_rest": np.exp(-scene.time_step / own["fall_time"]),
        "neural_rest": np.exp(-scene.time_step / neural_time),
        "rise_mix": neural_mix(scene.time_step, neural_time, own["rise_time"]),
        "fall_mix": neural_mix(scene.time_step, neural_time, own["fall_time"]),
    }
    columns["width"] = own["l_opt"] * np.sin(_of_muscles(muscles, "pennation"))
    columns["delay_steps"] = delay_steps(scene, chosen)
    s.row = structs_to_device(structs.MuscleRow, columns, device)
    before = expression_tables(scene).rows if scene.forces else None
    shapes = muscle_shapes(muscles, model, before)
    if shapes is not None:
        s.shape = structs_to_device(structs.CurveRow, shapes.columns, device)
        s.curve_table = to_device(shapes.table, wp.vec2, device)
    elif before is not None and len(before):
        s.curve_table = to_device(before, wp.vec2, device)
    masses = rows([muscle_mass(muscle, specific_tension(muscle, model)) for muscle in muscles] or [1.0])
    s.mass = to_device(masses, float, device)
    several = has_several_activations(muscles, model)
    if several or is_smoothed(muscles, model):
        widths = [
            RATES.get(given(one, model, "activation"), given(one, model, "activation_smoothing")) for one in muscles
        ]  # fmt: skip
        s.smoothing = to_device(rows(widths), float, device)
    _excitations(s, muscles, device)
    return s


def compiled_kind(
    scene: Scene, names: Topology, found: ActuationMap, capacity: int, lean: bool = False
) -> MuscleKind | None:
    """What a step for so many bodies (capacity) has compiled in for muscles; nothing where torques alone act.

    Args:
        lean: whether to leave out what can be left out, so that the step is faster and fits fewer scenes.
    """
    if found.by_torque_alone:
        return None
    kind = muscle_kind(scene.muscle_model, found.of(scene))
    elastic = (_elastic(scene.actuation.get(joint)) for joint in names.joints)
    drives = [_drive(found.drives[joint], spring) for joint, spring in zip(names.joints, elastic, strict=True)]
    kind = kind._replace(parts=len(torque_parts(found.table)))
    in_scratch = len(found.table.crossings) <= PULLS_A_BODY * capacity and kind.may_be_in_scratch
    joints = compiled_skeleton(scene.character)
    smooth = (muscle for muscle in found.of(scene) if not is_route(muscle))
    conditions = any(point.condition is not None for muscle in smooth for point in muscle.path)
    muscles, grouped = found.of(scene), grouped_paths(found.table, names, scene.character)
    return kind._replace(
        straight=lean and in_scratch and all_straight(found.table, names, scene.character),
        timed=not lean or any(muscle.excitation is not None for muscle in muscles),
        all_timed=lean and all(muscle.excitation is not None for muscle in muscles),
        pulls_in_scratch=in_scratch, mixed=structs.MIXED in drives, conditions=conditions,
        delayed=not lean or any(not isinstance(muscle.delay, float) or muscle.delay > 0.0 for muscle in muscles),
        coordinate_joints=bool(joints.joints), followers=joints.follows, shared=shared_joints(scene, names, found),
        paths=grouped.kind_of(muscles, scene.character)._replace(gathers=grouped.gathers),
    )  # fmt: skip


def neural_mix(time_step: float, neural_time: Any, time: Any) -> Floats:
    """What a step takes from the neural signal's way to go into the activation, see `activation.neural_step`."""
    neural, own = np.broadcast_arrays(np.asarray(neural_time, np.float64), np.asarray(time, np.float64))
    own = np.where(np.abs(own - neural) < 1e-9 * neural, own * (1.0 + 1e-6), own)  # so that nothing is divided by 0
    return np.asarray(neural / (neural - own) * (np.exp(-time_step / neural) - np.exp(-time_step / own)))


def delay_steps(scene: Scene, chosen: tuple[str, ...]) -> Floats:
    """Neural delays of the simulated muscles in steps, (rows, muscles).

    The original program holds N = max(1, floor(2000 delay)) values, of which it hears the oldest: N - 1 of its steps.
    """
    delay = _of_muscles([scene.character.muscles[name] for name in chosen], "delay")
    if law_of(scene.muscle_model) == "legacy":
        delay = (np.maximum(np.floor(delay * LEGACY_RATE + 1e-9), 1.0) - 1.0) / LEGACY_RATE
    return np.asarray(np.rint(delay / scene.time_step))


def _of_muscles(muscles: list[Muscle], field: str) -> Floats:
    """One number of all muscles, (rows, muscles); a one if there are none."""
    return rows([getattr(muscle, field) for muscle in muscles] or [1.0])


def _special_or_common(muscles: list[Muscle], model: MuscleModel, field: str) -> Floats:
    """One number of all muscles, (rows, muscles): its own, or that of their model; (rows, 1) if none has its own."""
    if all(getattr(muscle, field) is None for muscle in muscles):
        return _column(getattr(model, field))
    return rows([given(muscle, model, field) for muscle in muscles])


def _column(number: Any) -> Floats:
    """A number that all muscles share, (rows, 1)."""
    return np.reshape(np.asarray(number, dtype=np.float64), (-1, 1))


def _excitations(s: structs.Muscles, muscles: list[Muscle], device: Any) -> None:
    """Put in the excitations of the muscles that have their own."""
    time: list[Any] = []
    value: list[Any] = []
    start = [0]
    for muscle in muscles:
        if muscle.excitation is not None:
            time.extend(muscle.excitation.time)
            value.extend(muscle.excitation.value)
        start.append(len(time))
    period = [0.0 if muscle.excitation is None else muscle.excitation.period for muscle in muscles]
    s.knot_time = to_device(rows(time or [0.0]), float, device)
    s.knot_value = to_device(rows(value or [0.0]), float, device)
    columns = {"first_knot": start[:-1] or [0], "end_knot": start[1:] or [0], "period": rows(period or [0.0])}
    s.timed = structs_to_device(structs.TimedExcitation, columns, device)


def actuation_struct(scene: Scene, names: Topology, drives: dict[str, list[str]], device: Any) -> structs.Actuation:
    """The device structure of what drives the joints (see `kernels.structs.Actuation`)."""
    weights = {word: np.zeros((len(names.bodies), 3)) for word in ("torque", "muscle", "passive")}
    drive = np.zeros(len(names.bodies), dtype=int)
    stiffness: list[Any] = [0.0]
    damping: list[Any] = [0.0]
    rest = [np.array([[0.0, 0.0, 0.0, 1.0]])]
    for body, joint in enumerate(names.joints, 1):
        for axis, word in enumerate(drives[joint]):
            for kind in ("torque", "muscle"):
                weights[kind][body, axis] = word in (kind, "assisted")
        own = scene.actuation.get(joint) or Actuation("none")
        elastic = _elastic(own)
        drive[body] = _drive(drives[joint], elastic)
        for axis, word in enumerate(drives[joint]):
            weights["passive"][body, axis] = elastic and word in ("passive", "muscle", "assisted")
        stiffness.append(own.stiffness)
        damping.append(own.damping)
        rest.append(_rest(own))
    s = structs.Actuation()
    s.drive = to_device(drive, int, device)
    s.by_torque = to_device(weights["torque"], wp.vec3, device)
    s.by_muscles = to_device(weights["muscle"], wp.vec3, device)
    s.passive = to_device(weights["passive"], wp.vec3, device)
    s.rest = to_device(stacked(rest), wp.quat, device)
    s.stiffness = to_device(rows(stiffness), float, device)
    s.damping = to_device(rows(damping), float, device)
    return s


def _elastic(own: Actuation | None) -> bool:
    """Whether a joint has a spring-damper, or may have one by a number that is free."""
    numbers = [] if own is None else [own.stiffness, own.damping]
    return any(isinstance(number, Free) or bool(np.any(number)) for number in numbers)


def _drive(words: list[str], elastic: bool) -> int:
    """How the torque of a joint is made."""
    free = set(words) - {"kinematic"}
    if free <= {"torque"}:
        return int(structs.BY_TORQUE)
    return int(structs.BY_MUSCLES if free == {"muscle"} and not elastic else structs.MIXED)


def _rest(own: Actuation) -> Floats:
    """Relaxed orientation of a joint's child in its parent, (rows, 4)."""
    return from_rotation_vector(rows(own.rest))


def muscle_state(
    instances: int, muscles: int, crossings: int, capacity: int, zeros: Callable[..., wp.array], excited: bool = False,
    sharing_bodies: int = 0, apart_bodies: int = 0, parts: int = 0, groups: int = 0,
) -> structs.MuscleState:  # fmt: skip
    """Room for the state of the muscles of a batch; `capacity` is the longest delay in steps and one.

    Args:
        zeros: makes an array of a shape and dtype.
        excited: whether a controller excites muscles, and so wants to know what they feel.
        sharing_bodies: of the character, where torques are shared out among muscles; else 0.
        apart_bodies: the same where a kernel of its own finds paths.
        parts: that torques of joints are added up in. groups: of joints that move as one for paths.
    """
    shape = (instances, max(muscles, 1))
    s = structs.MuscleState()
    for name in ("activation", "neural", "damping", "fibre_length", "previous_fibre_length", "force"):
        setattr(s, name, zeros(*shape))
    s.excitation_ring = zeros(instances, max(capacity, 1), shape[1])
    s.moment_arm = zeros(instances, max(crossings, 1), dtype=wp.vec3)
    s.part_torque = zeros(instances if parts else 0, parts, dtype=wp.vec3)
    for name in ("group_turning", "group_moving"):
        setattr(s, name, zeros(instances if groups else 0, groups, dtype=wp.vec3))
    sharing = instances if sharing_bodies else 0
    s.sharing.muscle = zeros(sharing, shape[1], dtype=structs.SharedMuscle)
    s.sharing.share = zeros(sharing, shape[1])
    s.sharing.price = zeros(sharing, sharing_bodies, dtype=wp.vec3)
    apart = instances if apart_bodies else 0
    s.apart.rotation = zeros(apart, apart_bodies, dtype=wp.mat33)
    for name in (
        "position", "angular_velocity", "lag_angular", "joint_velocity", "coordinate_turning", "coordinate_moving"
    ):  # fmt: skip
        setattr(s.apart, name, zeros(apart, apart_bodies, dtype=wp.vec3))
    s.apart.stretch = zeros(apart, shape[1], dtype=wp.vec2)
    feeling = instances if excited else 0
    s.sensed = zeros(feeling, shape[1], dtype=wp.vec3)
    s.reflex = zeros(feeling, shape[1])
    s.stands = zeros(feeling, 2, dtype=int)
    s.landed = zeros(feeling, dtype=int)
    s.lean_at_lift = zeros(feeling, 2)
    return s


def model_parts(scene: Scene, names: Topology, found: ActuationMap, device: Any) -> dict[str, Any]:
    """The parts of the model that muscles need, by field of `kernels.structs.Model`."""
    paths = {name: scene.character.muscles[name] for name in found.muscles}
    table = path_table(paths, names, scene.character)
    grouped = grouped_paths(table, names, scene.character)
    return {
        "actuation": actuation_struct(scene, names, found.drives, device),
        "muscles": muscles_struct(scene, found.muscles, device),
        "paths": paths_struct(table, grouped, names, scene.character, device),
        "routes": route_struct(table, grouped, paths, names, scene.character, device),
        "reflexes": reflexes_struct(scene, names, found.muscles, device),
        "gait": gait_states_struct(scene, names, found.muscles, device),
    }
