"""Muscle paths of a biped, and what kernels say of their lengths, speeds and moment arms."""

from dataclasses import dataclass

import numpy as np
import warp as wp
from probes import turn_about

from biped import biped
from random_states import random_states
from warpmuscle.kernels import stages
from warpmuscle.kernels.memory.scratch import capacity_of, work_floats
from warpmuscle.model.joint_groups import grouped_paths
from warpmuscle.model.path_table import MusclePath, PathTable, path_table
from warpmuscle.model.paths import paths_struct
from warpmuscle.scene import Character, Condition, Scene, ViaPoint
from warpmuscle.simulation.stages import Stages

ZERO = (0.0, 0.0, 0.0)
KNEE_BENT = Condition("lKnee", -0.5, 0.4, blend=0.3)
FOOT_TURNED = Condition("lAnkle", -0.4, 0.3, blend=0.4, axis=1)
FOOT_RAISED = Condition("lAnkle", -0.2, 0.9, blend=0.4)


def points(*places: tuple[str, tuple[float, float, float]]) -> list[ViaPoint]:
    return [ViaPoint(body, position) for body, position in places]


PATHS: dict[str, MusclePath] = {
    "knee": points(("lUpperleg", (0.0, -0.1, 0.05)), ("lLowerleg", (0.0, 0.1, 0.06))),
    "knee, upwards": points(("lLowerleg", (0.0, 0.1, 0.06)), ("lUpperleg", (0.0, -0.1, 0.05))),
    "hip to toes": points(
        ("pelvis", (0.1, 0.05, -0.08)),
        ("lUpperleg", (0.03, 0.1, -0.06)),
        ("lUpperleg", (0.03, -0.15, -0.06)),
        ("lLowerleg", (0.0, -0.1, -0.07)),
        ("lFoot", (0.04, 0.0, -0.06)),
        ("lToes", (0.01, -0.01, 0.02)),
    ),
    "over three joints at once": points(("torso", (0.05, 0.1, 0.1)), ("lLowerleg", (0.03, 0.0, 0.05))),
    "shin to shin": points(
        ("lLowerleg", (0.0, 0.1, 0.05)), ("lUpperleg", (0.02, 0.0, 0.06)), ("rLowerleg", (0.02, 0.1, 0.05))
    ),
    "arm to leg": points(("lUpperarm", (0.05, 0.02, 0.05)), ("rUpperleg", (0.02, 0.1, 0.05))),
    "within a body": points(("pelvis", (0.1, 0.0, 0.0)), ("pelvis", (-0.1, 0.0, 0.0))),
    "conditional": [
        ViaPoint("pelvis", (0.1, 0.05, 0.08)),
        ViaPoint("lUpperleg", (0.03, -0.1, 0.1), KNEE_BENT),
        ViaPoint("lUpperleg", (0.03, -0.2, 0.08), KNEE_BENT),
        ViaPoint("lLowerleg", (0.0, 0.05, 0.09), FOOT_TURNED),
        ViaPoint("lLowerleg", (0.0, -0.2, 0.08), FOOT_RAISED),
        ViaPoint("lFoot", (0.0, 0.0, 0.03)),
    ],
    "on a condition of a joint that it does not cross": [
        ViaPoint("pelvis", (0.1, 0.05, 0.08)),
        ViaPoint("pelvis", (0.1, -0.05, 0.12), FOOT_TURNED),
        ViaPoint("lUpperleg", (0.0, 0.05, 0.09)),
    ],
}


def character() -> Character:
    """The biped with ball, universal, hinge and fixed joints; the axes of an ankle are not at right angles."""
    c = biped()
    c.joints["lAnkle"].axes = [(1.0, 0.0, 0.0), (0.3, 0.2, 1.0)]
    c.joints["lElbow"].type, c.joints["lElbow"].axes = "fixed", []
    return c


@dataclass
class Geometry:
    """What the kernel says of n instances and M muscles with C crossings."""

    table: PathTable
    length: np.ndarray  # (n, M)
    speed: np.ndarray  # (n, M)
    arm: np.ndarray  # (n, C, 3)


