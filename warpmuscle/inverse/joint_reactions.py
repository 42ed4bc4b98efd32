"""Joint reactions: the forces and moments that joints transmit while muscles make a motion.

As OpenSim's JointReaction: all that a joint puts on its child beyond what muscles and loads do, at the joint's frame on
the body that it acts on. Reserves act through the joints, so that their moments are part of it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import warp as wp

from warpmuscle.core.array_types import Floats
from warpmuscle.core.arrays import to_device
from warpmuscle.core.errors import ArgumentError
from warpmuscle.core.pose import conjugate, rotate
from warpmuscle.formats import SceneLike
from warpmuscle.formats.external_loads import TO_OPENSIM
from warpmuscle.inverse.activations import Activations
from warpmuscle.inverse.body_model import BodyModel, Dynamics
from warpmuscle.inverse.dynamics import Prepared, prepare
from warpmuscle.inverse.joint_frames import FrameOnBody, JointFrames, joint_frames
from warpmuscle.inverse.trial import Coordinates, Loads
from warpmuscle.kernels.inverse.muscle_wrenches import muscle_wrenches_of
from warpmuscle.model.routes import path_kind

SIDES, FRAMES = ("child", "parent"), ("child", "parent", "ground")


@dataclass(frozen=True)
class JointReactions:
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


def joint_reactions(
    model: SceneLike | BodyModel,
    coordinates: Coordinates | Sequence[Coordinates],
    loads: Loads | Sequence[Loads | None] | None = None,
    activations: Activations | Sequence[Activations] | None = None,
    *,
    on: str = "child",
    frame: str = "child",
    filter: float | None = None,
    times: Floats | Sequence[Floats] | None = None,
    device: str | None = None,
) -> JointReactions | list[JointReactions]:
    """Reactions of all joints, of one trial or of many at once.

    Args:
        model, coordinates, loads, filter, times, device: see `inverse_dynamics`.
        activations: of `static_optimization` of the same trials and times; without them no muscle pulls.
        on: "child" or "parent", which body a joint acts on. frame: whose axes are meant, or "ground".

    Raises:
        ArgumentError: see `inverse_dynamics`; or activations of other frames, or of muscles without lines of action.
        SceneError: the model cannot be read.
    """
    many = not isinstance(coordinates, Coordinates)
    body = model if isinstance(model, BodyModel) else BodyModel(model, device)
    trials = prepare(body, coordinates, loads, filter, times)
    given = [activations] if isinstance(activations, Activations) else activations
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
    if dynamics is None:
        dynamics = body.dynamics(trials.states, trials.loads)
    moment, force = dynamics.moment, dynamics.force
    if activations is not None:
        lengths = [len(one.times) for one in activations]
        if lengths != [len(one) for one in trials.times]:
            raise ArgumentError(
                f"numbers of frames: {lengths} of activations, {[len(one) for one in trials.times]} of the motions"
            )
        pulled = muscle_wrenches(body, trials, np.concatenate([one.force for one in activations]))
        moment, force = moment - pulled[0], force - pulled[1]
    return transmitted(body, trials.times, dynamics, moment, force, on, frame)


def check_ends(on: str, frame: str) -> None:
    """Raise ArgumentError where these are no ends of a joint."""
    if on not in SIDES or frame not in FRAMES:
        raise ArgumentError(
            f'on is "child" or "parent", and frame "child", "parent" or "ground", not {on!r}, {frame!r}'
        )


def transmitted(
    body: BodyModel, times: Sequence[Floats], dynamics: Dynamics, moment: Floats, force: Floats, on: str, frame: str
) -> list[JointReactions]:
    """Reactions of all joints by trial, whose frames follow one another.

    Args:
        dynamics: says where bodies are. moment, force: (n, B, 3) that each joint puts on its child, about its point.
    """
    joints = joints_of(body)
    names = body.topology.bodies
    found = [_reaction(body, one, dynamics, moment, force, on, frame) for one in joints]
    bodies = tuple((one.child if on == "child" else one.parent).body for one in joints)
    axes = tuple(
        "ground" if frame == "ground" else (one.child if frame == "child" else one.parent).body for one in joints
    )
    assert all(one.child.body in names for one in joints)
    ends = np.cumsum([len(own) for own in times])[:-1]
    stacked = [np.split(np.stack([array[k] for array in found], axis=1), ends) for k in range(3)]
    return [
        JointReactions(tuple(one.name for one in joints), bodies, axes, own, *arrays)
        for own, *arrays in zip(times, *stacked, strict=True)
    ]


def joints_of(body: BodyModel) -> list[JointFrames]:
    """The joints of a model: as its `.osim` has them, or else all of the scene's."""
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


