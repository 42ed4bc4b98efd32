"""How far constraints between bodies are from being met, and the nearest pose in which they are."""

from __future__ import annotations

import math

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.number_rows import rows
from warpmuscle.core.pose import conjugate, multiply, normalized, rotate, turned_to_heading
from warpmuscle.scene import Character, Constraint, JointState, Scene
from warpmuscle.scene.joints import joint_type, root_type
from warpmuscle.scene.topology import Topology

ROWS = {"weld": 6, "point": 3, "point_on_line": 2, "distance": 1}  # numbers that a constraint holds at 0
STEP = 1.0e-6  # rad or m, of differences
LONGEST = 0.2  # rad or m, by which an iteration moves a coordinate
MOST = 100  # iterations
SETTLED = 1.0e-11  # rad and m
DEPENDENT = 1.0e-7  # of the largest singular value: rows that say what others do
MET = 1.0e-8  # m or rad
MISSED = 1.0e-6  # m or rad, from which constraints are not met
STRAYS = 4  # other poses that `stray_pose` sets out from ...
STRAY, SEED = 0.3, 1  # rad or m, how far they are on average
SEARCHED = 300  # iterations of `searched_pose`
CLOSEST = 1.0e-12  # rad² or m², what an iteration gains when it ends

Poses = dict[str, tuple[Floats, Floats]]


def row_count(character: Character) -> int:
    """How many numbers all constraints of a character hold at 0."""
    return sum(ROWS[constraint.type] for constraint in character.constraints.values())


def perpendicular_axes(axis: Floats) -> Floats:
    """A unit vector along an axis (3,) and two across it, columns (3, 3)."""
    along = normalized(axis)
    beside = np.eye(3)[int(np.argmin(np.abs(along)))]
    second = normalized(np.cross(along, beside))
    return np.stack([along, second, np.cross(along, second)], axis=1)


def start_coordinates(scene: Scene, names: Topology) -> Floats:
    """Coordinates (1, C) at the start of a scene without free parameters; of a kinematic joint, where it is then."""
    state, root = scene.initial_state, root_type(scene.character)
    turn, still = normalized(rows(state.root_orientation)), np.zeros((1, 3))
    if state.heading is not None:
        turn = multiply(turned_to_heading(turn, rows(state.heading)), turn)
    parts = [root.coordinates_of(rows(state.root_position), turn, still, still)[0]]
    for name in names.joints:
        joint = scene.character.joints[name]
        q = joint_type(joint).start(joint, state.joints.get(name, JointState()))[0]
        motion = scene.motion.get(name)
        if q.shape[1] == 1 and motion is not None and motion.value and is_kinematic(scene, name):
            q = np.array(motion.value[0], dtype=float).reshape(1, 1)
        parts.append(q)
    return np.concatenate(parts, axis=1)


def is_kinematic(scene: Scene, joint: str) -> bool:
    """Whether the motion of a joint is prescribed."""
    return joint in scene.actuation and scene.actuation[joint].drive == "kinematic"


def bodies_at(character: Character, names: Topology, q: Floats) -> Poses:
    """Position (n, 3), m, of every body's frame and its orientation (n, 4), world, at coordinates (n, C)."""
    root = root_type(character).motion(q[:, names.coordinates_of(0)])
    found = {names.bodies[0]: (root.place, root.orientation)}
    for number, name in enumerate(names.joints, start=1):
        joint = character.joints[name]
        coordinates, speeds = names.arguments_of(number)
        motion = joint_type(joint).motion(joint, q[:, coordinates], np.zeros((len(q), len(speeds))))
        place, turn = found[joint.parent]
        anchor = place + rotate(turn, rows(joint.position_in_parent) + motion.place)
        turned = multiply(turn, motion.orientation)
        found[joint.child] = np.asarray(anchor - rotate(turned, rows(joint.position_in_child))), turned
    return found


def constraint_errors(character: Character, names: Topology, q: Floats) -> Floats:
    """What all constraints hold at 0, (n, rows), m and rad, at coordinates (n, C) of a numeric character."""
    poses = bodies_at(character, names, q)
    parts = [_errors(one, poses) for one in character.constraints.values()]
    return np.concatenate([np.zeros((len(q), 0)), *parts], axis=1)


