"""A recorded motion, its loads, moments and muscles as a `Recording`."""

from __future__ import annotations

import msgspec
import numpy as np

from warpmuscle.core.array_types import Floats, Integers
from warpmuscle.core.pose import conjugate, multiply, rotate
from warpmuscle.inverse.activations import Activations
from warpmuscle.inverse.body_model import BodyModel
from warpmuscle.inverse.dynamics import Prepared
from warpmuscle.inverse.recordings.belt import belt_velocity, on_belt
from warpmuscle.inverse.smoothing import spline
from warpmuscle.results.degrees_of_freedom import with_joint_angles
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Scene
from warpmuscle.scene.topology import coordinate_names, coordinate_units
from warpmuscle.studies.inverse_dynamics import BodyMotion, body_motions

FEET = ("talus", "calcn", "foot")  # in names of the bodies that ankles end at, in this order of preference
SIDES = (("_l", "l_", "left", "l"), ("_r", "r_", "right", "r"))  # ends or begins of names


def scene_with_feet(scene: Scene) -> Scene:
    """The scene, which says what its feet are if the names of its bodies do."""
    if scene.feet is not None:
        return scene
    for word in FEET:
        own = [name for name in scene.character.bodies if word in name.lower()]
        found = [[name for name in own if _on_side(name.lower(), word, side)] for side in SIDES]
        if all(len(names) == 1 for names in found):
            character = msgspec.structs.replace(scene.character, feet=(found[0][0], found[1][0]))
            return msgspec.structs.replace(scene, character=character)
    return scene


def _on_side(name: str, word: str, side: tuple[str, ...]) -> bool:
    rest = name.replace(word, "", 1)
    return rest in side or name.endswith(side[0]) or name.startswith(side[1])


def recorded_motions(
    body: BodyModel, trials: Prepared, effort: Floats, activations: list[Activations] | None = None
) -> list[Recording]:
    """Motions of all trials.

    Args:
        trials: as `dynamics.prepare` gives them. effort: (n, S) generalised forces of speeds, of all their frames.
    """
    scene = scene_with_feet(body.scene)
    found = []
    for k, times in enumerate(trials.times):
        part = slice(trials.starts[k], trials.starts[k + 1])
        own = None if activations is None else activations[k]
        found.append(_motion(body, scene, trials, part, times, effort[part], own))
    return found


def _motion(
    body: BodyModel, scene: Scene, trials: Prepared, part: slice, times: Floats, effort: Floats,
    activations: Activations | None,
) -> Recording:  # fmt: skip
    names, character = body.topology, scene.character
    q, v = trials.states.coordinates[part], trials.states.speeds[part]
    bodies = list(body_motions(scene, q, v).values())
    orientation = np.stack([one.orientation for one in bodies], axis=1)
    angular = np.stack([one.angular_velocity for one in bodies], axis=1)
    position = np.stack(_centres(body, bodies), axis=1)
    parents = list(names.parents[1:])
    unturned = conjugate(orientation[:, parents])
    mass = np.array([float(character.bodies[name].mass) for name in names.bodies])  # type: ignore[arg-type]
    com = np.einsum("b,nbk->nk", mass / mass.sum(), position)
    torque = -_torques(body, bodies, effort)
    arrays = {
        "time": np.asarray(times), "root_position": bodies[0].position, "root_orientation": orientation[:, 0],
        "root_velocity": _rate(times, bodies[0].position), "root_angular_velocity": angular[:, 0],
        "joint_orientation": multiply(unturned, orientation[:, 1:]),
        "joint_angular_velocity": rotate(unturned, angular[:, 1:] - angular[:, parents]),
        "joint_torque": torque, "joint_torque_desired": torque, "com": com, "com_velocity": _rate(times, com),
        "body_position": position, "body_orientation": orientation, "coordinate": q, "speed": v,
        "joint_angle": np.zeros((len(times), 0)),
        "joint_target": np.broadcast_to([0.0, 0.0, 0.0, 1.0], (len(times), len(parents), 4)).copy(),  # there are none
    }  # fmt: skip
    on_feet = [_loads_on(trials, scene, body, side) for side in (0, 1)]
    for word, own in zip(("left", "right"), on_feet, strict=True):
        arrays[f"foot_force_{word}"] = trials.loads.force[part][:, own].sum(axis=1)
    muscles: tuple[str, ...] = ()  # without activation dynamics, so that excitations are activations
    if activations is not None:
        muscles = activations.muscles
        arrays |= {
            "muscle_activation": activations.activation, "muscle_excitation": activations.activation,
            "muscle_force": activations.force, "muscle_desired_force": activations.force,
            "muscle_fibre_length": activations.fibre_length, "muscle_fibre_velocity": activations.fibre_velocity,
        }  # fmt: skip
    motion = Recording.of(
        arrays, names.joints, names.bodies, muscles, *coordinate_names(names, character), kept=list(arrays),
        **dict(zip(("coordinate_units", "speed_units"), coordinate_units(names, character), strict=True)),
    )  # fmt: skip
    feet = [number for own in on_feet for number in own]
    on, acting = [trials.loads.body[number] for number in feet], (trials.loads.force, trials.loads.point)
    belt = belt_velocity(times, position[:, on], angular[:, on], *(one[part][:, feet] for one in acting))
    return with_joint_angles(on_belt(motion, belt), scene)


def _centres(body: BodyModel, bodies: list[BodyMotion]) -> list[Floats]:
    """Centres of mass (n, 3) of all bodies, m."""
    found = [bodies[0].position]
    for number, one in enumerate(bodies[1:], start=1):
        joint = body.scene.character.joints[body.topology.joints[number - 1]]
        away = np.array([[float(x) for x in joint.position_in_child]])  # type: ignore[arg-type]
        found.append(one.position - rotate(one.orientation, away))
    return found


def _torques(body: BodyModel, bodies: list[BodyMotion], effort: Floats) -> Floats:
    """Torques (n, J, 3), N m, on the children of joints, world axes: what their free turns need."""
    found = np.zeros((len(effort), len(bodies) - 1, 3))
    for number, one in enumerate(bodies[1:], start=1):
        own = effort[:, body.topology.speeds_of(number)]
        if own.shape[1]:
            turning = np.stack(one.turning, axis=1)  # (n, S, 3)
            found[:, number - 1] = np.einsum("nks,ns->nk", np.linalg.pinv(turning, rcond=1e-6), own)
    return found


def _loads_on(trials: Prepared, scene: Scene, body: BodyModel, side: int) -> list[int]:
    """Which loads act on a foot and what hangs on it."""
    if scene.feet is None:
        return []
    foot = body.topology.bodies.index(scene.feet[side])
    return [k for k, number in enumerate(trials.loads.body) if _belongs(body.topology.parents, number, foot)]


def _belongs(parents: list[int] | tuple[int, ...] | Integers, number: int, foot: int) -> bool:
    """Whether a body is a foot, hangs on it, or carries it right before."""
    if number == parents[foot]:
        return True
    while number > foot:
        number = int(parents[number])
    return number == foot


def _rate(times: Floats, values: Floats) -> Floats:
    return spline(times, values, times, orders=2)[1]
