"""Joint reactions: the forces and moments that joints transmit while muscles make a motion.

As OpenSim's JointReaction: all that a joint puts on its child beyond what muscles and loads do, at the joint's frame on
the body that it acts on. Reserves act through the joints, so that their moments are part of it.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, overload
from weakref import WeakKeyDictionary

import numpy as np
import warp as wp

from warpmuscle.core.arguments import answering
from warpmuscle.core.array_types import Floats
from warpmuscle.core.arrays import structs_to_device, to_device
from warpmuscle.core.errors import ArgumentError
from warpmuscle.core.html_table import Tabulated
from warpmuscle.core.plain_text import number_of
from warpmuscle.formats import SceneLike
from warpmuscle.formats.external_loads import TO_OPENSIM
from warpmuscle.inverse.activations import Activations
from warpmuscle.inverse.body_model import BodyModel, Dynamics
from warpmuscle.inverse.coordinates import States
from warpmuscle.inverse.dynamics import INSTEAD, CoordinatesLike, LoadsLike, Prepared, Several, are_several, prepare
from warpmuscle.inverse.reactions.joint_frames import FrameOnBody, JointFrames, joint_frames
from warpmuscle.inverse.trial import Loads, each_of
from warpmuscle.kernels.inverse import joint_reactions as kernels
from warpmuscle.kernels.inverse.muscle_wrenches import muscle_wrenches_of
from warpmuscle.simulation.kernel_cache import said

_JOINTS: WeakKeyDictionary[BodyModel, list[JointFrames]] = WeakKeyDictionary()  # of models that are in use
SIDES, FRAMES = ("child", "parent"), ("child", "parent", "ground")


@dataclass(frozen=True, repr=False)
class JointReactions(Tabulated):
    """What J joints put on a body each in F frames."""

    joints: tuple[str, ...]  # (J,)
    bodies: tuple[str, ...]  # (J,) that they act on
    frames: tuple[str, ...]  # (J,) bodies whose axes forces and moments have, or `ground`
    times: Floats  # (F,) s
    force: Floats  # (F, J, 3) N
    moment: Floats  # (F, J, 3) N m, about the point
    point: Floats  # (F, J, 3) m, the joint's frame on the body, in those axes from the origin of their frame

    def columns(self) -> dict[str, Floats]:
        """All numbers (F,) by the names that OpenSim's files have, such as `hip_r_on_femur_r_in_femur_r_fx`."""
        found = {}
        for k, (joint, body, frame) in enumerate(zip(self.joints, self.bodies, self.frames, strict=True)):
            for letter, values in (("f", self.force), ("m", self.moment), ("p", self.point)):
                for axis, one in zip("xyz", values[:, k].T, strict=True):
                    found[f"{joint}_on_{body}_in_{frame}_{letter}{axis}"] = one
        return found


@overload
def joint_reactions(
    model: SceneLike | BodyModel, coordinates: CoordinatesLike, loads: LoadsLike = None,
    activations: Activations | Sequence[Activations] | None = None, *, on: str = "child", frame: str = "child",
    filter: float | None = None, times: Floats | Sequence[Floats] | None = None, exact_rates: bool = False,
    device: str | None = None,
) -> JointReactions: ...  # fmt: skip
@overload
def joint_reactions(
    model: SceneLike | BodyModel, coordinates: Several, loads: LoadsLike = None,
    activations: Activations | Sequence[Activations] | None = None, *, on: str = "child", frame: str = "child",
    filter: float | None = None, times: Floats | Sequence[Floats] | None = None, exact_rates: bool = False,
    device: str | None = None,
) -> list[JointReactions]: ...  # fmt: skip
@answering(INSTEAD)
@said("finding joint reactions")
def joint_reactions(
    model: SceneLike | BodyModel,
    coordinates: CoordinatesLike | Sequence[CoordinatesLike],
    loads: Loads | Sequence[Loads | None] | None = None,
    activations: Activations | Sequence[Activations] | None = None,
    *,
    on: str = "child",
    frame: str = "child",
    filter: float | None = None,
    times: Floats | Sequence[Floats] | None = None,
    exact_rates: bool = False,
    device: str | None = None,
) -> JointReactions | list[JointReactions]:
    """Reactions of all joints, of one trial or of many at once.

    Args:
        model, coordinates, loads, filter, times, exact_rates, device: see `inverse_dynamics`.
        activations: of `static_optimization` of the same trials and times; without them no muscle pulls.
        on: "child" or "parent", which body a joint acts on. frame: whose axes are meant, or "ground".

    Raises:
        ArgumentError: see `inverse_dynamics`; or activations of other frames, or of muscles without lines of action.
        SceneError: the model cannot be read.
    """
    many = are_several(coordinates)
    body = model if isinstance(model, BodyModel) else BodyModel(model, device)
    trials = prepare(body, coordinates, loads, filter, times, exact_rates, of_speeds=True).of_speeds
    given = None
    if activations is not None:
        given = each_of(Activations, activations, "activations", " that wm.static_optimization finds")
    found = reactions_of(body, trials, given, on, frame)
    return found if many else found[0]


