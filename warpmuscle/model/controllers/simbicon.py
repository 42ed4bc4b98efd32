"""A scene's SIMBICON controller as a kernel wants it: curves, components, trajectories and states in flat arrays."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import warp as wp

from warpmuscle.core.arrays import records_to_device, rows, starts, structs_to_device, to_device
from warpmuscle.core.pose import normalized
from warpmuscle.kernels import structs
from warpmuscle.kernels.contact.terrain import above_terrain
from warpmuscle.kernels.control.control import ControllerKind
from warpmuscle.kernels.control.coordinate_control import coordinate_control_stage, coordinate_control_stage_of
from warpmuscle.kernels.control.simbicon import (
    advance_machine,
    control_stage,
    held_control_stage,
    record_machine,
    simbicon_stages_of,
)
from warpmuscle.model.joints import by_coordinate
from warpmuscle.scene import PD, Balance, Component, Curve, Feedback, MachineState, Scene
from warpmuscle.scene.simbicon.checks import trajectory_joints
from warpmuscle.scene.simbicon.controller import Simbicon
from warpmuscle.scene.topology import Topology

SIMBICON = ControllerKind(control_stage, coordinate_control_stage, advance_machine, record_machine)
HELD = SIMBICON._replace(torques=held_control_stage, renews=True)

STANCE_RULE = {"left": structs.LEFT, "right": structs.RIGHT, "reverse": structs.REVERSE, "same": structs.SAME}
REVERSE_ON = {"left": structs.LEFT, "right": structs.RIGHT, "never": -1}


class Knots:
    """Collects curves one behind the other."""

    def __init__(self) -> None:
        self.phase: list[Any] = []
        self.value: list[Any] = []

    def add(self, phase: Sequence[Any], value: Sequence[Any]) -> tuple[int, int]:
        """Append a curve; returns the numbers of its first knot and of the one behind its last."""
        first = len(self.phase)
        self.phase += list(phase)
        self.value += list(value)
        return first, len(self.phase)

    def add_curve(self, curve: Curve | None) -> tuple[int, int]:
        """Append a curve, or an empty one."""
        return (0, 0) if curve is None else self.add(curve.phase, curve.value)


def trajectory_bodies(state: MachineState, controller: Simbicon, names: Topology) -> list[tuple[int, int]]:
    """Body of every trajectory in left and in right stance; -1 where a later trajectory drives the same joint."""
    pairs = (trajectory_joints(name, controller.pairs) for name in state.trajectories)
    meant = [[names.body_of_joint(joint) for joint in pair] for pair in pairs]
    return [
        (
            -1 if left in [later[0] for later in meant[i + 1 :]] else left,
            -1 if right in [later[1] for later in meant[i + 1 :]] else right,
        )
        for i, (left, right) in enumerate(meant)
    ]


def control_steps(scene: Scene) -> int:
    """Steps after which the controller renews its targets."""
    return max(round(1.0 / (scene.control_rate * scene.time_step)), 1) if scene.control_rate > 0.0 else 1


def compiled(scene: Scene) -> ControllerKind:
    """What a step has compiled in of the controller of a scene."""
    held = control_steps(scene) > 1
    if scene.ground.terrain is None:
        return HELD if held else SIMBICON
    stages, by_coordinate_stage = simbicon_stages_of(above_terrain), coordinate_control_stage_of(above_terrain)
    kind = (HELD if held else SIMBICON)._replace(coordinates=by_coordinate_stage)
    return kind._replace(torques=stages.held if held else stages.control)


def model_fields(scene: Scene, names: Topology, device: Any) -> dict[str, Any]:
    """The controller of a scene, whose numbers are floats or (n,) arrays, by field of `kernels.structs.Model`."""
    controller = scene.simbicon
    assert controller is not None
    return {"simbicon": simbicon_struct(controller, control_steps(scene), scene, names, device)}


def state_arrays(scene: Scene, instances: int, names: Topology, zeros: Callable[..., wp.array]) -> dict[str, wp.array]:
    """Room for the state of so many instances, by its place in `kernels.structs.State`.

    Args:
        zeros: makes an array of a shape and dtype.
    """
    held = (instances if control_steps(scene) > 1 else 0, len(names.bodies))
    return {
        "simbicon.phase": zeros(instances), "simbicon.stance": zeros(instances, dtype=int),
        "simbicon.machine_state": zeros(instances, dtype=int),
        "simbicon.target": zeros(*held, dtype=wp.quat), "simbicon.target_plan": zeros(*held, dtype=wp.vec2),
    }  # fmt: skip


def start_values(scene: Scene) -> dict[str, int]:
    """What of the state starts at anything but 0, by place."""
    controller = scene.simbicon
    assert controller is not None
    stance = structs.RIGHT if controller.start_stance == "right" else structs.LEFT
    return {"simbicon.stance": stance, "simbicon.machine_state": controller.start_state}


def simbicon_struct(controller: Simbicon, every: int, scene: Scene, names: Topology, device: Any) -> structs.Simbicon:
    """The device structure of a controller, see `kernels.structs.Simbicon`.

    Args:
        every: steps after which it renews its targets. scene: to which it belongs.
    """
    s = structs.Simbicon()
    s.every = every
    s.left_hip, s.right_hip = (names.body_of_joint(hip) for hip in controller.hips)
    s.heading_control = int(controller.heading_control)
    moved = [body for body, name in enumerate(names.joints, 1) if by_coordinate(name, scene.character)]
    _fill_gains(s, controller, names, moved, device)
    _fill_states(s, controller, names, device)
    return s


def _fill_gains(s: structs.Simbicon, controller: Simbicon, names: Topology, moved: list[int], device: Any) -> None:
    off = PD(kp=0.0, kd=0.0, torque_limit=0.0, scale=(0.0, 0.0, 0.0))
    gains = [controller.pd.get(joint, off) for joint in ("root", *names.joints)]
    columns = {field: rows([getattr(pd, field) for pd in gains]) for field in structs.Gains.vars}
    columns["scale"][:, moved] = 0.0  # PD follows their coordinate, see `kernels.control.coordinate_control`
    s.gains = structs_to_device(structs.Gains, columns, device)
    hip = {
        "damping": controller.stance_hip_damping,
        "max_velocity": controller.stance_hip_max_velocity,
        "predictive_scale": controller.root_predictive_torque_scale,
        "desired_heading": controller.desired_heading,
    }
    s.hip = structs_to_device(structs.HipControl, {field: rows([value]) for field, value in hip.items()}, device)


def _fill_states(s: structs.Simbicon, controller: Simbicon, names: Topology, device: Any) -> None:
    states, knots = controller.states, Knots()
    trajectories = [trajectory for state in states for trajectory in state.trajectories.values()]
    components = [component for trajectory in trajectories for component in trajectory.components]
    trajectory_start = starts(len(state.trajectories) for state in states)
    s.states = records_to_device(
        structs.ControlState, device,
        next_state=[state.next for state in states],
        on_foot_down=[state.transition == "foot_down" for state in states],
        stance_rule=[STANCE_RULE[state.stance] for state in states],
        first_trajectory=trajectory_start[:-1], end_trajectory=trajectory_start[1:],
    )  # fmt: skip
    s.state_time = to_device(rows([[state.time, state.longest] for state in states]), wp.vec2, device)
    s.balance_knots = to_device([_balance_knots(state.balance, knots) for state in states], int, device)
    bodies = [pair for state in states for pair in trajectory_bodies(state, controller, names)]
    strength = [knots.add_curve(t.strength) for t in trajectories]
    component_start = starts(len(t.components) for t in trajectories)
    s.trajectories = records_to_device(
        structs.Trajectory, device,
        left_body=[left for left, _ in bodies], right_body=[right for _, right in bodies],
        character_frame=[t.frame == "character" for t in trajectories],
        first_knot=[first for first, _ in strength], end_knot=[end for _, end in strength],
        first_component=component_start[:-1], end_component=component_start[1:],
    )  # fmt: skip
    _fill_components(s, components or [Component(axis=(1.0, 0.0, 0.0))], knots, device)
    columns = {"phase": rows(knots.phase or [0.0]), "value": rows(knots.value or [0.0])}
    s.knots = structs_to_device(structs.Knot, columns, device)


def _fill_components(s: structs.Simbicon, components: list[Component], knots: Knots, device: Any) -> None:
    none = Feedback(axis=(0.0, 0.0, 1.0))
    feedback = [none if component.feedback is None else component.feedback for component in components]
    curves = [knots.add(c.phase, c.angle) for c in components]
    s.components = records_to_device(
        structs.ComponentPlan, device,
        reverse=[REVERSE_ON[c.reverse_on] for c in components],
        first_knot=[first for first, _ in curves], end_knot=[end for _, end in curves],
        has_feedback=[c.feedback is not None for c in components],
    )  # fmt: skip
    columns = {
        "axis": normalized(rows([list(c.axis) for c in components])),
        "feedback_axis": normalized(rows([list(f.axis) for f in feedback])),
        "feedback_gain": rows([[f.cd, f.cv] for f in feedback]),
        "feedback_limits": rows([[*f.d_limits, *f.v_limits] for f in feedback]),
    }
    s.component_rows = structs_to_device(structs.ComponentRow, columns, device)


def _balance_knots(balance: Balance | None, knots: Knots) -> list[int]:
    """First and end of the four set-point curves of a state; the last number is -1 if it has none."""
    if balance is None:
        return [0] * 7 + [-1]
    curves = (balance.distance_x, balance.distance_z, balance.velocity_x, balance.velocity_z)
    return [number for curve in curves for number in knots.add_curve(curve)]