def _errors(constraint: Constraint, poses: Poses) -> Floats:
    (place, turn), (other_place, other_turn) = poses[constraint.body], poses[constraint.other_body]
    offset = place + rotate(turn, rows(constraint.position))
    offset = offset - other_place - rotate(other_turn, rows(constraint.other_position))
    if constraint.type == "distance":
        return np.asarray(np.linalg.norm(offset, axis=1, keepdims=True) - float(constraint.distance))  # type: ignore[arg-type]
    if constraint.type == "point_on_line":
        return np.asarray(rotate(conjugate(other_turn), offset) @ perpendicular_axes(rows(constraint.axis)[0])[:, 1:])
    if constraint.type == "point":
        return np.asarray(offset)
    axes = multiply(turn, normalized(rows(constraint.orientation)))
    other_axes = multiply(other_turn, normalized(rows(constraint.other_orientation)))
    missing = multiply(axes, conjugate(other_axes))
    angle = 2.0 * missing[:, :3] * np.where(missing[:, 3:] < 0.0, -1.0, 1.0)
    return np.concatenate([offset, angle], axis=1)


def slopes(character: Character, names: Topology, q: Floats, chosen: list[int]) -> Floats:
    """Derivatives (rows, k) of what constraints hold at 0 by chosen coordinates, at one pose (1, C)."""
    steps = STEP * np.eye(q.shape[1])[chosen]
    both = constraint_errors(character, names, np.concatenate([q + steps, q - steps]))
    return np.asarray((both[: len(chosen)] - both[len(chosen) :]).T / (2.0 * STEP))


def nearest_pose(
    character: Character, names: Topology, q: Floats, chosen: list[int], low: Floats, high: Floats
) -> tuple[Floats, float]:
    """The coordinates (1, C) that meet all constraints and are nearest to given ones, and what is missing, m or rad.

    The sum of squares of the changes is least among all poses near by, as in OpenSim's assembly, and chosen coordinates
    stay within bounds. Each iteration solves this for constraints as they are about the last pose.

    Args:
        chosen: coordinates that may change. low, high: (k,) their bounds.
    """
    return _approached(character, names, q, q[0, chosen], chosen, low, high)


def met_pose(
    character: Character, names: Topology, q: Floats, chosen: list[int], low: Floats, high: Floats
) -> tuple[Floats, float]:
    """The first pose that meets the constraints: of `nearest_pose`, `searched_pose`, or `stray_pose`."""
    for search in (nearest_pose, searched_pose):
        found, missing = search(character, names, q, chosen, low, high)
        if missing <= MISSED or not chosen:  # then there is no other pose
            return found, missing
    return stray_pose(character, names, q, chosen, low, high)


def searched_pose(
    character: Character, names: Topology, q: Floats, chosen: list[int], low: Floats, high: Floats
) -> tuple[Floats, float]:
    """The same by sequential quadratic programming, which measures each step by what it gains.

    Where the nearest pose is far away, constraints bend so much that steps of `nearest_pose` swing about it for ever.
    """
    from scipy.optimize import minimize  # takes a while, which only such poses cost

    start, pose = q[0, chosen].copy(), q.copy()
    independent = _independent_rows(character, names, q, chosen)

    def posed(x: Floats) -> Floats:
        pose[0, chosen] = np.where(np.isfinite(x), x, start)
        return pose

    held = {
        "type": "eq",
        "fun": lambda x: independent @ constraint_errors(character, names, posed(x))[0],
        "jac": lambda x: independent @ slopes(character, names, posed(x), chosen),
    }
    found = minimize(
        lambda x: 0.5 * ((x - start) ** 2).sum(), np.clip(start, low, high), jac=lambda x: x - start, method="SLSQP",
        bounds=list(zip(low, high, strict=True)), constraints=held, options={"maxiter": SEARCHED, "ftol": CLOSEST},
    )  # fmt: skip
    posed(np.clip(found.x, low, high))
    return pose, float(np.abs(constraint_errors(character, names, pose)).max(initial=0.0))


