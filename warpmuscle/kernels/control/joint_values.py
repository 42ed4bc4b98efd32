"""Coordinates and speeds of the joint that carries a body, wherever they stand in the state."""

from warpmuscle.kernels.functions import func
from warpmuscle.kernels.structs import ModelRef, StateRef


@func
def joint_coordinate(instance: int, body: int, k: int, model: ModelRef, state: StateRef) -> float:
    """Coordinate k of the joint, rad or m; of a ball a part of its quaternion, x, y, z, w."""
    return state.coordinates[instance, model.skeleton.plan[body].coordinate_start + k]


@func
def joint_speed(instance: int, body: int, k: int, model: ModelRef, state: StateRef) -> float:
    """Speed k of the joint, rad/s or m/s; of a ball about axis k of its child."""
    return state.speeds[instance, model.skeleton.plan[body].speed_start + k]


@func
def joint_speeds(body: int, model: ModelRef) -> int:
    """How many speeds the joint has: 3 of a ball, 2 of a universal joint, 0 of one that is fixed, 1 of others."""
    return model.skeleton.plan[body].speed_end - model.skeleton.plan[body].speed_start
