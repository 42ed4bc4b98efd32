"""Units of all numbers of a scene, by structure and field; "1" is that of a pure number."""

from __future__ import annotations

from warpmuscle.kernels.terms import TERMS
from warpmuscle.scene import (
    PD,
    Actuation,
    Balance,
    Body,
    Box,
    Capsule,
    Component,
    Condition,
    Controller,
    Curve,
    Excitation,
    Failure,
    Feedback,
    Ground,
    InitialState,
    Joint,
    JointState,
    Muscle,
    MuscleModel,
    Objective,
    Pulley,
    Reflex,
    Reflexes,
    Robustness,
    Scene,
    SearchStage,
    Sphere,
    State,
    Tracking,
    Trajectory,
    ViaPoint,
)
from warpmuscle.scene.motion import Motion
from warpmuscle.scene.part import Part

OF_OWNER = ""  # the number has the unit of the field that its structure stands in
UNITS: dict[type[Part], dict[str, str]] = {
    Sphere: {"center": "m", "radius": "m"},
    Capsule: {"start": "m", "end": "m", "radius": "m"},
    Box: {"low": "m", "high": "m"},
    Body: {"mass": "kg", "inertia": "kg m^2", "friction": "1"},
    Joint: {
        "position_in_parent": "m", "position_in_child": "m", "axes": "1", "limits": "rad",
        "limit_stiffness": "N m/rad", "limit_damping": "N m s/rad",
    },
    JointState: {"orientation": "1", "angular_velocity": "rad/s"},
    InitialState: {
        "root_position": "m", "root_orientation": "1", "root_velocity": "m/s", "root_angular_velocity": "rad/s",
        "heading": "rad",
    },
    Ground: {
        "normal": "1", "height": "m", "stiffness": "N/m", "damping": "N s/m", "tangential_damping": "N s/m",
        "friction": "1",
    },
    Failure: {
        "com_height": "1", "heading": "rad", "leg_crossing": "m", "self_collision": "m", "max_speed": "m/s or rad/s",
        "max_com_speed": "m/s",
    },
    Objective: dict.fromkeys((*TERMS, "custom"), "1")
    | {"target_speed": "m/s", "ground_force_bound": "1", "basal_rate": "W/kg", "failure_cost": "1"},
    Tracking: {"start": "s"},
    Robustness: {"velocity_noise": "m/s", "push": "N s", "push_duration": "s", "slope": "rad"},
    SearchStage: {
        "objective": "1", "failure": "1", "duration": "s", "candidates": "1", "sigma": "1", "until": "s", "target": "1",
    },
    Scene: {"duration": "s", "time_step": "s", "gravity": "m/s^2", "control_rate": "Hz"},
    PD: {"kp": "N m/rad", "kd": "N m s/rad", "torque_limit": "N m", "scale": "1"},
    Curve: {"phase": "1", "value": OF_OWNER},
    Feedback: {"axis": "1", "cd": "rad/m", "cv": "rad s/m", "d_limits": "m", "v_limits": "m/s"},
    Component: {"axis": "1", "phase": "1", "angle": "rad"},
    Trajectory: {"strength": "1"},
    Balance: {"distance_x": "m", "distance_z": "m", "velocity_x": "m/s", "velocity_z": "m/s"},
    State: {"time": "s"},
    Controller: {
        "stance_hip_damping": "N m s^2/rad^2", "stance_hip_max_velocity": "rad/s",
        "root_predictive_torque_scale": "kg", "desired_heading": "rad",
    },
    Motion: {"time": "s", "value": "rad", "rotation": "rad", "position": "m"},
    Condition: {"low": "rad", "high": "rad", "blend": "rad"},
    ViaPoint: {"position": "m", "start": "m", "end": "m", "at": "1"},
    Excitation: {"time": "s", "value": "1", "period": "s"},
    Pulley: {"moment_arm": "m", "rest_angle": "rad"},
    Muscle: {
        "rest_length": "m", "f_max": "N", "l_opt": "m", "l_slack": "m", "delay": "s", "pennation": "rad",
        "slow_fibres": "1", "specific_tension": "Pa",
    },
    MuscleModel: {
        "rise_time": "s", "fall_time": "s", "neural_time": "s", "initial_activation": "1", "v_max": "l_opt/s",
        "damping": "1", "specific_tension": "Pa",
    },
    Actuation: {"stiffness": "N m/rad", "damping": "N m s/rad", "rest": "rad"},
    Reflex: {"gain": "1", "offset": "1", "lead": "s"},
    Reflexes: {"stance_load": "1", "least": "1"},
}  # fmt: skip


def unit_below(owner: object, field: str, unit: str) -> str:
    """Unit of a field's numbers: that of the structure's field, else that of what the list, table or curve is in."""
    if not isinstance(owner, Part):
        return unit
    return UNITS.get(type(owner), {}).get(field, "1") or unit
