"""Writers of `.rbs`, `.sbc` and `.rs` files for the Simbicon Controller Editor Framework."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

from warpmuscle.core.errors import SceneError
from warpmuscle.core.files import shown
from warpmuscle.formats.rbs import PROPERTIES
from warpmuscle.formats.rbs_joints import mirrored
from warpmuscle.formats.rs import breadth_first
from warpmuscle.formats.sbc import SET_POINTS
from warpmuscle.scene import (
    Body,
    Capsule,
    Character,
    Component,
    Controller,
    Ground,
    InitialState,
    Joint,
    JointState,
    MachineState,
    Muscle,
    Scene,
    Shape,
    Sphere,
    Trajectory,
)
from warpmuscle.scene.joints import joint_type, root_type
from warpmuscle.scene.joints.joint_type import NO_AXIS, OTHER_AXIS
from warpmuscle.scene.validation.paths import usual_drive


def rbs_text(scene: Scene) -> str:
    """A character, and the ground unless it is the default one, as `.rbs` text; the scene has no free parameters."""
    character = scene.character
    lines: list[str] = []
    if (scene.ground.normal, scene.ground.height, scene.ground.friction) != _plane(Ground()):
        lines += _ground(scene.ground)
    for name, body in character.bodies.items():
        lines += _body(_word(name, f"character.bodies.{name}"), body, character)
    lines += ["ArticulatedFigure", f"\troot {character.root}", ""]
    marked = _marked(scene)
    for name, joint in character.joints.items():
        lines += _joint(_word(name, f"character.joints.{name}"), joint, marked=name in marked)
    for name, muscle in character.muscles.items():
        lines += _muscle(_word(name, f"character.muscles.{name}"), muscle)
    return "\n".join([*lines, "/ArticulatedFigure", ""])


def sbc_text(controller: Controller, state_file: str = "") -> str:
    """A controller as `.sbc` text; it has no free parameters.

    Args:
        controller: what to write.
        state_file: path of the `.rs` file that it starts from; none if empty.
    """
    lines = ["PDParams", "#\tjoint\tkp\tkd\ttorque limit\tscale x\ty\tz"]
    for name, gains in controller.pd.items():
        word = _word(name, f"controller.pd.{name}")
        lines.append(
            "\t".join([f"\t{word}", *map(shown, _floats([gains.kp, gains.kd, gains.torque_limit, *gains.scale]))])
        )
    lines += [
        "/PDParams",
        "",
        f"stanceHipDamping {_row(controller.stance_hip_damping)}",
        f"stanceHipMaxVelocity {_row(controller.stance_hip_max_velocity)}",
        f"rootPredictiveTorqueScale {_row(controller.root_predictive_torque_scale)}",
        "",
    ]
    for index, state in enumerate(controller.states):
        lines += [*_state(index, state), ""]
    lines += [f"startAtState {controller.start_state}", f"startingStance {controller.start_stance}"]
    return "\n".join([*lines, *([f"loadCharacterState {state_file}"] if state_file else []), ""])


def rs_text(initial: InitialState, character: Character) -> str:
    """An initial state as `.rs` text; without a heading of its own, the root's is written."""
    x, y, z, w = _floats(initial.root_orientation)
    heading = 2.0 * math.atan2(y, w) if initial.heading is None else initial.heading
    lines = [
        "# Heading", _row(heading), "",
        f"# Root ({character.root}): position, orientation (w x y z), velocity, angular velocity",
        _row(*_floats(initial.root_position)), _row(w, x, y, z), _row(*_floats(initial.root_velocity)),
        _row(*_floats(initial.root_angular_velocity)),
    ]  # fmt: skip
    for name in breadth_first(character):
        joint = initial.joints.get(name) or JointState()
        x, y, z, w = _floats(joint.orientation)
        lines += ["", f"# {name}", _row(w, x, y, z), _row(*_floats(joint.angular_velocity))]
    return "\n".join([*lines, ""])


def _plane(ground: Ground) -> tuple[Any, Any, Any]:
    return ground.normal, ground.height, ground.friction


def _ground(ground: Ground) -> list[str]:
    """The ground as a static plane through the point nearest to the origin."""
    normal, (height,) = _floats(ground.normal), _floats([ground.height])
    length = math.hypot(*normal)
    point = [component / length * height for component in normal]
    plane = f"\tCDP_Plane {_row(*normal)} {_row(*point)}"
    return [
        "RigidBody",
        "\tname ground",
        "\tstatic",
        plane,
        f"\tfrictionCoefficient {_row(ground.friction)}",
        "/End",
        "",
    ]


def _body(name: str, body: Body, character: Character) -> Iterator[str]:
    yield from ("A_RigidBody", f"\tname {name}", f"\tmass {_row(body.mass)}", f"\tmoi {_row(*body.inertia)}")
    yield from (f"\t{_shape(shape)}" for shape in body.shapes)
    yield f"\tfrictionCoefficient {_row(body.friction)}"
    if name == character.root and character.root_joint != "free":
        yield f"\t{root_type(character).keyword}"
    yield from ("/End", "")


def _shape(shape: Shape) -> str:
    if isinstance(shape, Sphere):
        return f"CDP_Sphere {_row(*shape.center, shape.radius)}"
    if isinstance(shape, Capsule):
        return f"CDP_Capsule {_row(*shape.start, *shape.end, shape.radius)}"
    return f"CDP_Box {_row(*shape.low, *shape.high)}"