def reactions_of(
    body: BodyModel,
    trials: Prepared,
    activations: Sequence[Activations] | None,
    on: str = "child",
    frame: str = "child",
    dynamics: Dynamics | None = None,
) -> list[JointReactions]:
    """Reactions of all joints in prepared trials; see `joint_reactions`.

    Args:
        dynamics: of the trials, if it is known already.
    """
    check_ends(on, frame)
    tension = None
    if activations is not None:
        other = next((one for one in activations if one.muscles != tuple(body.muscles)), None)
        if other is not None:
            raise ArgumentError(
                f"activations are of {number_of(len(other.muscles), 'muscle')}, and not those of the model in its order"
            )
        if not all(np.isfinite(one.force).all() for one in activations):
            raise ArgumentError("activations have forces that are not finite numbers")
        lengths = [len(one.times) for one in activations]
        if lengths != [len(one) for one in trials.times]:
            raise ArgumentError(
                f"numbers of frames: {lengths} of activations, {[len(one) for one in trials.times]} of the motions"
            )
        tension = np.concatenate([one.force for one in activations])
    return transmitted(body, trials, tension, dynamics, on, frame)


def check_ends(on: str, frame: str) -> None:
    """Raise ArgumentError where these are no ends of a joint."""
    if on not in SIDES or frame not in FRAMES:
        raise ArgumentError(
            f'on is "child" or "parent", and frame "child", "parent" or "ground", not {on!r}, {frame!r}'
        )


def transmitted(
    body: BodyModel, trials: Prepared, tension: Floats | None, dynamics: Dynamics | None, on: str, frame: str
) -> list[JointReactions]:
    """Reactions of all joints by trial, whose frames follow one another.

    Args:
        tension: (n, M) N, of all frames; None: no muscle pulls. dynamics: of the trials, if it is known already.
    """
    if dynamics is None and body.model_forces:
        dynamics = body.dynamics(trials.states, trials.loads)
    joints = joints_of(body)
    table = structs_to_device(kernels.ReactionJoint, _columns(body, joints, on, frame), body.device)
    parts = [
        _reactions(body, trials, table, tension, dynamics, part) for part in body.chunks(len(trials.states.coordinates))
    ]
    stacked = [np.concatenate(arrays) for arrays in zip(*parts, strict=True)]
    bodies = tuple((one.child if on == "child" else one.parent).body for one in joints)
    axes = tuple(
        "ground" if frame == "ground" else (one.child if frame == "child" else one.parent).body for one in joints
    )
    return [
        JointReactions(tuple(one.name for one in joints), bodies, axes, times, *own)
        for times, *own in zip(trials.times, *map(trials.split, stacked), strict=True)
    ]


def joints_of(body: BodyModel) -> list[JointFrames]:
    """The joints of a model: as its `.osim` has them, or else all of the scene's; its file is read once."""
    if body not in _JOINTS:
        _JOINTS[body] = _joints_of(body)
    return _JOINTS[body]


def _joints_of(body: BodyModel) -> list[JointFrames]:
    if body.file is not None:
        every = joint_frames(body.file)
        return [one for one in every if one.child.body in body.topology.bodies]
    found = []
    for name in body.topology.joints:
        joint = body.scene.character.joints[name]
        ends = (joint.parent, joint.position_in_parent), (joint.child, joint.position_in_child)
        found.append(
            JointFrames(
                name, *(FrameOnBody(one, np.array(place, np.float64), TO_OPENSIM.T, np.zeros(3)) for one, place in ends)
            )
        )
    return found