def geometry_of(stages_: Stages, paths: dict[str, MusclePath], c: Character | None = None) -> Geometry:
    """Of paths whose numbers may be arrays with one value an instance.

    Args:
        c: the character with such arrays in place of its free parameters, if it has any.
    """
    names, c, n = stages_.names, c or stages_.scene.character, stages_.instances
    table, (model, state) = path_table(paths, names, c), stages_.structs
    model.paths, model.muscles.count = (
        paths_struct(table, grouped_paths(table, names, c), names, c, stages_.device),
        len(paths),
    )
    shape = (n, max(len(paths), 1))
    outputs = [
        wp.zeros(shape, dtype=float, device=stages_.device),
        wp.zeros(shape, dtype=float, device=stages_.device),
        wp.zeros((n, max(len(table.crossings), 1)), dtype=wp.vec3, device=stages_.device),
    ]
    workspace = wp.zeros((n, work_floats(capacity_of(len(names.bodies)))), dtype=float, device=stages_.device)
    wp.launch(stages.muscle_paths_of(), n, [model, state, workspace], outputs, device=stages_.device)
    length, speed, arm = (array.numpy().astype(float) for array in outputs)
    return Geometry(table, length[:, : len(paths)], speed[:, : len(paths)], arm[:, : len(table.crossings)])


def somewhere(c: Character, count: int, seed: int = 0, speed: float = 3.0) -> Stages:
    """Random states of a character near the origin."""
    stages_, s = Stages(Scene("path", c), count, "cpu"), random_states(c, count, seed, speed)
    stages_.set_state(*(getattr(s, name) for name in type(s).__dataclass_fields__))
    return stages_


def gradient(stages_: Stages, geometry: Geometry) -> np.ndarray:
    """Derivatives of the lengths by the speeds' integrals (n, M, S), from the moment arms: arm . angular velocity.

    The angular velocity of each joint for a unit of each speed comes from the forward kinematics.
    """
    names, n = stages_.names, stages_.instances
    start, given = names.speed_start, stages_.structs[1].speeds.numpy().copy()
    result = np.zeros((n, len(geometry.table.muscles), names.speeds))
    for k in range(start[1], names.speeds):
        unit = np.zeros_like(given)
        unit[:, k] = 1.0
        stages_.structs[1].speeds.assign(unit)
        angular = stages_.forward_kinematics()["angular_velocity"].astype(float)
        body = int(np.searchsorted(start, k, side="right")) - 1
        relative = angular[:, body] - angular[:, names.parents[body]]
        for i, crossing in enumerate(geometry.table.crossings):
            if crossing.joint == body:
                result[:, crossing.muscle, k] = np.sum(geometry.arm[:, i] * relative, axis=1)
    stages_.structs[1].speeds.assign(given)
    return result


def differences(stages_: Stages, paths: dict[str, MusclePath], step: float = 4e-3) -> np.ndarray:
    """The same by central differences of the lengths; a ball joint turns about the axes of its child."""
    names, coordinates = stages_.names, stages_.structs[1].coordinates
    given = coordinates.numpy().copy()
    result = np.zeros((stages_.instances, len(paths), names.speeds))
    for body in range(1, len(names.bodies)):
        first = names.coordinate_start[body]
        for k in range(names.speed_start[body + 1] - names.speed_start[body]):
            lengths = []
            for way in (-step, step):
                moved = given.astype(float)
                if names.coordinate_start[body + 1] - first == 4:
                    q, turn = moved[:, first : first + 4], turn_about(np.eye(3)[k], np.array(way))
                    moved[:, first : first + 3] = (
                        q[:, 3:] * turn[:3] + turn[3] * q[:, :3] + np.cross(q[:, :3], turn[:3])
                    )
                    moved[:, first + 3] = q[:, 3] * turn[3] - q[:, :3] @ turn[:3]
                else:
                    moved[:, first + k] += way
                coordinates.assign(moved.astype(np.float32))
                lengths.append(geometry_of(stages_, paths).length)
            result[:, :, names.speed_start[body] + k] = (lengths[1] - lengths[0]) / (2.0 * step)
    coordinates.assign(given)
    return result


def on_the_knee(angles: np.ndarray, paths: dict[str, MusclePath]) -> tuple[Stages, Geometry]:
    """Paths at these knee angles, all else in the reference pose."""
    c = character()
    stages_ = Stages(Scene("path", c), len(angles), "cpu")
    coordinates = np.tile(stages_.structs[1].coordinates.numpy()[:1], (len(angles), 1))
    coordinates[:, stages_.names.coordinate_start[stages_.names.body_of_joint("lKnee")]] = angles
    stages_.structs[1].coordinates.assign(coordinates.astype(np.float32))
    return stages_, geometry_of(stages_, paths)


def with_condition(condition: Condition | None) -> MusclePath:
    return [
        ViaPoint("lUpperleg", (0.0, -0.1, 0.05)),
        ViaPoint("lUpperleg", (0.0, -0.2, 0.07), condition),
        ViaPoint("lUpperleg", (0.0, -0.25, 0.07), condition),
        ViaPoint("lLowerleg", (0.0, 0.1, 0.06)),
    ]
