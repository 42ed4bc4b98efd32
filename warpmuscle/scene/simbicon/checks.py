"""What must hold of a SIMBICON controller beyond its types."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from warpmuscle.core.errors import SceneError
from warpmuscle.core.plain_text import number_of
from warpmuscle.scene import Character, Component, Curve, Joint, MachineState
from warpmuscle.scene.number import Number
from warpmuscle.scene.simbicon.controller import Simbicon
from warpmuscle.scene.validation.checks import Checks, known
from warpmuscle.scene.validation.reflexes import check_reflexes


def trajectory_joints(name: str, pairs: Mapping[str, tuple[str, str]]) -> tuple[str, str]:
    """Joints that a trajectory of this name drives in left and in right stance (`lX` is the stance side in left)."""
    side, _, pair = name.partition("_")
    if side not in ("SWING", "STANCE"):
        return name, name
    left, right = pairs.get(pair, ("l" + pair, "r" + pair))
    return (left, right) if side == "STANCE" else (right, left)


def check_simbicon(check: Checks, controller: Simbicon, character: Character) -> None:
    """Names resolve, states lead to states, gains and curves are sound."""
    joints = character.joints
    for name in controller.pd:
        if name != "root":
            known(name, joints, "joint", f"controller.pd.{name}")
    for index, hip in enumerate(controller.hips):
        known(hip, joints, "joint", f"controller.hips.{index}")
        if joints[hip].parent != character.root:
            message = f"hip {hip!r} must be a joint of the root {character.root!r}, not of {joints[hip].parent!r}"
            raise SceneError(message, key=f"controller.hips.{index}")
    for pair, sides in controller.pairs.items():
        for index, joint in enumerate(sides):
            known(joint, joints, "joint", f"controller.pairs.{pair}.{index}")
    if controller.hips[0] == controller.hips[1]:
        raise SceneError(f"left and right are both {controller.hips[0]!r}", key="controller.hips")
    if not controller.states:
        raise SceneError("a controller needs at least one state", key="controller.states")
    _check_index(controller.start_state, controller.states, "controller.start_state")
    if controller.reflexes is not None:
        check_reflexes(check, "controller.reflexes", controller.reflexes)
    for index, state in enumerate(controller.states):
        key = f"controller.states.{index}"
        _check_index(state.next, controller.states, f"{key}.next")
        check_state(check, key, state, joints, controller.pairs)


def check_state(
    check: Checks, key: str, state: MachineState, joints: dict[str, Joint], pairs: Mapping[str, tuple[str, str]]
) -> None:
    """A state lasts to its end, its trajectories have joints, its curves knots."""
    least, greatest = check.interval(state.longest)
    if least < 1.0:
        raise SceneError(f"must be at least 1, is {least:g}", key=f"{key}.longest")
    if greatest > 1.0 and state.transition == "time_up":
        raise SceneError("only a state that ends on `foot_down` may last beyond phase 1", key=f"{key}.longest")
    for name, trajectory in state.trajectories.items():
        path = f"{key}.trajectories.{name}"
        for joint in trajectory_joints(name, pairs) if name != "root" else ():
            known(joint, joints, "joint", path, whose="of this trajectory" if joint != name else "")
        check_curve(check, f"{path}.strength", trajectory.strength)
        for index, component in enumerate(trajectory.components):
            check_component(check, f"{path}.components.{index}", component)
    if state.balance is not None:
        for field in state.balance.__struct_fields__:
            check_curve(check, f"{key}.balance.{field}", getattr(state.balance, field))


def check_component(check: Checks, key: str, component: Component) -> None:
    """A rotation has an axis, knots in order and feedback along some direction."""
    check.not_zero(f"{key}.axis", component.axis, "axis")
    check_knots(check, key, component.phase, component.angle, "angle")
    if component.feedback is not None:
        feedback = component.feedback
        check.not_zero(f"{key}.feedback.axis", feedback.axis, "axis")
        check.ordered(f"{key}.feedback.d_limits", *feedback.d_limits)
        check.ordered(f"{key}.feedback.v_limits", *feedback.v_limits)


def check_knots(check: Checks, key: str, phase: Sequence[Number], values: Sequence[Number], name: str) -> None:
    """As many values as phases; phases increase strictly."""
    if len(phase) != len(values):
        raise SceneError(f"{number_of(len(values), 'value')} for {number_of(len(phase), 'phase')}", key=f"{key}.{name}")
    check.increasing(f"{key}.phase", phase, "phases")


def check_curve(check: Checks, key: str, curve: Curve | None) -> None:
    """A curve has knots, and they are in order."""
    if curve is None:
        return
    if not curve.phase:
        raise SceneError("a curve needs at least one knot", key=f"{key}.phase")
    check_knots(check, key, curve.phase, curve.value, "value")


def _check_index(index: int, states: Sequence[Any], key: str) -> None:
    if not 0 <= index < len(states):
        raise SceneError(f"there is no state {index}; states are numbered 0 to {len(states) - 1}", key=key)