def muscle_wrenches(body: BodyModel, trials: Prepared, tension: Floats) -> tuple[Floats, Floats]:
    """Moments (n, B, 3), N m, and forces (n, B, 3), N, of muscles upon what each joint carries, world axes.

    Args:
        tension: (n, M) N.
    """
    muscles = [body.muscle(name) for name in body.muscles]
    without = next((name for name in body.muscles if body.muscle(name).polynomial or body.muscle(name).pulleys), None)
    if without is not None:
        raise ArgumentError(f"muscle {without!r} has a path without lines of action, a polynomial or pulleys; "
                            "joint reactions take paths of points")  # fmt: skip
    kernel = muscle_wrenches_of(path_kind(muscles, body.scene.character, body.table.most_levers))
    bodies, found = len(body.topology.bodies), []
    for part in body.chunks(len(tension)):
        stages, n = body.stages(trials.states, part), part.stop - part.start
        line, moment, force = (
            wp.zeros((n, count), dtype=wp.vec3, device=body.device) for count in (2 * bodies, bodies, bodies)
        )
        pulled = to_device(tension[part], float, body.device)
        inputs = [stages.model, stages.state, stages.workspace, pulled]
        wp.launch(kernel, n, inputs, [line, moment, force], device=body.device)
        found.append((moment.numpy().astype(np.float64), force.numpy().astype(np.float64)))
    moments, forces = (np.concatenate(arrays) for arrays in zip(*found, strict=True))
    return moments, forces


def _reaction(
    body: BodyModel, joint: JointFrames, dynamics: Dynamics, moment: Floats, force: Floats, on: str, frame: str
) -> tuple[Floats, Floats, Floats]:
    """Force, moment and point (n, 3) of a joint."""
    names = body.topology.bodies
    number = names.index(joint.child.body)
    sign = 1.0 if on == "child" else -1.0
    acting = joint.child if on == "child" else joint.parent
    origin = _places(body, dynamics, acting)
    own_force = sign * force[:, number]
    arm = dynamics.position[:, number] - origin
    own_moment = sign * moment[:, number] + np.cross(arm, own_force)
    shown = {"child": joint.child, "parent": joint.parent}.get(frame)
    vectors = [own_force, own_moment, origin]
    if shown is None or shown.body not in names:  # the ground
        shown_force, shown_moment, place = (values @ TO_OPENSIM.T for values in vectors)
        return shown_force, shown_moment, place
    axes, back = shown.axes, conjugate(dynamics.orientation[:, names.index(shown.body)])
    center = _places(body, dynamics, FrameOnBody(shown.body, np.zeros(3), axes, np.zeros(3)))
    turned = [rotate(back, values) @ axes for values in (own_force, own_moment, origin - center)]
    return turned[0], turned[1], turned[2] + shown.center


def _places(body: BodyModel, dynamics: Dynamics, frame: FrameOnBody) -> Floats:
    """Where a frame's origin is, (n, 3) m, world."""
    if frame.body not in body.topology.bodies:
        return np.zeros((len(dynamics.position), 3)) + frame.origin
    number = body.topology.bodies.index(frame.body)
    offset = frame.origin
    if number > 0:
        name = body.topology.joints[number - 1]
        offset = offset - np.array(body.scene.character.joints[name].position_in_child, dtype=np.float64)
    return dynamics.position[:, number] + rotate(dynamics.orientation[:, number], np.broadcast_to(offset, (1, 3)))
