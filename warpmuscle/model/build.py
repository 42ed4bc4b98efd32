"""A scene as the device structures of a batch: the model, and the states that instances start from."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import reduce
from operator import attrgetter
from typing import Any

import numpy as np
import warp as wp

from warpmuscle.core.array_types import Floats
from warpmuscle.core.arrays import repeat_rows, rows, structs_to_device, to_device
from warpmuscle.core.pose import multiply, normalized, rotate, turned_to_heading
from warpmuscle.kernels import structs
from warpmuscle.model.bodies import contacts_struct, ground_normal, skeleton_struct
from warpmuscle.model.collisions import collisions_struct, steps_between_tests
from warpmuscle.model.controllers.table import controller_fields, controller_start
from warpmuscle.model.couplings import constraints_struct, couplings_struct
from warpmuscle.model.muscles import model_parts, muscles_struct
from warpmuscle.model.objective import RecordedNorms, objective_fields
from warpmuscle.model.parts import part_values
from warpmuscle.model.prescribed_motion import Curves, motion_struct, scene_curves
from warpmuscle.model.structure import Structure
from warpmuscle.scene import Failure, InitialState, JointState, Scene
from warpmuscle.scene.accounting import negative_share
from warpmuscle.scene.joints import RootType, joint_type, root_type
from warpmuscle.scene.topology import Topology

Fields = dict[str, Any]  # by their place in `kernels.structs.Model`, such as `contacts.normal`


@dataclass(frozen=True)
class Start:
    """What instances start from: coordinates (rows, C) and speeds (rows, S), rows 1 or the number of instances."""

    coordinates: Floats
    speeds: Floats
    controller: Mapping[str, int]  # its state, by place in `kernels.structs.State`, where that is not 0
    activation: Floats  # (rows, 1) of the muscles


@dataclass(frozen=True)
class ReferenceGait:
    """A gait that the objective compares with, by bins of the phase."""

    orientation: Floats  # (2 bins, bodies, 4) of each body's joint, child in parent; left stance first
    tracked: Floats  # (bodies,) 1: the body's joint is compared
    by_contact: bool  # whether its cycles run from contact to contact of the left foot
    period: float = 0.0  # s, of these cycles; 0: not known
    begin: float = 0.0  # 0..1, the part of them that is nearest to the initial pose


@dataclass(frozen=True)
class ModelInputs:
    """What a model has besides what its scene says."""

    excitations: Mapping[str, wp.array] = field(default_factory=dict)  # by field of `kernels.structs.Muscles`
    motion: Curves | None = None  # of the kinematic coordinates; None: as the scene says
    slope: Floats | None = None  # (instances,) rad, by which the ground rises forwards
    reference: ReferenceGait | None = None
    norms: RecordedNorms | None = None


NO_INPUTS = ModelInputs()


def build_model(scene: Scene, structure: Structure, device: Any, inputs: ModelInputs = NO_INPUTS) -> structs.Model:
    """The model of a scene on a device; no other code writes its fields than this, `update_model`,
    `replaced` and `with_fields`.

    Args:
        scene: checked scene whose numbers are floats, or (n,) arrays with one value an instance (see
            `parameters.substitute`).
        structure: of the scene before its free parameters became numbers.
        inputs: what the model has besides.

    Raises:
        SceneError: more shapes or feet than there is room for, or a reflex that senses a muscle not simulated.
    """
    model = structs.Model()
    update_model(model, PARTS, scene, structure, device, inputs)
    return model


def update_model(
    model: structs.Model,
    parts: Iterable[str],
    scene: Scene,
    structure: Structure,
    device: Any,
    inputs: ModelInputs = NO_INPUTS,
    each: tuple[int, int] = (1, 1),
) -> None:
    """Make some of the `PARTS` of a model again, or `muscle laws`, whose numbers or inputs have changed.

    Args:
        each: rows of the scene's numbers, and how many instances, one behind the other, each of them is for.
    """
    count, times = each
    for part in parts:
        fields = _UPDATED[part](scene, structure, device, inputs)
        if count > 1 and times > 1:
            fields = {place: repeat_rows(value, count, times) for place, value in fields.items()}
        _put(model, fields)


@contextmanager
def replaced(model: structs.Model, fields: Fields) -> Iterator[None]:
    """For a while, let a model have other values in some of its fields."""
    before = {place: _copied(attrgetter(place)(model)) for place in fields}
    _put(model, fields)
    try:
        yield
    finally:
        _put(model, before)


def with_fields(model: structs.Model, fields: Fields) -> structs.Model:
    """A copy of a model, of the same arrays, with other values in some of its fields."""
    copy = _copied(model)
    _put(copy, fields)
    return copy


def muscles_model(scene: Scene, muscles: tuple[str, ...], device: Any) -> structs.Model:
    """A model of muscles of a scene without free parameters, and nothing else: to evaluate recorded quantities."""
    model = structs.Model()
    _put(model, {"muscles": muscles_struct(scene, muscles, device), "negative_share": negative_share(scene.objective)})
    return model


def _copied(value: Any) -> Any:
    """A structure whose fields stay what they are now, since Warp assigns structures field by field; or the value."""
    if not hasattr(value, "_cls"):
        return value
    copy = value._cls()
    copy.assign(value)
    return copy


def _put(model: structs.Model, fields: Fields) -> None:
    for place, value in fields.items():
        *outer, field = place.split(".")
        setattr(reduce(getattr, outer, model), field, value)


def _settings(scene: Scene, structure: Structure, device: Any, inputs: ModelInputs) -> Fields:
    failure = scene.failure
    return {
        "implicit_pd": int(scene.implicit_pd),
        "time_step": scene.time_step,
        "gravity": to_device(rows([scene.gravity]), float, device),
        "failure": failure_limits(failure, device),
        "fastest": failure.max_com_speed,
        "fail_on_body_contact": int(failure.body_contact),
    }


def _bodies(scene: Scene, structure: Structure, device: Any, inputs: ModelInputs) -> Fields:
    names = structure.names
    contacts, points = contacts_struct(scene, names, device)
    skeleton = skeleton_struct(scene, names, points, device)
    held = {"constraints": constraints_struct(scene, names, device)} if scene.character.constraints else {}
    return held | {
        "body_count": len(names.bodies),
        "level_count": len(names.level_start) - 1,
        "level_start": to_device(names.level_start, int, device),
        "contacts": contacts,
        "skeleton": skeleton,
        "foot_slots": skeleton.foot_side.shape[0] if scene.feet is not None else 0,
        "feet.left": names.bodies.index(scene.feet[0]) if scene.feet is not None else 0,
        "feet.right": names.bodies.index(scene.feet[1]) if scene.feet is not None else 0,
        "couplings": couplings_struct(scene, names, device),
    }


def _slope(scene: Scene, structure: Structure, device: Any, inputs: ModelInputs) -> Fields:
    return {"contacts.normal": to_device(ground_normal(scene.ground, inputs.slope), wp.vec3, device)}


def _controller(scene: Scene, structure: Structure, device: Any, inputs: ModelInputs) -> Fields:
    heading = to_device(rows([scene.heading]), float, device)
    found = {"heading": heading, "turns_from_start": int(scene.turns_from_start)}
    return found | controller_fields(scene, structure.names, device)


def _objective(scene: Scene, structure: Structure, device: Any, inputs: ModelInputs) -> Fields:
    return objective_fields(scene, structure.names, device, inputs.norms)


def _muscles(scene: Scene, structure: Structure, device: Any, inputs: ModelInputs) -> Fields:
    return model_parts(scene, structure.names, structure.actuation, device)


def _muscle_laws(scene: Scene, structure: Structure, device: Any, inputs: ModelInputs) -> Fields:
    return {"muscles": muscles_struct(scene, structure.actuation.muscles, device)}


def _excitations(scene: Scene, structure: Structure, device: Any, inputs: ModelInputs) -> Fields:
    return {f"muscles.{field}": array for field, array in inputs.excitations.items()}


def _collisions(scene: Scene, structure: Structure, device: Any, inputs: ModelInputs) -> Fields:
    if not structure.collision_pairs:
        return {}
    depth = rows([scene.failure.self_collision])[:, 0]
    return {"collisions": collisions_struct(scene, structure.names, structure.collision_pairs, depth, device)}


def _touching(scene: Scene, structure: Structure, device: Any, inputs: ModelInputs) -> Fields:
    return {"touch_interval": steps_between_tests(scene.time_step)}


def _motion(scene: Scene, structure: Structure, device: Any, inputs: ModelInputs) -> Fields:
    if not structure.kinematic.names:
        return {}
    return {"motion": motion_struct(structure.kinematic, motion_of(scene, structure, inputs), device)}


def _reference(scene: Scene, structure: Structure, device: Any, inputs: ModelInputs) -> Fields:
    reference = inputs.reference
    if reference is None:
        return {}
    return {
        "reference_bins": len(reference.orientation) // 2,
        "reference_by_contact": int(reference.by_contact),
        "reference_period": reference.period,
        "reference_begin": reference.begin,
        "reference": to_device(reference.orientation, wp.quat, device),
        "tracked": to_device(reference.tracked, float, device),
    }


def _custom_parts(scene: Scene, structure: Structure, device: Any, inputs: ModelInputs) -> Fields:
    return {"part_values": to_device(part_values(scene, structure.parts), float, device)}


def failure_limits(failure: Failure, device: Any) -> wp.array:
    """Limits of failure, whose numbers are floats or (n,) arrays, as `kernels.structs.Model.failure`."""
    limits = {field: rows([getattr(failure, field)]) for field in structs.FailureLimits.vars}
    return structs_to_device(structs.FailureLimits, limits, device)


Part = Callable[[Scene, Structure, Any, ModelInputs], Fields]
PARTS: dict[str, Part] = {  # a later one may replace fields of one before
    "settings": _settings, "bodies": _bodies, "slope": _slope, "controller": _controller, "objective": _objective,
    "muscles": _muscles, "excitations": _excitations, "collisions": _collisions, "touching": _touching,
    "motion": _motion, "reference": _reference, "own parts": _custom_parts,
}  # fmt: skip
_UPDATED = PARTS | {"muscle laws": _muscle_laws}  # and a part of one of them, which can be made again alone
_LAWS = {"f_max", "l_opt", "l_slack", "pennation"}  # of a muscle, which `muscles_struct` alone reads


def parts_of(paths: Iterable[str]) -> tuple[str, ...] | None:
    """Parts of the model, see `update_model`, in which numbers of a scene appear; None if they may be in any.

    Args:
        paths: of the numbers, such as `controller.states.0.time`.
    """
    found: dict[str, None] = {}
    for path in paths:
        table, *names = path.split(".")
        if table == "controller" and names[0] == "reflexes":  # their numbers are those of muscles
            found |= {"controller": None, "muscles": None, "excitations": None}
        elif table == "controller":
            found["controller"] = None
        elif table == "character" and names[0] == "muscles" and len(names) == 3 and names[2] in _LAWS:
            found |= {"muscle laws": None, "excitations": None}
        else:
            return None
    return tuple(found)


def motion_of(scene: Scene, structure: Structure, inputs: ModelInputs = NO_INPUTS) -> Curves:
    """The curves that the kinematic coordinates follow: those of the inputs, or those that the scene says."""
    if inputs.motion is not None:
        return inputs.motion
    held = start_of(scene, structure.names).coordinates
    return scene_curves(scene, structure.names, structure.kinematic, held)


def start_of(scene: Scene, names: Topology) -> Start:
    """Coordinates and speeds of a scene's initial state; quaternions are normalised here."""
    state = scene.initial_state
    coordinates, speeds = _root_start(state, root_type(scene.character))
    parts_q, parts_v = [coordinates], [speeds]
    for name in names.joints:
        joint = scene.character.joints[name]
        q, v = joint_type(joint).start(joint, state.joints.get(name, JointState()))
        parts_q.append(q)
        parts_v.append(v)
    return Start(
        coordinates=_beside(parts_q),
        speeds=_beside(parts_v),
        controller=controller_start(scene),
        activation=rows(_activations(scene)),
    )


def _activations(scene: Scene) -> list[Any]:
    """Of all muscles at the start, or of each of the scene, where some are named."""
    common, named = scene.muscle_model.initial_activation, scene.initial_state.activations
    return [named.get(name, common) for name in scene.character.muscles] if named else [common]


def _root_start(state: InitialState, root: RootType) -> tuple[Floats, Floats]:
    q = normalized(rows(state.root_orientation))
    position, velocity, angular = (
        rows(v) for v in (state.root_position, state.root_velocity, state.root_angular_velocity)
    )
    if state.heading is not None:
        turn = turned_to_heading(q, rows(state.heading))
        q, velocity, angular = multiply(turn, q), rotate(turn, velocity), rotate(turn, angular)
    return root.coordinates_of(position, q, velocity, angular)


def _beside(parts: list[Floats]) -> Floats:
    """(rows, k) arrays side by side, single rows repeated as often as needed."""
    count = max(len(part) for part in parts)
    return np.concatenate([np.broadcast_to(part, (count, part.shape[1])) for part in parts], axis=1)