def _independent_rows(character: Character, names: Topology, q: Floats, chosen: list[int]) -> Floats:
    """Combinations (k, rows) of constraints of which none says what others do, in several poses together."""
    random, pose, found = np.random.default_rng(SEED), q.copy(), []
    for _ in range(STRAYS):
        found.append(slopes(character, names, pose, chosen))
        pose[0, chosen] = q[0, chosen] + random.normal(size=len(chosen), scale=STRAY)
    ways, sizes, _ = np.linalg.svd(np.concatenate(found, axis=1), full_matrices=False)
    return np.asarray(ways[:, sizes > DEPENDENT * sizes.max(initial=0.0)].T)


def stray_pose(
    character: Character, names: Topology, q: Floats, chosen: list[int], low: Floats, high: Floats
) -> tuple[Floats, float]:
    """The same from other poses near by: two rods in line that are to come closer have no way that is the nearest.

    The result is the nearest pose that meets the constraints, or the one that misses them least.
    """
    found, missing, nearest = q, math.inf, math.inf
    random = np.random.default_rng(SEED)
    for _ in range(STRAYS):
        begin = q[0, chosen] + random.normal(size=len(chosen), scale=STRAY)
        pose, left = _approached(character, names, q, begin, chosen, low, high)
        far = float(np.linalg.norm(pose[0, chosen] - q[0, chosen])) if left <= MET else math.inf
        if far < nearest or (nearest == math.inf and left < missing):
            found, missing, nearest = pose, left, far
    return found, missing


def _approached(
    character: Character, names: Topology, q: Floats, begin: Floats, chosen: list[int], low: Floats, high: Floats
) -> tuple[Floats, float]:
    """The pose that `nearest_pose` finds from chosen coordinates (k,) to begin with."""
    start, now = q[0, chosen].copy(), np.clip(begin, low, high)
    pose = q.copy()
    for _ in range(MOST):
        pose[0, chosen] = now
        errors = constraint_errors(character, names, pose)[0]
        slope = slopes(character, names, pose, chosen)
        if not (np.isfinite(errors).all() and np.isfinite(slope).all()):
            return pose, math.inf
        target = _least_change(start, slope, slope @ now - errors, low, high)
        step = target - now
        longest = float(np.abs(step).max(initial=0.0))
        now = now + step * min(1.0, LONGEST / max(longest, 1e-30))
        if longest < SETTLED:
            break
    pose[0, chosen] = now
    return pose, float(np.abs(constraint_errors(character, names, pose)).max(initial=0.0))


def _least_change(start: Floats, slope: Floats, right: Floats, low: Floats, high: Floats) -> Floats:
    """The x nearest to `start` with slope x = right, within bounds as far as that can be."""
    found, held = start.copy(), np.zeros(len(start), dtype=bool)
    for _ in range(len(start) + 1):
        free = ~held
        missing = right - slope[:, held] @ found[held] - slope[:, free] @ start[free]
        found[free] = start[free] + np.linalg.pinv(slope[:, free], rcond=DEPENDENT) @ missing
        beyond = free & ((found < low) | (found > high))
        if not beyond.any():
            break
        found[beyond] = np.clip(found[beyond], low[beyond], high[beyond])
        held |= beyond
    return found


def movers(character: Character, names: Topology) -> list[str]:
    """Joints whose coordinates move a body that a constraint holds, in their order."""
    found: set[int] = set()
    for constraint in character.constraints.values():
        for end in (constraint.body, constraint.other_body):
            body = names.bodies.index(end)
            while body > 0:
                found.add(names.driver[body])
                body = names.parents[body]
    return [name for number, name in enumerate(names.joints, start=1) if number in found]


def meeting_speeds(character: Character, names: Topology, q: Floats, chosen: list[int], v: Floats) -> Floats:
    """The rates (k,) of chosen coordinates nearest to given ones with which constraints stay met."""
    slope = slopes(character, names, q, chosen)
    return np.asarray(v - np.linalg.pinv(slope, rcond=DEPENDENT) @ (slope @ v))