def _marked(scene: Scene) -> set[str]:
    """Joints that muscles alone drive, if the scene says so of some; otherwise muscles drive all that they cross."""
    if not scene.actuation:
        return set()
    own, character = scene.actuation, scene.character
    drives = {name: own[name].drive if name in own else usual_drive(name, character) for name in character.joints}
    return {name for name, drive in drives.items() if drive == "muscle"}


def _joint(name: str, joint: Joint, *, marked: bool) -> Iterator[str]:
    """A joint, marked as driven by muscles or not; limits of a ball joint take the signs of the original's motor."""
    axes: Sequence[Any] = joint.axes
    kind = joint_type(joint)
    if not kind.keyword:
        raise SceneError(f"this format has no {kind.name} joint", key=f"character.joints.{name}.type")
    if not axes and kind.axes:
        axes = [NO_AXIS, OTHER_AXIS]
    limits = [(low, high) for low, high in (_floats(pair) for pair in joint.limits)]
    limits = [mirrored(*pair) if i in kind.opposite_limits else pair for i, pair in enumerate(limits)]
    yield f"\t{kind.keyword} {_row(*(number for axis in axes for number in axis))}".rstrip()
    yield from (f"\t\tname {name}", f"\t\tparent {joint.parent}", f"\t\tchild {joint.child}")
    yield f"\t\tjointPPos {_row(*joint.position_in_parent)}"
    yield f"\t\tjointCPos {_row(*joint.position_in_child)}"
    if limits:
        yield f"\t\tjointLimits {_row(*(number for pair in limits for number in pair))}"
    if marked:
        yield "\t\tactuationType muscle"
    yield from ("\t/Joint", "")


def _muscle(name: str, muscle: Muscle) -> Iterator[str]:
    """A muscle, its points without their conditions."""
    for field in ("pulleys", "polynomial"):
        if getattr(muscle, field):
            raise SceneError(f"this format has no {field}; give a path of points", f"character.muscles.{name}.{field}")
    yield from ("\tMuscle", f"\t\tname {name}")
    for point in muscle.path:
        yield from (f"\t\tA_RigidBody {point.body}", f"\t\tposition {_row(*point.place())}")
    yield from (f"\t\t{keyword} {_row(getattr(muscle, field))}" for keyword, field in PROPERTIES.items())
    yield from ("\t/Muscle", "")


def _state(index: int, state: MachineState) -> Iterator[str]:
    if state.longest != 1.0:
        raise SceneError("this format has no states that last beyond phase 1", f"controller.states.{index}.longest")
    yield f"ConState {index}"
    if state.description:
        yield f"\tdescription {' '.join(state.description.split())}"
    yield f"\tnextState {state.next}"
    yield f"\ttransitionOn {'footDown' if state.transition == 'foot_down' else 'timeUp'}"
    yield from (f"\tstateStance {state.stance}", f"\ttime {_row(state.time)}")
    for keyword, field in SET_POINTS.items():
        curve = getattr(state.balance, field, None)
        if curve is not None:
            yield from _knots("\t", keyword, curve.phase, curve.value)
    for name, trajectory in state.trajectories.items():
        yield from _trajectory(_word(name, f"controller.states.{index}.trajectories.{name}"), trajectory)
    yield "/ConState"


def _trajectory(name: str, trajectory: Trajectory) -> Iterator[str]:
    yield from ("", f"\ttrajectory {name}")
    if trajectory.frame == "character":
        yield "\t\tcharacterFrameRelative"
    if trajectory.strength is not None:
        yield from _knots("\t\t", "strengthTrajectory", trajectory.strength.phase, trajectory.strength.value)
    for component in trajectory.components:
        yield from _component(component)
    yield "\t/trajectory"


def _component(component: Component) -> Iterator[str]:
    yield from ("\t\tcomponent", f"\t\t\trotationAxis {_row(*component.axis)}")
    if component.reverse_on != "never":
        yield f"\t\t\treverseTargetAngleOnStance {component.reverse_on}"
    feedback = component.feedback
    if feedback is not None:
        yield from ("\t\t\tfeedback linear", f"\t\t\t\tfeedbackProjectionAxis {_row(*feedback.axis)}")
        limits = zip(("dMin", "dMax", "vMin", "vMax"), (*feedback.d_limits, *feedback.v_limits), strict=True)
        for keyword, number in (("cd", feedback.cd), ("cv", feedback.cv), *limits):
            yield f"\t\t\t\t{keyword} {_row(number)}"
        yield "\t\t\t/feedback"
    yield from _knots("\t\t\t", "baseTrajectory", component.phase, component.angle)
    yield "\t\t/component"


def _knots(indent: str, keyword: str, phase: Sequence[Any], value: Sequence[Any]) -> Iterator[str]:
    yield f"{indent}{keyword}"
    yield from (f"{indent}\t{_row(*knot)}" for knot in zip(phase, value, strict=True))
    yield f"{indent}/{keyword}"


def _row(*numbers: Any) -> str:
    return " ".join(map(shown, numbers))


def _floats(numbers: Sequence[Any]) -> list[float]:
    """Numbers of a scene that has no free parameters."""
    return [float(number) for number in numbers]


def _word(name: str, key: str) -> str:
    """A name as these files can hold it."""
    if not name or name.split() != [name] or "#" in name:
        raise SceneError(f"{name!r} cannot be a name in this format: no blanks, no #", key=key)
    return name
