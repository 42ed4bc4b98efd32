"""Motors, servos and other simple actuators on joints, as forces along coordinates with controls over time."""

from __future__ import annotations

from warpmuscle.formats.mujoco.reference import HINGE, SLIDE, Reference
from warpmuscle.scene import Character, Force, Scene
from warpmuscle.scene.expressions.part import ExpressionCurve
from warpmuscle.scene.joints import joint_type

NO_DYNAMICS, FIXED, AFFINE, NO_BIAS = 0, 0, 1, 0  # mjtDyn, mjtGain, mjtBias
ON_JOINT, IN_PARENT = 0, 1  # mjtTrn, which are the same for hinges and slides
ONE_DEGREE = (HINGE, SLIDE)
LATER = 1.0  # s, of the second knot of a control that stays as it is


def put_drives(reference: Reference, scene: Scene) -> None:
    """Give a scene the forces of actuators that are no muscles, with controls as the first keyframe has them, or 0."""
    model = reference.model
    controls = model.key_ctrl[0] if model.nkey else [0.0] * model.nu
    waiting = []
    for actuator in range(model.nu):
        joint = driven_joint(reference, scene.character, actuator)
        if joint is not None:
            name = model.actuator(actuator).name or f"actuator{actuator}"
            control = float(controls[actuator])
            if model.actuator_ctrllimited[actuator]:
                low, high = (float(end) for end in model.actuator_ctrlrange[actuator])
                control = min(max(control, low), high)
            scene.forces[name] = _force(reference, actuator, joint, control)
            waiting.append(name)
    if waiting:
        some = ", ".join(waiting[:3]) + (", ..." if len(waiting) > 3 else "")
        reason = f"controls of {some} stay as they are at the start; change them in `forces.NAME.curves.control`"
        reference.lose("actuator", reason)


def driven_joint(reference: Reference, character: Character, actuator: int) -> str | None:
    """The joint of a motor or servo that a force along its coordinate stands for; None if there is no such."""
    model = reference.model
    simple = (
        model.actuator_dyntype[actuator] == NO_DYNAMICS
        and model.actuator_gaintype[actuator] in (FIXED, AFFINE)
        and model.actuator_biastype[actuator] in (NO_BIAS, AFFINE)
        and model.actuator_trntype[actuator] in (ON_JOINT, IN_PARENT)
    )
    if not simple or (model.actuator_gaintype[actuator] == AFFINE and model.actuator_gainprm[actuator, 1:3].any()):
        return None
    joint = int(model.actuator_trnid[actuator, 0])
    name = reference.name("joint", joint)
    if model.jnt_type[joint] not in ONE_DEGREE or joint in reference.held or name not in character.joints:
        return None
    own = character.joints[name]
    return name if joint_type(own).moves and not own.follows else None


def _force(reference: Reference, actuator: int, joint: str, control: float) -> Force:
    """gear (gain u + b0 + b1 gear q + b2 gear v), MuJoCo's "Force generation" for a scalar transmission."""
    model = reference.model
    gear, gain = float(model.actuator_gear[actuator, 0]), float(model.actuator_gainprm[actuator, 0])
    b0, b1, b2 = (float(number) for number in model.actuator_biasprm[actuator, :3])
    if model.actuator_biastype[actuator] == NO_BIAS:
        b0 = b1 = b2 = 0.0
    factors = {"control(t)": gear * gain, "q": gear * gear * b1, "qdot": gear * gear * b2}
    terms = [f"{factor!r}*{variable}" for variable, factor in factors.items() if factor or variable == "control(t)"]
    terms += [repr(gear * b0)] if b0 else []
    text = " + ".join(terms).replace("+ -", "- ")
    if model.actuator_forcelimited[actuator]:
        low, high = (gear * float(end) for end in model.actuator_forcerange[actuator])
        text = f"max({min(low, high)!r}, min({max(low, high)!r}, {text}))"
    curve = ExpressionCurve([0.0, LATER], [control, control], "linear")
    force = Force("coordinate_expression", joint, parameters={"scale": 1.0}, expressions={"effort": text})
    force.curves["control"] = curve
    return force