def muscle_wrenches(body: BodyModel, states: States, part: slice, tension: Floats) -> tuple[wp.array, wp.array]:
    """Moments (n, B), N m, and forces (n, B), N, of muscles upon what each joint carries, world axes, on the device.

    Args:
        part: which frames. tension: (n, M) N, of these.
    """
    muscles = [body.muscle(name) for name in body.muscles]
    without = next((name for name in body.muscles if body.muscle(name).polynomial or body.muscle(name).pulleys), None)
    if without is not None:
        raise ArgumentError(f"muscle {without!r} has a path without lines of action, a polynomial or pulleys; "
                            "joint reactions take paths of points")  # fmt: skip
    kernel = muscle_wrenches_of(body.grouped.kind_of(muscles, body.scene.character))
    bodies, n = len(body.topology.bodies), part.stop - part.start
    stages = body.stages(states, part)
    line, moment, force = (
        wp.zeros((n, count), dtype=wp.vec3, device=body.device) for count in (2 * bodies, bodies, bodies)
    )
    inputs = [stages.model, stages.state, stages.workspace, to_device(tension, float, body.device)]
    wp.launch(kernel, n, inputs, [line, moment, force], device=body.device)
    return moment, force


def _reactions(
    body: BodyModel, trials: Prepared, joints: wp.array, tension: Floats | None, dynamics: Dynamics | None, part: slice
) -> list[Floats]:
    """Forces, moments and points (n, J, 3) of some frames."""
    device, n = body.device, part.stop - part.start
    wrenches = kernels.JointWrenches()
    if dynamics is None:
        found = body.dynamics_on_device(trials.states, trials.loads, part)
        for name in ("moment", "force", "position", "orientation"):
            setattr(wrenches, name, getattr(found, name))
    else:
        for name in ("moment", "force", "position"):
            setattr(wrenches, name, to_device(getattr(dynamics, name)[part], wp.vec3, device))
        wrenches.orientation = to_device(dynamics.orientation[part], wp.quat, device)
    if tension is not None:
        pulled = muscle_wrenches(body, trials.states, part, tension[part])
        wrenches.pulled_moment, wrenches.pulled_force = pulled
    outputs = [wp.empty((n, len(joints)), dtype=wp.vec3, device=device) for _ in range(3)]
    wp.launch(kernels.joint_reactions, (n, len(joints)), [joints, wrenches], outputs, device=device)
    return [array.numpy().astype(np.float64) for array in outputs]


def _columns(body: BodyModel, joints: list[JointFrames], on: str, frame: str) -> dict[str, Any]:
    """Joints as the device has them, by column; see `kernels.inverse.joint_reactions.ReactionJoint`."""
    names = body.topology.bodies
    found: defaultdict[str, list[Any]] = defaultdict(list)
    for joint in joints:
        acting = joint.child if on == "child" else joint.parent
        shown = joint.parent if frame == "parent" else joint.child
        ground = frame == "ground" or shown.body not in names
        found["body"].append(names.index(joint.child.body))
        found["sign"].append(1.0 if on == "child" else -1.0)
        found["acting"].append(names.index(acting.body) if acting.body in names else -1)
        found["place"].append(acting.origin - _from_joint(body, acting.body))
        found["shown"].append(-1 if ground else names.index(shown.body))
        found["origin"].append(np.zeros(3) if ground else -_from_joint(body, shown.body))
        found["turn"].append(TO_OPENSIM if ground else shown.axes.T)
        found["center"].append(np.zeros(3) if ground else shown.center)
    return {name: np.array(values) for name, values in found.items()}


def _from_joint(body: BodyModel, name: str) -> Floats:
    """Where a body's joint is from its centre of mass, (3,) m; nowhere else of the root and the ground."""
    if name not in body.topology.bodies[1:]:
        return np.zeros(3)
    joint = body.topology.joints[body.topology.bodies.index(name) - 1]
    return np.array(body.scene.character.joints[joint].position_in_child, dtype=np.float64)
